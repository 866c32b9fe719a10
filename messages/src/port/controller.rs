//! The controller's end of the connection.

use super::contract::Contract;
use super::node::{COMMAND, SENSORS, SessionNode};
use super::opening::unblocked;
use super::placement::Placement;
use super::receiver::Receiver;
use super::sender::Sender;
use super::service::{self, ControlService, PendingRequest};
use super::waiting::Waiting;
use crate::action::{Action, GaitRequest};
use crate::error::PortError;
use crate::session::Session;
use crate::wire::{Command, Reply, Sensors, Stamp, Verdict};

/// The controller's end of the connection.
#[derive(Debug)]
pub struct ControllerPort {
    // Rust drops fields in their order. A successor waits for the writer of commands, so the service must be free before it.
    service: ControlService,
    command: Sender<Command>,
    sensors: Receiver<Sensors>,
    _node: SessionNode,
}

impl ControllerPort {
    /// Joins a session as its controller.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<ControllerPort, PortError> {
        ControllerPort::open_when_free(session, contract, || false)
    }

    /// Joins a session as its controller as soon as the present controller has left. It waits while `keep_waiting` returns true.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open_when_free(
        session: &Session,
        contract: &Contract,
        keep_waiting: impl Fn() -> bool,
    ) -> Result<ControllerPort, PortError> {
        unblocked(session, || ControllerPort::join(session, contract, keep_waiting))
    }

    fn join(
        session: &Session,
        contract: &Contract,
        keep_waiting: impl Fn() -> bool,
    ) -> Result<ControllerPort, PortError> {
        let node = SessionNode::open(session, contract)?;
        let sensors = Receiver::open(&node, SENSORS, contract.pace)?;
        let command = Sender::open(&node, COMMAND, "controller", keep_waiting)?;
        let service = ControlService::open(&node, service::CONTROLLER, "controller")?;
        node.reserve()?;
        command.notify_arrival()?; // a waiting plant then sends its last sensors at once
        Ok(ControllerPort { service, command, sensors, _node: node })
    }

    /// As [`PlantPort::waiting`](super::PlantPort::waiting).
    pub fn waiting(mut self, waiting: Waiting) -> ControllerPort {
        (self.sensors.waiting, self.command.waiting) = (waiting, waiting);
        self
    }

    /// As [`PlantPort::sharing`](super::PlantPort::sharing).
    pub fn sharing(mut self, processor: Option<usize>) -> ControllerPort {
        self.sensors.placement = processor.map(Placement::new);
        self
    }

    /// Seals and sends a command, and wakes the plant.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn send(&self, command: Command) -> Result<(), PortError> {
        self.command.send(command, self.sensors.peer())
    }

    /// Sends a command without sealing it: one that another process has sealed, or a damaged one in a test.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn send_raw(&self, command: Command) -> Result<(), PortError> {
        self.command.write(command, |_| (), self.sensors.peer())
    }

    /// Waits up to 10 ms for sensors, as [`PlantPort::wait`](super::PlantPort::wait).
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn wait(&mut self) -> Result<Option<Sensors>, PortError> {
        self.command.prepare()?;
        self.sensors.wait()
    }

    /// As [`PlantPort::next_request`](super::PlantPort::next_request).
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn next_request(&self) -> Result<Option<PendingRequest>, PortError> {
        self.service.next()
    }

    /// Answers all requests that have arrived: those to the gait by the verdict of `answer`, and all others by a refusal. `stamp` is that of
    /// the controller's last command.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn serve(&self, stamp: Stamp, mut answer: impl FnMut(GaitRequest) -> Verdict) -> Result<(), PortError> {
        while let Some(pending) = self.next_request()? {
            let verdict = match Action::decode(&pending.request) {
                Ok(Action::Gait(request)) => answer(request),
                Ok(_) => Verdict::WrongProcess,
                Err(verdict) => verdict,
            };
            self.answer(pending, Reply { stamp, verdict: verdict as u64, state: 0 })?;
        }
        Ok(())
    }

    /// As [`PlantPort::answer`](super::PlantPort::answer).
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, pending: PendingRequest, reply: Reply) -> Result<(), PortError> {
        self.service.answer(pending, reply)
    }
}
