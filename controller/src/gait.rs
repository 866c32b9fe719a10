//! The top level: what the centre of gravity and the swing foot are to do next, 3.3 of the paper.
//!
//! ```text
//!   stand → sway → lift → walk (exchange, exchange, …) → land → rest
//! ```
//! In *walk* both axes are pendulums (31), (32), whose states follow the measured centre of gravity: `gait/observer.rs`. The lateral
//! one is held on its orbit by the energy rule (39) and sets the time of the steps: `gait/lateral.rs`. The sagittal one is stabilised by
//! where the foot lands and by the ankle, `gait/placement.rs`, or by the paper's energy rule (42): `gait/stepping.rs`. The change of
//! support: `gait/exchange.rs`. All other phases: `gait/phases.rs`.

mod exchange;
mod lateral;
mod observer;
mod phases;
mod placement;
mod stepping;

use crate::constants::Constants;
use crate::pendulum::{PendulumState, Propagator, lateral_energy, sagittal_energy, turning_point};
use crate::scaled_parameters::ScaledParameters;
use crate::support::{Chain, Task, TaskVector};
use crate::swing::{MinimumJerkState, SwingHeight};
use lateral::OrbitLimits;
use messages::scene::{ControllerScene, Gait};
use observer::Observer;

/// What the robot is doing; the order is that of [`messages::wire::PHASES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Still, both feet down.
    Stand,
    /// The centre of gravity moves over the first support, both feet down.
    Sway,
    /// The swing foot leaves the ground.
    Lift,
    /// Stepping.
    Walk,
    /// Both feet down, coming to rest.
    Land,
    /// Still again.
    Rest,
}

/// Shares of the sole's half-depth and half-width within which the plan puts the zero-moment point: what is left is for the servos [-].
const ZMP_SHARE: [f64; 2] = [0.85, 0.9];

/// Constants of a gait.
#[derive(Clone, Debug)]
pub struct GaitModel {
    scene: ControllerScene,
    omega: [f64; 2],
    /// γ of the sagittal pendulum [-].
    swing_coupling: f64,
    /// W_2 [m].
    width: f64,
    /// One control period of each pendulum.
    propagator: [Propagator; 2],
    observer: Observer,
    /// By how much the joints come later than their rates are asked for [s].
    lag: f64,
    /// E_1 by (42) for a step of 1 m [m²/s²].
    unit_energy: f64,
    orbit_limits: OrbitLimits,
    /// Speed of the steady gait at touchdown per step length, c_v [1/s].
    touchdown_speed: f64,
    /// K: by how much farther the foot lands per deviation of the speed at touchdown [s].
    placement_gain: f64,
    /// How far from the sole's centre the plan puts the zero-moment point [m].
    zmp_range: [f64; 2],
    lift: SwingHeight,
    /// x_2 at which the first step is released [m].
    release: f64,
    pub(crate) parameters: ScaledParameters,
    /// Control period [s].
    h: f64,
}

/// State of a gait, in the support frame S.
#[derive(Clone, Copy, Debug)]
pub struct GaitState {
    /// What the robot is doing.
    pub phase: Phase,
    /// Time in this phase, or since the last exchange [s].
    pub since: f64,
    /// Time since the controller began [s].
    pub time: f64,
    /// Exchanges of support so far.
    pub steps: u64,
    /// x_c1 and x_c2: as planned, and when stepping as observed [m].
    pub com: [MinimumJerkState; 2],
    /// x_c3 as planned [m].
    pub height: f64,
    /// x_t1 as planned [m].
    pub foot: MinimumJerkState,
    /// x_t1 at which the foot is wanted to land [m].
    pub landing: f64,
    /// Step length W_1 in force [m].
    pub(crate) step: f64,
    /// What the last steps taught.
    pub(crate) corrections: Corrections,
}

/// Corrections learned from step to step: what model and landing do not give exactly.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Corrections {
    /// By how much landings overshoot [m].
    pub landing: f64,
    /// By how much longer steps are asked for, that they last as long as they should [s].
    pub time: f64,
    /// By how much longer steps are asked for, that they are as long as they should [m].
    pub step: f64,
}

/// What the lower levels are to do in this period.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// ẋ_ref of (30) [m/s, rad/s].
    pub xdot: TaskVector,
    /// Planned acceleration of the centre of gravity along axes 1 and 2 [m/s²].
    pub acceleration: [f64; 2],
    /// Share of the weight on the supporting foot [0…1].
    pub load: f64,
    /// Zero-moment point that the plan asks for: x_1 − (ẍ_1 − γ ẍ_t1)/ω_1² and x_2 − ẍ_2/ω_2² [m].
    pub zmp: [f64; 2],
}

impl GaitModel {
    /// The scene's gait on a robot with these constants, planned each `h` [s].
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
            width,
            propagator: omega.map(|omega| Propagator::new(omega, h)),
            observer: Observer::new(scene.com_feedback, h),
            lag: observer::lag(scene, h),
            unit_energy: sagittal_energy(omega[0], 1.0, period),
            orbit_limits: OrbitLimits::new(omega[1], width, period),
            touchdown_speed: omega[0] * (0.5 / quarter.tanh() - swing_coupling / quarter.sinh()),
            placement_gain: scene.foot_placement_gain / (omega[0] * (2.0 * quarter).tanh()),
            zmp_range: [0, 1].map(|k| ZMP_SHARE[k] * chain.sole_half[k]),
            lift: SwingHeight { height: scene.swing_height, reach: 0.5 * width - inner },
            release: scene.release_x2.unwrap_or(inner),
            parameters: chain.parameters,
            h,
        }
    }

    /// Standing as measured.
    pub fn start(&self, task: &Task) -> GaitState {
        GaitState {
            phase: Phase::Stand,
            since: 0.0,
            time: 0.0,
            steps: 0,
            com: [MinimumJerkState::at_rest(task.x[0]), MinimumJerkState::at_rest(task.x[1])],
            height: task.x[2],
            foot: MinimumJerkState::at_rest(task.x[3]),
            landing: task.x[3],
            step: 0.0,
            corrections: Corrections::default(),
        }
    }

    /// W_1 that the scene asks for [m].
    pub(crate) fn step_length(&self) -> f64 {
        0.5 * self.scene.speed * self.scene.period
    }

    /// Height of the swing foot that belongs to a place of the centre of gravity [m]. (43)
    pub(crate) fn height_at(&self, lateral: MinimumJerkState) -> f64 {
        self.lift.height_and_rate(lateral.x - 0.5 * self.width, 0.0).0
    }

    /// Time since the last exchange, on the orbit of the scene's period [s].
    pub(crate) fn since_exchange(&self, lateral: MinimumJerkState) -> f64 {
        (0.5 * self.scene.period - self.time_left(lateral)).max(0.0)
    }

    fn stopping(&self, state: &GaitState) -> bool {
        self.scene.stop_time.is_some_and(|stop| state.time >= stop)
    }

    /// Plans one period: advances the state and says what to do.
    pub fn plan(&self, state: &mut GaitState, task: &Task) -> Reference {
        self.change_phase(state);
        let [_, sway, _, land] = self.parameters.phases;
        let reference = match state.phase {
            Phase::Stand | Phase::Rest => self.hold(state, task),
            Phase::Sway => self.move_com(state, task, [0.0, self.release], sway),
            Phase::Lift => self.lift_foot(state, task),
            Phase::Walk => self.walk(state, task),
            Phase::Land => self.move_com(state, task, [0.5 * task.x[3], 0.5 * task.x[4]], land),
        };
        state.since += self.h;
        state.time += self.h;
        reference
    }

    fn change_phase(&self, state: &mut GaitState) {
        let [stand, sway, lift, land] = self.parameters.phases;
        let next = match state.phase {
            Phase::Stand if self.scene.gait == Gait::Walk && state.since >= stand && !self.stopping(state) => {
                Phase::Sway
            }
            Phase::Sway if state.since >= sway => Phase::Lift,
            Phase::Lift if state.since >= lift => Phase::Walk,
            Phase::Land if state.since >= land => Phase::Rest,
            _ => return,
        };
        state.phase = next;
        state.since = 0.0;
        for axis in &mut state.com {
            *axis = MinimumJerkState::at_rest(axis.x);
        }
    }

    /// (30): task rates that make the measured task follow the plan, the foot at the height and rate `lift` [m, m/s]. In *walk*
    /// the rates are asked for as much earlier as the servos are late.
    fn reference(&self, state: &mut GaitState, task: &Task, lift: [f64; 2], load: f64) -> Reference {
        let ScaledParameters { climb: fastest, climb_rate, .. } = self.parameters;
        let climb = (climb_rate * (self.scene.com_height - state.height)).clamp(-fastest, fastest);
        state.height += self.h * climb;
        let stepping = matches!(state.phase, Phase::Walk | Phase::Lift);
        let [sagittal, lateral] = state.com;
        let lag = if state.phase == Phase::Walk { self.lag } else { 0.0 };
        let ahead = |axis: MinimumJerkState| axis.v + lag * axis.a;
        let command = [sagittal.x, lateral.x, state.height, state.foot.x, self.width, lift[0], 0.0];
        let rate = [ahead(sagittal), ahead(lateral), climb, ahead(state.foot), 0.0, lift[1], 0.0];
        let (com, foot) = (self.scene.com_gain, self.scene.swing_gain);
        let gain = [com, com, com, foot, foot, foot, com];
        let xdot = TaskVector::from_fn(|k, _| {
            let held = !stepping && (3..6).contains(&k); // a foot on the ground stays where it is
            if held { 0.0 } else { gain[k] * (command[k] - task.x[k]) + rate[k] } // (30)
        });
        Reference { xdot, acceleration: [sagittal.a, lateral.a], load, zmp: self.zmp(state) }
    }

    /// E_1, E_2 of the plan by (33) [m²/s²].
    pub fn energies(&self, state: &GaitState) -> [f64; 2] {
        std::array::from_fn(|k| PendulumState { x: state.com[k].x, v: state.com[k].v }.energy(self.omega[k]))
    }

    /// Their references by (42) and (40) [m²/s²].
    pub fn energy_references(&self, state: &GaitState) -> [f64; 2] {
        let period = self.scene.period + 2.0 * state.corrections.time;
        [self.unit_energy * state.step * state.step, lateral_energy(self.omega[1], self.width, period)]
    }
}
