//! What a fuzzer calls, built by `tests/fuzz/run` alone, which says how: bytes in; out comes a run, or a sentence and its exit code.
//!
//! A panic, five seconds of the processor, energy out of nothing, a state that is no number, or a refusal that is no sentence are findings.

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
use shared::exit::{Exit, Failure};
use shared::list::SCENES;
use std::path::PathBuf;
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;

/// Steps and control periods of a run at most: what is done within a second, whatever the scene asks for.
const STEPS: f64 = 500.0;
const PERIODS: f64 = 50.0;
/// Energy that a period may make, as a part of what there is: a run tells of a hundredth of its motion [-].
const MADE: f64 = 1e-6;
/// Longest time of the processor for one input [s]; `tests/fuzz/run` ends what never ends, by the clock.
const LONGEST: f64 = 5.0;
/// Longest sentence [bytes].
const SENTENCE: usize = 1500;

/// What the bytes are, by the variable `BIPED_FUZZ`.
#[derive(Clone, Copy)]
enum FuzzTarget {
    /// A scene in TOML.
    Scene,
    /// Settings of the walk, one a line.
    Set,
    /// A robot in TOML or URDF, put into the walk.
    Robot,
    /// A contact problem in JSON, solved by every law.
    Contact,
    /// A recording in MCAP: looked at, fed to a controller and to a plant, made tables and a page of.
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
    let begun = seconds();
    let outcome = match *TARGET {
        FuzzTarget::Scene => scene(&String::from_utf8_lossy(input)),
        FuzzTarget::Set => set(&String::from_utf8_lossy(input)),
        FuzzTarget::Robot => load("walk", &[format!("robot={}", file(input).display())], SCENES).map_err(Failure::from).and_then(walks),
        FuzzTarget::Contact => commands(input, &[&["contact"]]),
        FuzzTarget::Recording => commands(input, &[&["info"], &["replay"], &["replay", "--plant"]]),
    };
    let took = seconds() - begun;
    assert!(took < LONGEST, "it took {took} s");
    if let Err(Failure { exit, message, .. }) = outcome {
        let known = [Exit::Usage, Exit::Fault, Exit::Incompatible, Exit::Fell, Exit::Unsolved].contains(&exit);
        assert!(known && !message.is_empty() && message.len() < SENTENCE, "{exit:?}: {message}");
    }
});

/// Time of the processor so far [s]: other programs take none of it.
fn seconds() -> f64 {
    let time = clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).expect("a clock");
    time.tv_sec() as f64 + time.tv_nsec() as f64 * 1e-9
}

/// A recording of this version to begin with, in the folder that is named last.
///
/// mcap 0.26 subtracts the length of a record from what is left of its chunk, however long it says it is. As a release that wraps, and what
/// follows is refused; with checks it panics, which ends the file.
fn begin() {
    let abort = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !panic.location().is_some_and(|place| place.file().contains("/mcap-0.26.")) {
            abort(panic);
        }
    }));
    if let FuzzTarget::Recording = *TARGET {
        let file = format!("{}/good.mcap", std::env::args().next_back().expect("a folder"));
        let wish = ["biped", "run", "stand", "--in-process", "--quiet", "--set", "duration=0.01", "--record", &file];
        dispatch(Cli::try_parse_from(wish).expect("a command"), &AtomicBool::new(false).into()).expect("a recording");
    }
}

fn scene(text: &str) -> Result<(), Failure> {
    let scene = parse(text, "fuzz")?;
    validate(&scene, "fuzz")?;
    if only_loses(&scene) {
        energy::check(&scene, periods(&scene) as usize, MADE)?;
    }
    walks(scene)
}

/// Whether nothing in a scene gives energy back or makes it: no springs, pushes, bounces, controller, nor a method that says it does.
fn only_loses(scene: &Scene) -> bool {
    let plant = &scene.plant;
    let lawful = plant.method == Method::MidpointContact && matches!(plant.law, Law::Cone | Law::Aligned);
    let passive = scene.controller.is_none() && scene.bodies.iter().all(|body| body.joint.is_none());
    lawful && passive && plant.restitution == 0.0 && plant.push_impulse == [0.0; 3]
}

/// No robot of a file: that is another target.
fn set(text: &str) -> Result<(), Failure> {
    let settings: Vec<String> =
        text.lines().filter(|line| !line.trim_start().starts_with("robot")).map(String::from).collect();
    walks(load("walk", &settings, SCENES)?)
}

/// A short while of a scene, and every number of it is one.
fn walks(scene: Scene) -> Result<(), Failure> {
    let duration = periods(&scene) / scene.rate;
    in_process(&Scene { duration, ..scene }, |truth| {
        let numbers = truth.base_position.iter().chain(&truth.base_velocity).chain(&truth.angle).chain(&truth.rate);
        assert!(numbers.copied().all(f64::is_finite), "at {} ns: {truth:?}", truth.stamp.sim_ns);
        Ok(())
    })
}

/// Control periods to be run; none where a single one takes too many steps.
fn periods(scene: &Scene) -> f64 {
    let steps = 1.0 / (scene.rate * scene.plant.dt);
    (scene.duration * scene.rate).min(STEPS / steps).min(PERIODS).floor()
}

/// These commands on a file of these bytes, up to the first that fails.
fn commands(input: &[u8], commands: &[&[&str]]) -> Result<(), Failure> {
    let file = file(input);
    for command in commands {
        let words = ["biped"].iter().chain(*command).map(PathBuf::from).chain([file.clone()]);
        let cli = Cli::try_parse_from(words).expect("a command");
        dispatch(cli, &AtomicBool::new(false).into())?;
    }
    Ok(())
}

/// These bytes as a file in memory.
fn file(input: &[u8]) -> PathBuf {
    let path = PathBuf::from(format!("/dev/shm/biped-fuzz-{}", std::process::id()));
    std::fs::write(&path, input).expect("room");
    path
}
