//! Constants and state of the gait.

use super::observer::{Observer, RESTING_POLE, servo_lag};
use super::orbits::OrbitLimits;
use crate::constants::Constants;
use crate::pendulum::{PendulumState, Propagator, lateral_energy, sagittal_energy, turning_point};
use crate::scaled_parameters::ScaledParameters;
use crate::support::{Chain, Task};
use crate::swing::{MinimumJerkState, SwingHeight};
use messages::scene::ControllerScene;
use messages::wire::Phase;

/// Shares of the sole's half-depth and half-width within which the plan keeps the zero-moment point [-]. The rest of the sole, up to
/// `SOLE_SHARE` of `constants.rs`, is a margin for the torques of the servos.
const ZMP_SHARE: [f64; 2] = [0.85, 0.9];

/// Constants of a gait.
#[derive(Clone, Debug)]
pub struct GaitModel {
    /// With the period that is walked.
    pub(super) scene: ControllerScene,
    pub(super) omega: [f64; 2],
    /// γ of the sagittal pendulum [-].
    pub(super) swing_coupling: f64,
    /// Position of the zero-moment point along in the steady gait, d: `lean.rs` [m].
    pub(super) lean: f64,
    /// W_2 [m].
    pub(super) width: f64,
    /// One control period of each pendulum.
    pub(super) propagator: [Propagator; 2],
    pub(super) observer: Observer,
    /// The slower observer of phase *rest*.
    pub(super) resting_observer: Observer,
    /// Delay of the joint rates after their references [s].
    pub(super) servo_lag: f64,
    /// E_1 by (42) for a step of 1 m [m²/s²].
    pub(crate) unit_energy: f64,
    pub(super) orbit_limits: OrbitLimits,
    /// Speed of the centre of gravity at touchdown in the steady gait, per step length, c_v [1/s].
    pub(super) touchdown_speed: f64,
    /// K: shift of the landing position per deviation of the speed at touchdown [s].
    pub(super) placement_gain: f64,
    /// Largest distance of the planned zero-moment point from the sole's centre, along and across [m].
    pub(super) zmp_range: [f64; 2],
    pub(super) swing_height: SwingHeight,
    /// x_2 at which the first step is released [m].
    pub(super) release: f64,
    pub(crate) parameters: ScaledParameters,
    /// Control period [s].
    pub(super) h: f64,
}

/// State of a gait, in the support frame S.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct GaitState {
    /// Phase of the gait.
    pub phase: Phase,
    /// Time since the phase began or, in *walk*, since the last exchange [s].
    pub since: f64,
    /// Simulated time [s].
    pub time: f64,
    /// Whether the controller started within the step under way: `resume.rs`.
    pub(crate) resumed: bool,
    /// Number of exchanges of support so far.
    pub steps: u64,
    /// x_c1 and x_c2: planned, and in *walk* corrected by the observer [m].
    pub com: [MinimumJerkState; 2],
    /// Planned x_c3 [m].
    pub height: f64,
    /// Planned x_t1 [m].
    pub foot: MinimumJerkState,
    /// Planned landing position x_t1 [m].
    pub landing: f64,
    /// Height at which the swing foot touched the ground too early in this step: `touch.rs` [m].
    pub(crate) ground: Option<f64>,
    /// Share to which limits are widened because ξ_1 deviates from the steady gait: `deviation.rs` [-].
    pub(crate) urgency: f64,
    /// Present step length W_1 [m].
    pub(crate) step: f64,
    /// Corrections learned from the last steps.
    pub(crate) corrections: Corrections,
}

/// Corrections learned from step to step, because the model does not describe the landing exactly.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Corrections {
    /// Overshoot of the landing position [m].
    pub landing: f64,
    /// Added to the planned duration of a step, so that the true duration is right [s].
    pub time: f64,
    /// Added to the planned length of a step, so that the true length is right [m].
    pub step: f64,
}

impl GaitState {
    /// Share of the weight on a new supporting foot [-]: it rises from `first` to 1 within the time `time` [s] after an exchange.
    pub(crate) fn loaded(&self, first: f64, time: f64) -> f64 {
        let rising = self.phase == Phase::Walk && self.steps > 0;
        if rising { first + (1.0 - first) * (self.since / time).min(1.0) } else { 1.0 }
    }
}

impl GaitModel {
    /// The gait of a scene for a robot with these constants, planned once each control period `h` [s].
    pub fn new(scene: &ControllerScene, chain: &Chain, constants: &Constants, h: f64) -> Self {
        let width = chain.leg_width();
        let (omega, period) = (constants.omega, scene.period);
        let swing_coupling = constants.swing_coupling;
        let quarter = 0.25 * omega[0] * period;
        let inner = turning_point(omega[1], width, period);
        GaitModel {
            scene: scene.clone(),
            omega,
            swing_coupling,
            lean: constants.lean,
            width,
            propagator: omega.map(|omega| Propagator::new(omega, h)),
            observer: Observer::new(scene.com_feedback, h),
            resting_observer: Observer::new(RESTING_POLE * scene.com_feedback, h),
            servo_lag: servo_lag(scene, omega[1], h),
            unit_energy: sagittal_energy(omega[0], 1.0, period),
            orbit_limits: OrbitLimits::new(omega[1], width, period),
            touchdown_speed: omega[0] * (0.5 / libm::tanh(quarter) - swing_coupling / libm::sinh(quarter)),
            placement_gain: scene.foot_placement_gain / (omega[0] * libm::tanh(2.0 * quarter)),
            zmp_range: [0, 1].map(|k| ZMP_SHARE[k] * chain.sole_half[k]),
            swing_height: SwingHeight { height: scene.swing_height, reach: 0.5 * width - inner },
            release: scene.release_x2.unwrap_or(inner),
            parameters: chain.parameters,
            h,
        }
    }

    /// State of a robot that stands still in the measured posture, at a simulated time [s].
    pub fn start(&self, task: &Task, time: f64) -> GaitState {
        GaitState {
            phase: Phase::Stand,
            since: 0.0,
            time,
            resumed: false,
            steps: 0,
            com: [MinimumJerkState::at_rest(task.x[0]), MinimumJerkState::at_rest(task.x[1])],
            height: task.x[2],
            foot: MinimumJerkState::at_rest(task.x[3]),
            landing: task.x[3],
            ground: None,
            urgency: 0.0,
            step: 0.0,
            corrections: Corrections::default(),
        }
    }

    /// Step length W_1 of the scene [m].
    pub(crate) fn step_length(&self) -> f64 {
        0.5 * self.scene.speed * self.scene.period
    }

    /// Height of the swing foot for a lateral position of the centre of gravity [m]. Source: (43).
    pub(crate) fn height_at(&self, lateral: MinimumJerkState) -> f64 {
        self.swing_height.height_and_rate(lateral.x - 0.5 * self.width, 0.0).0
    }

    /// Time since the last exchange on the orbit of the scene's period [s].
    pub(crate) fn since_exchange(&self, lateral: MinimumJerkState) -> f64 {
        (0.5 * self.scene.period - self.time_left(lateral)).max(0.0)
    }

    pub(crate) fn stopping(&self, state: &GaitState) -> bool {
        self.scene.stop_time.is_some_and(|stop| state.time >= stop)
    }

    /// Time until the exchange, rounded up to whole control periods [s]. The exchange takes place in the first period that finds x_2
    /// beyond W_2/2.
    pub(super) fn time_left(&self, lateral: MinimumJerkState) -> f64 {
        let left =
            PendulumState { x: lateral.x, v: lateral.v }.time_to(0.5 * self.width, self.omega[1], self.scene.period);
        (left / self.h).ceil().max(1.0) * self.h
    }

    /// E_1, E_2 of the plan by (33) [m²/s²].
    pub fn energies(&self, state: &GaitState) -> [f64; 2] {
        let rest = [self.lean, 0.0];
        std::array::from_fn(|k| PendulumState { x: state.com[k].x - rest[k], v: state.com[k].v }.energy(self.omega[k]))
    }

    /// Reference values of E_1, E_2 by (42) and (40) [m²/s²].
    pub fn energy_references(&self, state: &GaitState) -> [f64; 2] {
        let period = self.scene.period + 2.0 * state.corrections.time;
        [self.unit_energy * state.step * state.step, lateral_energy(self.omega[1], self.width, period)]
    }
}
