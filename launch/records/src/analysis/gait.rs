//! Step detection from the truth alone: a step begins where the feet exchange the support.
//!
//! The support foot is the one that carried nearly all of the load last. So a step needs neither a foot in the air nor a centre of mass that
//! crosses the midline between the soles. Where it does cross it, the time of the crossing is the start of the step.

use super::derived::{DerivedState, SoleState};
use super::extrema::LANDING_TIME;
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
    /// Time at which the foot carried nearly all of the load first [s].
    loaded: f64,
    /// Whether the start is a crossing of the midline.
    has_crossed: bool,
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

/// Passage of the centre of mass over the midline between the soles.
#[derive(Clone, Copy)]
struct MidlineCrossing {
    time: f64,
    com: Vector3<f64>,
    /// The foot towards which it leads.
    foot: usize,
}

/// Detects steps, record by record.
#[derive(Default)]
pub struct StepDetector {
    /// All steps. The last one may not have ended yet.
    pub steps: Vec<GaitStep>,
    /// A step whose foot carries the load, but neither for [`LANDING_TIME`] nor with the centre of mass on its side.
    pending: Option<GaitStep>,
    /// The current support foot.
    support: Option<usize>,
    /// Time at which the first support foot began to carry nearly all of the load [s].
    begin: f64,
    /// Time, centre of mass and lateral state of the previous record.
    previous: Option<(f64, Vector3<f64>, LateralState)>,
    /// The latest change of sides, which may be a rounding error.
    candidate: Option<MidlineCrossing>,
    /// The latest one after which the centre of mass has left the midline.
    crossing: Option<MidlineCrossing>,
}

impl StepDetector {
    /// A foot supports from where it carries more than this fraction of the load until the other one does. The walk has all of it on one
    /// foot, also if a foot drags. A robot with coarse encoders that sways on both feet after a stop has up to 0.98.
    const SUPPORT_LOAD: f64 = 0.99;
    /// The centre of mass is beyond the midline by more than this fraction of the distance of the soles. Without this threshold, rounding
    /// errors of a robot that cannot sway would cross it.
    const THRESHOLD: f64 = 0.01;

    /// Processes the next record.
    pub fn push(&mut self, derived: &DerivedState) {
        let Some((state, soles)) = LateralState::new(derived).zip(derived.soles) else { return };
        self.follow_crossings(derived, &state);
        match Self::bearing_foot(&soles) {
            Some(foot) => match self.support.replace(foot) {
                None => self.begin = derived.time,
                Some(before) if before != foot => self.exchange(foot, derived, soles[foot]),
                Some(_) => {}
            },
            // the robot stands, and shakes
            None if self.steps.is_empty() && derived.load > 0.0 && derived.time - self.begin < LANDING_TIME => {
                self.support = None;
            }
            None => {}
        }
        let before = if self.pending.is_some() { self.steps.last() } else { self.complete().last() };
        let last_begin = before.map_or(f64::NEG_INFINITY, |step| step.start);
        if let Some(step) = self.pending.as_mut().or(self.steps.last_mut()) {
            let own = self.crossing.filter(|crossing| crossing.foot == step.support && crossing.time > last_begin);
            if let Some(MidlineCrossing { time, com, .. }) = own.filter(|_| !step.has_crossed) {
                (step.start, step.com, step.has_crossed) = (time, com, true);
            }
            if state.distance_from(step.support) < step.x2_min {
                (step.x2_min, step.sole) = (state.distance_from(step.support), soles[step.support]);
            }
        }
        let is_certain = |step: &mut GaitStep| step.has_crossed || derived.time - step.loaded >= LANDING_TIME;
        self.steps.extend(self.pending.take_if(is_certain));
        self.previous = Some((derived.time, derived.com, state));
    }

    /// The foot that carries nearly all of the load.
    fn bearing_foot(soles: &[SoleState; 2]) -> Option<usize> {
        let load = soles[0].load + soles[1].load;
        (0..2).find(|foot| soles[*foot].load > Self::SUPPORT_LOAD * load)
    }

    /// Updates the crossings of the midline.
    fn follow_crossings(&mut self, derived: &DerivedState, state: &LateralState) {
        if let Some((time, com, previous)) = &self.previous
            && previous.support != state.support
        {
            let fraction = previous.offset / (previous.offset - state.offset);
            let (time, com) = (time + fraction * (derived.time - time), com.lerp(&derived.com, fraction));
            self.candidate = Some(MidlineCrossing { time, com, foot: state.support });
        }
        if state.offset.abs() > Self::THRESHOLD * state.width.abs() {
            self.crossing = self.candidate.take().or(self.crossing);
        }
    }

    /// The other foot carries the load: a step begins. But a support that was shorter than a landing was none: the foot bounced.
    fn exchange(&mut self, support: usize, derived: &DerivedState, sole: SoleState) {
        let (start, com) = (derived.time, derived.com);
        let since = self.pending.as_ref().or(self.steps.last()).map_or(self.begin, |step| step.loaded);
        if start - since >= LANDING_TIME {
            let x2_min = f64::INFINITY;
            self.pending = Some(GaitStep { start, com, support, x2_min, sole, loaded: start, has_crossed: false });
        } else if self.pending.take().or_else(|| self.steps.pop()).is_none() {
            self.begin = start;
        }
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
    use super::LateralState;
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

    /// A foot that drags carries a little of the load, and one that bounces at its landing gives it back for a moment.
    #[test]
    fn dragging_and_bouncing_feet_have_the_same_steps() {
        for (dragged, bounces) in [(0.005, false), (0.0, true), (0.005, true)] {
            let (walk, mut analysis) = (SyntheticWalk::new(0.06), RunAnalysis::new(&Scene::default()));
            for seq in 0..=8000 {
                let time = seq as f64 * 1e-3;
                let mut truth = walk.truth(seq, time);
                let since = (time - RELEASE + STEP / 2.0).rem_euclid(STEP);
                let loads: [f64; 8] = std::array::from_fn(|i| truth.contact_force[3 * i + 2]);
                for (i, load) in loads.into_iter().enumerate() {
                    let across = loads[(i + 4) % 8];
                    let is_back = bounces && time > RELEASE && (0.005..0.015).contains(&since);
                    let (own, other) = if is_back { (across, load) } else { (load, across) };
                    truth.contact_force[3 * i + 2] = (1.0 - dragged) * own + dragged * other;
                }
                analysis.push(&truth);
            }
            let (period, deviation) = analysis.gait.period(20);
            assert_eq!(analysis.gait.steps.len(), ((8.0 - RELEASE + STEP / 2.0) / STEP) as usize);
            assert!((period - 2.0 * STEP).abs() < 1e-6 && deviation < 1e-6, "{period} +- {deviation}");
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
