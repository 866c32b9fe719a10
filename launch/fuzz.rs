//! The entry point of the fuzzer, which `tests/fuzz/run` builds. Each input is run, or refused with a sentence and an exit code.
//!
//! Findings are: a panic, more than five seconds of processor time, an energy gain of a passive scene, a state that is not finite, and an error
//! without a sentence.

#![allow(unsafe_code, reason = "the fuzzer calls a function by its name")]
#![expect(clippy::expect_used, clippy::panic, reason = "a panic is a finding")]

#[path = "../tests/fuzz/energy.rs"]
mod energy;

use crate::{Cli, dispatch};
use clap::Parser;
use libfuzzer_sys::fuzz_target;
use messages::load::{load, parse, validate};
use messages::scene::{Law, Method, Scene};
use nix::time::{ClockId, clock_gettime};
use sessions::run::in_process;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::list::SCENES;
use shared::output::shortened;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;

/// Largest number of integration steps of a run. They take less than a second in any scene.
const MAX_STEPS: f64 = 500.0;
/// Largest number of control periods of a run.
const MAX_PERIODS: f64 = 50.0;
/// A greater energy gain in one control period is a finding, relative to the energy [-]. A run warns at a hundredth of its kinetic energy.
const MAX_GAIN: f64 = 1e-6;
/// Longest processor time of one input [s]. `tests/fuzz/run` ends an input that never returns, by the wall clock.
const MAX_TIME: f64 = 5.0;
/// A scene is interrupted, as by Ctrl-C, at the end of the control period in which its processor time exceeds this [s]. Its steps may be
/// slow, but it has to end.
const INTERRUPTED_AFTER: f64 = 2.0;
/// Greatest ratio of the inertias of a scene [-]: with more, rounding (1e-16) leaves less than four digits of the lesser.
const MAX_RATIO: f64 = 1e12;
/// Longest error message, as the program prints it [characters]: an excerpt of a file has several lines of up to 400.
const MAX_MESSAGE: usize = 2500;

/// The kind of input, by the environment variable `BIPED_FUZZ`.
#[derive(Clone, Copy)]
enum FuzzTarget {
    /// A scene in TOML.
    Scene,
    /// Settings of the walk, one per line.
    Set,
    /// A robot in TOML or URDF, for the walk.
    Robot,
    /// A contact problem in JSON, which every law solves.
    Contact,
    /// A recording in MCAP, which is inspected and replayed to a controller and to a plant.
    Recording,
}

static TARGET: LazyLock<FuzzTarget> = LazyLock::new(|| match std::env::var("BIPED_FUZZ").as_deref() {
    Ok("scene") => FuzzTarget::Scene,
    Ok("set") => FuzzTarget::Set,
    Ok("robot") => FuzzTarget::Robot,
    Ok("contact") => FuzzTarget::Contact,
    Ok("recording") => FuzzTarget::Recording,
    other => panic!("BIPED_FUZZ is {other:?}, not scene, set, robot, contact or recording"),
});

fuzz_target!(init: begin(), |input: &[u8]| {
    let start = seconds();
    let outcome = match *TARGET {
        FuzzTarget::Scene => scene(&String::from_utf8_lossy(input), start + INTERRUPTED_AFTER),
        FuzzTarget::Set => set(&String::from_utf8_lossy(input)),
        FuzzTarget::Robot => robot(&file(input)),
        FuzzTarget::Contact => commands(input, &[&["contact"]]),
        FuzzTarget::Recording => commands(input, &[&["info"], &["replay"], &["replay", "--plant"]]),
    };
    let took = seconds() - start;
    assert!(took < MAX_TIME, "it took {took} s");
    if let Err(Failure { exit, message, .. }) = outcome {
        let known = [Exit::Usage, Exit::Fault, Exit::Incompatible, Exit::Fell, Exit::Unsolved, Exit::Interrupted].contains(&exit);
        assert!(known && !message.is_empty() && shortened(&message).chars().count() < MAX_MESSAGE, "{exit:?}: {message}");
    }
});

/// Processor time of this process so far [s]. It does not depend on other programs.
fn seconds() -> f64 {
    let time = clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).expect("a clock");
    time.tv_sec() as f64 + time.tv_nsec() as f64 * 1e-9
}

/// Writes a recording of this version as a seed, into the folder that the last argument names.
fn begin() {
    if let FuzzTarget::Recording = *TARGET {
        let file = format!("{}/good.mcap", std::env::args().next_back().expect("a folder"));
        let arguments =
            ["biped", "run", "stand", "--in-process", "--quiet", "--set", "duration=0.01", "--record", &file];
        dispatch(Cli::try_parse_from(arguments).expect("a command"), &AtomicBool::new(false).into())
            .expect("a recording");
    }
}

/// Runs a scene, until the processor time `end` at most [s].
fn scene(text: &str, end: f64) -> Result<(), Failure> {
    let scene = parse(text, "fuzz")?;
    validate(&scene, "fuzz")?;
    if !is_within_precision(&scene) {
        return Ok(());
    }
    if is_passive(&scene) {
        energy::check(&scene, periods(&scene) as usize, MAX_GAIN, || seconds() < end)?;
    }
    runs(scene, || check_interrupt(&AtomicBool::new(seconds() >= end)))
}

/// Whether the inertias that a contact point meets differ by less than [`MAX_RATIO`]. Otherwise one step can take ten seconds, which
/// docs/RELIABILITY.md explains.
fn is_within_precision(scene: &Scene) -> bool {
    let inertias = scene.bodies.iter().flat_map(|body| {
        let points = body.contacts.iter().chain(body.spheres.iter().map(|ball| &ball.at)).chain([&body.size]);
        let reach = points.flatten().chain(&body.com).fold(f64::MIN_POSITIVE, |most: f64, part| most.max(part.abs()));
        body.moments().map(|moment| moment / reach.powi(2)).into_iter().chain([body.mass])
    });
    let (least, most) =
        inertias.fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), one| (least.min(one), most.max(one)));
    most <= MAX_RATIO * least
}

/// Whether a scene can only lose energy: it has no springs, pushes, restitution or controller, and its law and method gain none.
fn is_passive(scene: &Scene) -> bool {
    let plant = &scene.plant;
    let never_gains = plant.method == Method::MidpointContact && matches!(plant.law, Law::Cone | Law::Aligned);
    let is_undriven = scene.controller.is_none() && scene.bodies.iter().all(|body| body.joint.is_none());
    never_gains && is_undriven && plant.restitution == 0.0 && plant.push_impulse == [0.0; 3]
}

/// Runs the walk with settings, except those that name a robot file, which is another target.
fn set(text: &str) -> Result<(), Failure> {
    let settings: Vec<String> =
        text.lines().filter(|line| !line.trim_start().starts_with("robot")).map(String::from).collect();
    runs(load("walk", &settings, SCENES)?, || Ok(()))
}

/// Runs the walk of the robot in a file.
fn robot(file: &Path) -> Result<(), Failure> {
    runs(load("walk", &[format!("robot={}", file.display())], SCENES)?, || Ok(()))
}

/// Runs a scene for a short time, until `check` fails. All of its numbers have to be finite.
fn runs(scene: Scene, check: impl Fn() -> Result<(), Failure>) -> Result<(), Failure> {
    let duration = periods(&scene) / scene.rate;
    in_process(&Scene { duration, ..scene }, |truth| {
        let numbers = truth.base_position.iter().chain(&truth.base_velocity).chain(&truth.angle).chain(&truth.rate);
        assert!(numbers.copied().all(f64::is_finite), "at {} ns: {truth:?}", truth.stamp.sim_ns);
        check()
    })
}

/// Number of control periods to run; none if a single one has too many steps.
fn periods(scene: &Scene) -> f64 {
    let steps = 1.0 / (scene.rate * scene.plant.dt);
    (scene.duration * scene.rate).min(MAX_STEPS / steps).min(MAX_PERIODS).floor()
}

/// Runs commands on a file with these bytes, until one fails.
fn commands(input: &[u8], commands: &[&[&str]]) -> Result<(), Failure> {
    let file = file(input);
    for command in commands {
        let words = ["biped"].iter().chain(*command).map(PathBuf::from).chain([file.clone()]);
        let cli = Cli::try_parse_from(words).expect("a command");
        dispatch(cli, &AtomicBool::new(false).into())?;
    }
    Ok(())
}

/// Writes the bytes to a file in shared memory.
fn file(input: &[u8]) -> PathBuf {
    let path = PathBuf::from(format!("/dev/shm/biped-fuzz-{}", std::process::id()));
    std::fs::write(&path, input).expect("room");
    path
}
