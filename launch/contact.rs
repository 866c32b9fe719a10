//! `biped contact`: a contact problem that ended a run, as a file, and what each law makes of it.

use crate::exit::{Exit, Failure};
use crate::output::{say, write_whole};
use crate::study::table;
use clap::Args;
use messages::scene::Law;
use plant::PlantError;
use plant::contact::{Memory, Problem, Solver, tangents};
use plant::process::PlantProcessError;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Solves of each law, of which the fastest counts; fewer of a law that is slow.
const TRIALS: usize = 20;
const PATIENCE: Duration = Duration::from_millis(100);

/// Arguments of `biped contact`.
#[derive(Args)]
pub struct ContactArgs {
    /// File that a run has written
    file: PathBuf,
    /// Law to solve it with, also Facets(12) and any Sweep(n); repeatable. Without it: all others
    #[arg(long = "law", value_name = "NAME")]
    laws: Vec<Law>,
}

/// A contact problem, and what became of it in a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    step: u64,
    time: f64,
    law: Law,
    /// Absent if there was no impulse at all.
    residual: Option<f64>,
    tolerance: f64,
    problem: Problem,
}

impl Case {
    /// The case that a plant failed with, if it did with one.
    pub fn of(error: PlantProcessError) -> Option<Case> {
        match error {
            PlantProcessError::Plant(PlantError::Unsolved { step, time, law, residual, tolerance, problem }) => {
                let residual = Some(residual).filter(|residual| residual.is_finite());
                Some(Case { step, time, law, residual, tolerance, problem: *problem })
            }
            _ => None,
        }
    }

    /// Writes it to a file in the working folder; says where, or why not.
    pub fn keep(&self) -> String {
        let path = PathBuf::from(format!("contact-{}-step-{}.json", std::process::id(), self.step));
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        match write_whole(&path, &(text + "\n")) {
            Ok(()) => format!("; it is in {0}: see `biped contact {0}`", path.display()),
            Err(error) => format!("; it cannot be written: {error}"),
        }
    }

    fn read(args: &ContactArgs) -> Result<Case, Failure> {
        let refused = |reason: String| Failure::new(Exit::Usage, format!("{}: {reason}", args.file.display()));
        let text = messages::file::text(&args.file).map_err(|error| refused(error.to_string()))?;
        let case: Case =
            serde_json::from_str(&text).map_err(|error| refused(format!("not a contact problem: {error}")))?;
        case.problem.check().map_err(|reason| refused(format!("not a contact problem: {reason}")))?;
        Ok(case)
    }
}

/// Solves the problem of a file and prints a table.
///
/// # Errors
/// A file that cannot be read or is no contact problem.
pub fn run(args: &ContactArgs) -> Result<(), Failure> {
    let case = Case::read(args)?;
    let laws = if args.laws.is_empty() { &Law::ALL[..] } else { &args.laws };
    let Problem { contacts, tangents, .. } = case.problem;
    let residual = case.residual.map_or("none".into(), |residual| format!("{residual:.1e}"));
    say(format!(
        "Step {} at t = {:.4} s: {contacts} contacts, {tangents} tangents; {} left {residual}, not {:.1e}.\n\n",
        case.step, case.time, case.law, case.tolerance
    ));
    let columns =
        ["law", "own residual", "natural map", "Signorini", "energy J", "pivots", "fallback", "least time µs"];
    let rows = [columns.map(String::from).to_vec()].into_iter().chain(laws.iter().map(|&law| row(&case.problem, law)));
    say(table(&rows.collect::<Vec<_>>()));
    Ok(())
}

/// What one law makes of it, from a fresh start.
fn row(problem: &Problem, law: Law) -> Vec<String> {
    if tangents(law) > problem.tangents {
        return [law.to_string(), "needs two tangents".into()].into_iter().chain(vec!["-".into(); 6]).collect();
    }
    let problem = problem.narrowed(tangents(law));
    let mut solver = Solver::default();
    let (mut report, mut least) = (Default::default(), f64::INFINITY);
    let begun = Instant::now();
    for trial in 0..TRIALS {
        if trial > 0 && begun.elapsed() > PATIENCE {
            break;
        }
        let start = Instant::now();
        report = solver.solve(&problem, law, &mut Memory::default());
        least = least.min(start.elapsed().as_secs_f64());
    }
    vec![
        law.to_string(),
        format!("{:.1e}", report.own),
        format!("{:.1e}", report.natural_map),
        format!("{:.1e}", report.signorini),
        format!("{:.2e}", report.energy_gain),
        report.pivots.to_string(),
        if report.fallback { "yes" } else { "no" }.into(),
        format!("{:.1}", 1e6 * least),
    ]
}
