//! The top level: what the centre of gravity and the swing foot are to do next, 3.3 of the paper.
//!
//! ```text
//!   stand → sway → lift → walk (exchange, exchange, …) → land → rest
//! ```
//! In *walk* both axes are pendulums (31), (32). The lateral one is held on its orbit by the energy rule (39) and beats
//! the time; the sagittal one is stabilised by where the foot lands, or by the paper's energy rule (42): `gait/stepping.rs`. The
//! change of support: `gait/exchange.rs`.

mod exchange;
mod stepping;

use crate::constants::Constants;
use crate::measures::Measures;
use crate::pendulum::{Flow, Motion, lateral_energy, sagittal_energy, turning_point};
use crate::support::{Chain, Task, TaskVector};
use crate::swing::{Lift, Travel};
use messages::scene::{ControllerScene, Gait};

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
    flow: [Flow; 2],
    /// E_1 by (42) for a step of 1 m, and E_2 by (40) [m²/s²].
    energy: [f64; 2],
    /// Speed of the steady gait at touchdown per step length, c_v [1/s].
    touchdown_speed: f64,
    /// K: by how much farther the foot lands per deviation of the speed at touchdown [s].
    placement_gain: f64,
    lift: Lift,
    /// x_2 at which the first step is released [m].
    release: f64,
    pub(crate) measures: Measures,
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
    /// x_c1 and x_c2 as planned [m].
    pub com: [Travel; 2],
    /// x_c3 as planned [m].
    pub height: f64,
    /// x_t1 as planned [m].
    pub foot: Travel,
    /// x_t1 at which the foot is wanted to land [m].
    pub landing: f64,
    /// Step length W_1 in force [m].
    pub(crate) step: f64,
    /// By how much the last landings overshot [m].
    pub(crate) trim: f64,
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
    /// Zero-moment point along axis 2 that the plan asks for, x_2 − ẍ_2/ω_2² [m].
    pub zmp: f64,
    /// Time until the next exchange, if stepping [s].
    pub time_left: Option<f64>,
}

impl GaitModel {
    /// The scene's gait on a robot with these constants, planned each `h` [s].
    pub fn new(scene: &ControllerScene, chain: &Chain, constants: &Constants, h: f64) -> Self {
        let width = chain.leg_width();
        let (omega, period) = (constants.omega, scene.period);
        let inner = turning_point(omega[1], width, period);
        let swing_coupling = if period > chain.measures.slow { 0.0 } else { 0.3 * constants.swing_coupling };
        let quarter = 0.25 * omega[0] * period;
        GaitModel {
            scene: scene.clone(),
            omega,
            swing_coupling,
            width,
            flow: omega.map(|omega| Flow::new(omega, h)),
            energy: [sagittal_energy(omega[0], 1.0, period), lateral_energy(omega[1], width, period)],
            touchdown_speed: omega[0] * (0.5 / quarter.tanh() - swing_coupling / quarter.sinh()),
            placement_gain: scene.foot_placement_gain / (omega[0] * (2.0 * quarter).tanh()),
            lift: Lift { height: scene.swing_height, reach: 0.5 * width - inner },
            release: scene.release_x2.unwrap_or(inner),
            measures: chain.measures,
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
            com: [Travel::at(task.x[0]), Travel::at(task.x[1])],
            height: task.x[2],
            foot: Travel::at(task.x[3]),
            landing: task.x[3],
            step: 0.0,
            trim: 0.0,
        }
    }

    /// W_1 that the scene asks for [m].
    pub(crate) fn step_length(&self) -> f64 {
        0.5 * self.scene.speed * self.scene.period
    }

    /// Height of the swing foot that belongs to a place of the centre of gravity [m]. (43)
    pub(crate) fn height_at(&self, lateral: Travel) -> f64 {
        self.lift.height_and_rate(lateral.x - 0.5 * self.width, 0.0).0
    }

    /// Time since the last exchange, on the orbit of the scene's period [s].
    pub(crate) fn since_exchange(&self, lateral: Travel) -> f64 {
        (0.5 * self.scene.period - self.time_left(lateral)).max(0.0)
    }

    fn stopping(&self, state: &GaitState) -> bool {
        self.scene.stop_time.is_some_and(|stop| state.time >= stop)
    }

    /// Plans one period: advances the state and says what to do.
    pub fn plan(&self, state: &mut GaitState, task: &Task) -> Reference {
        self.change_phase(state);
        let [_, sway, _, land] = self.measures.phases;
        let reference = match state.phase {
            Phase::Stand | Phase::Rest => self.hold(state, task),
            Phase::Sway => self.shift(state, task, [0.0, self.release], sway),
            Phase::Lift => self.raise(state, task),
            Phase::Walk => self.walk(state, task),
            Phase::Land => self.shift(state, task, [0.5 * task.x[3], 0.5 * task.x[4]], land),
        };
        state.since += self.h;
        state.time += self.h;
        reference
    }

    fn change_phase(&self, state: &mut GaitState) {
        let [stand, sway, lift, land] = self.measures.phases;
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
            *axis = Travel::at(axis.x);
        }
    }

    /// Where the weight has to be carried along axis 2 [m].
    fn zmp(&self, state: &GaitState) -> f64 {
        state.com[1].x - state.com[1].a / self.omega[1].powi(2) // (32)
    }

    /// Both feet down and still, or moving as planned.
    fn hold(&self, state: &mut GaitState, task: &Task) -> Reference {
        let load = 1.0 - self.zmp(state) / self.width;
        self.follow(state, task, 0.0, [0.0; 2], load.clamp(0.0, 1.0))
    }

    /// Both feet down, the centre of gravity on its way to `target` [m] since the phase began.
    fn shift(&self, state: &mut GaitState, task: &Task, target: [f64; 2], duration: f64) -> Reference {
        let left = duration - state.since;
        for (axis, target) in state.com.iter_mut().zip(target) {
            *axis = if left > self.measures.freeze { axis.toward(target, left, self.h) } else { Travel::at(axis.x) };
        }
        self.hold(state, task)
    }

    /// The weight leaves the swing foot, then the foot leaves the ground.
    fn raise(&self, state: &mut GaitState, task: &Task) -> Reference {
        let height = self.height_at(state.com[1]);
        let Measures { phases: [_, _, lift, _], unload, .. } = self.measures;
        let r = (state.since / lift).min(1.0);
        let rise = r.powi(3) * (10.0 - 15.0 * r + 6.0 * r * r); // least jerk
        let rate = 30.0 * r * r * (1.0 - r).powi(2) / lift;
        let load = 1.0 - state.com[1].x / self.width * (1.0 - state.since / unload).max(0.0);
        self.follow(state, task, height * rise, [0.0, height * rate], load.clamp(0.0, 1.0))
    }

    /// (30): task rates that make the measured task follow the plan.
    fn follow(&self, state: &mut GaitState, task: &Task, lift: f64, foot_rate: [f64; 2], load: f64) -> Reference {
        let Measures { climb: fastest, climb_rate, .. } = self.measures;
        let climb = (climb_rate * (self.scene.com_height - state.height)).clamp(-fastest, fastest);
        state.height += self.h * climb;
        let stepping = matches!(state.phase, Phase::Walk | Phase::Lift);
        let [sagittal, lateral] = state.com;
        let command = [sagittal.x, lateral.x, state.height, state.foot.x, self.width, lift, 0.0];
        let rate = [sagittal.v, lateral.v, climb, foot_rate[0], 0.0, foot_rate[1], 0.0];
        let (com, foot) = (self.scene.com_gain, self.scene.swing_gain);
        let gain = [com, com, com, foot, foot, foot, com];
        let xdot = TaskVector::from_fn(|k, _| {
            let held = !stepping && (3..6).contains(&k); // a foot on the ground stays where it is
            if held { 0.0 } else { gain[k] * (command[k] - task.x[k]) + rate[k] } // (30)
        });
        Reference { xdot, acceleration: [sagittal.a, lateral.a], load, zmp: self.zmp(state), time_left: None }
    }

    /// E_1, E_2 of the plan by (33) [m²/s²].
    pub fn energies(&self, state: &GaitState) -> [f64; 2] {
        std::array::from_fn(|k| Motion { x: state.com[k].x, v: state.com[k].v }.energy(self.omega[k]))
    }

    /// Their references by (42) and (40) [m²/s²].
    pub fn energy_references(&self, state: &GaitState) -> [f64; 2] {
        let [sagittal, lateral] = self.energy;
        [sagittal * state.step * state.step, lateral]
    }
}
