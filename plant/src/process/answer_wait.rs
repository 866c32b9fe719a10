//! The wait of a plant for the command that answers its sensors, in lockstep. The plant of this crate uses it, and plants in other
//! languages do.

use super::error::PlantProcessError;
use crate::command_pipeline::CommandPipeline;
use messages::clock::{Timeout, now_ns};
use messages::port::{PlantPort, PortError};
use messages::wire::{Sensors, Stamp};
use std::time::Duration;

/// Result of one part of the wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waited {
    /// The answer to the sensors. Before the first command was accepted, only an accepted answer counts.
    Answered,
    /// Another command.
    Received,
    /// No command.
    Nothing,
}

/// The waits for the answers of a run, one after the other.
pub struct AnswerWait {
    timeout: Timeout,
    patience: Duration,
    /// When sensors were last sent [ns].
    last_sent_ns: u64,
}

impl AnswerWait {
    /// Waits of at most `patience` for each answer.
    pub fn new(patience: Duration) -> AnswerWait {
        AnswerWait { timeout: Timeout::new("controller", patience), patience, last_sent_ns: 0 }
    }

    /// Begins the wait for the answer to sensors that were sent at this time [ns].
    pub fn begin(&mut self, sent_ns: u64) {
        self.timeout.restart();
        self.last_sent_ns = sent_ns;
    }

    /// Waits for the next command, for some milliseconds at most, and receives it.
    ///
    /// # Errors
    /// If the connection fails.
    pub fn poll(
        &mut self,
        port: &mut PlantPort,
        commands: &mut CommandPipeline,
        sensors: &Sensors,
    ) -> Result<Waited, PortError> {
        let Some(command) = port.wait()? else { return Ok(Waited::Nothing) };
        commands.receive(&command, sensors.stamp.seq);
        let is_answer = command.answers(&sensors.stamp) && commands.has_command();
        Ok(if is_answer { Waited::Answered } else { Waited::Received })
    }

    /// Sends the same sensors again from time to time, and the controller repeats its answer. So the controller learns that the plant is
    /// alive, and a message that a connection has lost is replaced.
    ///
    /// # Errors
    /// If the connection fails.
    pub fn heartbeat(&mut self, port: &PlantPort, sensors: &Sensors) -> Result<(), PortError> {
        if now_ns() - self.last_sent_ns > PlantPort::HEARTBEAT_NS {
            self.last_sent_ns = now_ns();
            port.send(Sensors { stamp: Stamp { mono_ns: self.last_sent_ns, ..sensors.stamp }, ..*sensors })?;
        }
        Ok(())
    }

    /// Restarts the patience, because a request has stopped simulated time.
    pub fn restart(&mut self) {
        self.timeout.restart();
    }

    /// Whether the patience is over.
    pub fn is_over(&mut self) -> bool {
        self.timeout.has_expired()
    }

    /// Checks that the patience is not over.
    ///
    /// # Errors
    /// [`PlantProcessError::NoController`] if it is, with the counters so far.
    pub fn check(&mut self, commands: &CommandPipeline) -> Result<(), PlantProcessError> {
        if !self.is_over() {
            return Ok(());
        }
        let counters = commands.tally().to_string();
        let counters = if counters.is_empty() { counters } else { format!("; {counters}") };
        Err(PlantProcessError::NoController(self.patience, counters))
    }
}
