//! The link between plant, controller and recorder: these are the only files that know iceoryx2, but for the marker of a message.
//!
//! | topic | from → to | buffer | when full |
//! |---|---|---|---|
//! | `biped/sensors` | plant → controller | 1 | the newest replaces the oldest |
//! | `biped/command` | controller → plant | 1 | the newest replaces the oldest |
//! | `biped/truth` | plant → recorders | 1024 | lockstep: the plant waits; real time: dropped and counted |
//! | `biped/served` | plant, controller → recorders | 64 | the newest replaces the oldest |
//! | `biped/plant/service`, `biped/controller/service` | whoever → plant, controller | 2 | request and response |
//!
//! A recorder rings once it has begun to read a run; a plant that has said all waits for that, so that nothing is lost.
//!
//! Beside sensors and command an event of the same name wakes the reader. A topic has one writer; a second plant or
//! controller is refused. Whoever comes first makes the topics, with the [`Contract`] as attributes, and whoever brings
//! another contract is refused with both values.

mod bare;
mod contract;
mod error;
mod link;
mod node;
mod service;
mod truth;

pub use crate::action::Action;
pub use crate::wire::Verdict;
pub use bare::BarePort;
pub use contract::{Contract, Pace};
pub use error::PortError;
pub use link::Waiting;
pub use node::REQUIRED_SHM;
pub use service::{PendingRequest, ask};

use crate::session::Session;
use crate::wire::{Command, Reply, Sensors, Served, Truth};
use error::broken;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;
use link::{Receiver, Sender, TopicReader};
use node::{SERVED_BUFFER, SessionNode, TRUTH, TRUTH_BUFFER};
use service::ControlService;
use std::ops::Deref;
use std::time::Duration;
use truth::TruthSender;

/// What carries the messages; both sides need this very version.
pub const TRANSPORT: &str = "iceoryx2 0.10.0";

const SENSORS: &str = "biped/sensors";
const COMMAND: &str = "biped/command";
/// A tunnel has looked for messages within this time.
const TUNNEL: Duration = Duration::from_millis(200);

/// The plant's end.
#[derive(Debug)]
pub struct PlantPort {
    sensors: Sender<Sensors>,
    command: Receiver<Command>,
    truth: TruthSender,
    service: ControlService,
    node: SessionNode,
}

impl PlantPort {
    /// Takes the plant's node in a session.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<PlantPort, PortError> {
        let node = SessionNode::open(session, contract)?;
        let sensors = Sender::open(&node, SENSORS, "plant", || false)?;
        let (command, truth) =
            (Receiver::open(&node, COMMAND, contract.pace)?, TruthSender::open(&node, contract.pace)?);
        let service = ControlService::open(&node, service::PLANT, "plant")?;
        node.reserve()?;
        Ok(PlantPort { sensors, command, truth, service, node })
    }

    /// The same, waiting otherwise than [`Waiting::Hybrid`].
    pub fn waiting(mut self, waiting: Waiting) -> PlantPort {
        (self.sensors.waiting, self.command.waiting) = (waiting, waiting);
        self
    }

    /// Seals and sends sensors, and wakes the controller.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn send(&self, sensors: Sensors) -> Result<(), PortError> {
        self.sensors.send(sensors, self.command.peer_sent_ns)
    }

    /// Sends sensors as they are, sealed or not: bad ones on purpose.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn send_raw(&self, sensors: Sensors) -> Result<(), PortError> {
        self.sensors.write(sensors, |_| (), self.command.peer_sent_ns)
    }

    /// Seals and sends truth to whoever records.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn record(&self, truth: Truth) -> Result<(), PortError> {
        self.truth.send(truth)
    }

    /// The next command that has arrived, as it came: the gate judges it.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn try_receive(&mut self) -> Result<Option<Command>, PortError> {
        self.command.next()
    }

    /// The next request, if somebody asks for something.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn next_request(&self) -> Result<Option<PendingRequest>, PortError> {
        self.service.next()
    }

    /// Seals and sends the answer, and tells whoever records; that the asker has gone is no error.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, asked: PendingRequest, reply: Reply) -> Result<(), PortError> {
        self.service.answer(asked, reply)
    }

    /// Waits a little for a command, long enough to sleep and short enough to notice a stop request; meanwhile a
    /// controller that has just come gets the sensors it missed.
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

    /// To be called when all is said: waits a little for a recorder that has not begun to read and would get nothing.
    pub fn finish(&self) {
        self.truth.wait_for_recorder();
        self.wait_for_tunnel();
    }

    /// To be called after the last word, whatever the end: a tunnel, which looks for messages now and then, must still find it.
    pub fn wait_for_tunnel(&self) {
        if self.node.has_tunnel() {
            std::thread::sleep(TUNNEL);
        }
    }

    /// Messages of truth that a recorder did not get.
    pub fn unrecorded(&self) -> u64 {
        self.truth.lost()
    }
}

/// The controller's end.
#[derive(Debug)]
pub struct ControllerPort {
    // Before the command, whose node a successor waits for: fields are dropped in order.
    service: ControlService,
    command: Sender<Command>,
    sensors: Receiver<Sensors>,
    _node: SessionNode,
}

impl ControllerPort {
    /// Takes the controller's node in a session.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<ControllerPort, PortError> {
        ControllerPort::open_when_free(session, contract, || false)
    }

    /// The same after whoever has the node now, once it is free; `waits` is asked whether to wait on.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open_when_free(
        session: &Session,
        contract: &Contract,
        waits: impl Fn() -> bool,
    ) -> Result<ControllerPort, PortError> {
        let node = SessionNode::open(session, contract)?;
        let sensors = Receiver::open(&node, SENSORS, contract.pace)?;
        let command = Sender::open(&node, COMMAND, "controller", waits)?;
        let service = ControlService::open(&node, service::CONTROLLER, "controller")?;
        node.reserve()?;
        command.notify_arrival()?; // a plant that waits gives us its last sensors at once
        Ok(ControllerPort { service, command, sensors, _node: node })
    }

    /// As [`PlantPort::waiting`].
    pub fn waiting(mut self, waiting: Waiting) -> ControllerPort {
        (self.sensors.waiting, self.command.waiting) = (waiting, waiting);
        self
    }

    /// Seals and sends a command, and wakes the plant.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn send(&self, command: Command) -> Result<(), PortError> {
        self.command.send(command, self.sensors.peer_sent_ns)
    }

    /// Sends a command as it is, sealed or not: what somebody else made, or a bad one on purpose.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn send_raw(&self, command: Command) -> Result<(), PortError> {
        self.command.write(command, |_| (), self.sensors.peer_sent_ns)
    }

    /// Waits a little for sensors, as [`PlantPort::wait`].
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn wait(&mut self) -> Result<Option<Sensors>, PortError> {
        self.command.prepare()?;
        self.sensors.wait()
    }

    /// As [`PlantPort::asked`].
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn next_request(&self) -> Result<Option<PendingRequest>, PortError> {
        self.service.next()
    }

    /// As [`PlantPort::answer`].
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, asked: PendingRequest, reply: Reply) -> Result<(), PortError> {
        self.service.answer(asked, reply)
    }
}

/// A recorder's end.
#[derive(Debug)]
pub struct RecorderPort {
    truth: TopicReader<Truth>,
    served: TopicReader<Served>,
    notifier: Notifier<ipc::Service>,
    /// Run of the last record read: a plant started anew waits for a ring of its own.
    run: Option<u64>,
    _node: SessionNode,
}

impl RecorderPort {
    /// Begins to listen to a session's truth.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<RecorderPort, PortError> {
        RecorderPort::at(SessionNode::open(session, contract)?)
    }

    /// Begins to listen to a running session, whatever its contract.
    ///
    /// # Errors
    /// [`PortError::NoSession`] if there is none.
    pub fn attach(session: &Session) -> Result<RecorderPort, PortError> {
        RecorderPort::at(SessionNode::attach(session)?)
    }

    fn at(node: SessionNode) -> Result<RecorderPort, PortError> {
        let truth = TopicReader::open(&node.truth()?, TRUTH_BUFFER)?;
        let served = TopicReader::open(&node.served()?, SERVED_BUFFER)?;
        let notifier = node.event(TRUTH)?.notifier_builder().create().map_err(|e| broken("the wake-up", e))?;
        Ok(RecorderPort { truth, served, notifier, run: None, _node: node })
    }

    /// The next request that was answered, if there is one. Whatever took effect before a truth is here once that can be read.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn served(&self) -> Result<Option<Served>, PortError> {
        self.served.next()
    }

    /// The next message of truth, in order, if there is one: in its slot, to be let go of before the next.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn read(&mut self) -> Result<Option<impl Deref<Target = Truth> + use<>>, PortError> {
        let truth = self.truth.poll()?;
        let run = truth.as_ref().map(|truth| truth.stamp.run);
        if run.is_some() && run != self.run {
            self.run = run;
            self.notifier.notify().map_err(|e| broken("the wake-up", e))?;
        }
        Ok(truth)
    }
}
