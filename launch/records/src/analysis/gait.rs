//! Step detection from the motion alone: a step begins where the feet exchange the support.
//!
//! The centre of mass crosses the midline between the soles, towards a foot that has been off the ground and landed. Where a load holds the
//! centre of mass on one side, the foot off the ground tells which one supports.

use super::derived::{DerivedState, SoleState};
use nalgebra::{Vector2, Vector3};

/// One step: from one change of the support foot to the next.
#[derive(Clone, Debug)]
pub struct GaitStep {
    /// Time of the change of support at its start [s].
    pub start: f64,
    /// Centre of mass at that time [m].
    pub com: Vector3<f64>,
    /// Support foot: 0 left, 1 right.
    pub support: usize,
    /// Least lateral distance of the centre of mass from the support sole's centre, x_2 min [m].
    pub x2_min: f64,
    /// The support sole at the time of x_2 min: the footprint.
    pub sole: SoleState,
}

/// State in the lateral plane in the support frame S. Axis 2 points from the support foot to the other foot.
#[derive(Clone, Copy, Debug)]
pub struct LateralState {
    /// Support foot: 0 left, 1 right.
    pub support: usize,
    /// Distance x_c2 of the centre of mass from the support sole's centre [m].
    pub position: f64,
    /// Rate [m/s].
    pub velocity: f64,
    /// Signed distance from the midline, positive on the left [m].
    offset: f64,
    /// Distance of the left sole's centre from the right one's, negative for crossed legs [m].
    width: f64,
}

impl LateralState {
    /// The lateral state of a record. The foot on the same side of the midline as the centre of mass is the support foot.
    /// The lateral direction is perpendicular to the mean heading of the feet. `None` without feet.
    pub fn new(derived: &DerivedState) -> Option<Self> {
        let [left, right] = derived.soles.as_ref()?;
        let heading = (left.heading + right.heading).try_normalize(0.0).unwrap_or(left.heading);
        let across = Vector2::new(-heading.y, heading.x);
        let lateral = |vector: Vector2<f64>| across.dot(&vector);
        let (l, r, c) = (lateral(left.centre.xy()), lateral(right.centre.xy()), lateral(derived.com.xy()));
        let offset = c - (l + r) / 2.0;
        let rate = lateral(derived.com_velocity.xy());
        let (support, position, velocity) = if offset >= 0.0 { (0, l - c, -rate) } else { (1, c - r, rate) };
        Some(LateralState { support, position, velocity, offset, width: l - r })
    }

    /// Distance of the centre of mass from the centre of a foot's sole, towards the other foot [m].
    fn distance_from(&self, foot: usize) -> f64 {
        if foot == self.support { self.position } else { self.width - self.position }
    }
}

/// Detects steps, record by record.
#[derive(Default)]
pub struct StepDetector {
    /// All steps. The last one may not have ended yet.
    pub steps: Vec<GaitStep>,
    /// Height of the centre of mass above the lowest contact point in the first record [m].
    height: Option<f64>,
    /// The current support foot.
    support: Option<usize>,
    /// Whether each foot has been off the ground since the start of the latest step.
    was_aloft: [bool; 2],
    /// Time, centre of mass and lateral state of the previous record.
    previous: Option<(f64, Vector3<f64>, LateralState)>,
    /// Time and centre of mass of the latest midline crossing since the start of the latest step.
    crossing: Option<(f64, Vector3<f64>)>,
}

impl StepDetector {
    /// A foot is off the ground, and the centre of mass beyond the midline, by more than this fraction of the distance of the soles. Without
    /// this threshold, feet that rattle or rounding errors would step.
    const THRESHOLD: f64 = 0.01;
    /// The same of a foot, relative to the first height of the centre of mass above the lowest point [-]: feet that stand far apart rise no
    /// higher than others.
    const LIFT: f64 = 0.0025;

    /// Processes the next record.
    pub fn push(&mut self, derived: &DerivedState) {
        let Some((state, soles)) = LateralState::new(derived).zip(derived.soles) else { return };
        if let Some((time, com, previous)) = &self.previous
            && previous.support != state.support
        {
            let fraction = previous.offset / (previous.offset - state.offset);
            self.crossing = Some((time + fraction * (derived.time - time), com.lerp(&derived.com, fraction)));
        }
        let threshold = Self::THRESHOLD * state.width.abs();
        let height = *self.height.get_or_insert(derived.com.z - derived.lowest_point);
        let is_aloft = soles.map(|sole| sole.clearance > threshold.min(Self::LIFT * height));
        let has_landed = self.was_aloft[state.support] && soles[state.support].load > 0.0;
        let support = match is_aloft {
            [false, true] => Some(0),
            [true, false] => Some(1),
            _ if has_landed && state.offset.abs() > threshold => Some(state.support),
            _ => self.support,
        };
        if let (Some(before), Some(support)) = (self.support, support)
            && before != support
        {
            self.was_aloft = [false; 2];
            let crossing = self.crossing.take().filter(|_| state.support == support);
            let (start, com) = crossing.unwrap_or((derived.time, derived.com));
            self.steps.push(GaitStep { start, com, support, x2_min: f64::INFINITY, sole: soles[support] });
        }
        if let Some(step) = self.steps.last_mut()
            && state.distance_from(step.support) < step.x2_min
        {
            (step.x2_min, step.sole) = (state.distance_from(step.support), soles[step.support]);
        }
        self.was_aloft = [0, 1].map(|foot| self.was_aloft[foot] || is_aloft[foot]);
        (self.support, self.previous) = (support, Some((derived.time, derived.com, state)));
    }

    /// The steps that have ended.
    pub fn complete(&self) -> &[GaitStep] {
        self.steps.split_last().map_or(&[], |(_, done)| done)
    }

    /// Mean and standard deviation of the last `count` periods of two steps [s]. NaN without a period.
    pub fn period(&self, count: usize) -> (f64, f64) {
        let periods: Vec<f64> = self.steps.windows(3).rev().take(count).map(|w| w[2].start - w[0].start).collect();
        let mean = mean(periods.iter().copied());
        (mean, self::mean(periods.iter().map(|period| (period - mean).powi(2))).sqrt())
    }

    /// Mean of x_2 min over the last `count` complete steps [m]. NaN without a complete step.
    pub fn x2_min(&self, count: usize) -> f64 {
        mean(self.complete().iter().rev().take(count).map(|step| step.x2_min))
    }

    /// Mean forward speed over the whole periods in the second half of the walk [m/s]. NaN with fewer than three steps.
    pub fn speed(&self) -> f64 {
        let (Some(first), Some(last)) = (self.steps.first(), self.steps.last()) else { return f64::NAN };
        let middle = (first.start + last.start) / 2.0;
        (self.steps.iter().rev().step_by(2).skip(1))
            .take_while(|step| step.start >= middle)
            .last()
            .or_else(|| self.steps.iter().rev().nth(2))
            .map_or(f64::NAN, |step| (last.com.x - step.com.x) / (last.start - step.start))
    }
}

/// Mean of the values. NaN without values.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value));
    if count == 0 { f64::NAN } else { sum / f64::from(count) }
}

#[cfg(test)]
mod tests {
    use super::{LateralState, StepDetector};
    use crate::analysis::RunAnalysis;
    use crate::analysis::synthetic::{RELEASE, STEP, SyntheticWalk};
    use messages::scene::Scene;
    use std::f64::consts::TAU;

    /// Analyses a synthetic walk from standing until `end`, at 1 kHz.
    fn walk(step_length: f64, end: f64) -> RunAnalysis {
        let (walk, mut analysis) = (SyntheticWalk::new(step_length), RunAnalysis::new(&Scene::default()));
        for seq in 0..=(end * 1e3) as u64 {
            analysis.push(&walk.truth(seq, seq as f64 * 1e-3));
        }
        analysis
    }

    #[test]
    fn the_gait_parameters_of_a_limit_cycle_are_exact() {
        let analysis = walk(0.06, 8.0);
        let (period, deviation) = analysis.gait.period(20);
        assert!((period - 2.0 * STEP).abs() < 1e-6 && deviation < 1e-6, "{period} +- {deviation}");
        assert!((analysis.gait.x2_min(20) - SyntheticWalk::x2_min()).abs() < 1e-9, "{}", analysis.gait.x2_min(20));
        assert_eq!(analysis.gait.steps.len(), ((8.0 - RELEASE + STEP / 2.0) / STEP) as usize);
        let supports: Vec<_> = analysis.gait.steps.iter().map(|step| step.support).collect();
        assert!(supports.windows(2).all(|pair| pair[0] != pair[1]) && supports[0] == 1, "{supports:?}");
        assert!((analysis.gait.speed() - 0.2).abs() < 1e-6, "{}", analysis.gait.speed());
        assert_eq!(analysis.extrema.fall, None);
    }

    #[test]
    fn a_walk_whose_centre_of_mass_stays_on_one_side_has_the_same_steps() {
        let mut scene = Scene::default();
        (scene.plant.payload_kg, scene.plant.payload_offset) = (5.0, [0.0, 0.1, 0.1]);
        let (walk, mut analysis) = (SyntheticWalk::new(0.06), RunAnalysis::new(&scene));
        for seq in 0..=8000 {
            analysis.push(&walk.truth(seq, seq as f64 * 1e-3));
            let last = analysis.last.as_ref().map(|last| &last.derived);
            assert!(last.and_then(LateralState::new).is_some_and(|state| state.support == 0), "{seq} ms");
        }
        let (period, deviation) = analysis.gait.period(20);
        assert_eq!(analysis.gait.steps.len(), ((8.0 - RELEASE + STEP / 2.0) / STEP) as usize);
        assert!((period - 2.0 * STEP).abs() < 1e-3 && deviation < 1e-3, "{period} +- {deviation}");
    }

    /// The feet rise by 1 cm at most, however far they are apart.
    #[test]
    fn a_walk_with_feet_far_apart_has_the_same_steps() {
        let walk = SyntheticWalk::new(0.06);
        for distance in [1.0, 4.0, 8.0, 12.0] {
            let (mut analysis, mut detector) = (RunAnalysis::new(&Scene::default()), StepDetector::default());
            for seq in 0..=8000 {
                analysis.push(&walk.truth(seq, seq as f64 * 1e-3));
                let mut derived = analysis.last.as_ref().expect("a record").derived.clone();
                derived.com.y *= distance;
                derived.soles.iter_mut().flatten().for_each(|sole| sole.centre.y *= distance);
                detector.push(&derived);
            }
            let expected = ((8.0 - RELEASE + STEP / 2.0) / STEP) as usize;
            assert_eq!(detector.steps.len(), expected, "feet {distance} times as far apart");
        }
    }

    #[test]
    fn swaying_on_both_feet_is_not_stepping() {
        let mut scene = Scene::default();
        (scene.plant.payload_kg, scene.plant.payload_offset) = (2.0, [0.0, -0.035, 0.0]);
        let (walk, mut analysis, mut sides) = (SyntheticWalk::new(0.06), RunAnalysis::new(&scene), [false; 2]);
        for seq in 0..8000 {
            let sway = 0.9 - 0.4 * (TAU * seq as f64 * 1e-3).cos(); // from standing to the greatest sway and back
            let mut truth = walk.truth(seq, sway);
            truth.stamp.sim_ns = seq * 1_000_000;
            analysis.push(&truth);
            let state = analysis.last.as_ref().and_then(|last| LateralState::new(&last.derived)).expect("feet");
            sides[usize::from(state.offset > 0.0)] |= state.offset.abs() > 0.02 * state.width;
        }
        assert_eq!((sides, analysis.gait.steps.len()), ([true; 2], 0));
    }

    #[test]
    fn standing_is_not_stepping() {
        assert!(walk(0.06, 0.5).gait.steps.is_empty());
        let mut analysis = RunAnalysis::new(&Scene::default());
        let mut truth = SyntheticWalk::new(0.0).truth(0, 0.0);
        for seq in 0..1000 {
            // Rounding errors cross the midline at every record.
            truth.base_position[1] = if seq % 2 == 0 { 1e-6 } else { -1e-6 };
            truth.stamp.sim_ns = seq * 1_000_000;
            analysis.push(&truth);
        }
        assert!(analysis.gait.steps.is_empty());
    }
}
