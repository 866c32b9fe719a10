//! A scene: the simulated robot, the method of simulation, and the controller, as in a TOML file.
//!
//! `biped list --keys` prints the comment of each field, so the comment gives meaning and unit.

mod choices;
mod defaults;
mod ground;

pub use crate::law::{Iteration, Law};
pub use choices::{Base, Gait, Jitter, Method, NominalInertia, Sagittal, Switching};
pub use defaults::steps_of_push;
pub use ground::{Ground, GroundTile, RandomTiles};

use crate::robot::Body;
use crate::wire::JOINTS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// All data of a run. Plant and controller use the same scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct Scene {
    /// One sentence that `biped list` prints.
    pub description: String,
    /// Simulated time [s].
    pub duration: f64,
    /// Rate of control, encoders and recording [Hz]; a whole number of plant steps must fit into one period.
    pub rate: f64,
    /// The simulated robot and its ground.
    pub plant: PlantScene,
    /// Disturbances of commands on their way to the plant.
    #[serde(skip_serializing_if = "LinkScene::is_perfect")]
    pub link: LinkScene,
    /// State at time zero.
    pub initial: Initial,
    /// The walking controller; absent: nothing drives the joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerScene>,
    /// Robot: a TOML or URDF file, by its path relative to the scene's file. Values that the scene leaves out are scaled to that robot by
    /// dynamic similarity. If the scene has `bodies`, this is only their name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Bodies. The base is the one without a joint; absent: the robot of the paper's Table 1.
    pub bodies: Vec<Body>,
}

/// The plant and the method of its simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct PlantScene {
    /// Integration step [s].
    pub dt: f64,
    /// Coordinates of the base.
    pub base: Base,
    /// Contact law.
    pub law: Law,
    /// Largest residual of a step for the contact laws with a complementary basis (`Aligned`, `Complementarity`, `EnergyQp`,
    /// `EnergyQpGap`), relative to the step's scale. If a step exceeds it, the run ends and writes the contact problem to a file for
    /// `biped contact`. The other laws flag such a step as a fallback and continue [-].
    pub tolerance: f64,
    /// Integration method.
    pub method: Method,
    /// Error tolerance of `StepDoubling` and `EventDriven` in a step, relative to 1 + |x| [-].
    pub tolerance_step: f64,
    /// Gravity [m/s²].
    pub gravity: f64,
    /// Slope of the ground, downhill along x. Gravity is tilted instead of the ground [deg].
    pub incline_deg: f64,
    /// Heights of the ground; absent: the plane z = 0.
    #[serde(skip_serializing_if = "Ground::is_default")]
    pub ground: Ground,
    /// Coulomb friction coefficient of the ground [-].
    pub friction: f64,
    /// Newton's coefficient of restitution e. A point that lands with v_N leaves with at least -e v_N, or with less where friction would
    /// otherwise create energy; 0: plastic contact. The methods `SemiImplicitEuler`, `MidpointContact`, `StepDoubling`, `Rk4Impact` and
    /// `EventDriven` support it [-].
    pub restitution: f64,
    /// Stiffness of a contact point under the law `SpringDamper` [N/m].
    pub contact_stiffness: f64,
    /// Damping ratio of a contact point under the law `SpringDamper`; 1 is critical damping [-].
    pub contact_damping_ratio: f64,
    /// Drive inertia reflected at each joint, J_r; absent in a scene with `bodies` and without a controller: 0 [kg·m²].
    pub drive_inertia: f64,
    /// Viscous damping of each joint, D [N·m·s/rad].
    pub joint_damping: f64,
    /// Torque limit of the drives [N·m].
    pub torque_limit: f64,
    /// Encoder resolution: 2 to this power counts per turn [bit].
    pub encoder_bits: u32,
    /// Delay between a torque command and its effect [control periods].
    pub latency_ticks: u32,
    /// Probability that a control period repeats the torques of the preceding one [-].
    pub stale_probability: f64,
    /// Seed of the plant's random numbers.
    pub seed: u64,
    /// Mass of a payload added to a body [kg].
    pub payload_kg: f64,
    /// Position of the payload in the body's frame [m].
    pub payload_offset: [f64; 3],
    /// Body that carries the payload; empty: the base.
    pub payload_body: String,
    /// Impulse of a push in W, spread evenly over its duration [N·s].
    pub push_impulse: [f64; 3],
    /// Start of the push [s].
    pub push_time: f64,
    /// Duration of the push [s].
    pub push_duration: f64,
    /// Body that is pushed, at its centre of mass with its payload; empty: the base.
    pub push_body: String,
}

impl PlantScene {
    /// Angle of one encoder count [rad].
    pub fn radians_per_count(&self) -> f64 {
        TAU / libm::exp2(f64::from(self.encoder_bits))
    }
}

/// Disturbances of commands on their way to the plant. By default there are none: a command acts in the period that it answers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct LinkScene {
    /// Delay of every command. A command acts from the first control period that begins at or after its arrival [ms].
    pub delay_ms: f64,
    /// Additional delay: its maximum (uniform), its standard deviation (normal), or its value within a burst (burst) [ms].
    pub jitter_ms: f64,
    /// Distribution of the additional delay.
    pub jitter: Jitter,
    /// Probability that a command never arrives [-].
    pub loss: f64,
    /// Probability that a command arrives a second time, with a delay of its own [-].
    pub duplicate: f64,
    /// Probability that a command arrives one control period later, after its successor [-].
    pub reorder: f64,
    /// Seed of these disturbances.
    pub seed: u64,
}

impl LinkScene {
    /// Whether every command arrives without delay, exactly once and in order.
    pub fn is_perfect(&self) -> bool {
        *self == LinkScene::default()
    }
}

/// State at time zero. Position and orientation of the base are those of the base body's frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct Initial {
    /// Position of the base in W [m].
    pub position: [f64; 3],
    /// If given, the base is moved vertically until the lowest contact point has this height above the ground [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<f64>,
    /// Roll, pitch and yaw of the base, applied as yaw, then pitch, then roll [deg].
    pub orientation_deg: [f64; 3],
    /// Velocity of the base in W [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity of the base in W [rad/s].
    pub angular_velocity: [f64; 3],
    /// Joint positions, in the order of the bodies; absent: zeros [rad or m].
    pub joints: Vec<f64>,
    /// Joint rates, in the same order; absent: zeros [rad/s or m/s].
    pub joint_rates: Vec<f64>,
}

impl Initial {
    /// Position of each joint in the order of the encoders [rad or m]; zero if it is not given, or if the robot has fewer joints.
    pub fn angles(&self) -> [f64; JOINTS] {
        std::array::from_fn(|k| self.joints.get(k).copied().unwrap_or(0.0))
    }
}

/// The paper's controller, with the parameters that the paper leaves open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct ControllerScene {
    /// Task after the start.
    pub gait: Gait,
    /// Period T of two steps [s].
    pub period: f64,
    /// Walking speed; the step length is W_1 = speed·T/2 [m/s].
    pub speed: f64,
    /// Time at which the robot begins to stop; absent: never [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_time: Option<f64>,
    /// Height of the centre of gravity above the sole, z_c [m].
    pub com_height: f64,
    /// Greatest height of the swing foot, h_max of (43) [m].
    pub swing_height: f64,
    /// Lateral position x_2 of the centre of gravity at which the first step begins; absent: the turning point of the orbit with the
    /// reference energy (40) [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_x2: Option<f64>,
    /// Energy gain k_E of (39) in the lateral plane [1/s].
    pub energy_gain: f64,
    /// Rule that stabilises the sagittal plane.
    pub sagittal: Sagittal,
    /// Foot placement gain; 1 removes a deviation in one step [-].
    pub foot_placement_gain: f64,
    /// Energy gain of (42) in the sagittal plane, for the rule `energy` [1/s].
    pub sagittal_energy_gain: f64,
    /// Pole of the observers by which the planned pendulums follow the measured centre of gravity; 0: the plan ignores the
    /// measurement [1/s].
    pub com_feedback: f64,
    /// Task gain K_p of (30) for the centre of gravity and the trunk [1/s].
    pub com_gain: f64,
    /// Task gain K_p of (30) for the swing foot [1/s].
    pub swing_gain: f64,
    /// Bound on each joint rate in the QP (28)-(29); absent: the closed form without bounds [rad/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_limit: Option<f64>,
    /// Bound on each servo's torque, converted to rate bounds of the QP; absent: none [N·m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_bound: Option<f64>,
    /// Nominal inertia J_n of the servos (23); absent: `matrix`, but `diagonal` with a `torque_bound`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal_inertia: Option<NominalInertia>,
    /// Switching element of the sliding mode.
    pub switching: Switching,
    /// Inverse of the switching time, 1/T_s of (24) [1/s].
    pub switch_rate: f64,
    /// Bandwidth g of the disturbance observer, S(s) = s/(s + g) [rad/s].
    pub observer_bandwidth: f64,
    /// Cut-off frequency of the low-pass filter of the encoder difference [Hz].
    pub rate_filter_hz: f64,
    /// Whether to feed forward gravity and the planned acceleration.
    pub feed_forward: bool,
}

impl ControllerScene {
    /// The nominal inertia of the servos. A bound on each torque bounds each rate only if J_n is diagonal.
    pub fn nominal_inertia(&self) -> NominalInertia {
        let implied = if self.torque_bound.is_some() { NominalInertia::Diagonal } else { NominalInertia::Matrix };
        self.nominal_inertia.unwrap_or(implied)
    }
}
