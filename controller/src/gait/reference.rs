//! The reference: set-points of the gait for the levels below it in one control period.

use super::model::{GaitModel, GaitState};
use crate::scaled_parameters::ScaledParameters;
use crate::support::{Task, TaskVector};
use crate::swing::MinimumJerkState;
use messages::wire::Phase;

/// Share of the weight on the new supporting foot immediately after an exchange, as the servos assume it [-]. If they assume the whole weight on
/// a foot that has just touched the ground, their gain is too high, and the walk shakes at a delay of 5 ms.
const FIRST_SUPPORT: f64 = 0.65;

/// Reference for the lower levels in one control period.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// ẋ_ref of (30) [m/s, rad/s].
    pub xdot: TaskVector,
    /// Planned acceleration of the centre of gravity along axes 1 and 2 [m/s²].
    pub acceleration: [f64; 2],
    /// Share of the weight on the supporting foot [0…1].
    pub load: f64,
    /// Share of the weight on the supporting foot as the servos assume it (`servo.rs`). It rises after an exchange, and is the planned one in
    /// *land* and *rest* [0…1].
    pub support: f64,
    /// Planned zero-moment point: x_1 − (ẍ_1 − γ ẍ_t1)/ω_1² and x_2 − ẍ_2/ω_2² [m].
    pub zmp: [f64; 2],
}

impl GaitModel {
    /// Task rates (30) that make the measured task follow the plan, with the swing foot at height and rate `lift` [m, m/s]. In
    /// *walk*, *land* and *rest* the rates lead the plan by the delay of the servos.
    pub(super) fn reference(&self, state: &mut GaitState, task: &Task, lift: [f64; 2], load: f64) -> Reference {
        let ScaledParameters { climb: fastest, climb_rate, .. } = self.parameters;
        let climb = (climb_rate * (self.scene.com_height - state.height)).clamp(-fastest, fastest);
        state.height += self.h * climb;
        let stepping = matches!(state.phase, Phase::Walk | Phase::Lift);
        let [sagittal, lateral] = state.com;
        let follows = matches!(state.phase, Phase::Walk | Phase::Land | Phase::Rest); // the plan follows the measured state
        let lag = if follows { self.servo_lag } else { 0.0 };
        let ahead = |axis: MinimumJerkState| axis.v + lag * axis.a;
        let command = [sagittal.x, lateral.x, state.height, state.foot.x, self.width, lift[0], 0.0];
        let rate = [ahead(sagittal), ahead(lateral), climb, ahead(state.foot), 0.0, lift[1], 0.0];
        let (com, foot) = (self.scene.com_gain, self.scene.swing_gain);
        let gain = [com, com, com, foot, foot, foot, com];
        let xdot = TaskVector::from_fn(|k, _| {
            let held = !stepping && (3..6).contains(&k); // a foot on the ground must not move
            if held { 0.0 } else { gain[k] * (command[k] - task.x[k]) + rate[k] } // (30)
        });
        Reference {
            xdot,
            acceleration: [sagittal.a, lateral.a],
            load,
            support: self.support(state, load),
            zmp: self.zmp(state),
        }
    }

    /// Share of the weight on the supporting foot as the servos assume it [0…1].
    fn support(&self, state: &GaitState, load: f64) -> f64 {
        match state.phase {
            Phase::Walk => state.loaded(FIRST_SUPPORT, self.parameters.touchdown),
            Phase::Land | Phase::Rest => load,
            Phase::Stand | Phase::Sway | Phase::Lift => 1.0,
        }
    }

    /// Zero-moment point of the plan, by (31) and (32) [m].
    pub(super) fn zmp(&self, state: &GaitState) -> [f64; 2] {
        let [sagittal, lateral] = state.com;
        let [omega_1, omega_2] = self.omega;
        [
            sagittal.x - (sagittal.a - self.swing_coupling * state.foot.a) / (omega_1 * omega_1), // (31)
            lateral.x - lateral.a / (omega_2 * omega_2),                                          // (32)
        ]
    }
}
