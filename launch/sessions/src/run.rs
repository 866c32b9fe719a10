//! The main job: run a scene, watch over it, record it, and say what came out.

mod args;
mod one_process;
mod two_processes;
mod watch;

use crate::model::RunModel;
use messages::load;
use messages::scene::Scene;
use nix::time::ClockId;
use plant::Plant;
use plant::smallest::smallest;
use records::recording::McapRecorder;
use records::report;
use records::summary::Summary;
use shared::exit::{Exit, Failure};
use shared::output::{keeps, say, tell, unwritten};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use watch::{Watch, fell};

pub use args::RunArgs;
pub use one_process::{disturbed_in_process, in_process};
pub use watch::goes_on;

/// A depth at the beginning that is told; less is the rounding of a pose that somebody wrote down [m].
const TOLD_DEPTH: f64 = 1e-6;

/// Energy made that is told, as a part of the greatest kinetic energy [-]: what the default leaves a walk is a hundredth of this.
const TOLD_ENERGY: f64 = 0.02;

/// Runs a scene. Also of a run that was cut short, what was recorded is summed up and written.
///
/// # Errors
/// A sentence and an exit code; a fall is one of them.
pub fn run(args: &RunArgs, stop: &AtomicBool) -> Result<(), Failure> {
    args.system.suits(args.pace.pace())?;
    let begun = Instant::now() - processor_time(); // so much of it the program took to get here
    let written = args.scene.load()?;
    let plan = args.smallest.then(|| smallest(&written)).transpose()?;
    let scene = plan.as_ref().map_or(&written, |plan| &plan.scene);
    if scene.controller.is_none() && (args.controller.is_some() || !args.swap.is_empty()) {
        let alone = format!("scene {} has no controller, so --controller and --swap do nothing", args.scene.scene);
        return Err(Failure::new(Exit::Usage, alone));
    }
    if let Some(late) = args.swap.iter().find(|swap| swap.time >= scene.duration) {
        let words = format!("--swap {}: the run ends at {} s", late.time, scene.duration);
        return Err(Failure::new(Exit::Usage, words));
    }
    tell_depth(scene);
    let mut watch = Watch::new(scene, args.out.is_some(), args.quiet);
    for output in args.record.path().into_iter().chain(args.out.as_deref()) {
        for input in [Some(&args.scene.scene), args.scene.robot.as_ref()].into_iter().flatten() {
            keeps(Path::new(input), output)?;
        }
    }
    args.out.as_deref().map_or(Ok(()), report::prepare)?;
    watch.tape = args.record.recorder(scene)?;
    let outcome = match args.in_process {
        true => one_process::run(scene, &mut watch, stop),
        false => two_processes::run(args, scene, &mut watch, stop),
    };
    watch.progress.finish();
    if let Some(Err(end)) = watch.tape.take().map(McapRecorder::finish) {
        tell(format_args!("{}", end.message));
        watch.end = Some(end);
    }
    if watch.lost > 0 {
        tell(format_args!("{} control periods were not recorded", watch.lost));
    }
    if watch.latest.seq == 0 {
        return outcome.and(Err(Failure::new(Exit::Fault, "the run ended, but nothing of it was recorded")));
    }
    let processes = if args.in_process || scene.controller.is_none() { 1 } else { 2 };
    let wall = begun.elapsed();
    let RunModel { size, cost_ratio } = RunModel::of(&written, plan.as_ref())?;
    let summary = Summary::new(&args.scene.scene, &watch.recorder, wall, processes).with_model(size, cost_ratio);
    let recording_ended_by = watch.end.as_ref().map(|end| end.message.clone());
    let summary = Summary { recording_ended_by, ..summary.with_end(outcome.as_ref().err()) };
    // The report before the summary is printed: a standard output that is full ends this program.
    let report = args.out.as_deref().map_or(Ok(()), |folder| {
        let written = report::write(folder, &watch.recorder, &summary, scene, &load::text(scene));
        written.map_err(|error| unwritten(folder, &error))
    });
    if outcome.is_ok() || summary.duration_s > 0.0 {
        say(&summary); // a start that failed has none
    }
    if outcome.is_ok() {
        tell_energy(&summary);
    }
    report?;
    if let Some(folder) = &args.out {
        say(format_args!("  {:<20} {}\n", "report", folder.join("report.html").display()));
    }
    let failed = watch.end.filter(|end| end.exit != Exit::Ok);
    let recorded =
        failed.map_or(Ok(()), |end| Err(Failure::new(end.exit, "the run is over, but not all of it is recorded")));
    match (summary.fall_time_s, outcome.and(recorded)) {
        // What fails after a fall fails because of it.
        (Some(time), Ok(())) => Err(fell(time)),
        (Some(time), Err(failure)) if matches!(failure.exit, Exit::Fault | Exit::Unrecorded) => {
            Err(Failure::new(Exit::Fell, format!("the robot fell after {time:.2} s; then {}", failure.message)))
        }
        (_, outcome) => outcome,
    }
}

/// Says so if energy was made or lost by nobody.
fn tell_energy(summary: &Summary) {
    let Summary { energy_made_j, energy_lost_j, kinetic_max_j: kinetic, .. } = summary;
    let is_pushed = summary.requests.iter().any(|asked| asked.impulse_ns.is_some());
    for (what, energy, is_known, other) in [
        ("made", *energy_made_j, is_pushed, ""),
        ("lost", *energy_lost_j, false, ", and a method of second order loses less"),
    ] {
        if energy > TOLD_ENERGY * kinetic && !is_known {
            tell(format_args!(
                "the run {what} {energy:.1e} J, of {kinetic:.1e} J of motion at most: plant.dt is too long for plant.method{other}"
            ));
        }
    }
}

/// Says so if the scene begins inside the ground. What keeps a plant from being made is told by the run.
fn tell_depth(scene: &Scene) {
    let depth = Plant::new(scene).map_or(0.0, |plant| plant.truth().penetration);
    if depth > TOLD_DEPTH {
        let millimetres = depth * 1e3;
        tell(format_args!(
            "the scene begins {millimetres:.3} mm inside the ground, which lifts it out: initial.clearance = 0 puts it on the ground"
        ));
    }
}

/// What this process has computed so far.
fn processor_time() -> Duration {
    ClockId::CLOCK_PROCESS_CPUTIME_ID.now().map_or(Duration::ZERO, Duration::from)
}
