//! View (iii): which method fails in which scene at 1 ms, and why.

use super::cases::{Combination, ComparisonScene, HOP, PENETRATION, Question, scene};
use super::csv::{Measurement, OURS, View};

use super::precision::{MethodTrial, NoMetrics};
use super::trial::{RunEnd, watch};
use super::watch::{ChartProgress, Job};
use messages::scene::Method;
use plant::PlantError;
use rayon::prelude::*;
use shared::exit::Failure;
use strum::VariantArray;

/// The step [s]. A method that has not run with it is judged at the nearest step.
const H: f64 = 1e-3;
/// The scene with infinitely many impacts in finite time.
const ZENO: &str = "zeno";

/// Why a method fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray)]
pub enum Cause {
    /// The state grows without bound.
    BlowUp,
    /// The solver needs its fallback.
    NoSolution,
    /// Infinitely many impacts in finite time are not resolved.
    Zeno,
    /// A body that should stay on the ground rises.
    Hop,
    /// A body penetrates the ground.
    Tunnelling,
    /// A sticking body moves.
    Creep,
    /// The answer is wrong by 1 %, or the energy by 0.1 %.
    Drift,
    /// The motion depends on the order of the contacts.
    Order,
}

impl Cause {
    /// Name in the table. The map shows the first letter.
    pub fn name(self) -> &'static str {
        match self {
            Cause::BlowUp => "B blow-up",
            Cause::NoSolution => "N no solution",
            Cause::Zeno => "Z Zeno stall",
            Cause::Hop => "H hop",
            Cause::Tunnelling => "T tunnelling",
            Cause::Creep => "C creep",
            Cause::Drift => "D drift",
            Cause::Order => "O order-dependent",
        }
    }

    /// The criterion in words.
    pub fn rule(self) -> &'static str {
        match self {
            Cause::BlowUp => "the state or the error grows without bound",
            Cause::NoSolution => "the solver needs its fallback, or gives up",
            Cause::Zeno => "the bouncing ball, which should rest after 1.355 s, does not",
            Cause::Hop => "a body on the ground rises by more than 0.1 mm",
            Cause::Tunnelling => "a body penetrates the ground by more than 0.1 mm",
            Cause::Creep => "a sticking body creeps faster than 1 µm/s",
            Cause::Drift => "the answer is wrong by more than 1 %, in flight the energy by 0.1 %",
            Cause::Order => "with the contacts in another order the final position differs by more than 1 nm",
        }
    }

    /// The criterion as a number.
    pub fn limit(self) -> f64 {
        match self {
            Cause::BlowUp | Cause::NoSolution => 0.0,
            Cause::Zeno | Cause::Hop | Cause::Tunnelling => 1e-4,
            Cause::Creep => 1e-6,
            Cause::Drift => 1e-2,
            Cause::Order => 1e-9,
        }
    }
}

/// Suffix of a measured threshold in the metric column.
pub const MEASURED: &str = " measured";
/// Suffix of an exact threshold.
pub const EXACT: &str = " exact";
/// Metric of a method without failures.
pub const SOUND: &str = "sound";
/// Metric of a method that cannot simulate the scene.
pub const REFUSED: &str = "refused";

/// A row for each cause of each failure, and one row for each method and scene without failures.
///
/// # Errors
/// Ctrl-C, or a scene that is refused for a reason other than its law or method.
pub fn measure(trials: &[MethodTrial], progress: &ChartProgress) -> Result<Vec<Measurement>, Failure> {
    let mut combinations: Vec<Combination> = Vec::new();
    let mut at_h: Vec<&MethodTrial> = Vec::new();
    for trial in trials {
        if !combinations.contains(&trial.combination) {
            combinations.push(trial.combination);
        }
        let far = |trial: &MethodTrial| (trial.h / H).ln().abs();
        match at_h.iter_mut().find(|known| known.case.name == trial.case.name && known.combination == trial.combination)
        {
            Some(known) if far(trial) < far(known) => *known = trial,
            Some(_) => {}
            None => at_h.push(trial),
        }
    }
    progress.expect(at_h.len() + combinations.len());
    let compared = at_h.par_iter().map(|trial| {
        progress.step(Job::Failing)?;
        Ok(self::row(trial.case.name, trial.combination, trial.h, &causes(trial)))
    });
    combinations.retain(|combination| combination.method != Method::StepDoubling); // as in the cases where contacts open and close
    let zeno = combinations.par_iter().map(|&combination| {
        progress.step(Job::Failing)?;
        Ok(self::row(ZENO, combination, H, &bouncing(combination)?))
    });
    let rows: Vec<Vec<Measurement>> = compared.chain(zeno).collect::<Result<_, Failure>>()?;
    Ok(rows.into_iter().flatten().collect())
}

type Causes = Option<Vec<(Cause, f64)>>;

fn row(scene: &str, combination: Combination, h: f64, causes: &Causes) -> Vec<Measurement> {
    let row = |metric: &str, error: f64| Measurement {
        view: View::Failures,
        scene: scene.into(),
        engine: OURS.into(),
        method: combination.name(),
        dt: h,
        metric: metric.into(),
        error,
        cost: f64::NAN,
        us_per_step: f64::NAN,
    };
    match causes {
        None => vec![row(REFUSED, f64::NAN)],
        Some(causes) if causes.is_empty() => vec![row(SOUND, f64::NAN)],
        Some(causes) => causes.iter().map(|&(cause, amount)| row(cause.name(), amount)).collect(),
    }
}

/// The causes of failure of a run, the most serious first; none if the scene was refused.
fn causes(trial: &MethodTrial) -> Causes {
    let metrics = match &trial.result {
        Err(NoMetrics::Refused) => return None,
        Err(NoMetrics::Broken(error)) => return Some(vec![(broken(error), f64::INFINITY)]),
        Ok(metrics) => metrics,
    };
    let metric = |name: &str| metrics.iter().find(|metric| metric.0 == name).map_or(0.0, |metric| metric.1);
    let wrong = trial.case.question.metrics().iter().map(|name| metric(name)).fold(0.0, f64::max);
    // An error of 0.1 % of the energy counts as much as one of 1 % of a distance.
    let drift = match trial.case.question {
        Question::Flight => 10.0 * wrong,
        Question::Stick | Question::Stand | Question::Drop => 0.0,
        _ => wrong,
    };
    let found = [
        (Cause::BlowUp, if wrong < 1e3 { 0.0 } else { wrong }),
        (Cause::NoSolution, trial.fallbacks as f64),
        (Cause::Hop, metric(HOP)),
        (Cause::Tunnelling, metric(PENETRATION)),
        (Cause::Creep, metric("creep_m_per_s")),
        (Cause::Drift, drift),
        (Cause::Order, disorder(trial)),
    ];
    Some(failing(&found))
}

/// The causes of failure whose value exceeds the limit or is NaN.
fn failing(found: &[(Cause, f64)]) -> Vec<(Cause, f64)> {
    found.iter().copied().filter(|(cause, amount)| amount.is_nan() || *amount > cause.limit()).collect()
}

fn broken(error: &PlantError) -> Cause {
    match error {
        PlantError::NotFinite { .. } | PlantError::Singular { .. } => Cause::BlowUp,
        _ => Cause::NoSolution,
    }
}

/// Distance of the final centre of mass from that of a run with the contact points of each body in reverse order [m].
fn disorder(trial: &MethodTrial) -> f64 {
    let mut scene = trial.scene.clone();
    scene.bodies.iter_mut().for_each(|body| body.contacts.reverse());
    match watch(&scene, &[]) {
        RunEnd::Done(log) => log.end().zip(trial.end).map_or(0.0, |(one, other)| (one - other).norm()),
        _ => 0.0,
    }
}

/// Failures with the bouncing ball, which should come to rest within 1.355 s and stay at rest.
fn bouncing(combination: Combination) -> Result<Causes, Failure> {
    let scene = scene(ZENO, combination, H, &[])?;
    let log = match watch(&scene, &[]) {
        RunEnd::Refused => return Ok(None),
        RunEnd::Broken(error) if broken(&error) == Cause::BlowUp => {
            return Ok(Some(vec![(Cause::BlowUp, f64::INFINITY)]));
        }
        RunEnd::Broken(_) => return Ok(Some(vec![(Cause::Zeno, f64::INFINITY)])),
        RunEnd::Done(log) => log,
    };
    let radius = scene.bodies[0].spheres.first().map_or(0.0, |ball| ball.radius);
    let heights = || log.samples.iter().map(|sample| (sample.time, sample.totals.com.z - radius));
    let late = heights().filter(|(time, _)| *time > 1.6).fold(0.0, |late: f64, (_, height)| late.max(height));
    let deep = heights().fold(0.0, |deep: f64, (_, height)| deep.max(-height));
    let found = [(Cause::Zeno, late), (Cause::Tunnelling, deep)];
    Ok(Some(failing(&found)))
}

/// Position of a case among the columns of the map.
pub fn columns(chosen: &[ComparisonScene]) -> Vec<&'static str> {
    chosen.iter().map(|case| case.name).chain([ZENO]).collect()
}
