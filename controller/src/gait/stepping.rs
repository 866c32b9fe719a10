//! One control period of *walk*: observed state, inputs of the two pendulums (31), (32), and height of the swing foot (43).

use super::model::{GaitModel, GaitState};
use super::reference::Reference;
use crate::pendulum::{PendulumState, Propagator, virtual_input};
use crate::scaled_parameters::ScaledParameters;
use crate::support::Task;
use crate::swing::MinimumJerkState;
use messages::scene::Sagittal;
use messages::wire::Phase;

/// Limit of the sagittal virtual input under the paper's rule [m/s²]. It prevents the drift that the paper calls flottage.
const INPUT_LIMIT: f64 = 0.5;

impl GaitModel {
    /// One control period of *walk*.
    pub(super) fn walk(&self, state: &mut GaitState, task: &Task, load: f64) -> Reference {
        self.observe(state, task); // (25)
        let left = self.time_left(state.com[1]);
        let u_2 = self.lateral_input(state); // (39)
        let u_1 = match self.scene.sagittal {
            Sagittal::FootPlacement => {
                let zmp = self.place_foot(state, left);
                self.swing_coupling * state.foot.a - self.omega[0].powi(2) * zmp
            }
            Sagittal::Energy => self.mirror_foot(state, left), // (42)
        };
        let [sagittal, lateral] = state.com;
        state.com = [pendulum(sagittal, &self.propagator[0], u_1), pendulum(lateral, &self.propagator[1], u_2)]; // (31), (32)
        let outward = state.com[1].x - 0.5 * self.width;
        let (height, rate) = self.swing_height.height_and_rate(outward, state.com[1].v); // (43)
        let higher = 1.0 + state.urgency;
        let lift = self.above_ground(state, task, load, [height * higher, rate * higher]);
        self.reference(state, task, lift, 1.0)
    }

    /// Corrects the plan by the measured centre of gravity. Under the paper's sagittal rule (42) axis 1 is not corrected: the foot
    /// that mirrors the centre of gravity is still moving when it lands, and the resulting jump of the measured speed would make
    /// the robot fall.
    pub(super) fn observe(&self, state: &mut GaitState, task: &Task) {
        let axes = match self.scene.sagittal {
            Sagittal::FootPlacement => 0..2,
            Sagittal::Energy => 1..2,
        };
        let observer = if state.phase == Phase::Rest { &self.resting_observer } else { &self.observer };
        for k in axes {
            let axis = &mut state.com[k];
            let innovation = task.x[k] - axis.x;
            axis.x += observer.position * innovation;
            axis.v += observer.rate * innovation;
        }
    }

    /// The paper's sagittal rule: the centre of gravity stays halfway between the feet, x_t1 = 2 x_c1, and u_1 controls the energy
    /// that belongs to the step length.
    fn mirror_foot(&self, state: &mut GaitState, left: f64) -> f64 {
        let [energy, _] = self.energies(state);
        let [reference, _] = self.energy_references(state);
        let ScaledParameters { fading, starting, .. } = self.parameters;
        let [sagittal, _] = state.com;
        let propagator = Propagator::new(self.omega[0], left);
        state.landing = 2.0 * PendulumState { x: sagittal.x, v: sagittal.v }.propagated(&propagator, 0.0).x;
        state.foot = MinimumJerkState { x: 2.0 * sagittal.x, v: 2.0 * sagittal.v, a: 2.0 * sagittal.a };
        if sagittal.v.abs() < starting {
            return INPUT_LIMIT.copysign(state.step) * f64::from(state.step != 0.0); // start from rest
        }
        virtual_input(self.scene.sagittal_energy_gain, reference - energy, sagittal.v, fading, INPUT_LIMIT)
    }
}

/// One period of ẍ = ω²x + u.
pub(super) fn pendulum(now: MinimumJerkState, period: &Propagator, u: f64) -> MinimumJerkState {
    let next = PendulumState { x: now.x, v: now.v }.propagated(period, u);
    MinimumJerkState { x: next.x, v: next.v, a: period.omega * period.omega * next.x + u }
}
