//! A scene: what is simulated, how, and with which controller. TOML in, checked values out.
//!
//! Every field's comment is what `biped list --keys` prints, so it says meaning and unit.

mod defaults;

pub use crate::law::{Iteration, Law};
use crate::robot::Body;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Everything that a run needs to know, the same for plant and controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// One sentence for `biped list`.
    pub description: String,
    /// Simulated time [s].
    pub duration: f64,
    /// Rate of control, encoders and recording [Hz]; a whole number of plant steps must fit into one period.
    pub rate: f64,
    /// The simulated robot and its ground.
    pub plant: PlantScene,
    /// What happens to commands on their way to the plant.
    #[serde(skip_serializing_if = "LinkScene::is_perfect")]
    pub link: LinkScene,
    /// State at time zero.
    pub initial: Initial,
    /// The walking controller; absent: nothing drives the joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerScene>,
    /// Robot: a TOML or URDF file, its path being relative to the scene's; what the scene leaves out follows from it by dynamic
    /// similarity. Beside `bodies` it is but their name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Bodies, the base being the one without a joint; absent: the robot of the paper's Table 1.
    pub bodies: Vec<Body>,
}

/// How the plant simulates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlantScene {
    /// Integration step [s].
    pub dt: f64,
    /// Coordinates of the base.
    pub base: Base,
    /// Contact law.
    pub law: Law,
    /// Greatest residual that a contact law with a complementary basis (`Aligned`, `Complementarity`, `EnergyQp`, `EnergyQpGap`) may leave in
    /// a step, relative to the step's scale. Beyond it the run ends and writes the contact problem to a file for `biped contact`. The other
    /// laws flag such a step as a fallback and go on [-].
    pub tolerance: f64,
    /// Integration method.
    pub method: Method,
    /// Error that `StepDoubling` and `EventDriven` allow themselves in a step, relative to 1 + |x| [-].
    pub tolerance_step: f64,
    /// Gravity [m/s²].
    pub gravity: f64,
    /// Slope of the ground, downhill along x, made by tilting gravity [deg].
    pub incline_deg: f64,
    /// Coulomb friction coefficient of the ground [-].
    pub friction: f64,
    /// Newton's coefficient of restitution: what lands at v_N leaves with at least -e v_N, or less where friction would make energy of that; 0:
    /// contact is plastic. Of the methods `SemiImplicitEuler`, `MidpointContact`, `StepDoubling`, `Rk4Impact`, `EventDriven` [-].
    pub restitution: f64,
    /// Stiffness of a contact point under the law `SpringDamper` [N/m].
    pub contact_stiffness: f64,
    /// Damping of a contact point under the law `SpringDamper`, 1 being critical [-].
    pub contact_damping_ratio: f64,
    /// Drive inertia reflected at each joint, J_r; absent in a scene with bodies of its own and no controller: 0 [kg·m²].
    pub drive_inertia: f64,
    /// Viscous damping of each joint, D [N·m·s/rad].
    pub joint_damping: f64,
    /// Greatest torque that a drive gives [N·m].
    pub torque_limit: f64,
    /// Encoder resolution: counts per turn are 2 to this power [bit].
    pub encoder_bits: u32,
    /// Delay between a torque command and its effect [control periods].
    pub latency_ticks: u32,
    /// Probability that a control period keeps the torques of the one before [-].
    pub stale_probability: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Mass added to a body [kg].
    pub payload_kg: f64,
    /// Where the added mass sits, in the body's frame [m].
    pub payload_offset: [f64; 3],
    /// Body that carries the added mass; empty: the base.
    pub payload_body: String,
    /// Impulse of a push, spread over its duration, in W [N·s].
    pub push_impulse: [f64; 3],
    /// Start of the push [s].
    pub push_time: f64,
    /// Duration of the push [s].
    pub push_duration: f64,
    /// Body whose centre of mass is pushed; empty: the base.
    pub push_body: String,
}

/// What happens to commands on their way to the plant. By default nothing: they arrive in the period that they answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LinkScene {
    /// Delay of every command; it acts from the first control period that begins at or after its arrival [ms].
    pub delay_ms: f64,
    /// Greatest additional delay (uniform), its standard deviation (normal), or that within a burst [ms].
    pub jitter_ms: f64,
    /// How the additional delay is distributed.
    pub jitter: Jitter,
    /// Probability that a command never arrives [-].
    pub loss: f64,
    /// Probability that a command arrives a second time, delayed anew [-].
    pub duplicate: f64,
    /// Probability that a command comes one control period later than it would, behind its successor [-].
    pub reorder: f64,
    /// Seed of all of that.
    pub seed: u64,
}

/// Distribution of the additional delay of a command, independent of others but for bursts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Jitter {
    /// Uniform between 0 and `jitter_ms`.
    #[default]
    Uniform,
    /// Normal with the standard deviation `jitter_ms` about `delay_ms`; what would come before it was sent is mirrored.
    Normal,
    /// `jitter_ms` within bursts and none outside: one begins .5 s after the last has ended and lasts .05 s on average, both
    /// exponentially distributed (Gilbert's two-state chain).
    Burst,
}

impl Jitter {
    /// Every distribution.
    pub const ALL: [Jitter; 3] = [Jitter::Uniform, Jitter::Normal, Jitter::Burst];
}

impl LinkScene {
    /// Whether every command arrives at once, once and in order.
    pub fn is_perfect(&self) -> bool {
        *self == LinkScene::default()
    }
}

/// State at time zero. The base pose is that of the base body's frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Initial {
    /// Position of the base in W [m].
    pub position: [f64; 3],
    /// If given, the base is lifted or lowered until the lowest contact point is this far above the ground [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<f64>,
    /// Roll, pitch and yaw of the base, applied as yaw, then pitch, then roll [deg].
    pub orientation_deg: [f64; 3],
    /// Velocity of the base in W [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity of the base in W [rad/s].
    pub angular_velocity: [f64; 3],
    /// Joint angles, in the order of the bodies that carry them; absent: zeros [rad or m].
    pub joints: Vec<f64>,
    /// Joint rates, likewise [rad/s or m/s].
    pub joint_rates: Vec<f64>,
}

/// The paper's controller and every choice that it leaves open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ControllerScene {
    /// What the robot does after standing up.
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
    /// Distance x_2 of the centre of gravity from the support foot at which the first step is released; absent: on the
    /// orbit of the reference energy (40) [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_x2: Option<f64>,
    /// Energy gain k_E of (39) in the lateral plane [1/s].
    pub energy_gain: f64,
    /// How the sagittal plane is stabilised.
    pub sagittal: Sagittal,
    /// Foot placement gain, 1 being dead-beat [-].
    pub foot_placement_gain: f64,
    /// Energy gain of (42) in the sagittal plane, for the paper's own rule [1/s].
    pub sagittal_energy_gain: f64,
    /// Rate at which the planner's pendulums follow the measured centre of gravity, the pole of their observers; 0: they do not look at the
    /// robot [1/s].
    pub com_feedback: f64,
    /// Task gain K_p of (30) for the centre of gravity and the trunk [1/s].
    pub com_gain: f64,
    /// Task gain K_p of (30) for the swing foot [1/s].
    pub swing_gain: f64,
    /// Bound on each joint rate in the QP (28)-(29); absent: the closed form without bounds [rad/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_limit: Option<f64>,
    /// Bound on each servo's torque, turned into rate bounds of the QP; absent: none [N·m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_bound: Option<f64>,
    /// Switching of the sliding mode: inside a boundary layer, or the true relay.
    pub switching: Switching,
    /// Inverse of the switching time, 1/T_s of (24) [1/s].
    pub switch_rate: f64,
    /// Bandwidth g of the disturbance observer, S(s) = s/(s + g) [rad/s].
    pub observer_bandwidth: f64,
    /// Cut-off of the low-pass on the encoder difference [Hz].
    pub rate_filter_hz: f64,
    /// Feed gravity and the planned acceleration forward.
    pub feed_forward: bool,
}

/// Coordinates of the base: as few degrees of freedom as the scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Base {
    /// Bolted to the world: none.
    Fixed,
    /// Forward, up and pitch: three.
    Planar,
    /// The paper's virtual joints x, y, z, yaw, pitch, roll: six.
    Virtual,
    /// Position and unit quaternion, velocities in W: six, without a singularity; the default.
    Quaternion,
}

/// Integration methods: how a step of `dt` goes from one state to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Method {
    /// Position with the old velocity. First order, and it gains energy: here to be seen failing.
    ExplicitEuler,
    /// Velocity first, position with the new velocity: the paper's. First order.
    SemiImplicitEuler,
    /// Moreau-Jean, theta = 1/2: forces and velocities are means over the step, contact acts at its end. Second order.
    MoreauJean,
    /// All forces at half a step's travel, position by half steps of old and new velocity. Second order, one evaluation.
    MidpointMoreau,
    /// The midpoint rule with the contact law at the end of the step, landings at their own time, springs and dampers implicit. Second
    /// order where contact lasts, rolls, turns and lands; it makes no energy.
    MidpointContact,
    /// Runge-Kutta of fourth order for the free motion, contact as one impulse at the end of the step.
    Rk4,
    /// Runge-Kutta of fourth order with the contact forces in every stage; a step is split at impact and at the end of slip.
    Rk4Impact,
    /// The implicit midpoint rule, contact included, iterated to rounding. Second order, symmetric in time.
    ImplicitMidpoint,
    /// `MidpointContact` in steps as short as `tolerance_step` asks for: one step is compared with two half steps.
    StepDoubling,
    /// Dormand-Prince 8(5,3) with contact forces in every stage, steps by `tolerance_step`, events located: the reference.
    EventDriven,
}

impl Method {
    /// Every method, from simple to exact.
    pub const ALL: [Method; 10] = [
        Method::ExplicitEuler,
        Method::SemiImplicitEuler,
        Method::MoreauJean,
        Method::MidpointMoreau,
        Method::MidpointContact,
        Method::Rk4,
        Method::Rk4Impact,
        Method::ImplicitMidpoint,
        Method::StepDoubling,
        Method::EventDriven,
    ];

    /// Whether what lands can bounce: it finds the landing, or stops it at the end of the step.
    pub fn bounces(self) -> bool {
        match self {
            Method::SemiImplicitEuler | Method::MidpointContact | Method::StepDoubling => true,
            Method::Rk4Impact | Method::EventDriven => true,
            Method::ExplicitEuler | Method::MoreauJean | Method::MidpointMoreau => false,
            Method::Rk4 | Method::ImplicitMidpoint => false,
        }
    }

    /// Whether its steps are as short as `tolerance_step` asks for.
    pub fn chooses_steps(self) -> bool {
        matches!(self, Method::StepDoubling | Method::EventDriven)
    }
}

/// What the controller makes the robot do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gait {
    /// Stand on both feet.
    Stand,
    /// Step in place, or walk when `speed` is not zero.
    Walk,
}

/// Rule that stabilises the sagittal plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sagittal {
    /// Put the foot where the predicted state at touchdown asks for it.
    FootPlacement,
    /// The paper's: mirror the foot about the centre of gravity, x_t1 = 2 x_c1, and control the energy E_1 by (42).
    Energy,
}

/// Switching element of the sliding mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Switching {
    /// Proportional within one switching period's reach of the surface.
    BoundaryLayer,
    /// The sign of the surface, full amplitude.
    Relay,
}
