//! The truth of a control period: data that only the simulation knows, collected over its steps.

use crate::contact::Report;
use crate::kinematics::Pose;
use crate::model::Model;
use crate::state::State;
use messages::wire::{CONTACTS, FNV_START, JOINTS, Torques, Truth};

/// Factor of the hash of all states: 2⁶⁴ over the golden ratio, odd, so that multiplication loses no bit.
const HASH_FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
/// Rotation of the hash after each number [bit]. It brings the high bits, which depend on most others, to where the next factor spreads them.
const HASH_ROTATION: u32 = 29;

/// Extremes and sums over the steps of one control period, and the hash of the whole run.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Record {
    impulse: [[f64; 3]; CONTACTS],
    worst: Report,
    fallbacks: u64,
    hash: u64,
}

impl Default for Record {
    fn default() -> Self {
        Record { impulse: [[0.0; 3]; CONTACTS], worst: Report::default(), fallbacks: 0, hash: FNV_START }
    }
}

impl Record {
    /// Clears the data of the preceding period.
    pub fn begin_period(&mut self) {
        *self = Record { fallbacks: self.fallbacks, hash: self.hash, ..Record::default() };
    }

    /// Adds the report of a solved contact problem.
    pub fn note(&mut self, report: &Report) {
        let worst = &mut self.worst;
        worst.natural_map = greater(report.natural_map, worst.natural_map);
        worst.signorini = greater(report.signorini, worst.signorini);
        worst.slip_misalignment = greater(report.slip_misalignment, worst.slip_misalignment);
        worst.energy_gain = greater(report.energy_gain, worst.energy_gain);
        worst.pivots = worst.pivots.max(report.pivots);
        self.fallbacks += u64::from(report.fallback);
    }

    /// Counts a step as a fallback if `flagged`: its method did not reach the accuracy that it guarantees.
    pub fn flag(&mut self, flagged: bool) {
        self.fallbacks += u64::from(flagged);
    }

    /// Adds an impulse on contact point `id` [N·s]. Points beyond the capacity of a message are not recorded.
    pub fn push(&mut self, id: usize, impulse: [f64; 3]) {
        if let Some(sum) = self.impulse.get_mut(id) {
            sum.iter_mut().zip(impulse).for_each(|(sum, part)| *sum += part);
        }
    }

    /// Adds the state after a step to the hash.
    pub fn fold(&mut self, state: &State) {
        self.hash = state.x.iter().chain(&state.xdot).fold(self.hash, |hash, number| {
            (hash ^ number.to_bits()).wrapping_mul(HASH_FACTOR).rotate_left(HASH_ROTATION)
        });
    }

    /// The truth at the end of a control period of `period` [s]. Stamp and timing stay zero.
    pub fn truth(&self, model: &Model, state: &State, pose: &Pose, torques: &Torques, period: f64) -> Truth {
        let base = &pose.links[model.base_link];
        let frame = pose.arm(model.base_link, &model.base_frame);
        let over_ground = model.contact_points.iter().map(|corner| (corner, pose.reference + pose.lowest(corner)));
        let heights =
            over_ground.filter(|(corner, point)| corner.may_touch(point.x)).map(|(_, at)| at.z - model.ground_at(&at));
        let lowest = heights.fold(f64::INFINITY, f64::min);
        let mut truth = Truth {
            base_position: (pose.reference + frame).into(),
            base_orientation: pose.orientation(model.base_link),
            base_velocity: base.velocity.at(&frame).into(),
            base_spin: base.velocity.angular.into(),
            torque: torques.torque,
            contact_force: std::array::from_fn(|k| self.impulse[k / 3][k % 3] / period),
            natural_map: self.worst.natural_map,
            signorini: self.worst.signorini,
            slip_misalignment: self.worst.slip_misalignment,
            energy_gain: self.worst.energy_gain,
            penetration: (-lowest).max(0.0),
            hash: self.hash,
            fallbacks: self.fallbacks,
            pivots: u64::from(self.worst.pivots),
            ..Truth::default()
        };
        for k in 0..model.joint_dof.len().min(JOINTS) {
            truth.angle[k] = state.joint(model, k);
            truth.rate[k] = state.joint_rate(model, k);
        }
        truth
    }
}

/// The larger of two numbers, or NaN if one of them is NaN. `f64::max` would ignore a NaN.
fn greater(a: f64, b: f64) -> f64 {
    if b.is_nan() || b >= a { b } else { a }
}
