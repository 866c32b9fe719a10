//! Options of a plant process, and why it ended early.

use crate::PlantError;
use messages::legible;
use messages::port::{Pace, PortError};
use std::time::Duration;

/// Why a plant process ended before the end of its scene.
#[derive(Debug, thiserror::Error)]
pub enum PlantProcessError {
    /// The connection could not be opened, or it failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The simulation failed.
    #[error("plant: {0}")]
    Plant(#[from] PlantError),
    /// No controller answered in lockstep, or none started; with the counters so far.
    #[error("no controller answered within {patience} s{1}", patience = legible(.0.as_secs_f64()))]
    NoController(Duration, String),
    /// The controller stopped sending, and nobody re-armed the drives.
    #[error("the controller was silent for {0} control periods: the drives were switched off")]
    Silent(u64),
    /// Ctrl-C or SIGTERM.
    #[error("interrupted")]
    Interrupted,
}

/// Options of a plant process.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Lockstep or real time.
    pub pace: Pace,
    /// In real time: simulated time per real time [-].
    pub speed: f64,
    /// How long to wait for a controller.
    pub patience: Duration,
}
