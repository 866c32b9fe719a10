//! Names behind the numbers in messages.

/// Names of [`Telemetry::phase`](super::Telemetry).
pub const PHASES: [&str; 6] = ["stand", "sway", "lift", "walk", "land", "rest"];

/// Names of [`Truth::state`](super::Truth): not yet driven; driven; standing still in time; on old torques; damped; drives off until
/// re-armed.
pub const STATES: [&str; 6] = ["wait", "run", "paused", "hold", "damp", "fault"];

/// Why a command is refused, in the order in which the gate looks.
pub const REFUSALS: [&str; 9] = [
    "of another version",
    "for another run",
    "of a controller that has been replaced",
    "damaged",
    "not newer than the last",
    "ahead of the sensors",
    "not finite",
    "beyond four times the torque limit",
    "a jump beyond twice the torque limit",
];

/// Names of [`Request::kind`](super::Request).
pub const REQUESTS: [&str; 7] = ["pause", "resume", "step", "reset", "push", "rearm", "set"];

/// Names of [`Reply::verdict`](super::Reply).
pub const VERDICTS: [&str; 5] =
    ["done", "this request is for the other process", "no such body", "a number is out of range", "damaged request"];
