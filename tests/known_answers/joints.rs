//! Springs and dampers on joints.

use crate::support::{assert_near, plant, run, step};
use messages::load::parse;
use plant::Plant;

const LEVER: &str = r#"
[plant]
base = "fixed"
gravity = 0.0
drive_inertia = 0.0
[[bodies]]
name = "wall"
mass = 1.0
size = [0.1, 0.1, 0.1]
[[bodies]]
name = "lever"
mass = 1.0
size = [0.1, 0.1, 0.1]
inertia = [0.5, 0.5, 0.5]
joint = { parent = "wall", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0], stiffness = 50.0, damping = 2.0, rest = 0.3 }
"#;

/// J q'' = k (q0 - q) - d q', released at rest at q = 0: q0 (1 - e^(-a t) (cos w t + a/w sin w t)), a = d/2J, w² = k/J - a².
#[test]
fn a_spring_with_a_damper_oscillates_by_its_formula() {
    let (a, w) = (2.0, 96f64.sqrt());
    let exact = |t: f64| 0.3 * (1.0 - (-a * t).exp() * ((w * t).cos() + a / w * (w * t).sin()));
    let error = |dt: f64| {
        let mut scene = parse(LEVER, "lever").expect("a scene");
        scene.plant.dt = dt;
        let mut plant = Plant::new(&scene).expect("a lever");
        run(&mut plant, 1.0);
        (plant.state().joint(plant.model(), 0) - exact(1.0)).abs()
    };
    let (coarse, fine) = (error(1e-3), error(5e-4));
    println!("off by {coarse:e} rad, {fine:e} with half the step");
    assert!(coarse < 2e-3 && fine < 0.51 * coarse);
}

/// The damping of the servos is integrated implicitly, so it limits no step. At 3 N·m·s/rad an explicit integration diverges above 0.92 ms.
#[test]
fn servos_hold_a_robot_in_the_air_at_any_step() {
    let joints = [
        "left foot",
        "left ankle",
        "left shank",
        "left thigh",
        "right thigh",
        "right shank",
        "right ankle",
        "right foot",
    ];
    let mut settings = vec!["rate=100".to_string(), "plant.drive_inertia=0".into(), "plant.dt=0.01".into()];
    for joint in joints {
        settings.push(format!("bodies.{joint}.joint.stiffness=400"));
        settings.push(format!("bodies.{joint}.joint.damping=3"));
    }
    settings.extend([
        "plant.gravity=0".into(),
        "initial.clearance=1".into(),
        "initial.joints=[0.1, -0.2, 0.4, -0.2, -0.2, 0.4, -0.2, 0.1]".into(),
    ]);
    let settings: Vec<_> = settings.iter().map(String::as_str).collect();
    let mut plant = plant("stand", &settings);
    for _ in 0..1000 {
        step(&mut plant);
    }
    let model = plant.model();
    for k in 0..8 {
        assert_near("angle", plant.state().joint(model, k), 0.0, 1e-6);
    }
}
