//! What happened in a run, in words, for the log panel.

use messages::wire::{PHASES, STATES, Truth};
use schemars::JsonSchema;
use serde::Serialize;

/// `foxglove.Log`.
#[derive(Serialize, JsonSchema)]
pub(super) struct LogMessage {
    timestamp: FoxgloveTime,
    level: u8,
    message: String,
    name: &'static str,
    file: &'static str,
    line: u32,
}

impl LogMessage {
    fn new(time: u64, level: u8, message: String) -> LogMessage {
        LogMessage { timestamp: FoxgloveTime::new(time), level, message, name: "biped", file: "", line: 0 }
    }

    /// Something that is not of the run itself.
    pub fn warning(time: u64, message: String) -> LogMessage {
        LogMessage::new(time, WARNING, message)
    }
}

/// A time of Foxglove's messages.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(super) struct FoxgloveTime {
    sec: u64,
    nsec: u32,
}

impl FoxgloveTime {
    /// Of nanoseconds.
    pub fn new(ns: u64) -> FoxgloveTime {
        FoxgloveTime { sec: ns / 1_000_000_000, nsec: (ns % 1_000_000_000) as u32 }
    }
}

const INFO: u8 = 2;
const WARNING: u8 = 3;

/// What was known before.
#[derive(Default)]
pub(super) struct EventDetector {
    before: Option<Truth>,
}

impl EventDetector {
    /// What this truth tells that the one before did not.
    pub fn of(&mut self, truth: &Truth, time: u64) -> Vec<LogMessage> {
        let log = |level, message| LogMessage::new(time, level, message);
        let Some(before) = self.before.replace(*truth) else {
            return vec![log(INFO, format!("run {:016x} begins", truth.stamp.run))];
        };
        let mut logs = vec![];
        if truth.state != before.state {
            let name = STATES.get(truth.state as usize).copied().unwrap_or("?");
            logs.push(log(if name == "run" { INFO } else { WARNING }, format!("plant: {name}")));
        }
        if truth.telemetry.phase != before.telemetry.phase {
            let name = PHASES.get(truth.telemetry.phase as usize).copied().unwrap_or("?");
            logs.push(log(INFO, format!("controller: {name}")));
        }
        // What is counted at every period says so once it begins.
        let news = [
            (truth.tally.takeovers > before.tally.takeovers, "another controller has taken over"),
            (truth.fallbacks > before.fallbacks, "a contact problem needed a fallback"),
            (truth.tally.refused != before.tally.refused, "a command was refused"),
            (truth.tally.skipped > before.tally.skipped, "real time was ahead: periods are skipped"),
        ];
        logs.extend(news.iter().filter(|(is_so, _)| *is_so).map(|(_, what)| log(WARNING, (*what).into())));
        logs
    }
}
