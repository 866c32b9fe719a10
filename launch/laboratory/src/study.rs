//! `biped study`: tables that the documents quote. Each case is a scene with some values changed.

use messages::load::load;
use messages::scene::Scene;
use rayon::prelude::*;
use records::analysis::RunAnalysis;
use records::summary::Summary;
use sessions::run::{check_run, in_process};
use shared::csv;
use shared::exit::{Exit, Failure};
use shared::list::SCENES;
use shared::progress::BatchProgress;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

mod args;
mod cases;
mod orbit;
mod problems;
mod pushes;
pub mod tables;

pub use args::StudyArgs;
use args::{Study, belongs_to};
use cases::{StudyCase, cases};
use tables::{publish, table};

/// The result: a summary, also of a fall, or why there is none.
pub type RunOutcome = Result<Summary, String>;

/// Runs the cases of a study on all cores, prints the table, and writes it if `--out` is given.
///
/// # Errors
/// Ctrl-C, a folder that cannot be written, or a bad case (excluded by a test). Falls and simulations that blow up
/// are rows of the table.
pub fn run(args: &StudyArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let solves = matches!(args.study, Study::Problems);
    if args.count.is_some() && !solves {
        return Err(belongs_to("--count", "problems"));
    }
    args.pushes.check(args.study)?;
    args.out.as_deref().map_or(Ok(()), |folder| tables::prepare(folder, args.study))?;
    if let Study::Pushes = args.study {
        return pushes::run(args, stop);
    }
    if solves {
        let count = args.count.unwrap_or(1_000_000) as usize;
        let counter = BatchProgress::new(args.quiet, count, 0, "problems");
        let mut results = problems::solve(count, stop, |more| counter.add_done(more))?;
        counter.finish();
        let rows = problems::rows(&mut results);
        return publish(args, &table(&rows), &[("", csv::text(&rows))]);
    }
    let cases = cases(args.study);
    let counter = BatchProgress::new(args.quiet, cases.len(), 0, "cases");
    let study = |case| {
        let outcome = simulate(case, stop);
        counter.add_done(1);
        outcome
    };
    let outcomes: Vec<RunOutcome> = cases.par_iter().map(study).collect::<Result<_, Failure>>()?;
    counter.finish();
    let rows = rows(args.study, &cases, &outcomes);
    let more = match args.study {
        Study::Attraction => format!("\n{}", table(&orbit::rows(stop)?)),
        _ => String::new(),
    };
    publish(args, &(markdown(&rows, &outcomes) + &more), &[("", with_commands(rows, &cases))])
}

fn simulate(case: &StudyCase, stop: &AtomicBool) -> Result<RunOutcome, Failure> {
    observe(case.scene, &load(case.scene, &case.settings, SCENES)?, stop)
}

/// Runs a scene in this process, to its end or its fall.
///
/// # Errors
/// Only Ctrl-C. Every other failure is an outcome of the run.
pub fn observe(name: &str, scene: &Scene, stop: &AtomicBool) -> Result<RunOutcome, Failure> {
    let (mut recorder, start) = (RunAnalysis::without_rows(scene), Instant::now());
    let result = in_process(scene, |truth| {
        recorder.push(truth);
        check_run(&recorder, stop)
    });
    match result {
        Err(failure) if failure.exit == Exit::Interrupted => Err(failure),
        // a failure after a fall is a consequence of the fall
        Err(failure) if recorder.extrema.fall.is_none() => Ok(Err(failure.message)),
        _ => Ok(Ok(Summary::new(name, &recorder, start.elapsed(), 1))),
    }
}

/// Whether the scene is refused before its first control period, because the robot cannot do what it asks for.
pub fn is_refused(scene: &Scene) -> bool {
    let mut begins = false;
    let _ = in_process(scene, |_| {
        begins = true;
        Err(Failure::new(Exit::Ok, "it begins"))
    });
    !begins
}

type StudyColumn = (&'static str, fn(&Summary) -> String);

/// Columns that a study shows.
fn columns(study: Study) -> Vec<StudyColumn> {
    let all: [StudyColumn; 8] = [
        ("x m", |s| fixed(s.distance_m, 2)),
        ("y m", |s| fixed(s.lateral_m, 3)),
        ("yaw °", |s| fixed(s.yaw_deg, 2)),
        ("m/s", |s| fixed(s.speed_mps, 3)),
        ("period s", |s| fixed(s.period_s, 3) + " ± " + &fixed(s.period_std_s, 3)),
        ("x_2 min mm", |s| fixed(1e3 * s.x2_min_m, 1)),
        ("peak N·m", |s| fixed(s.peak_torque_nm.into_iter().fold(0.0, f64::max), 1)),
        ("tilt °", |s| fixed(s.foot_tilt_max_deg, 2)),
    ];
    let contact: [StudyColumn; 9] = [
        ("hop mm", |s| fixed(1e3 * s.hop_max_m, 2)),
        ("sinks mm", |s| fixed(1e3 * s.penetration_max_m, 3)),
        ("peak force N", |s| fixed(s.peak_force_n, 0)),
        ("slip angle °", |s| fixed(s.slip_misalignment_max_deg, 1)),
        ("Signorini", |s| format!("{:.0e}", s.signorini_max)),
        ("natural map", |s| format!("{:.0e}", s.natural_map_max)),
        ("energy gain J", |s| format!("{:.0e}", s.energy_gain_max_j)),
        ("fallbacks", |s| s.fallbacks.to_string()),
        ("µs/step", |s| fixed(1e6 * s.plant_median_s / s.steps_per_period as f64, 2)),
    ];
    let more: &[StudyColumn] = if let Study::Laws = study { &contact } else { &[] };
    all.iter().chain(more).copied().collect()
}

/// A number; a dash if it could not be measured, or if the simulation blew up after a fall.
fn fixed(value: f64, digits: usize) -> String {
    if value.abs() < 1e6 { format!("{value:.digits$}") } else { "-".into() }
}

/// The table as cells. The first row names the columns.
fn rows(study: Study, cases: &[StudyCase], outcomes: &[RunOutcome]) -> Vec<Vec<String>> {
    let columns = columns(study);
    let names = ["case", "outcome"].into_iter().chain(columns.iter().map(|column| column.0));
    let cells = |outcome: &RunOutcome| match outcome {
        Err(error) => [error.clone()].into_iter().chain(columns.iter().map(|_| String::new())).collect(),
        Ok(summary) => {
            let fate = summary.fall_time_s.map_or("up".into(), |time| format!("fell at {time:.1} s"));
            [fate].into_iter().chain(columns.iter().map(|column| column.1(summary))).collect::<Vec<_>>()
        }
    };
    let body = cases.iter().zip(outcomes).map(|(case, outcome)| [vec![case.name.clone()], cells(outcome)].concat());
    [names.map(String::from).collect()].into_iter().chain(body).collect()
}

fn markdown(rows: &[Vec<String>], outcomes: &[RunOutcome]) -> String {
    let up = outcomes.iter().filter(|outcome| outcome.as_ref().is_ok_and(|summary| !summary.fell)).count();
    format!("{}\n{up} of {} stay up.\n", table(rows), outcomes.len())
}

/// The same with the command line that repeats each case.
fn with_commands(mut rows: Vec<Vec<String>>, cases: &[StudyCase]) -> String {
    let command = |case: &StudyCase| {
        let settings = case.settings.iter().map(|setting| format!(" --set '{setting}'"));
        format!("biped run {}{}", case.scene, settings.collect::<String>())
    };
    let commands = ["command".into()].into_iter().chain(cases.iter().map(command));
    rows.iter_mut().zip(commands).for_each(|(row, command)| row.push(command));
    csv::text(&rows)
}

#[cfg(test)]
mod tests {
    use super::cases::case;
    use super::*;
    use clap::ValueEnum;

    #[test]
    fn every_case_of_every_study_is_a_good_scene_and_has_its_own_name() {
        for study in Study::value_variants() {
            let cases = cases(*study);
            for (i, case) in cases.iter().enumerate() {
                assert!(load(case.scene, &case.settings, SCENES).is_ok(), "{study:?}: {}", case.name);
                assert!(cases[..i].iter().all(|other| other.name != case.name), "{study:?}: {} twice", case.name);
            }
        }
    }

    #[test]
    fn a_simulation_that_blows_up_is_a_row_and_not_the_end_of_the_study() {
        // friction makes it spin too fast for any step
        let wild = case("too fast", "drop", &["initial.velocity=[1e30, 1e30, -1e30]"]);
        let calm = case("as it is", "drop", &["duration=0.01"]);
        let stop = AtomicBool::new(false);
        let outcomes = [&wild, &calm].map(|case| simulate(case, &stop).expect("not interrupted"));
        assert!(outcomes[0].as_ref().is_err_and(|words| words.contains("plant.dt is too long")), "{:?}", outcomes[0]);
        let rows = rows(Study::Laws, &[wild, calm], &outcomes);
        assert!(rows[1][1].contains("plant.dt is too long") && rows[2][1] == "up", "{rows:?}");
        assert!(rows.iter().all(|row| row.len() == rows[0].len()));
        assert!(markdown(&rows, &outcomes).ends_with("1 of 2 stay up.\n"));
    }
}
