//! kill −9: at random times, at every system call of start-up, and in a session with restarts.

use super::test_session::{FaultTrial, LIMIT, LONG, SessionRole, TestSession, TrialOutcome, is_finite, send, walk};
use crate::subject::{Subject, eventually};
use messages::clock::now_ns;
use messages::port::{Contract, ControllerPort, Pace, PlantPort, RecorderPort};
use messages::scene::Scene;
use messages::session::has_threads;
use messages::wire::{Command, Sensors, Stamp, Truth};
use nix::sys::signal::Signal;
use plant::Simulation;
use shared::output::temporary_folder;
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Range of the time of a kill after the start [ms]. The start-up takes a fifth of it.
const SPAN: u64 = 600;

/// Kills one process of a run at a random time. The others must report it and end. Their time begins when the killed process has ended,
/// which may take the system seconds while the machine writes much to a disk.
pub fn at_random(victim: SessionRole, random: &mut fastrand::Rng) -> FaultTrial {
    let pace: &[&str] = if random.bool() { &["--realtime"] } else { &[] };
    let test_session = TestSession::run(&[pace, &["--patience", "1", "--set", "duration=1000"]].concat())?;
    let wait = Duration::from_millis(random.u64(0..SPAN));
    std::thread::sleep(wait);
    let number = test_session.wait_for(victim)?;
    send(number, Signal::SIGKILL)?;
    eventually("the killed process ends", LONG, || !has_threads(number))?;
    let start = Instant::now();
    let (took, _, output) = test_session.must_end(start).map_err(|error| format!("killed after {wait:?}: {error}"))?;
    // a killed launcher reports nothing
    match victim {
        SessionRole::Launcher => Ok(took.into()),
        _ if output.contains(&format!("the {} failed", victim.name())) && output.contains("SIGKILL") => Ok(took.into()),
        _ => Err(format!("killed after {wait:?}, it was not named: {output}")),
    }
}

/// The system calls of a role until it waits for the other one: name, and number of calls with this name so far.
pub fn calls(role: SessionRole) -> Result<Vec<(String, u32)>, String> {
    let test_session = TestSession::empty();
    let folder = temporary_folder("calls").map_err(|error| error.message)?;
    let list = folder.join("calls");
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut strace = std::process::Command::new("strace");
    strace.arg("-qq").arg("-o").arg(&list).arg(program);
    strace.args([role.name(), "walk", "--patience", "0.1", "--session", test_session.session.name()]);
    Subject::start(&mut strace)?.end(LIMIT * 10)?;
    let text = std::fs::read_to_string(&list).map_err(|error| error.to_string());
    let _ = std::fs::remove_dir_all(&folder);
    let text = text?;
    let names = text.lines().filter_map(|line| line.split_once('(')).map(|(name, _)| name.to_string());
    let mut counts = HashMap::new();
    let count = |name: String| {
        let count = counts.entry(name.clone()).or_insert(0);
        *count += 1;
        (name, *count)
    };
    Ok(names.map(count).collect())
}

/// Kills a role just before a system call of its start-up, in a session that has another member. The files that it leaves must not block
/// a new process. Measures the time from the start of the new process to its first exchange.
pub fn at_call(victim: SessionRole, call: &(String, u32)) -> FaultTrial {
    let test_session = TestSession::empty();
    let (_, scene) = walk(&["duration=0.02"])?;
    let arguments =
        [victim.name(), "walk", "--patience", "1", "--set", "duration=0.02", "--session", test_session.session.name()];
    let mut strace = std::process::Command::new("strace");
    let (name, count) = call;
    strace.args(["-qq", "-o", "/dev/null", "-e", &format!("inject={name}:signal=KILL:when={count}")]);
    strace.arg(std::env::current_exe().map_err(|error| error.to_string())?).args(arguments);
    let at = |error: String| format!("killed at {name} {count}: {error}");
    let mut peer = SurvivingPeer::open(victim, &test_session, &scene).map_err(at)?;
    let mut dying = Subject::start(&mut strace)?;
    eventually("the killed process ends", LIMIT * 10, || {
        let _ = peer.answer();
        dying.has_ended()
    })
    .map_err(at)?;
    let start = Instant::now();
    let mut successor = Subject::biped(&arguments)?;
    peer.done = false;
    let mut lost = None;
    let answered = eventually("a successor is answered", LIMIT, || {
        let has_ended = successor.has_ended(); // checked before its last messages are read
        lost = peer.answer().err();
        peer.done || lost.is_some() || has_ended
    });
    let took = start.elapsed();
    if let Some(error) = answered.err().or(lost) {
        return Err(at(error));
    }
    if !peer.done {
        return Err(at(format!("its successor ended: {}", successor.output())));
    }
    eventually("its successor ends", LIMIT, || {
        let _ = peer.answer(); // goodbye
        successor.has_ended()
    })
    .map_err(at)?;
    let (status, output) = successor.end(LIMIT).map_err(at)?;
    drop(peer);
    let left = test_session.session.shm_files();
    match () {
        () if !status.success() => Err(at(format!("its successor ended with {status}: {output}"))),
        () if !left.is_empty() => Err(at(format!("left {}", left[0].display()))),
        () => Ok(took.into()),
    }
}

/// The peer of the killed process, played by this program.
struct SurvivingPeer {
    place: SurvivorPort,
    /// The sensors of the robot, if this program is the plant.
    sensors: Sensors,
    /// Whether all messages of the other side have been read.
    done: bool,
}

enum SurvivorPort {
    Plant(Box<PlantPort>),
    Controller(Box<ControllerPort>),
}

impl SurvivingPeer {
    fn open(victim: SessionRole, test_session: &TestSession, scene: &Scene) -> Result<SurvivingPeer, String> {
        let contract = &Contract::of(scene, Pace::Lockstep);
        let sensors = Simulation::new(scene, 1, 1).map_err(|error| error.to_string())?.sensors();
        let place = match victim {
            SessionRole::Plant => {
                ControllerPort::open(&test_session.session, contract).map(Box::new).map(SurvivorPort::Controller)
            }
            SessionRole::Controller | SessionRole::Launcher => {
                PlantPort::open(&test_session.session, contract).map(Box::new).map(SurvivorPort::Plant)
            }
        };
        Ok(SurvivingPeer { place: place.map_err(|error| error.to_string())?, sensors, done: false })
    }

    /// One exchange, or a short wait.
    fn answer(&mut self) -> Result<(), String> {
        let sent = match &mut self.place {
            SurvivorPort::Controller(port) => port.wait().and_then(|sensors| {
                let Some(Sensors { stamp, last, .. }) = sensors else { return Ok(()) };
                self.done |= last != 0;
                let stamp = Stamp { run: stamp.run, seq: stamp.seq, ack: stamp.seq, epoch: 1, ..Stamp::default() };
                port.send(Command { stamp, ..Command::default() })
            }),
            SurvivorPort::Plant(port) => {
                self.sensors.stamp.seq += 1;
                let said = port.send(Sensors { last: u64::from(self.done), ..self.sensors });
                said.and_then(|()| port.wait()).map(|command| self.done |= command.is_some())
            }
        };
        sent.map_err(|error| error.to_string())
    }
}

/// Repeatedly kills plant or controller of a lockstep walk with restarts. Measures the time from each kill to the first accepted command of
/// the new process, and for comparison the time that the host takes to start this program.
pub fn and_respawn(victim: SessionRole, trials: usize, random: &mut fastrand::Rng) -> Result<Vec<FaultTrial>, String> {
    let most = trials.to_string();
    let mut test_session = TestSession::run(&["--respawn", &most, "--set", "duration=100000"])?;
    test_session.is_set()?;
    let mut port = RecorderPort::attach(&test_session.session).map_err(|error| error.to_string())?;
    let mut files = None;
    let mut next = |what: &str, holds: &dyn Fn(&Truth) -> bool| -> Result<Truth, String> {
        let (mut found, mut wrong) = (None, None);
        eventually(what, LIMIT, || {
            while let (Ok(Some(truth)), None, None) = (port.read(), found, &wrong) {
                wrong = is_finite(&truth).err();
                found = holds(&truth).then_some(*truth);
            }
            found.is_some() || wrong.is_some()
        })?;
        wrong.map_or(Ok(()), Err)?;
        found.ok_or_else(|| what.into())
    };
    let (mut results, mut host) = (vec![], vec![]);
    for _ in 0..trials {
        host.push(start_of_a_process()?);
        let now = now_ns();
        let before = next("a walk", &|truth| truth.stamp.mono_ns > now && truth.state == 1)?;
        let files = *files.get_or_insert_with(|| test_session.session.shm_files().len());
        std::thread::sleep(Duration::from_millis(random.u64(50..400)));
        let number = test_session.wait_for(victim)?;
        let killed = now_ns();
        send(number, Signal::SIGKILL)?;
        let is_new = |truth: &Truth| {
            let another = truth.stamp.run != before.stamp.run || truth.tally.takeovers > before.tally.takeovers;
            truth.stamp.mono_ns > killed && another && truth.stamp.seq > 1
        };
        let first = next("a new process drives", &is_new);
        let time = first.map(|first| Duration::from_nanos(first.stamp.mono_ns - killed));
        host.sort_unstable();
        let of_host = [host.len() / 2, host.len() - 1].map(|nth| host[nth].as_millis());
        let remark = format!(
            "the host starts a program in {}, at most {} ms; the session had {files} files, and has {}",
            of_host[0],
            of_host[1],
            test_session.session.shm_files().len()
        );
        results.push(time.map(|time| TrialOutcome { time: Some(time), remark }));
        if results.last().is_some_and(Result::is_err) {
            break;
        }
    }
    drop(port);
    send(test_session.wait_for(SessionRole::Launcher)?, Signal::SIGTERM)?;
    test_session.must_end(Instant::now())?;
    Ok(results)
}

/// Time to start this program without doing anything.
fn start_of_a_process() -> Result<Duration, String> {
    let start = Instant::now();
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    std::process::Command::new(program).arg("--version").output().map_err(|error| error.to_string())?;
    Ok(start.elapsed())
}
