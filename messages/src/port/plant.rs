//! The plant's end of the connection.

use super::contract::Contract;
use super::node::{COMMAND, SENSORS, SessionNode};
use super::opening::unblocked;
use super::placement::Placement;
use super::receiver::Receiver;
use super::sender::Sender;
use super::service::{self, ControlService, PendingRequest};
use super::truth::TruthSender;
use super::waiting::Waiting;
use crate::error::PortError;
use crate::session::Session;
use crate::wire::{Command, Reply, Sensors, Truth};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A tunnel looks for messages at least this often.
const TUNNEL_POLL: Duration = Duration::from_millis(200);

/// The plant's end of the connection.
#[derive(Debug)]
pub struct PlantPort {
    sensors: Sender<Sensors>,
    command: Receiver<Command>,
    truth: TruthSender,
    service: ControlService,
    node: SessionNode,
}

impl PlantPort {
    /// A plant that waits sends its sensors again this often [ns].
    pub const HEARTBEAT_NS: u64 = 100_000_000;

    /// Joins a session as its plant.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<PlantPort, PortError> {
        PlantPort::open_with_stop(session, contract, Arc::default())
    }

    /// The same for a process that is asked to stop by `stop`: from then on the port hardly waits for a recorder, which may have been
    /// killed.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open_with_stop(
        session: &Session,
        contract: &Contract,
        stop: Arc<AtomicBool>,
    ) -> Result<PlantPort, PortError> {
        unblocked(session, || PlantPort::join(session, contract, stop))
    }

    fn join(session: &Session, contract: &Contract, stop: Arc<AtomicBool>) -> Result<PlantPort, PortError> {
        let node = SessionNode::open(session, contract)?;
        let sensors = Sender::open(&node, SENSORS, "plant", || false)?;
        let command = Receiver::open(&node, COMMAND, contract.pace)?;
        let truth = TruthSender::open(&node, contract.pace, stop)?;
        let service = ControlService::open(&node, service::PLANT, "plant")?;
        node.reserve()?;
        Ok(PlantPort { sensors, command, truth, service, node })
    }

    /// The same port with this way of waiting instead of [`Waiting::Hybrid`].
    pub fn waiting(mut self, waiting: Waiting) -> PlantPort {
        (self.sensors.waiting, self.command.waiting) = (waiting, waiting);
        self
    }

    /// The same port, which may move the calling thread to this processor while the machine is busy. Both sides should name the same
    /// one. This has an effect in lockstep only.
    pub fn sharing(mut self, processor: Option<usize>) -> PlantPort {
        self.command.placement = processor.map(Placement::new);
        self
    }

    /// Seals and sends sensors, and wakes the controller.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn send(&self, sensors: Sensors) -> Result<(), PortError> {
        self.sensors.send(sensors, self.command.peer())
    }

    /// Sends sensors without sealing them. Tests use this for damaged messages.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn send_raw(&self, sensors: Sensors) -> Result<(), PortError> {
        self.sensors.write(sensors, |_| (), self.command.peer())
    }

    /// Seals the truth and sends it to the recorders.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn record(&self, truth: Truth) -> Result<(), PortError> {
        self.truth.send(truth)
    }

    /// The next command that has arrived, not yet validated.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn try_receive(&mut self) -> Result<Option<Command>, PortError> {
        self.command.next()
    }

    /// The next request, if there is one.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn next_request(&self) -> Result<Option<PendingRequest>, PortError> {
        self.service.next()
    }

    /// Seals and sends the reply to a request, and reports both to the recorders. It is no error if the client has gone.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, pending: PendingRequest, reply: Reply) -> Result<(), PortError> {
        self.service.answer(pending, reply)
    }

    /// Waits up to 10 ms for a command. A caller can therefore notice a stop request between two calls. A controller that has just
    /// joined gets the last sensors.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn wait(&mut self) -> Result<Option<Command>, PortError> {
        self.sensors.prepare()?;
        let command = self.command.wait()?;
        if command.is_none() {
            self.sensors.catch_up()?;
        }
        Ok(command)
    }

    /// Waits a short time for a recorder that has not begun to read. It must be called after the last message of a run.
    pub fn finish(&self) {
        self.truth.wait_for_recorder();
        self.wait_for_tunnel();
    }

    /// Waits long enough for a tunnel to read the last message of this process. A tunnel polls, so the port must stay open until then.
    pub fn wait_for_tunnel(&self) {
        if self.node.has_tunnel() {
            std::thread::sleep(TUNNEL_POLL);
        }
    }

    /// Number of messages of truth that a recorder did not receive.
    pub fn unrecorded(&self) -> u64 {
        self.truth.lost()
    }
}
