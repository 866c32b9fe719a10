//! Steps, seen from outside: where the centre of mass crosses the line midway between the soles.

use super::derived::{DerivedState, SoleState};
use nalgebra::{Vector2, Vector3};

/// One step: from one exchange of support to the next.
#[derive(Clone, Debug)]
pub struct GaitStep {
    /// Time of the exchange that began it [s].
    pub start: f64,
    /// Centre of mass at that time [m].
    pub com: Vector3<f64>,
    /// Supporting foot: 0 left, 1 right.
    pub support: usize,
    /// Least lateral distance of the centre of mass from the support sole's centre, x_2 min [m].
    pub x2_min: f64,
    /// The support sole at that moment: the footprint.
    pub sole: SoleState,
}

/// State of the lateral plane in the support frame S: axis 2 from the support foot toward the other.
#[derive(Clone, Copy, Debug)]
pub struct LateralState {
    /// Supporting foot: 0 left, 1 right.
    pub support: usize,
    /// Distance x_c2 of the centre of mass from the support sole's centre [m].
    pub position: f64,
    /// Its rate [m/s].
    pub velocity: f64,
    /// Signed distance from the midline, positive on the left [m].
    offset: f64,
    /// Distance between the soles' centres [m].
    width: f64,
}

impl LateralState {
    /// Reads the lateral plane off a derived; the side of the midline on which the centre of mass is supports.
    /// The lateral direction is square to the mean heading of the feet. `None` without feet.
    pub fn new(derived: &DerivedState) -> Option<Self> {
        let [left, right] = derived.soles.as_ref()?;
        let heading = (left.heading + right.heading).try_normalize(0.0).unwrap_or(left.heading);
        let across = Vector2::new(-heading.y, heading.x);
        let along = |place: Vector2<f64>| across.dot(&place);
        let (l, r, c) = (along(left.centre.xy()), along(right.centre.xy()), along(derived.com.xy()));
        let offset = c - (l + r) / 2.0;
        let rate = along(derived.com_velocity.xy());
        let (support, position, velocity) = if offset >= 0.0 { (0, l - c, -rate) } else { (1, c - r, rate) };
        Some(LateralState { support, position, velocity, offset, width: (l - r).abs() })
    }
}

/// Counts steps as samples come in.
#[derive(Default)]
pub struct StepDetector {
    /// Every step so far; the last is still going on.
    pub steps: Vec<GaitStep>,
    side: Option<usize>,
    /// Time, centre of mass and lateral plane of the derived before.
    before: Option<(f64, Vector3<f64>, LateralState)>,
    crossing: Option<(f64, Vector3<f64>)>,
    turning_point: Option<(f64, SoleState)>,
}

impl StepDetector {
    /// A crossing counts once the centre of mass is this share of the soles' distance beyond the midline: standing
    /// still on it is not walking.
    const DEAD_BAND: f64 = 0.01;

    /// Takes the next derived.
    pub fn push(&mut self, derived: &DerivedState) {
        let Some((now, soles)) = LateralState::new(derived).zip(derived.soles) else { return };
        if let Some((time, com, then)) = &self.before
            && then.support != now.support
        {
            let share = then.offset / (then.offset - now.offset);
            self.crossing = Some((time + share * (derived.time - time), com.lerp(&derived.com, share)));
            self.turning_point = None;
        }
        if self.turning_point.is_none_or(|(least, _)| now.position < least) {
            self.turning_point = Some((now.position, soles[now.support]));
        }
        if now.offset.abs() > Self::DEAD_BAND * now.width {
            if self.side.is_some_and(|side| side != now.support) {
                self.begin(now.support, soles[now.support]);
            }
            self.side = Some(now.support);
        }
        if let (Some(step), Some((least, sole))) = (self.steps.last_mut(), self.turning_point)
            && step.support == now.support
            && least < step.x2_min
        {
            (step.x2_min, step.sole) = (least, sole);
        }
        self.before = Some((derived.time, derived.com, now));
    }

    fn begin(&mut self, support: usize, sole: SoleState) {
        if let Some((start, com)) = self.crossing {
            self.steps.push(GaitStep { start, com, support, x2_min: f64::INFINITY, sole });
        }
    }

    /// Steps that have ended.
    pub fn complete(&self) -> &[GaitStep] {
        self.steps.split_last().map_or(&[], |(_, done)| done)
    }

    /// Mean and standard deviation of the last `count` periods, a period being two steps [s]; NaN without any.
    pub fn period(&self, count: usize) -> (f64, f64) {
        let periods: Vec<f64> = self.steps.windows(3).rev().take(count).map(|w| w[2].start - w[0].start).collect();
        let mean = mean(periods.iter().copied());
        (mean, self::mean(periods.iter().map(|period| (period - mean).powi(2))).sqrt())
    }

    /// Mean of x_2 min over the last `count` complete steps [m]; NaN without any.
    pub fn x2_min(&self, count: usize) -> f64 {
        mean(self.complete().iter().rev().take(count).map(|step| step.x2_min))
    }

    /// Mean forward speed over the last half of the walk, over whole periods [m/s]; NaN with fewer than three steps.
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

/// Mean; NaN of nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value));
    if count == 0 { f64::NAN } else { sum / f64::from(count) }
}

#[cfg(test)]
mod tests {
    use crate::analysis::RunAnalysis;
    use crate::analysis::synthetic::{RELEASE, STEP, SyntheticWalk};
    use messages::scene::Scene;

    /// Records a made-up walk from standing until `end`, at 1 kHz.
    fn walk(step_length: f64, end: f64) -> RunAnalysis {
        let (fake, mut analysis) = (SyntheticWalk::new(step_length), RunAnalysis::new(&Scene::default()));
        for seq in 0..=(end * 1e3) as u64 {
            analysis.push(&fake.truth(seq, seq as f64 * 1e-3));
        }
        analysis
    }

    #[test]
    fn a_limit_cycle_is_measured_as_it_is() {
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
    fn standing_is_not_stepping() {
        assert!(walk(0.06, 0.5).gait.steps.is_empty());
        let mut analysis = RunAnalysis::new(&Scene::default());
        let mut truth = SyntheticWalk::new(0.0).truth(0, 0.0);
        for seq in 0..1000 {
            // Rounding errors cross the midline at every derived.
            truth.base_position[1] = if seq % 2 == 0 { 1e-6 } else { -1e-6 };
            truth.stamp.sim_ns = seq * 1_000_000;
            analysis.push(&truth);
        }
        assert!(analysis.gait.steps.is_empty());
    }
}
