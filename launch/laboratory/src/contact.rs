//! `biped contact`: a contact problem that ended a run, read from a file and solved by each law.

use crate::study::tables::table;
use clap::Args;
use messages::scene::Law;
use plant::contact::{Memory, Problem, Solver, tangents};
use shared::exit::{Exit, Failure};
use shared::output::print_text;
use shared::unsolved_problem::UnsolvedProblem;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Number of solutions with each law; fewer for a slow law. The fastest counts.
const TRIALS: usize = 20;
const PATIENCE: Duration = Duration::from_millis(100);

/// Arguments of `biped contact`.
#[derive(Args)]
pub struct ContactArgs {
    /// File of the contact problem, as the run has written it
    file: PathBuf,
    /// Contact law to solve the problem with, for example Cone, Facets(12) or Sweep(50); repeatable. By default all laws
    #[arg(long = "law", value_name = "NAME")]
    laws: Vec<Law>,
}

/// Solves the problem of a file and prints a table.
///
/// # Errors
/// A file that cannot be read or is not a contact problem.
pub fn run(args: &ContactArgs) -> Result<(), Failure> {
    let refused = |reason| Failure::new(Exit::Usage, format!("{}: {reason}", args.file.display()));
    let case = UnsolvedProblem::read(&args.file).map_err(refused)?;
    let laws = if args.laws.is_empty() { &Law::ALL[..] } else { &args.laws };
    let Problem { contacts, tangents, .. } = case.problem;
    let residual = case.residual.map_or("none".into(), |residual| format!("{residual:.1e}"));
    print_text(format!(
        "Step {} at t = {:.4} s: {contacts} contacts, {tangents} tangents; {} left {residual}, not {:.1e}.\n\n",
        case.step, case.time, case.law, case.tolerance
    ));
    let columns =
        ["law", "own residual", "natural map", "Signorini", "energy J", "pivots", "fallback", "least time µs"];
    let rows = [columns.map(String::from).to_vec()].into_iter().chain(laws.iter().map(|&law| row(&case.problem, law)));
    print_text(table(&rows.collect::<Vec<_>>()));
    Ok(())
}

/// The result of one law, without a warm start, as a row of the table.
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
