//! The link between plant, controller and recorder: these are the only files that know iceoryx2, but for the marker of a message.
//!
//! | topic | from → to | buffer | when full |
//! |---|---|---|---|
//! | `biped/sensors` | plant → controller | 1 | the newest replaces the oldest |
//! | `biped/command` | controller → plant | 1 | the newest replaces the oldest |
//! | `biped/truth` | plant → recorders | 1024 | lockstep: the plant waits; real time: dropped and counted |
//! | `biped/served` | plant, controller → recorders | 64 | the newest replaces the oldest |
//! | `biped/plant/desk`, `biped/controller/desk` | whoever → plant, controller | 2 | request and response |
//!
//! A recorder rings once it has begun to read a run; a plant that has said all waits for that, so that nothing is lost.
//!
//! Beside sensors and command an event of the same name wakes the reader. A topic has one writer; a second plant or
//! controller is refused. Whoever comes first makes the topics, with the [`Contract`] as attributes, and whoever brings
//! another contract is refused with both values.

mod bare;
mod contract;
mod desk;
mod error;
mod link;
mod place;
mod truth;

pub use crate::ask::{Ask, Verdict};
pub use bare::BarePort;
pub use contract::{Contract, Pace};
pub use desk::{Asked, ask};
pub use error::PortError;
pub use link::Waiting;
pub use place::ROOM;

use crate::session::Session;
use crate::wire::{Command, Reply, Sensors, Served, Truth};
use desk::Desk;
use error::broken;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;
use link::{Inlet, Outlet, Reader};
use place::{Place, SERVED_BUFFER, TRUTH, TRUTH_BUFFER};
use std::ops::Deref;
use std::time::Duration;
use truth::TruthOutlet;

/// What carries the messages; both sides need this very version.
pub const TRANSPORT: &str = "iceoryx2 0.10.0";

const SENSORS: &str = "biped/sensors";
const COMMAND: &str = "biped/command";
/// A tunnel has looked for messages within this time.
const TUNNEL: Duration = Duration::from_millis(200);

/// The plant's end.
#[derive(Debug)]
pub struct PlantPort {
    sensors: Outlet<Sensors>,
    command: Inlet<Command>,
    truth: TruthOutlet,
    desk: Desk,
    place: Place,
}

impl PlantPort {
    /// Takes the plant's place in a session.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<PlantPort, PortError> {
        let place = Place::open(session, contract)?;
        let sensors = Outlet::open(&place, SENSORS, "plant", || false)?;
        let (command, truth) =
            (Inlet::open(&place, COMMAND, contract.pace)?, TruthOutlet::open(&place, contract.pace)?);
        let desk = Desk::open(&place, desk::PLANT, "plant")?;
        place.reserve()?;
        Ok(PlantPort { sensors, command, truth, desk, place })
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
        self.sensors.send(sensors, self.command.heard_ns)
    }

    /// Sends sensors as they are, sealed or not: bad ones on purpose.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn pass_on(&self, sensors: Sensors) -> Result<(), PortError> {
        self.sensors.write(sensors, |_| (), self.command.heard_ns)
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
    pub fn take(&mut self) -> Result<Option<Command>, PortError> {
        self.command.next()
    }

    /// The next request, if somebody asks for something.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn asked(&self) -> Result<Option<Asked>, PortError> {
        self.desk.next()
    }

    /// Seals and sends the answer, and tells whoever records; that the asker has gone is no error.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, asked: Asked, reply: Reply) -> Result<(), PortError> {
        self.desk.answer(asked, reply)
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
        self.truth.linger();
        self.let_go();
    }

    /// To be called after the last word, whatever the end: a tunnel, which looks for messages now and then, must still find it.
    pub fn let_go(&self) {
        if self.place.has_tunnel() {
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
    // Before the command, whose place a successor waits for: fields are dropped in order.
    desk: Desk,
    command: Outlet<Command>,
    sensors: Inlet<Sensors>,
    _place: Place,
}

impl ControllerPort {
    /// Takes the controller's place in a session.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<ControllerPort, PortError> {
        ControllerPort::succeed(session, contract, || false)
    }

    /// The same after whoever has the place now, once it is free; `waits` is asked whether to wait on.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn succeed(
        session: &Session,
        contract: &Contract,
        waits: impl Fn() -> bool,
    ) -> Result<ControllerPort, PortError> {
        let place = Place::open(session, contract)?;
        let sensors = Inlet::open(&place, SENSORS, contract.pace)?;
        let command = Outlet::open(&place, COMMAND, "controller", waits)?;
        let desk = Desk::open(&place, desk::CONTROLLER, "controller")?;
        place.reserve()?;
        command.knock()?; // a plant that waits gives us its last sensors at once
        Ok(ControllerPort { desk, command, sensors, _place: place })
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
        self.command.send(command, self.sensors.heard_ns)
    }

    /// Sends a command as it is, sealed or not: what somebody else made, or a bad one on purpose.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn pass_on(&self, command: Command) -> Result<(), PortError> {
        self.command.write(command, |_| (), self.sensors.heard_ns)
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
    pub fn asked(&self) -> Result<Option<Asked>, PortError> {
        self.desk.next()
    }

    /// As [`PlantPort::answer`].
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, asked: Asked, reply: Reply) -> Result<(), PortError> {
        self.desk.answer(asked, reply)
    }
}

/// A recorder's end.
#[derive(Debug)]
pub struct RecorderPort {
    truth: Reader<Truth>,
    served: Reader<Served>,
    bell: Notifier<ipc::Service>,
    /// Run of the last record read: a plant started anew waits for a ring of its own.
    run: Option<u64>,
    _place: Place,
}

impl RecorderPort {
    /// Begins to listen to a session's truth.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<RecorderPort, PortError> {
        RecorderPort::at(Place::open(session, contract)?)
    }

    /// Begins to listen to a running session, whatever its contract.
    ///
    /// # Errors
    /// [`PortError::NoSession`] if there is none.
    pub fn visit(session: &Session) -> Result<RecorderPort, PortError> {
        RecorderPort::at(Place::visit(session)?)
    }

    fn at(place: Place) -> Result<RecorderPort, PortError> {
        let truth = Reader::open(&place.truth()?, TRUTH_BUFFER)?;
        let served = Reader::open(&place.served()?, SERVED_BUFFER)?;
        let bell = place.event(TRUTH)?.notifier_builder().create().map_err(|e| broken("the wake-up", e))?;
        Ok(RecorderPort { truth, served, bell, run: None, _place: place })
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
        let truth = self.truth.look()?;
        let run = truth.as_ref().map(|truth| truth.stamp.run);
        if run.is_some() && run != self.run {
            self.run = run;
            self.bell.notify().map_err(|e| broken("the wake-up", e))?;
        }
        Ok(truth)
    }
}
