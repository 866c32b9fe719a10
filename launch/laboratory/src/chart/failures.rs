//! View (iii): which method fails in which scene at 1 ms, and why.

use super::cases::{Case, HOP, PENETRATION, Question, Way, scene};
use super::csv::{OURS, Row, View};

use super::precision::{Fate, Trial};
use super::trial::{Outcome, watch};
use super::watch::{Job, Watch};
use messages::scene::Method;
use plant::PlantError;
use rayon::prelude::*;
use shared::exit::Failure;
use strum::VariantArray;

/// The step [s]; where a way has not run with it, the nearest.
const H: f64 = 1e-3;
/// The scene with infinitely many impacts.
pub const ZENO: &str = "zeno";

/// Why a method fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray)]
pub enum Cause {
    /// The state grows without bound.
    BlowUp,
    /// The solver finds no solution by its own means.
    NoSolution,
    /// Infinitely many impacts in finite time are not got over.
    Zeno,
    /// What should stay on the ground rises.
    Hop,
    /// What touches sinks in.
    Tunnelling,
    /// What sticks moves.
    Creep,
    /// The answer is wrong by a per cent, the energy by a thousandth.
    Drift,
    /// Contacts in another order give another motion.
    Order,
}

impl Cause {
    /// In the table, the first letter being that of the map.
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

    /// What counts as failing, in words.
    pub fn rule(self) -> &'static str {
        match self {
            Cause::BlowUp => "the state or the error grows without bound",
            Cause::NoSolution => "the solver needs its fallback, or gives up",
            Cause::Zeno => "the bouncing ball, which rests after 1.355 s, never does",
            Cause::Hop => "what lies on the ground rises by more than 0.1 mm",
            Cause::Tunnelling => "something sinks in by more than 0.1 mm",
            Cause::Creep => "what sticks creeps faster than 1 µm/s",
            Cause::Drift => "the answer is off by more than 1 %, in flight the energy by 0.1 %",
            Cause::Order => "the same contacts in another order end elsewhere by more than 1 nm",
        }
    }

    /// The same as a number.
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

/// Ends of the metrics that thresholds have in the table.
pub const MEASURED: &str = " measured";
/// The other one.
pub const EXACT: &str = " exact";
/// In the table, of a method that passes.
pub const SOUND: &str = "sound";
/// In the table, of a method that a scene cannot be simulated with.
pub const REFUSED: &str = "refused";

/// A row for each cause of each failure, and one for each method and scene without any.
///
/// # Errors
/// Ctrl-C, or a scene that is refused for other reasons than its law or method.
pub fn rows(trials: &[Trial], progress: &Watch) -> Result<Vec<Row>, Failure> {
    let mut ways: Vec<Way> = Vec::new();
    let mut at_h: Vec<&Trial> = Vec::new();
    for trial in trials {
        if !ways.contains(&trial.way) {
            ways.push(trial.way);
        }
        let far = |trial: &Trial| (trial.h / H).ln().abs();
        match at_h.iter_mut().find(|known| known.case.name == trial.case.name && known.way == trial.way) {
            Some(known) if far(trial) < far(known) => *known = trial,
            Some(_) => {}
            None => at_h.push(trial),
        }
    }
    progress.expect(at_h.len() + ways.len());
    let compared = at_h.par_iter().map(|trial| {
        progress.step(Job::Failing)?;
        Ok(self::row(trial.case.name, trial.way, trial.h, &causes(trial)))
    });
    ways.retain(|way| way.method != Method::StepDoubling); // as of the cases where points come and go
    let zeno = ways.par_iter().map(|&way| {
        progress.step(Job::Failing)?;
        Ok(self::row(ZENO, way, H, &bouncing(way)?))
    });
    let rows: Vec<Vec<Row>> = compared.chain(zeno).collect::<Result<_, Failure>>()?;
    Ok(rows.into_iter().flatten().collect())
}

type Causes = Option<Vec<(Cause, f64)>>;

fn row(scene: &str, way: Way, h: f64, causes: &Causes) -> Vec<Row> {
    let row = |metric: &str, error: f64| Row {
        view: View::Failures,
        scene: scene.into(),
        engine: OURS.into(),
        method: way.name(),
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

/// Why a run fails, the gravest first; none if it was refused.
fn causes(trial: &Trial) -> Causes {
    let metrics = match &trial.result {
        Err(Fate::Refused) => return None,
        Err(Fate::Broken(error)) => return Some(vec![(broken(error), f64::INFINITY)]),
        Ok(metrics) => metrics,
    };
    let metric = |name: &str| metrics.iter().find(|metric| metric.0 == name).map_or(0.0, |metric| metric.1);
    let wrong = trial.case.question.metrics().iter().map(|name| metric(name)).fold(0.0, f64::max);
    // A thousandth of the energy counts as much as a hundredth of a distance.
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

/// The causes whose amount is beyond the limit, or no number.
fn failing(found: &[(Cause, f64)]) -> Vec<(Cause, f64)> {
    found.iter().copied().filter(|(cause, amount)| amount.is_nan() || *amount > cause.limit()).collect()
}

fn broken(error: &PlantError) -> Cause {
    match error {
        PlantError::NotFinite { .. } | PlantError::Singular { .. } => Cause::BlowUp,
        _ => Cause::NoSolution,
    }
}

/// How far the centre of mass ends from where it ends with the contact points of each body in reverse order [m].
fn disorder(trial: &Trial) -> f64 {
    let mut scene = trial.scene.clone();
    scene.bodies.iter_mut().for_each(|body| body.contacts.reverse());
    match watch(&scene, &[]) {
        Outcome::Done(log) => log.end().zip(trial.end).map_or(0.0, |(one, other)| (one - other).norm()),
        _ => 0.0,
    }
}

/// The ball that bounces to rest within 1.355 s: whether it does, and stays.
fn bouncing(way: Way) -> Result<Causes, Failure> {
    let scene = scene(ZENO, way, H, &[])?;
    let log = match watch(&scene, &[]) {
        Outcome::Refused => return Ok(None),
        Outcome::Broken(error) if broken(&error) == Cause::BlowUp => {
            return Ok(Some(vec![(Cause::BlowUp, f64::INFINITY)]));
        }
        Outcome::Broken(_) => return Ok(Some(vec![(Cause::Zeno, f64::INFINITY)])),
        Outcome::Done(log) => log,
    };
    let radius = scene.bodies[0].spheres.first().map_or(0.0, |ball| ball.radius);
    let heights = || log.sights.iter().map(|sight| (sight.time, sight.totals.com.z - radius));
    let late = heights().filter(|(time, _)| *time > 1.6).fold(0.0, |late: f64, (_, height)| late.max(height));
    let deep = heights().fold(0.0, |deep: f64, (_, height)| deep.max(-height));
    let found = [(Cause::Zeno, late), (Cause::Tunnelling, deep)];
    Ok(Some(failing(&found)))
}

/// The case that a column of the map belongs to, for its order.
pub fn columns(chosen: &[Case]) -> Vec<&'static str> {
    chosen.iter().map(|case| case.name).chain([ZENO]).collect()
}
