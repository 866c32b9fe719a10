//! Events of a run as text, for the log panel of Foxglove.

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

    /// A warning.
    pub fn warning(time: u64, message: String) -> LogMessage {
        LogMessage::new(time, WARNING, message)
    }
}

/// `foxglove.Time`.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(super) struct FoxgloveTime {
    sec: u64,
    nsec: u32,
}

impl FoxgloveTime {
    /// The time of a number of nanoseconds.
    pub fn new(ns: u64) -> FoxgloveTime {
        FoxgloveTime { sec: ns / 1_000_000_000, nsec: (ns % 1_000_000_000) as u32 }
    }
}

/// Levels of `foxglove.Log`.
const INFO: u8 = 2;
const WARNING: u8 = 3;

/// Detects events by comparing successive records.
#[derive(Default)]
pub(super) struct EventDetector {
    previous: Option<Truth>,
}

impl EventDetector {
    /// The events between the previous record and this one.
    pub fn detect(&mut self, truth: &Truth, time: u64) -> Vec<LogMessage> {
        let log = |level, message| LogMessage::new(time, level, message);
        let Some(previous) = self.previous.replace(*truth) else {
            return vec![log(INFO, format!("run {:016x} begins", truth.stamp.run))];
        };
        let mut logs = vec![];
        if truth.state != previous.state {
            let name = STATES.get(truth.state as usize).copied().unwrap_or("?");
            logs.push(log(if name == "run" { INFO } else { WARNING }, format!("plant: {name}")));
        }
        if truth.telemetry.phase != previous.telemetry.phase {
            let name = PHASES.get(truth.telemetry.phase as usize).copied().unwrap_or("?");
            logs.push(log(INFO, format!("controller: {name}")));
        }
        // Refusals are reported once, when their counters start to change.
        let warnings = [
            (truth.tally.takeovers > previous.tally.takeovers, "another controller has taken over"),
            (truth.fallbacks > previous.fallbacks, "a contact problem needed a fallback"),
            (truth.tally.refused != previous.tally.refused, "a command was refused"),
            (truth.tally.skipped > previous.tally.skipped, "the simulation is behind real time: periods are skipped"),
        ];
        logs.extend(
            warnings.iter().filter(|(has_occurred, _)| *has_occurred).map(|(_, text)| log(WARNING, (*text).into())),
        );
        logs
    }
}
