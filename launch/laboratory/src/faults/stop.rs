//! SIGSTOP and SIGCONT: processes that are alive but silent.

use super::test_session::{FaultTrial, LIMIT, SessionRole, TestSession, TrialOutcome, is, is_finite, send};
use crate::subject::eventually;
use messages::port::RecorderPort;
use nix::sys::signal::Signal;
use shared::exit::Exit;
use shared::output::temporary_folder;
use std::time::{Duration, Instant};

/// A stopped recorder's buffer of 1024 periods is full after this long.
const FULL: Duration = Duration::from_millis(1500);
/// Simulated duration of a lockstep run that takes seconds of real time, so that it can be stopped before its end [s].
const LENGTH: &str = "duration=200";
/// Window for the lateness of the loop.
const WINDOW: Duration = Duration::from_secs(3);

/// Stops one process of a lockstep run for a while. The run must end in the same state, bit for bit.
pub fn and_continue(victim: SessionRole, reference: &str, random: &mut fastrand::Rng) -> FaultTrial {
    let folder = temporary_folder("stop").map_err(|error| error.message)?;
    let out = folder.to_string_lossy().into_owned();
    let mut test_session = TestSession::run(&["--set", LENGTH, "--out", &out])?;
    test_session.is_set()?;
    let number = test_session.wait_for(victim)?;
    send(number, Signal::SIGSTOP)?;
    let pause = Duration::from_millis(random.u64(5..2000));
    std::thread::sleep(pause);
    let start = Instant::now();
    send(number, Signal::SIGCONT)?;
    let ended = test_session.must_end_some_time(start);
    let hash = hash(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    let (_, status, output) = ended?;
    match hash? {
        _ if !is(status, Exit::Ok) => Err(format!("stopped for {pause:?}: {status}: {output}")),
        hash if hash != reference => Err(format!("after a stop of {pause:?} the trajectory is different")),
        _ => Ok(TrialOutcome::default()),
    }
}

/// Hash of the trajectory of an undisturbed run, for [`and_continue`].
pub fn reference() -> Result<String, String> {
    let folder = temporary_folder("reference").map_err(|error| error.message)?;
    let out = folder.to_string_lossy().into_owned();
    let run = TestSession::run(&["--set", LENGTH, "--out", &out])?;
    run.must_end_some_time(Instant::now())?;
    let hash = hash(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    hash
}

fn hash(folder: &std::path::Path) -> Result<String, String> {
    let text = std::fs::read_to_string(folder.join("summary.json")).map_err(|error| format!("summary: {error}"))?;
    let json: serde_json::Value = serde_json::from_str(&text).map_err(|error| format!("summary: {error}"))?;
    Ok(json["trajectory_hash"].to_string())
}

/// Stops plant or controller for good. The others must report the silent process, and all must end. The time is measured from
/// the end of their time limit.
pub fn for_ever(victim: SessionRole, random: &mut fastrand::Rng) -> FaultTrial {
    let patience = Duration::from_secs(1);
    let pace: &[&str] = if random.bool() { &["--realtime"] } else { &[] };
    let mut test_session = TestSession::run(&[pace, &["--patience", "1", "--set", "duration=1000"]].concat())?;
    test_session.is_set()?;
    std::thread::sleep(Duration::from_millis(random.u64(0..500)));
    let number = test_session.wait_for(victim)?;
    send(number, Signal::SIGSTOP)?;
    let (took, status, output) = test_session.must_end(Instant::now() + patience)?;
    match output.contains("silent") || output.contains("answered within") || output.contains("sent sensors within") {
        true if !is(status, Exit::Ok) => Ok(took.into()),
        _ => Err(format!("{status}, and no message names the silent process: {output}")),
    }
}

/// Lateness of the loop in real time, alternately with a reading and with a stopped recorder. Medians are used because the load of the
/// machine varies.
pub fn the_recorder(rounds: usize) -> FaultTrial {
    let mut test_session =
        TestSession::run(&["--realtime", "--set", "duration=100000", "--set", "controller.gait=\"stand\""])?;
    test_session.is_set()?;
    // The launcher records. This process is a second recorder, which continues to read.
    let launcher = test_session.wait_for(SessionRole::Launcher)?;
    let mut port = RecorderPort::attach(&test_session.session).map_err(|error| error.to_string())?;
    let mut listen = |span: Duration| -> Result<[f64; 2], String> {
        let (mut late, start) = (vec![], Instant::now());
        while start.elapsed() < span {
            while let Some(truth) = port.read().map_err(|error| error.to_string())? {
                is_finite(&truth)?;
                late.push(truth.late_ns as f64 * 1e-3);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok([quantile(&mut late, 0.5), quantile(&mut late, 0.99)])
    };
    let (mut reading, mut stalled) = ([vec![], vec![]], [vec![], vec![]]);
    for _ in 0..rounds {
        let pair = [listen(WINDOW)?, {
            send(launcher, Signal::SIGSTOP)?;
            listen(FULL)?;
            listen(WINDOW)?
        }];
        send(launcher, Signal::SIGCONT)?;
        listen(WINDOW / 3)?;
        for share in 0..2 {
            reading[share].push(pair[0][share]);
            stalled[share].push(pair[1][share]);
        }
    }
    drop(port);
    send(launcher, Signal::SIGTERM)?;
    test_session.must_end(Instant::now())?;
    let [from, to] = [reading, stalled].map(|both| both.map(|mut values| quantile(&mut values, 0.5)));
    let ratio = [to[0] / from[0], to[1] / from[1]];
    let remark = format!(
        "median {:.1} → {:.1} µs (×{:.2}), p99 {:.0} → {:.0} µs (×{:.2}), {rounds} turns",
        from[0], to[0], ratio[0], from[1], to[1], ratio[1]
    );
    match ratio[0] < 1.5 && ratio[1] < 2.0 {
        true => Ok(TrialOutcome { time: None, remark }),
        false => Err(remark),
    }
}

/// A quantile.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get((values.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN)
}

/// Stops the launcher for good. Its processes must detect this and go on without a recorder.
pub fn the_launcher_for_ever() -> FaultTrial {
    let mut test_session = TestSession::run(&["--realtime", "--set", "duration=8"])?;
    test_session.is_set()?;
    let launcher = test_session.wait_for(SessionRole::Launcher)?;
    send(launcher, Signal::SIGSTOP)?;
    eventually("plant and controller end by themselves", LIMIT * 5, || {
        test_session.find(SessionRole::Plant).is_empty() && test_session.find(SessionRole::Controller).is_empty()
    })?;
    let start = Instant::now();
    send(launcher, Signal::SIGCONT)?;
    Ok(test_session.must_end(start)?.0.into())
}
