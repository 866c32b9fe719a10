//! Greatest and least values over all records of a run, and fall detection.

use super::derived::DerivedState;
use super::kinematic_tree::KinematicTree;
use messages::wire::{JOINTS, Truth};

/// Time that a landing foot needs until its whole sole rests on the ground [s].
const LANDING_TIME: f64 = 0.04;
/// Height of the trunk below which the robot has fallen, relative to its initial height above the feet [-].
const FALL_TRUNK_HEIGHT: f64 = 0.6;
/// Height of the centre of mass below which the robot has fallen, relative to its initial height [-].
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
    /// Start of the current single support [s].
    single_support_start: Option<f64>,
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
    /// Greatest height of the lowest contact point after the first contact [m].
    pub hop: f64,
    /// Greatest lateral distance of the centre of mass from its initial position [m].
    pub drift: f64,
    initial: Option<InitialPosture>,
    has_touched_ground: bool,
}

/// The posture in the first record: the reference for fall and drift. Heights are above the lowest contact point [m].
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
        match derived.single_support() {
            Some(sole) => {
                let since = *self.single_support_start.get_or_insert(derived.time);
                if derived.time - since >= LANDING_TIME {
                    self.zmp_margin = self.zmp_margin.min(sole.zmp_margin);
                }
            }
            None => self.single_support_start = None,
        }
        self.has_touched_ground |= derived.load > 0.0;
        if self.has_touched_ground {
            raise(&mut self.hop, derived.clearance);
        }
        let start = self.initial.get_or_insert_with(|| InitialPosture::new(derived));
        raise(&mut self.drift, (derived.com.y - start.y).abs());
        if robot.feet.is_some() && self.fall.is_none() && start.has_fallen(derived) {
            self.fall = Some(derived.time);
        }
    }
}

impl InitialPosture {
    /// The posture of the first record.
    pub fn new(derived: &DerivedState) -> Self {
        let ground = if derived.clearance.is_finite() { derived.clearance } else { 0.0 };
        InitialPosture {
            y: derived.com.y,
            trunk_height: derived.trunk_height - ground,
            com_height: derived.com.z - ground,
        }
    }

    /// True if the trunk is too low or too tilted, or the centre of mass is too low.
    pub fn has_fallen(&self, derived: &DerivedState) -> bool {
        derived.trunk_height < FALL_TRUNK_HEIGHT * self.trunk_height
            || derived.trunk_tilt > FALL_TILT_DEG.to_radians()
            || derived.com.z < FALL_COM_HEIGHT * self.com_height
    }
}

/// Replaces `greatest` by a greater value or by NaN. NaN persists.
fn raise(greatest: &mut f64, value: f64) {
    if value > *greatest || value.is_nan() {
        *greatest = value;
    }
}

#[cfg(test)]
mod tests {
    use crate::analysis::synthetic::SyntheticWalk;
    use crate::analysis::{RunAnalysis, TIME_AFTER_FALL};
    use messages::scene::Scene;
    use messages::wire::Truth;

    #[test]
    fn a_fall_is_detected_at_its_time_and_ends_step_detection() {
        let (walk, mut analysis) = (SyntheticWalk::new(0.06), RunAnalysis::new(&Scene::default()));
        for seq in 0..6000 {
            let time = seq as f64 * 1e-3;
            let mut truth = walk.truth(seq, time);
            // Tips over backwards about the ground from 4 s on, at 1 rad/s.
            let tilt = (time - 4.0).max(0.0);
            truth.base_orientation = [(tilt / 2.0).cos(), 0.0, -(tilt / 2.0).sin(), 0.0];
            analysis.push(&truth);
        }
        let fall = analysis.extrema.fall.expect("45 degrees is a fall");
        assert!((fall - 4.0 - 45f64.to_radians()).abs() < 2e-3, "{fall}");
        assert!(analysis.gait.steps.iter().all(|step| step.start < fall));
        assert_eq!(analysis.time_of_completed_fall(), Some(fall));
        let last = analysis.last.expect("a last record").derived.time;
        assert!((last - fall - TIME_AFTER_FALL).abs() < 2e-3, "the record ends at {last} s");
    }

    #[test]
    fn tilt_of_the_loaded_foot_and_margin_of_the_zero_moment_point_are_exact() {
        let (walk, scene) = (SyntheticWalk::new(0.06), Scene::default());
        // In single support on the right foot, the zero-moment point up to 0.3 of the half width off the centre.
        let mut analysis = RunAnalysis::new(&scene);
        (4000..6000).for_each(|seq| analysis.push(&walk.truth(seq, seq as f64 * 1e-3)));
        assert!((analysis.extrema.zmp_margin - 0.05 * 0.7).abs() < 1e-5, "{}", analysis.extrema.zmp_margin);
        assert!((analysis.rows[0].derived.load - 14.0 * 9.81).abs() < 1e-9);
        assert!(analysis.extrema.foot_tilt < 1e-12);
        let mut tilted = walk.truth(6000, 6.0);
        let (loaded, free) = if tilted.telemetry.support == 0 { (0, 7) } else { (7, 0) };
        tilted.angle[free] += 0.2;
        analysis.push(&tilted);
        assert!(analysis.extrema.foot_tilt < 1e-12, "a foot in the air may tilt");
        tilted.angle[loaded] += 0.01;
        analysis.push(&tilted);
        assert!((analysis.extrema.foot_tilt - 0.01).abs() < 1e-12, "{}", analysis.extrema.foot_tilt);
    }

    #[test]
    fn a_nan_residual_stays_visible() {
        let mut analysis = RunAnalysis::new(&Scene::default());
        let walk = SyntheticWalk::new(0.0);
        for seq in 0..3 {
            let truth = walk.truth(seq, seq as f64 * 1e-3);
            analysis.push(&Truth { signorini: if seq == 1 { f64::NAN } else { 1e-16 }, ..truth });
        }
        assert!(analysis.extrema.signorini.is_nan() && analysis.extrema.natural_map > 0.0);
    }
}
