//! Rules for the values of a scene or a robot. Each rule contains the sentence of its error message.

use super::error::SceneError;
use super::magnitude::{MAX_MAGNITUDE, first_excess};
use crate::robot::{Body, DriveParameters, JointKind, Robot, require_biped_tree, require_few_joints};
use crate::scene::{ControllerScene, LinkScene, NominalInertia, Scene};
use crate::wire::JOINTS;
use crate::{legible, rounded_down};
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use toml::Value;

/// Longest run, of 32 years [s]. The time stamp of a message counts nanoseconds, and 64 bits hold 584 years.
const MAX_DURATION: f64 = 1e9;
/// Largest number of steps in a control period. The plant answers requests only between control periods.
const MAX_STEPS: f64 = 1e6;
/// Least tolerance for the error of a step, relative to 1 + |entry of the state| [-]. With less the steps would be as short as allowed.
const MIN_TOLERANCE_STEP: f64 = 1e-16;
/// Longest name of a robot, which may be the path of its file [characters].
const MAX_PATH: usize = 4096;
/// Longest name of a body [characters].
const MAX_NAME: usize = 100;
/// Longest description [bytes].
const MAX_DESCRIPTION: usize = 10_000;
/// Relative deviation from a whole number of steps that counts as rounding [-].
const STEP_ROUNDING: f64 = 1e-9;
/// Longest delay between a torque command and its effect [control periods].
const MAX_LATENCY_TICKS: u32 = 1000;
/// Longest delay and largest jitter of a command [ms].
const MAX_DELAY_MS: f64 = 1000.0;
/// Resolutions of encoders [bit]: 8 have 1.4° per count, and beyond 30 a count is finer than any encoder.
const ENCODER_BITS: RangeInclusive<u32> = 8..=30;
/// A slope with this incline is a wall [deg].
const VERTICAL_DEG: f64 = 90.0;
/// Shortest step of the gait [control periods].
const LEAST_STEP_PERIODS: f64 = 10.0;

/// Checks every value of a scene; `origin` names it in the error.
///
/// # Errors
/// [`SceneError::Invalid`] for the first value that cannot be simulated or controlled.
pub fn validate(scene: &Scene, origin: &str) -> Result<(), SceneError> {
    let check = Validator { origin };
    check.numbers(&scene.bodies)?;
    let table = Value::try_from(scene).map_err(|error| check.fail("scene", error, "it cannot be written as TOML"))?;
    check.finite(&table)?;
    check.names(scene.robot_name(), &scene.bodies)?;
    check.tree(&scene.bodies)?;
    check.description(&scene.description)?;
    check.timing(scene)?;
    check.plant(scene)?;
    check.link(&scene.link)?;
    check.bodies(&scene.bodies)?;
    check.initial(scene)?;
    scene.controller.as_ref().map_or(Ok(()), |controller| check.controller(scene, controller))
}

/// Checks every value of a robot; `origin` names it in the error. First of all it must be a trunk with two legs.
pub(super) fn robot(robot: &Robot, origin: &str) -> Checked {
    let check = Validator { origin };
    let no_biped = |reason| SceneError::Robot { origin: origin.into(), reason };
    require_few_joints(robot.bodies.iter().filter(|body| body.joint.is_some()).count()).map_err(no_biped)?;
    check.numbers(&robot.bodies)?;
    let table = Value::try_from(robot).map_err(|error| check.fail("robot", error, "it cannot be written as TOML"))?;
    check.finite(&table)?;
    check.names(&robot.name, &robot.bodies)?;
    check.tree(&robot.bodies)?;
    require_biped_tree(&robot.bodies).map_err(no_biped)?;
    let DriveParameters { inertia, damping, torque_limit, encoder_bits } = robot.drives;
    check.not_negative("drives.inertia", inertia.unwrap_or(0.0))?;
    check.not_negative("drives.damping", damping.unwrap_or(0.0))?;
    check.not_negative("drives.torque_limit", torque_limit.unwrap_or(1.0))?;
    check.encoder_bits("drives.encoder_bits", encoder_bits.unwrap_or(8))?;
    check.bodies(&robot.bodies)
}

/// Checks values; its errors name their origin.
pub(super) struct Validator<'a> {
    origin: &'a str,
}

pub(super) type Checked = Result<(), SceneError>;

impl Validator<'_> {
    fn fail(&self, key: &str, value: impl ToString, rule: impl Into<String>) -> SceneError {
        let value = value.to_string();
        let value = value.parse().map_or(value, legible);
        SceneError::Invalid { origin: self.origin.into(), key: key.into(), value, rule: rule.into() }
    }

    pub(super) fn require(&self, holds: bool, key: &str, value: impl ToString, rule: impl Into<String>) -> Checked {
        if holds { Ok(()) } else { Err(self.fail(key, value, rule)) }
    }

    pub(super) fn positive(&self, key: &str, value: f64) -> Checked {
        self.require(value > 0.0, key, value, "it must be greater than 0")
    }

    pub(super) fn not_negative(&self, key: &str, value: f64) -> Checked {
        self.require(value >= 0.0, key, value, "it must not be negative")
    }

    fn encoder_bits(&self, key: &str, bits: u32) -> Checked {
        let rule = format!("it must be {} to {}", ENCODER_BITS.start(), ENCODER_BITS.end());
        self.require(ENCODER_BITS.contains(&bits), key, bits, rule)
    }

    /// Checks that every number is finite and at most [`MAX_MAGNITUDE`]. The error names the path to the first one that is not.
    fn finite(&self, value: &Value) -> Checked {
        match first_excess(value) {
            Some((path, number)) => {
                let rule = format!("every number must be finite, and none beyond {MAX_MAGNITUDE:e}");
                Err(self.fail(&path, format!("{number:e}"), rule))
            }
            None => Ok(()),
        }
    }

    /// Checks names. They are printed without escaping, so they must not contain control characters. Lengths are limited because a scene
    /// is handed to other processes in an environment variable.
    fn names(&self, robot: &str, bodies: &[Body]) -> Checked {
        let plain = |key: &str, name: &str, limit: usize| {
            let good = name.chars().count() <= limit && !name.contains(char::is_control);
            let rule = format!("a name must have at most {limit} characters, and no control characters");
            self.require(good, key, format!("{:?}", beginning(name)), rule)
        };
        plain("name of the robot", robot, MAX_PATH)?;
        for (i, body) in bodies.iter().enumerate() {
            let key = format!("bodies.{i}.name");
            plain(&key, &body.name, MAX_NAME)?;
            self.require(!body.name.is_empty(), &key, "\"\"", "a body needs a name")?;
        }
        Ok(())
    }

    fn description(&self, text: &str) -> Checked {
        let rule = format!("a description must have at most {MAX_DESCRIPTION} bytes");
        self.require(text.len() <= MAX_DESCRIPTION, "description", format!("{:?}", beginning(text)), rule)
    }

    fn timing(&self, scene: &Scene) -> Checked {
        self.positive("duration", scene.duration)?;
        let rule = format!("it must be at most {MAX_DURATION:e} s");
        self.require(scene.duration <= MAX_DURATION, "duration", scene.duration, rule)?;
        self.positive("rate", scene.rate)?;
        self.positive("plant.dt", scene.plant.dt)?;
        let steps = 1.0 / (scene.rate * scene.plant.dt);
        let rule = format!("at most {MAX_STEPS} steps may fit into a control period of 1/{} s", legible(scene.rate));
        self.require(steps <= MAX_STEPS, "plant.dt", scene.plant.dt, rule)?;
        let whole = steps.round() >= 1.0 && (steps - steps.round()).abs() < STEP_ROUNDING * steps;
        let rule = format!(
            "a whole number of steps must fit into one control period of 1/{} s, not {}: try {}",
            legible(scene.rate),
            legible(steps),
            legible(1.0 / (scene.rate * steps.round().max(1.0))),
        );
        self.require(whole, "plant.dt", scene.plant.dt, rule)?;
        let periods = scene.duration * scene.rate;
        let rule = format!("it must be at least one control period of 1/{} s", legible(scene.rate));
        self.require(periods.round() >= 1.0, "duration", scene.duration, rule)
    }

    fn plant(&self, scene: &Scene) -> Checked {
        let plant = &scene.plant;
        self.positive("plant.tolerance", plant.tolerance)?;
        let tolerance = plant.tolerance_step;
        let rule = format!("it must be at least {MIN_TOLERANCE_STEP:e}, the rounding of a step");
        self.require(tolerance >= MIN_TOLERANCE_STEP, "plant.tolerance_step", tolerance, rule)?;
        self.not_negative("plant.gravity", plant.gravity)?;
        let tilt = plant.incline_deg;
        self.require(tilt.abs() < VERTICAL_DEG, "plant.incline_deg", tilt, "it must lie between -90 and 90")?;
        self.ground(&plant.ground)?;
        self.not_negative("plant.friction", plant.friction)?;
        let bounce = plant.restitution;
        self.require((0.0..=1.0).contains(&bounce), "plant.restitution", bounce, "it must lie between 0 and 1")?;
        self.positive("plant.contact_stiffness", plant.contact_stiffness)?;
        self.not_negative("plant.contact_damping_ratio", plant.contact_damping_ratio)?;
        self.not_negative("plant.drive_inertia", plant.drive_inertia)?;
        self.not_negative("plant.joint_damping", plant.joint_damping)?;
        self.not_negative("plant.torque_limit", plant.torque_limit)?;
        self.encoder_bits("plant.encoder_bits", plant.encoder_bits)?;
        let ticks = plant.latency_ticks;
        let rule = format!("it must be at most {MAX_LATENCY_TICKS}");
        self.require(ticks <= MAX_LATENCY_TICKS, "plant.latency_ticks", ticks, rule)?;
        let stale = plant.stale_probability;
        let rule = "a probability must lie between 0 and 1";
        self.require((0.0..=1.0).contains(&stale), "plant.stale_probability", stale, rule)?;
        self.not_negative("plant.payload_kg", plant.payload_kg)?;
        self.not_negative("plant.push_time", plant.push_time)?;
        self.positive("plant.push_duration", plant.push_duration)?;
        for (key, name) in [("plant.payload_body", &plant.payload_body), ("plant.push_body", &plant.push_body)] {
            self.known_body(&scene.bodies, key, name)?;
        }
        Ok(())
    }

    fn link(&self, link: &LinkScene) -> Checked {
        for (key, delay) in [("link.delay_ms", link.delay_ms), ("link.jitter_ms", link.jitter_ms)] {
            let rule = format!("it must lie between 0 and {MAX_DELAY_MS} ms");
            self.require((0.0..=MAX_DELAY_MS).contains(&delay), key, delay, rule)?;
        }
        for (key, share) in
            [("link.loss", link.loss), ("link.duplicate", link.duplicate), ("link.reorder", link.reorder)]
        {
            self.require((0.0..=1.0).contains(&share), key, share, "a probability must lie between 0 and 1")?;
        }
        Ok(())
    }

    fn initial(&self, scene: &Scene) -> Checked {
        let joints = scene.bodies.iter().filter(|body| body.joint.is_some()).count();
        let lists = [("initial.joints", &scene.initial.joints), ("initial.joint_rates", &scene.initial.joint_rates)];
        for (key, list) in lists {
            let rule = format!("it must be empty or have one value for each of the {joints} joints");
            self.require(list.is_empty() || list.len() == joints, key, format!("{list:?}"), rule)?;
        }
        self.initial_rotation(scene)?;
        let contacts = scene.bodies.iter().any(|body| body.contact_spheres().next().is_some());
        let clearance = scene.initial.clearance;
        let rule = "it needs a body with contact points or balls";
        self.require(clearance.is_none() || contacts, "initial.clearance", clearance.unwrap_or(0.0), rule)?;
        self.not_negative("initial.clearance", clearance.unwrap_or(0.0))
    }

    /// Checks that no body turns by more than half a turn in a step: it would appear to turn the other way. A method that chooses its
    /// own steps makes them short enough.
    fn initial_rotation(&self, scene: &Scene) -> Checked {
        if scene.plant.method.chooses_steps() {
            return Ok(());
        }
        let (dt, initial) = (scene.plant.dt, &scene.initial);
        let joints = scene.bodies.iter().filter_map(|body| body.joint.as_ref());
        let turning = joints.zip(&initial.joint_rates).filter(|(joint, _)| joint.kind == JointKind::Revolute);
        let fastest = turning.map(|(_, rate)| rate.abs()).fold(0.0, f64::max);
        let whole = initial.angular_velocity.iter().map(|part| part * part).sum::<f64>().sqrt();
        for (key, rate) in [("initial.angular_velocity", whole), ("initial.joint_rates", fastest)] {
            let rule = format!(
                "no body may turn by more than half a turn in a step of plant.dt = {dt} s: at most {} rad/s",
                legible(rounded_down(PI / dt))
            );
            self.require(rate * dt <= PI, key, format!("{rate:e}"), rule)?;
        }
        Ok(())
    }

    fn controller(&self, scene: &Scene, controller: &ControllerScene) -> Checked {
        let joints = scene.bodies.iter().filter(|body| body.joint.is_some()).count();
        let rule = format!("the walking controller needs a biped like that of Table 1, with {JOINTS} joints");
        self.require(joints == JOINTS, "number of joints", joints, rule)?;
        for (key, value) in [
            ("controller.period", controller.period),
            ("controller.com_height", controller.com_height),
            ("controller.com_gain", controller.com_gain),
            ("controller.swing_gain", controller.swing_gain),
            ("controller.switch_rate", controller.switch_rate),
            ("controller.rate_filter_hz", controller.rate_filter_hz),
            ("controller.release_x2", controller.release_x2.unwrap_or(1.0)),
            ("controller.rate_limit", controller.rate_limit.unwrap_or(1.0)),
            ("controller.torque_bound", controller.torque_bound.unwrap_or(1.0)),
        ] {
            self.positive(key, value)?;
        }
        for (key, value) in [
            ("controller.stop_time", controller.stop_time.unwrap_or(0.0)),
            ("controller.swing_height", controller.swing_height),
            ("controller.energy_gain", controller.energy_gain),
            ("controller.foot_placement_gain", controller.foot_placement_gain),
            ("controller.sagittal_energy_gain", controller.sagittal_energy_gain),
            ("controller.com_feedback", controller.com_feedback),
            ("controller.observer_bandwidth", controller.observer_bandwidth),
        ] {
            self.not_negative(key, value)?;
        }
        let bounded = controller.torque_bound.is_some();
        let rule = "it must be diagonal with controller.torque_bound, because the torque of a joint depends on all rates with a matrix";
        let matrix = controller.nominal_inertia() == NominalInertia::Matrix;
        self.require(!(bounded && matrix), "controller.nominal_inertia", "matrix", rule)?;
        let half = controller.period / 2.0;
        let rule = format!(
            "half of it, one step, must last at least {LEAST_STEP_PERIODS} control periods of 1/{} s",
            legible(scene.rate)
        );
        self.require(half * scene.rate >= LEAST_STEP_PERIODS, "controller.period", controller.period, rule)
    }
}

/// The beginning of a text, for an error message.
fn beginning(text: &str) -> String {
    const SHOWN: usize = 40;
    let cut = if text.chars().count() > SHOWN { "…" } else { "" };
    text.chars().take(SHOWN).collect::<String>() + cut
}
