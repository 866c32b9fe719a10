//! Claims about a body that slides and turns: friction opposes the velocity of each contact, as the round cone requires; contacts that
//! could carry the load in many ways carry it with the least norm; and points that land at once land together.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_plant::Plant;
use messages::load::load;
use messages::wire::Torques;

/// The state at the end of a scene from `tests/data`; each step obeys Coulomb's law.
fn end(name: &str, settings: &[&str]) -> Plant {
    let file = format!("{}/tests/data/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let settings: Vec<_> = settings.iter().map(ToString::to_string).collect();
    let scene = load(&file, &settings, &[]).expect("a scene");
    let mut plant = Plant::new(&scene).expect("a plant");
    for _ in 0..(scene.duration * scene.rate).round() as usize {
        plant.advance(&Torques::default()).expect("a step");
        assert!(plant.truth().natural_map <= 1e-10 && plant.truth().fallbacks == 0, "{:?}", plant.truth());
    }
    plant
}

/// Angular velocity about the vertical at the end of a scene [rad/s].
fn turning(name: &str, settings: &[&str]) -> f64 {
    end(name, settings).state().xdot[5]
}

/// Three legs carry a puck. Its equations of motion, integrated by the classical method of fourth order in steps of 1e-4 s, give .706702
/// rad/s after half a second.
#[test]
fn a_puck_that_slides_and_turns_is_braked_about_the_vertical() {
    for (settings, most) in [(vec![], 2e-4), (vec!["plant.dt=0.00025"], 5e-5), (vec!["plant.method=EventDriven"], 1e-6)]
    {
        let found = turning("slide-and-turn", &settings);
        println!("{settings:?}: {found}");
        assert!((found - 0.706_702).abs() < most, "{settings:?}: {found}");
    }
}

/// A fourth point .4 mm above the ground never touches, so it must not change anything.
#[test]
fn a_point_without_load_changes_nothing() {
    let found = turning("untouched-point", &[]);
    println!("{found}");
    assert!((found - 1.662_76).abs() < 5e-4, "{found}");
}

/// The least norm, in N·s, loads five legs equally, one of them in the centre of turning. So four fifths of μmg brake at the radius r, and
/// after .2 s the rate is 6 - .8 · μ m g r t / I = 2.861 rad/s.
#[test]
fn five_legs_share_the_load_equally() {
    let exact = 6.0 - 0.8 * 0.2 * 9.81 * 0.1 * 0.2 / 0.01;
    for dt in ["0.001", "0.000125"] {
        let found = turning("five-legs", &[&format!("plant.dt={dt}")]);
        println!("{dt}: {found} rad/s, exact {exact}");
        assert!((found - exact).abs() < 1e-3, "{dt}: {found}, exact {exact}");
    }
}

/// After a landing the heights of four corners differ by rounding. Each carries the load that it carries with impacts and slips located in
/// time, and none is left without load.
#[test]
fn a_box_that_has_landed_slides_on_all_its_corners() {
    let loads = |settings: &[&str]| {
        let plant = end("landing-box", settings);
        plant.truth().contact_force.iter().skip(2).step_by(3).take(4).copied().collect::<Vec<_>>()
    };
    let located = loads(&["plant.method=EventDriven"]);
    for dt in ["0.001", "0.0005", "0.000125"] {
        let found = loads(&[&format!("plant.dt={dt}")]);
        println!("{dt}: {found:.4?} N, located {located:.4?} N");
        for (found, located) in found.iter().zip(&located) {
            assert!((found - located).abs() < 2e-3 * located, "{dt}: {found} N, located {located} N");
        }
    }
}

/// A box that stands on one edge tips onto the parallel one. Its two corners land together, although the heights of contacts have errors
/// of h²: the rate is that with located impacts, at every step length.
#[test]
fn an_edge_lands_as_a_whole() {
    let rate = |settings: &[&str]| end("landing-box", &[settings, &["duration=0.045"]].concat()).state().xdot[3];
    let located = rate(&["plant.method=EventDriven"]);
    for dt in ["0.001", "0.0005", "0.0002", "0.0001"] {
        let found = rate(&[&format!("plant.dt={dt}")]);
        println!("{dt}: {found} rad/s, located {located}");
        assert!((found - located).abs() < 1e-3 * located.abs(), "{dt}: {found} rad/s, located {located}");
    }
}
