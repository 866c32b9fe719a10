//! The link between plant, controller and recorder: the only file that knows iceoryx2.
//!
//! | topic | from → to | buffer | when full |
//! |---|---|---|---|
//! | `biped/sensors` | plant → controller | 1 | the newest replaces the oldest |
//! | `biped/command` | controller → plant | 1 | the newest replaces the oldest |
//! | `biped/truth` | plant → recorders | 4096 | lockstep: the plant waits; real time: dropped and counted |
//!
//! Beside sensors and command an event of the same name wakes the reader. A topic has one writer; a second plant or
//! controller is refused. Whoever comes first makes the topics, with the [`Contract`] as attributes, and whoever brings
//! another contract is refused with both values.

use crate::clock::now_ns;
use crate::scene::Scene;
use crate::session::{Membership, Session};
use crate::wire::{Command, FNV_START, SCHEMA_HASH, Sensors, Stamped, Truth, fnv1a};
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError as Open, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::port_factory::{event, publish_subscribe};
use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Readers of truth: the recorder and one more.
const RECORDERS: usize = 2;
/// Readers of a link: its other end, and room for onlookers.
const LINK_READERS: usize = 4;
/// Messages of truth that a recorder may lag behind.
const TRUTH_BUFFER: usize = 4096;
/// Patience of a lockstep plant with a recorder whose buffer is full.
const RECORDER_PATIENCE: Duration = Duration::from_secs(3);
/// A waiting reader spins for this long before it sleeps: longer than a tick of the other side takes.
const SPIN: Duration = Duration::from_micros(50);
/// For so long after its own last message a reader is surely still spinning [ns].
const AWAKE_NS: u64 = SPIN.as_nanos() as u64 / 2;
/// A sleeping reader looks around this often, so that a stop request or a restarted peer is noticed.
const SLICE: Duration = Duration::from_millis(10);
/// Time to keep trying while another process is just making or removing the same topic.
const OPENING: Duration = Duration::from_secs(2);

/// Who sets the pace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// The plant waits for each answer: as fast as possible, and every run the same.
    Lockstep,
    /// The clock does: each control period takes as long as in reality.
    RealTime,
}

impl Pace {
    fn name(self) -> &'static str {
        match self {
            Pace::Lockstep => "lockstep",
            Pace::RealTime => "realtime",
        }
    }
}

/// What both sides must agree on before they speak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contract {
    /// Hash of the wire format, [`SCHEMA_HASH`].
    pub schema: u64,
    /// Hash of the scene's plant and bodies.
    pub model: u64,
    /// Control rate [Hz].
    pub rate: f64,
    /// Lockstep or real time.
    pub pace: Pace,
}

impl Contract {
    /// The contract of a scene.
    pub fn of(scene: &Scene, pace: Pace) -> Contract {
        // Debug prints every field, and floats so that they read back exactly.
        let text = format!("{:?}{:?}", scene.plant, scene.bodies);
        Contract { schema: SCHEMA_HASH, model: fnv1a(FNV_START, text.as_bytes()), rate: scene.rate, pace }
    }

    fn attributes(&self) -> [(&'static str, String); 4] {
        [
            ("wire schema", format!("{:016x}", self.schema)),
            ("model", format!("{:016x}", self.model)),
            ("rate", format!("{} Hz", self.rate)),
            ("pace", self.pace.name().into()),
        ]
    }
}

/// Why a link could not be made or broke.
#[derive(Debug, Error)]
pub enum PortError {
    /// A name that cannot be part of a file name.
    #[error("`{name}` cannot name a session: use 1 to 32 letters, digits or hyphens")]
    SessionName {
        /// As given.
        name: String,
    },
    /// The other side brings another contract.
    #[error(
        "session `{session}` speaks {what} {theirs}, this process {ours}: start both with the same program, scene and options"
    )]
    Incompatible {
        /// Name of the session.
        session: String,
        /// Which part of the contract.
        what: &'static str,
        /// Value already there.
        theirs: String,
        /// Value brought.
        ours: String,
    },
    /// The topic was made by something else.
    #[error(
        "session `{session}` was made by another version of this program ({reason}): end that one, or use another --session"
    )]
    Foreign {
        /// Name of the session.
        session: String,
        /// As iceoryx2 says it.
        reason: String,
    },
    /// There may be only one.
    #[error("session `{session}` already has a {role}: end that one, or use another --session")]
    Taken {
        /// Name of the session.
        session: String,
        /// Plant or controller.
        role: &'static str,
    },
    /// Shared memory is missing, full or unusable.
    #[error("shared memory: {0}")]
    SharedMemory(String),
}

fn broken(what: &str, reason: impl Debug) -> PortError {
    PortError::SharedMemory(format!("{what} failed: {reason:?}"))
}

/// The plant's end.
#[derive(Debug)]
pub struct PlantPort {
    sensors: Outlet<Sensors>,
    command: Inlet<Command>,
    truth: TruthOutlet,
    _place: Place,
}

impl PlantPort {
    /// Takes the plant's place in a session.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<PlantPort, PortError> {
        let place = Place::open(session, contract)?;
        let sensors = Outlet::open(&place, SENSORS, "plant")?;
        let (command, truth) = (Inlet::open(&place, COMMAND)?, TruthOutlet::open(&place, contract.pace)?);
        Ok(PlantPort { sensors, command, truth, _place: place })
    }

    /// Seals and sends sensors, and wakes the controller.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn send(&self, sensors: Sensors) -> Result<(), PortError> {
        self.sensors.send(sensors, self.command.heard_ns)
    }

    /// Seals and sends truth to whoever records.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn record(&self, truth: Truth) -> Result<(), PortError> {
        self.truth.send(truth)
    }

    /// The newest sound command that has arrived since the last call.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn newest(&mut self) -> Result<Option<Command>, PortError> {
        self.command.newest()
    }

    /// Waits a little for a command, long enough to sleep and short enough to notice a stop request; meanwhile a
    /// controller that has just come gets the sensors it missed.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn wait(&mut self) -> Result<Option<Command>, PortError> {
        let command = self.command.wait()?;
        if command.is_none() {
            self.sensors.catch_up()?;
        }
        Ok(command)
    }

    /// Commands dropped because magic, schema hash or check sum were wrong.
    pub fn unsound(&self) -> u64 {
        self.command.unsound
    }

    /// Messages of truth that a recorder did not get.
    pub fn unrecorded(&self) -> u64 {
        self.truth.lost.load(Relaxed)
    }
}

/// The controller's end.
#[derive(Debug)]
pub struct ControllerPort {
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
        let place = Place::open(session, contract)?;
        let command = Outlet::open(&place, COMMAND, "controller")?;
        let sensors = Inlet::open(&place, SENSORS)?;
        Ok(ControllerPort { command, sensors, _place: place })
    }

    /// Seals and sends a command, and wakes the plant.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn send(&self, command: Command) -> Result<(), PortError> {
        self.command.send(command, self.sensors.heard_ns)
    }

    /// Waits a little for sensors, as [`PlantPort::wait`].
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn wait(&mut self) -> Result<Option<Sensors>, PortError> {
        self.sensors.wait()
    }

    /// Sensors dropped because magic, schema hash or check sum were wrong.
    pub fn unsound(&self) -> u64 {
        self.sensors.unsound
    }
}

/// A recorder's end.
#[derive(Debug)]
pub struct RecorderPort {
    truth: Reader<Truth>,
    _place: Place,
}

impl RecorderPort {
    /// Begins to listen to a session's truth.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<RecorderPort, PortError> {
        let place = Place::open(session, contract)?;
        let truth = Reader::open(&place.truth()?, TRUTH_BUFFER)?;
        Ok(RecorderPort { truth, _place: place })
    }

    /// The next message of truth, in order, if there is one.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn next(&self) -> Result<Option<Truth>, PortError> {
        self.truth.next()
    }
}

type Topic<M> = publish_subscribe::PortFactory<ipc::Service, M, ()>;

const SENSORS: &str = "biped/sensors";
const COMMAND: &str = "biped/command";
const TRUTH: &str = "biped/truth";

/// One process's place in a session: the node, and what it may open.
#[derive(Debug)]
struct Place {
    // Before the membership, whose end clears away what the node leaves: fields are dropped in order.
    node: Node<ipc::Service>,
    contract: Contract,
    membership: Membership,
}

impl Place {
    fn open(session: &Session, contract: &Contract) -> Result<Place, PortError> {
        // What goes wrong is told in our own words; IOX2_LOG_LEVEL shows iceoryx2's as well.
        set_log_level_from_env_or(LogLevel::Fatal);
        let footprint = (RECORDERS * TRUTH_BUFFER * (size_of::<Truth>() + 128)) as u64;
        session.demand(4 * footprint)?;
        let membership = session.enter()?;
        let mut config = Config::default();
        let root = session.root().into_os_string().into_encoded_bytes();
        config.global.prefix = FileName::new(session.prefix().as_bytes()).map_err(|e| broken("naming", e))?;
        config.global.set_root_path(&iceoryx2::prelude::Path::new(&root).map_err(|e| broken("naming", e))?);
        // The default handler would swallow Ctrl-C; the program has its own.
        let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let node = builder.create().map_err(|e| broken("joining the session", e))?;
        Ok(Place { node, contract: *contract, membership })
    }

    fn topic<M: Stamped>(&self, name: &str, shape: Shape) -> Result<Topic<M>, PortError> {
        let service = service_name(name)?;
        let builder = || self.node.service_builder(&service).publish_subscribe::<M>();
        let required = self.required()?;
        let open = || {
            builder()
                .max_publishers(1)
                .max_subscribers(shape.readers)
                .history_size(shape.history)
                .subscriber_max_buffer_size(shape.buffer)
                .subscriber_max_borrowed_samples(1)
                .enable_safe_overflow(shape.overwrite)
                .open_or_create_with_attributes(&required)
        };
        let error = match patiently(open, incompatible) {
            Ok(topic) => return Ok(topic),
            Err(error) => error,
        };
        match builder().open() {
            Ok(found) if error == Open::IncompatibleAttributes.into() => Err(self.disagreement(found.attributes())),
            _ if incompatible(&error) || error == Open::ServiceInCorruptedState.into() => {
                Err(PortError::Foreign { session: self.membership.session().into(), reason: format!("{error:?}") })
            }
            _ => Err(broken("opening a topic", error)),
        }
    }

    fn truth(&self) -> Result<Topic<Truth>, PortError> {
        self.topic(TRUTH, Shape { readers: RECORDERS, buffer: TRUTH_BUFFER, history: 0, overwrite: false })
    }

    fn link<M: Stamped>(&self, name: &str) -> Result<Topic<M>, PortError> {
        self.topic(name, Shape { readers: LINK_READERS, buffer: 1, history: 1, overwrite: true })
    }

    fn event(&self, name: &str) -> Result<event::PortFactory<ipc::Service>, PortError> {
        let service = service_name(name)?;
        patiently(|| self.node.service_builder(&service).event().open_or_create(), |_| false)
            .map_err(|e| broken("the wake-up", e))
    }

    fn required(&self) -> Result<AttributeVerifier, PortError> {
        self.contract.attributes().iter().try_fold(AttributeVerifier::new(), |verifier, (key, value)| {
            let (key, value) = (AttributeKey::try_from(*key), AttributeValue::try_from(value.as_str()));
            let (key, value) = (key.map_err(|e| broken("naming", e))?, value.map_err(|e| broken("naming", e))?);
            verifier.require(&key, &value).map_err(|e| broken("naming", e))
        })
    }

    /// The first part of the contract that the session's makers have otherwise.
    fn disagreement(&self, found: &AttributeSet) -> PortError {
        let session = self.membership.session().to_string();
        for (what, ours) in self.contract.attributes() {
            let key = AttributeKey::try_from(what).ok();
            let theirs = key.and_then(|key| found.key_value(&key, 0).map(|value| value.to_string()));
            let theirs = theirs.unwrap_or_else(|| "unknown".into());
            if theirs != ours {
                return PortError::Incompatible { session, what, theirs, ours };
            }
        }
        PortError::Foreign { session, reason: "attributes differ".into() }
    }
}

/// Quality of service of a topic.
struct Shape {
    readers: usize,
    buffer: usize,
    history: usize,
    overwrite: bool,
}

fn service_name(name: &str) -> Result<ServiceName, PortError> {
    name.try_into().map_err(|e| broken("naming", e))
}

/// Whether an existing topic is of another make, which waiting does not change.
fn incompatible(error: &PublishSubscribeOpenOrCreateError) -> bool {
    use Open::*;
    let kinds = [IncompatibleAttributes, IncompatibleTypes, VersionMismatch, IncompatibleOverflowBehavior];
    kinds.iter().any(|&kind| *error == kind.into())
}

/// Retries for a while what is not final: another process may be making or removing the same thing at this moment.
fn patiently<T, E>(mut open: impl FnMut() -> Result<T, E>, is_final: impl Fn(&E) -> bool) -> Result<T, E> {
    let start = Instant::now();
    loop {
        match open() {
            Err(error) if !is_final(&error) && start.elapsed() < OPENING => {
                std::thread::sleep(Duration::from_millis(2));
            }
            result => return result,
        }
    }
}

/// Writing end of a topic with a wake-up.
#[derive(Debug)]
struct Outlet<M: Stamped> {
    writer: Publisher<ipc::Service, M, ()>,
    bell: Notifier<ipc::Service>,
}

impl<M: Stamped> Outlet<M> {
    fn open(place: &Place, name: &str, role: &'static str) -> Result<Outlet<M>, PortError> {
        let topic = place.link::<M>(name)?;
        let writer = topic.publisher_builder().max_loaned_samples(1).create().map_err(|error| match error {
            PublisherCreateError::ExceedsMaxSupportedPublishers => {
                PortError::Taken { session: place.membership.session().into(), role }
            }
            error => broken("writing", error),
        })?;
        let bell = place.event(name)?.notifier_builder().create().map_err(|e| broken("the wake-up", e))?;
        Ok(Outlet { writer, bell })
    }

    /// Writes, and rings unless the reader is surely awake: it sent its own last message at `heard_ns` and has spun for
    /// this one since. A ring is a system call and costs more than a tick.
    fn send(&self, message: M, heard_ns: u64) -> Result<(), PortError> {
        self.writer.send_copy(message.sealed()).map_err(|e| broken("writing", e))?;
        if now_ns().saturating_sub(heard_ns) >= AWAKE_NS {
            self.bell.notify().map_err(|e| broken("the wake-up", e))?;
        }
        Ok(())
    }

    /// Gives the last message to a reader that has come since, and wakes it.
    fn catch_up(&self) -> Result<(), PortError> {
        self.writer.update_connections().map_err(|e| broken("connecting", e))?;
        self.bell.notify().map_err(|e| broken("the wake-up", e))?;
        Ok(())
    }
}

/// Reading end of a topic with a wake-up.
#[derive(Debug)]
struct Inlet<M: Stamped> {
    reader: Reader<M>,
    bell: Listener<ipc::Service>,
    unsound: u64,
    /// When the writer sent what was read last, by its monotonic clock, which is ours [ns].
    heard_ns: u64,
}

impl<M: Stamped> Inlet<M> {
    fn open(place: &Place, name: &str) -> Result<Inlet<M>, PortError> {
        let reader = Reader::open(&place.link::<M>(name)?, 1)?;
        let bell = place.event(name)?.listener_builder().create().map_err(|e| broken("the wake-up", e))?;
        Ok(Inlet { reader, bell, unsound: 0, heard_ns: 0 })
    }

    fn newest(&mut self) -> Result<Option<M>, PortError> {
        let mut newest = None;
        while let Some(message) = self.reader.next()? {
            match message.is_sound() {
                true => {
                    self.heard_ns = message.stamp().mono_ns;
                    newest = Some(message);
                }
                false => self.unsound += 1,
            }
        }
        Ok(newest)
    }

    /// Spins first and sleeps then; gives up after a slice.
    fn wait(&mut self) -> Result<Option<M>, PortError> {
        let start = Instant::now();
        loop {
            let waited = start.elapsed(); // before the look: what comes after it is rung for, once we may sleep
            let message = self.newest()?;
            if message.is_some() || waited >= SLICE {
                return Ok(message);
            }
            if waited < SPIN {
                std::hint::spin_loop();
                continue;
            }
            match self.bell.timed_wait(|_| (), SLICE - waited) {
                Ok(_) | Err(ListenerWaitError::InterruptSignal) => (),
                Err(error) => return Err(broken("the wake-up", error)),
            }
        }
    }
}

/// Reading end of a topic.
#[derive(Debug)]
struct Reader<M: Stamped>(Subscriber<ipc::Service, M, ()>);

impl<M: Stamped> Reader<M> {
    fn open(topic: &Topic<M>, buffer: usize) -> Result<Reader<M>, PortError> {
        topic.subscriber_builder().buffer_size(buffer).create().map(Reader).map_err(|e| broken("reading", e))
    }

    /// A copy of the next message; its slot is free again at once.
    fn next(&self) -> Result<Option<M>, PortError> {
        Ok(self.0.receive().map_err(|e| broken("reading", e))?.map(|sample| *sample))
    }
}

/// Writing end of the truth.
#[derive(Debug)]
struct TruthOutlet {
    writer: Publisher<ipc::Service, Truth, ()>,
    lost: Arc<AtomicU64>,
}

impl TruthOutlet {
    fn open(place: &Place, pace: Pace) -> Result<TruthOutlet, PortError> {
        let lost = Arc::new(AtomicU64::new(0));
        let (counter, gave_up) = (lost.clone(), AtomicBool::new(false));
        // Called while a recorder's buffer is full. One that has once been given up is not waited for again.
        let when_full = move |full: &BackpressureInfo| {
            if pace == Pace::Lockstep && full.elapsed_time < RECORDER_PATIENCE && !gave_up.load(Relaxed) {
                return BackpressureAction::Retry;
            }
            if pace == Pace::Lockstep && !gave_up.swap(true, Relaxed) {
                eprintln!("the recorder has not read for {} s: going on without it", RECORDER_PATIENCE.as_secs());
            }
            counter.fetch_add(1, Relaxed);
            BackpressureAction::DiscardData
        };
        let topic = place.truth()?;
        let builder = topic.publisher_builder().max_loaned_samples(1).set_backpressure_handler(when_full);
        let writer = builder.create().map_err(|e| broken("writing", e))?;
        Ok(TruthOutlet { writer, lost })
    }

    fn send(&self, truth: Truth) -> Result<(), PortError> {
        self.writer.send_copy(truth.sealed()).map_err(|e| broken("writing", e))?;
        Ok(())
    }
}
