//! Greatest and least values over all records of a run, and fall detection.

use super::derived::DerivedState;
use super::kinematic_tree::KinematicTree;
use messages::wire::{JOINTS, Truth};

/// Time that a landing foot needs until its whole sole rests on the ground [s].
const LANDING_TIME: f64 = 0.04;
/// Height of the trunk below which the robot has fallen, relative to its height in the reference posture [-].
const FALL_TRUNK_HEIGHT: f64 = 0.6;
/// Height of the centre of mass below which the robot has fallen, relative to its height in the reference posture [-].
const FALL_COM_HEIGHT: f64 = 0.5;
/// Tilt of the trunk above which the robot has fallen [deg].
const FALL_TILT_DEG: f64 = 45.0;

/// Extrema up to the latest record. A NaN value makes the extremum NaN, so an invalid residual stays visible.
pub struct Extrema {
    /// Time of the fall [s].
    pub fall: Option<f64>,
    /// Greatest torque of each drive [N·m].
    pub torque: [f64; JOINTS],
    /// Greatest magnitude of the mechanical power of each drive [W].
    pub power: [f64; JOINTS],
    /// Greatest tilt of the foot with the greater load [rad].
    pub foot_tilt: f64,
    /// Least distance of the zero-moment point from the edge of the sole in single support [m]. The first
    /// [`LANDING_TIME`] of each single support is excluded: a foot may still rest on one edge then.
    pub zmp_margin: f64,
    /// Foot of the current single support, and its start [s].
    single_support_start: Option<(usize, f64)>,
    /// Greatest Signorini residual, relative to the scale of its step.
    pub signorini: f64,
    /// Greatest natural-map residual, relative to the scale of its step.
    pub natural_map: f64,
    /// Greatest energy above that of free motion [J].
    pub energy_gain: f64,
    /// Greatest angle between friction and the direction opposite to slip [rad].
    pub slip_misalignment: f64,
    /// Deepest penetration [m].
    pub penetration: f64,
    /// Greatest normal force of the ground on the whole robot, mean over a control period [N].
    pub force: f64,
    /// Greatest height of the nearest contact point above the ground, after the first contact [m].
    pub hop: f64,
    /// Greatest lateral distance of the centre of mass from its initial position [m].
    pub drift: f64,
    initial: Option<InitialPosture>,
    has_touched_ground: bool,
}

/// The reference for fall and drift: the posture in the first record, or the lower one that the controller is told to take. Heights are
/// above the lowest contact point [m].
pub struct InitialPosture {
    y: f64,
    trunk_height: f64,
    com_height: f64,
}

impl Default for Extrema {
    fn default() -> Self {
        Extrema {
            fall: None,
            torque: [0.0; JOINTS],
            power: [0.0; JOINTS],
            foot_tilt: f64::NEG_INFINITY,
            zmp_margin: f64::INFINITY,
            single_support_start: None,
            signorini: 0.0,
            natural_map: 0.0,
            energy_gain: f64::NEG_INFINITY,
            slip_misalignment: 0.0,
            penetration: 0.0,
            force: 0.0,
            hop: f64::NEG_INFINITY,
            drift: 0.0,
            initial: None,
            has_touched_ground: false,
        }
    }
}

impl Extrema {
    /// Updates the extrema with the next record.
    pub fn push(&mut self, robot: &KinematicTree, truth: &Truth, derived: &DerivedState) {
        for i in 0..JOINTS {
            raise(&mut self.torque[i], truth.torque[i].abs());
            raise(&mut self.power[i], (truth.torque[i] * truth.rate[i]).abs());
        }
        raise(&mut self.signorini, truth.signorini);
        raise(&mut self.natural_map, truth.natural_map);
        raise(&mut self.energy_gain, truth.energy_gain);
        raise(&mut self.slip_misalignment, truth.slip_misalignment);
        raise(&mut self.penetration, truth.penetration);
        raise(&mut self.force, derived.load);
        if let Some((foot, soles)) = derived.loaded_foot().zip(derived.soles) {
            raise(&mut self.foot_tilt, soles[foot].tilt);
        }
        let supporting = derived.single_support();
        // support may pass to the other foot between two records
        let start = self.single_support_start.filter(|(before, _)| supporting.is_some_and(|(foot, _)| foot == *before));
        self.single_support_start = supporting.map(|(foot, _)| start.unwrap_or((foot, derived.time)));
        if let Some((_, sole)) = supporting
            && self.has_landed(derived.time)
        {
            self.zmp_margin = self.zmp_margin.min(sole.zmp_margin);
        }
        self.has_touched_ground |= derived.load > 0.0;
        if self.has_touched_ground {
            raise(&mut self.hop, derived.clearance);
        }
        let start = self.initial.get_or_insert_with(|| InitialPosture::new(robot, derived));
        raise(&mut self.drift, (derived.com.y - start.y).abs());
        if robot.feet.is_some() && self.fall.is_none() && start.has_fallen(derived) {
            self.fall = Some(derived.time);
        }
    }

    /// Whether one foot supports at this time of the latest record, and has done so for [`LANDING_TIME`] [s].
    pub fn has_landed(&self, time: f64) -> bool {
        self.single_support_start.is_some_and(|(_, since)| time - since >= LANDING_TIME)
    }
}

impl InitialPosture {
    /// The posture of the first record.
    pub fn new(robot: &KinematicTree, derived: &DerivedState) -> Self {
        let foot = if derived.lowest_point.is_finite() { derived.lowest_point } else { 0.0 };
        let [trunk_height, com_height] = [derived.trunk_height, derived.com.z].map(|height| height - foot);
        // A commanded crouch lowers the trunk by nearly the same part as the centre of mass.
        let lowered = robot.commanded_com_height.map_or(1.0, |height| (height / com_height).clamp(0.0, 1.0));
        InitialPosture { y: derived.com.y, trunk_height: lowered * trunk_height, com_height: lowered * com_height }
    }

    /// True if the trunk is too low or too tilted, or the centre of mass is too low.
    pub fn has_fallen(&self, derived: &DerivedState) -> bool {
        let ground = ground_under(derived);
        derived.trunk_height - ground < FALL_TRUNK_HEIGHT * self.trunk_height
            || derived.trunk_tilt > FALL_TILT_DEG.to_radians()
            || derived.com.z - ground < FALL_COM_HEIGHT * self.com_height
    }
}

/// Height of the ground under the robot [m]: that of its lowest contact point, less the distance by which all of them are above the ground.
/// A point within the side of a higher tile is not above it, and the ground is never above the lowest point.
fn ground_under(derived: &DerivedState) -> f64 {
    let ground = derived.lowest_point - derived.clearance.max(0.0);
    if ground.is_finite() { ground } else { 0.0 }
}

/// Replaces `greatest` by a greater value or by NaN. NaN persists.
fn raise(greatest: &mut f64, value: f64) {
    if value > *greatest || value.is_nan() {
        *greatest = value;
    }
}

#[cfg(test)]
mod tests;
