//! One period of stepping: energies (39), pendulums (31), (32), the swing foot (43), and where it lands.

use super::{GaitModel, GaitState, Reference};
use crate::measures::Measures;
use crate::pendulum::{Flow, Motion, virtual_input};
use crate::support::Task;
use crate::swing::Travel;
use messages::scene::Sagittal;

/// Limits of the sagittal and the lateral virtual input, against what the paper calls flottage [m/s²].
const INPUT_LIMIT: [f64; 2] = [0.5, 0.6];

impl GaitModel {
    /// One period of stepping.
    pub(super) fn walk(&self, state: &mut GaitState, task: &Task) -> Reference {
        self.feed_back(state, task);
        let [energy_1, energy_2] = self.energies(state);
        let [reference_1, reference_2] = self.energy_references(state);
        let [sagittal, lateral] = state.com;
        let Measures { fading, starting, .. } = self.measures;
        let u_2 = virtual_input(self.scene.energy_gain, reference_2 - energy_2, lateral.v, fading, INPUT_LIMIT[1]); // (39)
        let left = self.time_left(lateral);
        state.com[1] = pendulum(lateral, &self.flow[1], u_2); // (32)
        let lateral = state.com[1];
        let u_1 = match self.scene.sagittal {
            Sagittal::FootPlacement => {
                self.place_foot(state, left);
                self.swing_coupling * state.foot.a
            }
            Sagittal::Energy => {
                let flow = Flow::new(self.omega[0], left);
                state.landing = 2.0 * Motion { x: sagittal.x, v: sagittal.v }.after(&flow, 0.0).x;
                state.foot = Travel { x: 2.0 * sagittal.x, v: 2.0 * sagittal.v, a: 2.0 * sagittal.a };
                if sagittal.v.abs() < starting {
                    INPUT_LIMIT[0].copysign(state.step) * f64::from(state.step != 0.0) // leave the rest point
                } else {
                    let missing = reference_1 - energy_1;
                    virtual_input(self.scene.sagittal_energy_gain, missing, sagittal.v, fading, INPUT_LIMIT[0])
                }
            }
        };
        state.com[0] = pendulum(sagittal, &self.flow[0], u_1); // (31)
        let (height, rate) = self.lift.height_and_rate(lateral.x - 0.5 * self.width, lateral.v); // (43)
        let reference = self.follow(state, task, height, [state.foot.v, rate], 1.0);
        Reference { time_left: Some(left), ..reference }
    }

    /// Time until the exchange, in whole control periods: it comes with the first one that finds x_2 beyond W_2/2 [s].
    pub(super) fn time_left(&self, lateral: Travel) -> f64 {
        let left = Motion { x: lateral.x, v: lateral.v }.time_to(0.5 * self.width, self.omega[1], self.scene.period);
        (left / self.h).ceil().max(1.0) * self.h
    }

    /// Feeds the measured centre of gravity back into the plan.
    fn feed_back(&self, state: &mut GaitState, task: &Task) {
        for (axis, measured) in state.com.iter_mut().zip([task.x[0], task.x[1]]) {
            axis.x += self.scene.com_feedback * self.h * (measured - axis.x);
        }
    }

    /// Chooses where the foot lands from the predicted touchdown, and moves it on its way there.
    ///
    /// ```text
    ///   x_t1 = x_e + W_1/2 + K (v_e − v_ref),   K = k coth(ωT/2)/ω
    /// ```
    /// k = 1 ends a deviation in one step; k = 0 mirrors the foot about the centre of gravity and its step-to-step map
    /// has an eigenvalue of modulus 1: the robot falls. The prediction (x_e, v_e) holds the foot's own effect γ ẍ_t, in
    /// which x_t1 occurs; it is solved for. The paper writes only "a function of the gravity center".
    fn place_foot(&self, state: &mut GaitState, left: f64) {
        let (omega, gamma) = (self.omega[0], self.swing_coupling);
        if left > self.measures.freeze {
            let [sagittal, _] = state.com;
            let foot = state.foot;
            let [whole, half] = [left, 0.5 * left].map(|time| Flow::new(omega, time));
            let free = Motion { x: sagittal.x, v: sagittal.v }.after(&whole, 0.0);
            let x_e = free.x - gamma * whole.sinh * foot.v / omega;
            let v_e = free.v - gamma * whole.cosh * foot.v;
            // Moving the foot by ΔX shifts (x_e, v_e) by these, per metre.
            let per_x = gamma * half.cosh;
            let per_v = gamma * omega * half.sinh;
            let gain = self.placement_gain;
            let v_ref = self.touchdown_speed * state.step;
            let fixed = x_e + 0.5 * state.step + gain * (v_e - v_ref);
            let per_x_t = per_x + gain * per_v;
            state.landing = (fixed - per_x_t * foot.x) / (1.0 - per_x_t);
            state.foot = foot.toward(state.landing - state.trim, left, self.h);
        } else {
            state.foot = Travel { x: state.foot.x + self.h * state.foot.v, a: 0.0, ..state.foot };
        }
    }
}

/// One period of ẍ = ω²x + u.
fn pendulum(now: Travel, period: &Flow, u: f64) -> Travel {
    let next = Motion { x: now.x, v: now.v }.after(period, u);
    Travel { x: next.x, v: next.v, a: period.omega * period.omega * next.x + u }
}
