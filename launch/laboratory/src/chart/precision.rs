//! View (i): error against CPU time per simulated second, for steps from coarse to fine.

use super::cases::{self, Combination, ComparisonScene, HOP, PENETRATION, combinations, steps};
use super::core::Core;
use super::csv::{Measurement, OURS, View};
use super::metrics::{Metric, SIGNORINI, metrics};
use super::trial::{RunEnd, time, watch_until};
use super::watch::{ChartProgress, Job};
use messages::scene::Scene;
use nalgebra::Vector3;
use plant::PlantError;
use rayon::prelude::*;
use shared::exit::{Exit, Failure};

/// Why a run has no metrics.
#[derive(Clone, Debug)]
pub enum NoMetrics {
    /// The method cannot simulate the scene.
    Refused,
    /// The run broke off.
    Broken(PlantError),
}

/// One run of the sweep.
#[derive(Clone, Debug)]
pub struct MethodTrial {
    /// The scene.
    pub case: ComparisonScene,
    /// Law and integrator.
    pub combination: Combination,
    /// Step [s].
    pub h: f64,
    /// The scene as it ran.
    pub scene: Scene,
    /// Metrics, or why there are none.
    pub result: Result<Vec<Metric>, NoMetrics>,
    /// Steps that needed the solver's fallback.
    pub fallbacks: u64,
    /// Where the centre of mass ended [m].
    pub end: Option<Vector3<f64>>,
    /// Hash of every state.
    pub hash: u64,
    /// CPU time [s].
    pub seconds: f64,
}

/// Every case with every method and step: first recorded in parallel, then timed one after the other.
///
/// # Errors
/// Ctrl-C, a scene that is refused, or a timed run that differs from the recorded one.
pub fn trials(chosen: &[ComparisonScene], quick: bool, watch: &ChartProgress) -> Result<Vec<MethodTrial>, Failure> {
    let mut plan = Vec::new();
    for case in chosen {
        for combination in combinations(case) {
            let duration = cases::scene(case.name, combination, 1e-3, &[])?.duration;
            plan.extend(steps(case, combination, duration, quick).into_iter().map(|h| (*case, combination, h)));
        }
    }
    watch.expect(2 * plan.len());
    let mut trials: Vec<MethodTrial> =
        plan.into_par_iter().map(|plan| run(plan, watch)).collect::<Result<_, Failure>>()?;
    let _core = Core::hold();
    for trial in trials.iter_mut().filter(|trial| trial.result.is_ok()) {
        watch.step(Job::Timing)?;
        let (seconds, hash) = time(&trial.scene, &[], watch.stop)?;
        if hash != trial.hash {
            let message = format!(
                "{} with {}: the timed run differs from the watched one",
                trial.case.name,
                trial.combination.name()
            );
            return Err(Failure::new(Exit::Fault, message));
        }
        trial.seconds = seconds;
    }
    Ok(trials)
}

fn run(
    (case, combination, h): (ComparisonScene, Combination, f64),
    progress: &ChartProgress,
) -> Result<MethodTrial, Failure> {
    progress.step(Job::Watching)?;
    let scene = cases::scene(case.name, combination, h, &[])?;
    let mut trial = MethodTrial {
        case,
        combination,
        h,
        scene,
        result: Ok(Vec::new()),
        fallbacks: 0,
        end: None,
        hash: 0,
        seconds: f64::NAN,
    };
    match watch_until(&trial.scene, &[], progress.stop) {
        RunEnd::Refused => trial.result = Err(NoMetrics::Refused),
        RunEnd::Broken(error) => trial.result = Err(NoMetrics::Broken(error)),
        RunEnd::Done(log) => {
            trial.end = log.end();
            trial.result = Ok(metrics(case.question, &trial.scene, &log));
            (trial.fallbacks, trial.hash) = (log.fallbacks, log.hash);
        }
    }
    Ok(trial)
}

impl MethodTrial {
    /// Rows of the table. The errors of a run that broke off are infinite.
    pub fn rows(&self) -> Vec<Measurement> {
        let row = |metric: &str, error: f64| Measurement {
            view: View::Precision,
            scene: self.case.name.into(),
            engine: OURS.into(),
            method: self.combination.name(),
            dt: self.h,
            metric: metric.into(),
            error,
            cost: self.seconds / self.scene.duration,
            us_per_step: 1e6 * self.seconds / self.scene.periods() as f64,
        };
        match &self.result {
            Ok(metrics) => metrics.iter().map(|metric| row(metric.0, metric.1)).collect(),
            Err(NoMetrics::Broken(_)) => {
                self.case.question.metrics().iter().map(|name| row(name, f64::INFINITY)).collect()
            }
            Err(NoMetrics::Refused) => Vec::new(),
        }
    }
}

/// Violations below which a method obeys Coulomb's law up to rounding: of (19), relative to the step's scale [-]; of the gap, as a hop or a
/// penetration [m].
const OBEYS: [(&str, f64); 3] = [(SIGNORINI, 1e-8), (HOP, 1e-7), (PENETRATION, 1e-7)];

/// Whether a method does not converge to Coulomb's law; the drawings have a hollow mark for it.
///
/// `runs` are rows of one method in one scene. Under a method that converges, the violations of (19) and of the gap shrink with the step at
/// least as its square root. A method is hollow if its violation at the finest step is above rounding, and greater than that at the coarsest step
/// times the square root of the ratio of the steps.
pub fn is_hollow(runs: &[&Measurement]) -> bool {
    OBEYS.iter().any(|&(metric, rounding)| {
        let mut values: Vec<_> =
            runs.iter().filter(|row| row.metric == metric).map(|row| (row.dt, row.error)).collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        match values.as_slice() {
            [finest, .., coarsest] => {
                let expected = (finest.0 / coarsest.0).sqrt();
                finest.1 > rounding && finest.1 > expected * coarsest.1
            }
            _ => false,
        }
    })
}
