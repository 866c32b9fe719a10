//! `biped run`: runs a scene, records it, and prints a summary.

mod args;
mod idle_keys;
mod monitor;
mod one_process;
mod role_starter;
mod set_points;
mod two_processes;
mod warnings;

use crate::children::require_program;
use crate::model::RunModel;
use controller::Controller;
use controller::process::ProcessError;
use messages::legible;
use messages::load;
use messages::scene::Scene;
use monitor::{RunMonitor, fall_failure};
use nix::time::ClockId;
use plant::smallest::smallest;
use records::recording::McapRecorder;
use records::report;
use records::summary::Summary;
use shared::exit::{Exit, Failure};
use shared::output::{log, print_text, refuse_overwriting_input, write_failure};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use warnings::{warn_of_energy_error, warn_of_penetration, warn_of_settings_without_effect, warn_of_unfinished_stop};

pub use args::RunArgs;
pub use monitor::check_run;
pub use one_process::{InProcess, in_process};
pub use warnings::warn_of_duration;

/// Runs a scene. A run that ends early is summarized and reported too.
///
/// # Errors
/// Why the run failed, with an exit code. A fall is a failure.
pub fn run(args: &RunArgs, stop: &AtomicBool) -> Result<(), Failure> {
    args.system.check_pace(args.pace.pace())?;
    args.share.check(args.session.is_some())?;
    let start = Instant::now() - processor_time(); // includes the start of the program
    let named_scene = args.scene.load()?;
    let plan = args.smallest.then(|| smallest(&named_scene)).transpose()?;
    let scene = plan.as_ref().map_or(&named_scene, |plan| &plan.scene);
    check_arguments(args, scene)?;
    warn_of_duration(scene);
    warn_of_settings_without_effect(scene);
    idle_keys::named(&args.scene, scene).iter().for_each(log);
    let push_out = warn_of_penetration(scene);
    let mut monitor = RunMonitor::new(scene, args.out.is_some(), args.quiet);
    let new_folder = args.out.as_deref().filter(|folder| !folder.exists());
    args.out.as_deref().map_or(Ok(()), report::prepare)?;
    monitor.recording = args.record.recorder(scene)?;
    let outcome = match args.in_process {
        true => one_process::run(scene, &mut monitor, stop),
        false => two_processes::run(args, scene, &mut monitor, stop),
    };
    monitor.progress.finish();
    if let Some(Err(end)) = monitor.recording.take().map(McapRecorder::finish) {
        log(format_args!("{}", end.message));
        monitor.recording_end = Some(end);
    }
    if monitor.lost > 0 {
        log(format_args!("{} control periods were not recorded", monitor.lost));
    }
    if monitor.latest.seq == 0 {
        new_folder.map(std::fs::remove_dir); // it is empty
        return outcome
            .and(Err(Failure::new(Exit::Fault, "the run ended before its first control period was recorded")));
    }
    let processes = if args.in_process || scene.controller.is_none() { 1 } else { 2 };
    let wall = start.elapsed();
    let RunModel { size, cost_ratio } = RunModel::of(&named_scene, plan.as_ref())?;
    let summary = Summary::new(&args.scene.scene, &monitor.recorder, wall, processes).with_model(size, cost_ratio);
    let recording_ended_by = monitor.recording_end.as_ref().map(|end| end.message.clone());
    let summary = Summary { recording_ended_by, ..summary.with_end(outcome.as_ref().err()) };
    // The report is written before the summary is printed, because a write error of standard output ends the program.
    let report = args.out.as_deref().map_or(Ok(()), |folder| {
        let written = report::write(folder, &monitor.recorder, &summary, scene, &load::text(scene));
        written.map_err(|error| write_failure(folder, &error))
    });
    if outcome.is_ok() || summary.duration_s > 0.0 {
        print_text(&summary); // after a failed start there is no summary
    }
    if outcome.is_ok() {
        warn_of_energy_error(&summary, &scene.plant.ground, push_out);
        warn_of_unfinished_stop(scene, &monitor.recorder);
    }
    report?;
    if let Some(folder) = &args.out {
        print_text(format_args!("  {:<20} {}\n", "report", folder.join("report.html").display()));
    }
    let recorded = match monitor.recording_end.filter(|end| end.exit != Exit::Ok) {
        Some(end) => Err(Failure::new(end.exit, "the run is complete, but its recording is not")),
        None => Ok(()),
    };
    with_fall(outcome.and(recorded), summary.fall_time_s)
}

/// Checks that the arguments fit the scene and that no output replaces an input.
fn check_arguments(args: &RunArgs, scene: &Scene) -> Result<(), Failure> {
    if scene.controller.is_none() && (args.controller.is_some() || !args.swap.is_empty()) {
        let words = format!("scene {} has no controller, so --controller and --swap have no effect", args.scene.scene);
        return Err(Failure::new(Exit::Usage, words));
    }
    if let Some(late) = args.swap.iter().find(|swap| swap.time >= scene.duration) {
        let words = format!("--swap {}: the run ends at {} s", legible(late.time), legible(scene.duration));
        return Err(Failure::new(Exit::Usage, words));
    }
    for (option, command) in args.programs() {
        require_program(&command).map_err(|words| Failure::new(Exit::Usage, format!("{option}{command}: {words}")))?;
    }
    if scene.controller.is_some() && args.controller.is_none() {
        Controller::new(scene).map_err(ProcessError::from)?; // it refuses set-points, heights and robots: before any process starts
    }
    for output in args.record.path().into_iter().chain(args.out.as_deref()) {
        for input in [Some(&args.scene.scene), args.scene.robot.as_ref()].into_iter().flatten() {
            refuse_overwriting_input(Path::new(input), output)?;
        }
    }
    Ok(())
}

/// The outcome of a run in which the robot may have fallen. A fall is a failure, and a fault after a fall is its consequence.
fn with_fall(outcome: Result<(), Failure>, fall_time: Option<f64>) -> Result<(), Failure> {
    match (fall_time, outcome) {
        (Some(time), Ok(())) => Err(fall_failure(time)),
        (Some(time), Err(failure)) if matches!(failure.exit, Exit::Fault | Exit::Unrecorded) => {
            Err(Failure::new(Exit::Fell, format!("the robot fell after {time:.2} s; then {}", failure.message)))
        }
        (_, outcome) => outcome,
    }
}

/// Processor time of this process so far.
fn processor_time() -> Duration {
    ClockId::CLOCK_PROCESS_CPUTIME_ID.now().map_or(Duration::ZERO, Duration::from)
}
