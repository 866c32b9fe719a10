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
        let supporting = derived.single_support().zip(derived.loaded_foot());
        // support may pass to the other foot between two records
        let start = self.single_support_start.filter(|(before, _)| supporting.is_some_and(|(_, foot)| foot == *before));
        self.single_support_start = supporting.map(|(_, foot)| start.unwrap_or((foot, derived.time)));
        if let Some((sole, _)) = supporting
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
mod tests {
    use crate::analysis::synthetic::SyntheticWalk;
    use crate::analysis::{RunAnalysis, TIME_AFTER_FALL};
    use messages::scene::{ControllerScene, GroundTile, Scene};
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

    /// The robot of Table 1 upright with both soles at this height [m], its ankles and hips bent by an angle [rad].
    fn crouch(bend: f64, sole: f64) -> Truth {
        let leg = [0.0, bend, -2.0 * bend, bend]; // equal shank and thigh of .2 m
        let angle = std::array::from_fn(|i| if i < 4 { leg[i] } else { -leg[7 - i] });
        // Above the hips: half the trunk, .15 m. Below the ankles: .1 m.
        let base_position = [0.0, 0.0, sole + 0.15 + 0.4 * bend.cos() + 0.1];
        Truth { base_position, base_orientation: [1.0, 0.0, 0.0, 0.0], angle, ..Truth::default() }
    }

    /// The analysis of records at 0, 1, 2 s, ...
    fn analysis(scene: &Scene, records: &[Truth]) -> RunAnalysis {
        let mut analysis = RunAnalysis::new(scene);
        for (second, record) in (0..).zip(records) {
            let mut truth = *record;
            truth.stamp.sim_ns = second * 1_000_000_000;
            truth.contact_force[2] = 1.0;
            analysis.push(&truth);
        }
        analysis
    }

    const UPRIGHT: f64 = 0.76;
    const COLLAPSED: f64 = 1.45;

    #[test]
    fn heights_for_fall_and_hop_are_above_the_ground_under_the_robot() {
        let tile = |x, height| GroundTile { x, y: [-9.0, 9.0], height };
        let mut scene = Scene::default();
        scene.plant.ground.tiles =
            vec![tile([-9.0, -1.0], -0.2), tile([-1.0, 1.0], 0.0), tile([1.0, 8.0], -0.6), tile([8.0, 9.0], 0.5)];
        let at = |x: f64, mut truth: Truth| {
            truth.base_position[0] = x;
            truth
        };
        let down = [at(-5.0, crouch(UPRIGHT, -0.2)), at(0.0, crouch(UPRIGHT, 0.0)), at(5.0, crouch(UPRIGHT, -0.6))];
        let upright = analysis(&scene, &down);
        assert_eq!(upright.extrema.fall, None);
        assert!(upright.extrema.hop.abs() < 1e-12, "{}", upright.extrema.hop);
        let jump = analysis(&scene, &[down[0], at(5.0, crouch(COLLAPSED, -0.3))]);
        assert_eq!(jump.extrema.fall, None, "legs drawn up in the air are no fall");
        assert!((jump.extrema.hop - 0.3).abs() < 1e-12, "{}", jump.extrema.hop);
        let astride = analysis(&scene, &[down[1], at(1.0, crouch(UPRIGHT, 0.0))]);
        assert_eq!(astride.extrema.fall, None, "the heels on the edge of a step");
        let inside = analysis(&scene, &[down[0], at(7.95, crouch(UPRIGHT, -0.6))]);
        assert_eq!(inside.extrema.fall, None, "the toes in the side of a wall");
        for (x, height) in [(-5.0, -0.2), (0.0, 0.0), (5.0, -0.6), (1.0, 0.0)] {
            let collapsed = analysis(&scene, &[down[0], at(x, crouch(COLLAPSED, height))]);
            assert_eq!(collapsed.extrema.fall, Some(1.0), "at {x} m");
        }
    }

    #[test]
    fn a_posture_as_low_as_commanded_is_no_fall() {
        let fall = |com_height: Option<f64>| {
            let controller = com_height.map(|com_height| ControllerScene { com_height, ..ControllerScene::default() });
            let scene = Scene { controller, ..Scene::default() };
            analysis(&scene, &[crouch(UPRIGHT, 0.0), crouch(COLLAPSED, 0.0)]).extrema.fall
        };
        assert_eq!([None, Some(0.27), Some(0.3)].map(fall), [Some(1.0); 3]);
        assert_eq!([Some(0.18), Some(0.15)].map(fall), [None; 2]);
    }

    #[test]
    fn tilt_of_the_loaded_foot_and_margin_of_the_zero_moment_point_are_exact() {
        let (walk, scene) = (SyntheticWalk::new(0.06), Scene::default());
        // In single support on the right foot, the zero-moment point up to 0.3 of the half width off the centre.
        let mut analysis = RunAnalysis::new(&scene);
        (4000..6000).for_each(|seq| analysis.push(&walk.truth(seq, seq as f64 * 1e-3)));
        let landed: Vec<bool> = analysis.rows.iter().map(|row| row.has_landed).collect();
        assert!(!landed[..8].contains(&true) && landed.contains(&true), "{landed:?}"); // the first 35 ms, every 5 ms
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

    /// With few records, or steps without double support, the load passes from all of one foot to all of the other between two records.
    #[test]
    fn each_foot_has_its_time_to_land_although_support_passes_between_two_records() {
        let mut analysis = RunAnalysis::new(&Scene::default());
        let foot_of = |k: usize, analysis: &RunAnalysis| analysis.robot.feet.as_ref().expect("feet")[k].body;
        let bodies = [0, 1].map(|k| foot_of(k, &analysis));
        for tick in 0..200_u64 {
            // the left foot until 100 ms, on all corners; then the right one, for 30 ms on one corner
            let foot = usize::from(tick >= 100);
            let mut truth = crouch(UPRIGHT, 0.0);
            truth.stamp.sim_ns = tick * 1_000_000;
            let own = analysis.robot.contacts.iter().enumerate().filter(|(_, (body, _))| *body == bodies[foot]);
            let corners: Vec<usize> =
                own.map(|(i, _)| i).take(if (100..130).contains(&tick) { 1 } else { 4 }).collect();
            corners.iter().for_each(|i| truth.contact_force[3 * i + 2] = 10.0);
            analysis.push(&truth);
        }
        assert!((analysis.extrema.zmp_margin - 0.05).abs() < 1e-12, "{}", analysis.extrema.zmp_margin);
    }

    #[test]
    fn a_point_over_a_gap_of_the_ground_has_no_height() {
        let mut scene = Scene::default();
        let left = scene.bodies.iter().position(|body| body.name == messages::robot::LEFT_FOOT).expect("a foot");
        scene.bodies[left].tiles = Some(messages::robot::Tiles { first: 0.0, pitch: 10.0, length: 1.0 });
        let at = |x: f64, right_knee: f64| {
            let mut truth = crouch(UPRIGHT, 0.0);
            truth.base_position[0] = x;
            truth.angle[5] += right_knee;
            truth
        };
        let over_gap = analysis(&scene, &[at(0.0, 0.0), at(5.0, 0.5)]).extrema.hop;
        let over_ground = analysis(&scene, &[at(0.0, 0.0), at(10.0, 0.5)]).extrema.hop;
        assert!(over_gap > 0.02 && over_ground.abs() < 1e-9, "{over_gap} m, {over_ground} m");
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
