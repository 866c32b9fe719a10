//! Processes that do not belong to a session: a second one in a role, and one with another contract.

use super::test_session::{FaultTrial, LIMIT, SessionRole, TestSession, TrialOutcome, is, walk};
use crate::conform;
use crate::subject::Subject;
use messages::port::{Contract, ControllerPort, Pace, PlantPort, PortError};
use shared::exit::Exit;
use std::time::{Duration, Instant};

/// The disturbed walk.
const WALK: [&str; 2] = ["--set", "duration=1000"];

/// A second process in a role must be refused with a sentence, and the first one must go on.
pub fn second(role: SessionRole) -> FaultTrial {
    let mut test_session = TestSession::run(&WALK)?;
    test_session.is_set()?;
    let start = Instant::now();
    let intruder = match role {
        SessionRole::Launcher => vec!["run", "walk", "--quiet"],
        role => vec![role.name(), "walk", "--set", WALK[1]],
    };
    let intruder = Subject::biped(&[&intruder[..], &["--session", test_session.session.name()]].concat())?;
    let (status, output) = intruder.end(LIMIT)?;
    let took = start.elapsed();
    if !is(status, Exit::Incompatible) || !(output.contains("already")) {
        return Err(format!("it was not refused: {status}: {output}"));
    }
    walks_on(&test_session)?;
    Ok(took.into())
}

/// A peer with another wire schema, model, rate or pace must be refused with both values, and the first peer must continue.
pub fn other_contract() -> FaultTrial {
    let mut test_session = TestSession::run(&WALK)?;
    test_session.is_set()?;
    let (_, scene) = walk(&[WALK[1]])?;
    let ours = Contract::of(&scene, Pace::Lockstep);
    let mut named = vec![];
    for (_, other) in conform::others(&ours) {
        let opened = [
            ControllerPort::open(&test_session.session, &other).err(),
            PlantPort::open(&test_session.session, &other).err(),
        ];
        for error in opened {
            match error {
                Some(PortError::Incompatible { what, theirs, ours, .. }) if theirs != ours => named.push(what),
                other => return Err(format!("not refused as incompatible: {other:?}")),
            }
        }
    }
    walks_on(&test_session)?;
    named.dedup();
    Ok(TrialOutcome { time: None, remark: format!("each refused with both values: {}", named.join(", ")) })
}

/// Checks that the original processes are still running a moment later.
fn walks_on(test_session: &TestSession) -> Result<(), String> {
    std::thread::sleep(Duration::from_millis(200));
    let there =
        [SessionRole::Plant, SessionRole::Controller, SessionRole::Launcher].map(|role| test_session.find(role).len());
    if there == [1, 1, 1] { Ok(()) } else { Err(format!("of plant, controller and launcher there are {there:?}")) }
}
