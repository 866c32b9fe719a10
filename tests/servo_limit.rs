//! Claim: a joint of the simulated plant with a servo and a delayed link is unstable exactly where the eigenvalues of the sampled loop
//! predict it.

#![expect(clippy::expect_used, reason = "a test may panic")]

use controller::encoder::{EncoderModel, EncoderState};
use controller::servo::{ServoModel, ServoState};
use controller::stability::ServoLoop;
use controller::support::{JointMatrix, Joints};
use messages::load::parse;
use messages::scene::{ControllerScene, LinkScene, Method, Scene};
use messages::wire::{Command, Torques};
use plant::Plant;
use plant::inject::Injector;

/// A rotating wheel of .5 kg·m² on a fixed axle, without gravity.
const WHEEL: &str = r#"
[plant]
base = "fixed"
gravity = 0.0
drive_inertia = 0.0
encoder_bits = 30
torque_limit = 1e4
[initial]
joint_rates = [0.01]
[[bodies]]
name = "axle"
mass = 1.0
size = [0.1, 0.1, 0.1]
[[bodies]]
name = "wheel"
mass = 1.0
size = [0.1, 0.1, 0.1]
inertia = [0.5, 0.5, 0.5]
joint = { parent = "axle", axis = [0.0, 0.0, 1.0], at = [0.0, 0.0, 0.0] }
"#;
const INERTIA: f64 = 0.5;
const PERIODS: usize = 6000;

/// Speed of the wheel in each control period, until it is 20 times the initial one [rad/s].
fn speeds(scene: &Scene, settings: &ControllerScene, ratio: f64, delay: u32) -> Vec<f64> {
    let period = 1.0 / scene.rate;
    let mut plant = Plant::new(scene).expect("a good scene");
    let mut link =
        Injector::new(&LinkScene { delay_ms: 1e3 * period * f64::from(delay), ..LinkScene::default() }, period);
    let reader = EncoderModel::new(scene.plant.radians_per_count(), period, settings.rate_filter_hz);
    let servo = ServoModel::new(settings, JointMatrix::identity() * (ratio * INERTIA), period, 1.0);
    let (mut reading, mut state, mut newest) = (EncoderState::default(), ServoState::default(), Command::default());
    let (zero, limits) = (Joints::zeros(), [-1e3, 1e3].map(Joints::repeat));
    let mut speeds = Vec::new();
    let mut encoders = plant.encoders();
    for tick in 0..PERIODS as u64 {
        reader.read(&mut reading, &encoders);
        servo.observe(&mut state, &reading.rate);
        let (torque, _) = servo.drive(&mut state, &reading.rate, &zero, &zero, &limits, 1.0);
        link.push(tick, &Command { torques: Torques { torque: torque.into() }, ..Command::default() });
        while let Some(command) = link.pop(tick) {
            newest = command;
        }
        encoders = plant.advance(&newest.torques).expect("a period");
        let speed = plant.truth().rate[0];
        if speed.abs() > 0.2 {
            break;
        }
        speeds.push(speed);
    }
    speeds
}

/// Growth factor per control period, from the largest speeds in two long intervals. The second interval is the last one above the encoder
/// noise.
fn growth(speeds: &[f64]) -> f64 {
    let above_noise = speeds.iter().rposition(|speed| speed.abs() > 1e-3).unwrap_or(0) + 1;
    let stretch = above_noise / 3;
    let most = |part: &[f64]| part.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()));
    let (early, late) = (
        most(&speeds[above_noise - 2 * stretch..above_noise - stretch]),
        most(&speeds[above_noise - stretch..above_noise]),
    );
    (late / early).powf(1.0 / stretch as f64)
}

#[test]
fn the_servo_loop_is_unstable_exactly_where_its_eigenvalues_predict_it() {
    let (mut scene, settings) = (parse(WHEEL, "wheel").expect("a scene"), ControllerScene::default());
    let methods = [(Method::SemiImplicitEuler, 0.75), (Method::MidpointContact, 0.5)]; // the method of Euler has two steps in a control period
    let cases = methods.iter().flat_map(|of| [0.5, 1.0, 2.0, 2.5, 3.581, 6.0].map(|ratio| (*of, ratio)));
    for ((method, midpoint), ratio) in cases {
        scene.plant.method = method;
        let servo = ServoLoop {
            inertia_ratio: ratio,
            period: 1.0 / scene.rate,
            switch_rate: settings.switch_rate,
            observer_bandwidth: settings.observer_bandwidth,
            rate_filter_hz: settings.rate_filter_hz,
            midpoint,
        };
        let critical = servo.critical_delay();
        for delay in (0..30_u32).filter(|delay| (f64::from(*delay) - critical).abs() < 4.0) {
            let (speeds, radius) = (speeds(&scene, &settings, ratio, delay), servo.spectral_radius(f64::from(delay)));
            let has_grown = speeds.len() < PERIODS;
            // unstable loops grow by a factor of 20 within these periods; nearer to the limit the growth is measured below
            if (radius - 1.0).abs() * PERIODS as f64 > 20_f64.ln() {
                assert_eq!(has_grown, radius > 1.0, "ratio {ratio}, delay {delay}: spectral radius {radius}");
            }
            assert_eq!(radius > 1.0, f64::from(delay) > critical, "ratio {ratio}, delay {delay}: limit {critical}");
            // Near the limit, one slow oscillation dominates.
            if (f64::from(delay) - critical).abs() < 1.0 && (radius - 1.0).abs() < 0.01 {
                let growth = growth(&speeds);
                let off = (growth - radius).abs();
                assert!(off < 5e-4, "ratio {ratio}, delay {delay}: {growth} a period, spectral radius {radius}");
            }
        }
    }
}
