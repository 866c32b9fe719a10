//! The runs of each study.

use super::args::Study;
use messages::scene::Law;

/// One run of a table.
pub struct StudyCase {
    /// Name of the row.
    pub name: String,
    /// The scene.
    pub scene: &'static str,
    /// Changed settings.
    pub settings: Vec<String>,
}

/// A case.
pub fn case(name: impl Into<String>, scene: &'static str, settings: &[&str]) -> StudyCase {
    StudyCase { name: name.into(), scene, settings: settings.iter().map(|setting| (*setting).into()).collect() }
}

/// The runs of a study.
pub fn cases(study: Study) -> Vec<StudyCase> {
    match study {
        Study::Margins => margins(),
        Study::Laws => laws(),
        Study::Attraction => attraction(),
        Study::Endurance => endurance(),
        Study::Problems | Study::Pushes => vec![], // see `problems` and `pushes`
    }
}

fn margins() -> Vec<StudyCase> {
    let mut cases = vec![case("walk as it is", "walk", &[]), case("stamp as it is, 14 s", "stamp", &["duration=14"])];
    let mut vary = |what: &str, unit: &str, key: &str, values: &[&str]| {
        cases.extend(values.iter().map(|v| case(format!("{what} {v}{unit}"), "walk", &[&format!("{key}={v}")])));
    };
    vary("dt", " s", "plant.dt", &["0.000125", "0.00025", "0.0005"]);
    vary("integrator", "", "plant.method", &["SemiImplicitEuler", "MoreauJean", "MidpointMoreau", "Rk4", "Rk4Impact"]);
    vary("latency", " ms", "plant.latency_ticks", &["1", "2", "3", "4"]);
    vary("stale ticks, probability", "", "plant.stale_probability", &["0.2", "0.5"]);
    vary("friction", "", "plant.friction", &["0.4", "0.3", "0.2", "0.15", "0.08"]);
    vary("payload", " kg", "plant.payload_kg", &["1", "2", "3", "4", "6"]);
    vary("encoder", " bit", "plant.encoder_bits", &["18", "16", "15", "14", "13"]);
    vary("torque limit", " N·m", "plant.torque_limit", &["25", "20", "16", "14", "12.5", "12"]);
    vary("drive inertia", " kg·m²", "plant.drive_inertia", &["0", "0.01", "0.03", "0.3", "0.5"]);
    vary("joint damping", " N·m·s", "plant.joint_damping", &["0.2", "0.5"]);
    vary("speed", " m/s", "controller.speed", &["-0.3", "-0.1", "0.1", "0.3"]);
    vary("observer of the CoG", " 1/s", "controller.com_feedback", &["5", "10", "40"]);
    cases.push(case("control 250 Hz", "walk", &["rate=250"]));
    cases.push(case("control 500 Hz", "walk", &["rate=500"]));
    cases.push(case("control 2000 Hz", "walk", &["rate=2000", "plant.dt=0.0005"]));
    cases.push(case("relay", "walk", &["controller.switching=relay"]));
    cases.push(case("joint rates ≤ 4 rad/s in the QP", "walk", &["controller.rate_limit=4"]));
    cases.push(case("no drive inertia, 1 ms late", "walk", &["plant.drive_inertia=0", "plant.latency_ticks=1"]));
    cases.push(case(
        "no drive inertia, a number for each joint (control)",
        "walk",
        &["plant.drive_inertia=0", "controller.nominal_inertia=diagonal"],
    ));
    cases.push(case("the paper's sagittal rule", "walk-literal", &[]));
    cases.push(case("the paper, all at once", "paper", &[]));
    cases.push(case("without feedback from the robot (control)", "walk", &["controller.com_feedback=0"]));
    cases.push(case(
        "without that and without foot placement (control)",
        "walk",
        &["controller.com_feedback=0", "controller.foot_placement_gain=0"],
    ));
    cases.push(case(
        "all at once: 1 ms late, 16 bit, μ 0.4, 1 kg off centre, 25 N·m",
        "walk",
        &[
            "plant.latency_ticks=1",
            "plant.encoder_bits=16",
            "plant.friction=0.4",
            "plant.payload_kg=1",
            "plant.payload_offset=[0.03, 0.02, 0.1]",
            "plant.torque_limit=25",
        ],
    ));
    for (scene, name) in [("walk", "walking"), ("stamp", "stamping")] {
        for (direction, impulse) in [("forward", [2, 0]), ("backward", [-2, 0]), ("left", [0, 2]), ("right", [0, -2])] {
            for eighth in 0..8 {
                let time = 8.0 + 0.6 * f64::from(eighth) / 8.0;
                cases.push(case(
                    format!("2 N·s {direction} at {eighth}/8 of a period, {name}"),
                    scene,
                    &[
                        "duration=14",
                        &format!("plant.push_impulse=[{}.0, {}.0, 0.0]", impulse[0], impulse[1]),
                        &format!("plant.push_time={time}"),
                    ],
                ));
            }
        }
    }
    cases
}

fn laws() -> Vec<StudyCase> {
    let under = |law: Law, name: &str, scene: &'static str, settings: &[&str]| {
        case(format!("{name}, {law}"), scene, &[settings, &[&format!("plant.law={law}")]].concat())
    };
    let each = |name: &str, scene: &'static str, settings: &[&str]| -> Vec<StudyCase> {
        [Law::EnergyQp, Law::Complementarity, Law::Aligned, Law::Cone]
            .map(|law| under(law, name, scene, settings))
            .into()
    };
    [
        Law::ALL.map(|law| under(law, "walk 14 s", "walk", &[])).into(),
        each("walk 110 s", "walk", &["duration=110"]),
        each("walk 14 s, dt 0.25 ms", "walk", &["plant.dt=0.00025"]),
        each("stamp 60 s", "stamp", &[]),
        each("slide at 1 m/s", "slide", &["initial.velocity=[1.0, 0.0, 0.0]"]),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn attraction() -> Vec<StudyCase> {
    let mut cases = Vec::new();
    for gain in ["4.0", "0.0"] {
        for start in ["0.030", "0.034", "0.0388", "0.041", "0.044"] {
            cases.push(case(
                format!("k_E = {gain}, released at x_2 = {start} m"),
                "stamp",
                &[
                    "duration=11", // the last 20 periods, which are averaged, begin after more than 8 steps
                    &format!("controller.energy_gain={gain}"),
                    &format!("controller.release_x2={start}"),
                ],
            ));
        }
    }
    cases
}

fn endurance() -> Vec<StudyCase> {
    vec![
        case("walk 110 s", "walk", &["duration=110"]),
        case("walk 600 s", "walk", &["duration=600"]),
        case("stamp 600 s", "stamp", &["duration=600"]),
        case("the paper's sagittal rule 110 s", "walk-literal", &["duration=110"]),
    ]
}
