//! The node of a process in a session: it opens the topics and services as the contract requires.

use super::bell::Bell;
use super::contract::{Contract, Pace};
use crate::error::PortError;
use crate::session::{Membership, Session, ShmUsage};
use crate::wire::{Reply, Request, SCHEMA_HASH, Served, Stamped, Truth};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError as Open, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};
use std::time::{Duration, Instant};

/// Topic of the sensors.
pub(super) const SENSORS: &str = "biped/sensors";
/// Topic of the commands.
pub(super) const COMMAND: &str = "biped/command";
/// Topic of the truth, and the event by which a recorder announces that it reads.
pub(super) const TRUTH: &str = "biped/truth";
/// Topic of the answered requests.
const SERVED: &str = "biped/served";

/// Largest number of readers of the truth: the recorder, a web page and a terminal.
const RECORDERS: usize = 3;
/// Largest number of readers of sensors or commands: the other side, and some observers.
const LINK_READERS: usize = 4;
/// Number of messages of truth by which a recorder may lag behind. The memory for all of them is allocated at the start: four times
/// as many would take 6 ms.
pub(super) const TRUTH_BUFFER: usize = 1024;
/// Shared memory that must be free when a session begins: four times what its largest topic needs [bytes].
pub const REQUIRED_SHM: u64 = (4 * RECORDERS * TRUTH_BUFFER * (size_of::<Truth>() + 128)) as u64;
/// Number of ended processes whose last messages a reader can still receive. iceoryx2 examines all of these connections at each
/// poll. Its default is 128.
const EXPIRED_CONNECTIONS: usize = 2;
/// While another process creates or removes the same topic, opening it is retried for this long.
const OPEN_TIMEOUT: Duration = Duration::from_secs(2);
/// Interval of these attempts.
const OPEN_RETRY: Duration = Duration::from_millis(2);
/// Largest number of writers of answered requests: plant and controller, and the successors of processes that were just killed.
const SERVED_WRITERS: usize = 4;
/// Number of answered requests by which a recorder may lag behind: more than people send in a few milliseconds.
pub(super) const SERVED_BUFFER: usize = 64;

pub(super) type TopicFactory<M> = publish_subscribe::PortFactory<ipc::Service, M, ()>;
type ServiceFactory = request_response::PortFactory<ipc::Service, Request, (), Reply, ()>;

/// The node of a process in a session.
#[derive(Debug)]
pub(super) struct SessionNode {
    // Rust drops fields in their order. The node must go first, because the end of the membership removes its files.
    node: Node<ipc::Service>,
    /// `None` for a process that attaches to a running session.
    contract: Option<Contract>,
    membership: Membership,
}

impl SessionNode {
    /// Joins a session as one of the processes that create it.
    pub fn open(session: &Session, contract: &Contract) -> Result<SessionNode, PortError> {
        ShmUsage::require(REQUIRED_SHM)?;
        SessionNode::join(session, Some(*contract))
    }

    /// Joins a session that other processes have created.
    pub fn attach(session: &Session) -> Result<SessionNode, PortError> {
        session.require_running()?;
        SessionNode::join(session, None)
    }

    fn join(session: &Session, contract: Option<Contract>) -> Result<SessionNode, PortError> {
        // Errors are reported by this program. IOX2_LOG_LEVEL also shows the messages of iceoryx2.
        set_log_level_from_env_or(LogLevel::Fatal);
        let membership = session.join()?;
        let mut config = Config::default();
        let root = session.root().into_os_string().into_encoded_bytes();
        config.global.prefix =
            FileName::new(session.prefix().as_bytes()).map_err(|e| PortError::failed("naming", e))?;
        config.global.set_root_path(&iceoryx2::prelude::Path::new(&root).map_err(|e| PortError::failed("naming", e))?);
        // A new node removes the files of dead nodes. A node need not do so at its end: the last process of the session does.
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.defaults.publish_subscribe.subscriber_expired_connection_buffer = EXPIRED_CONNECTIONS;
        config.defaults.request_response.server_expired_connection_buffer = EXPIRED_CONNECTIONS;
        session.remove_incomplete_files();
        // iceoryx2's default signal handler would handle Ctrl-C. The program has its own handler.
        let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let node = builder.create().map_err(|e| PortError::failed("joining the session", e))?;
        session.restrict_access();
        session.remove_unused_services(); // the new node has already removed those of dead nodes
        Ok(SessionNode { node, contract, membership })
    }

    fn topic<M: Stamped>(&self, name: &str, shape: TopicSettings) -> Result<TopicFactory<M>, PortError> {
        let service = service_name(name)?;
        let builder = || self.node.service_builder(&service).publish_subscribe::<M>();
        let required = self.required()?;
        let open = || {
            let builder = builder()
                .max_publishers(shape.writers + usize::from(self.has_tunnel()))
                .max_subscribers(shape.readers)
                .history_size(shape.history)
                .subscriber_max_buffer_size(shape.buffer)
                .subscriber_max_borrowed_samples(1)
                .enable_safe_overflow(shape.overwrite);
            match self.contract {
                Some(_) => builder.open_or_create_with_attributes(&required),
                // A process without a contract must not create topics.
                None => builder.open().map_err(Into::into),
            }
        };
        let error = match with_retries(open, incompatible) {
            Ok(topic) => return Ok(topic),
            Err(error) => error,
        };
        match builder().open() {
            Ok(found) if error == Open::IncompatibleAttributes.into() => {
                Err(self.contract_difference(found.attributes()))
            }
            _ if incompatible(&error) || error == Open::ServiceInCorruptedState.into() => {
                Err(PortError::Foreign { session: self.session().into(), reason: format!("{error:?}") })
            }
            _ if error == Open::DoesNotExist.into() => {
                Err(PortError::Absent { session: self.session().into(), role: "plant" })
            }
            _ => Err(PortError::failed("opening a topic", error)),
        }
    }

    /// Topic of the truth.
    pub fn truth(&self) -> Result<TopicFactory<Truth>, PortError> {
        self.topic(
            TRUTH,
            TopicSettings { writers: 1, readers: RECORDERS, buffer: TRUTH_BUFFER, history: 0, overwrite: false },
        )
    }

    /// Topic of the answered requests.
    pub fn served(&self) -> Result<TopicFactory<Served>, PortError> {
        let shape = TopicSettings {
            writers: SERVED_WRITERS,
            readers: RECORDERS,
            buffer: SERVED_BUFFER,
            history: 0,
            overwrite: true,
        };
        self.topic(SERVED, shape)
    }

    /// Topic of sensors or commands.
    pub fn link<M: Stamped>(&self, name: &str) -> Result<TopicFactory<M>, PortError> {
        self.topic(name, TopicSettings { writers: 1, readers: LINK_READERS, buffer: 1, history: 1, overwrite: true })
    }

    /// Writing end of an event.
    pub fn notifier(&self, name: &str) -> Result<Notifier<ipc::Service>, PortError> {
        self.event(name)?.notifier_builder().create().map_err(|e| PortError::failed("the wake-up", e))
    }

    /// Reading end of an event.
    pub fn listener(&self, name: &str) -> Result<Listener<ipc::Service>, PortError> {
        self.event(name)?.listener_builder().create().map_err(|e| PortError::failed("the wake-up", e))
    }

    /// The bell of a topic. It is used in lockstep only.
    pub fn bell(&self, topic: &str) -> Result<Option<Bell>, PortError> {
        let is_lockstep = self.contract.is_some_and(|contract| contract.pace == Pace::Lockstep);
        is_lockstep.then(|| Bell::open(self.membership.session(), topic)).transpose()
    }

    fn event(&self, name: &str) -> Result<event::PortFactory<ipc::Service>, PortError> {
        let service = service_name(name)?;
        with_retries(|| self.node.service_builder(&service).event().open_or_create(), |_| false)
            .map_err(|e| PortError::failed("the wake-up", e))
    }

    /// Creates a control service.
    pub fn service(&self, name: &str) -> Result<ServiceFactory, PortError> {
        let service = service_name(name)?;
        let service = || self.node.service_builder(&service).request_response::<Request, Reply>().max_servers(1);
        let schema = self.schema()?;
        with_retries(|| service().open_or_create_with_attributes(&schema), |_| false)
            .map_err(|e| PortError::failed("opening the control service", e))
    }

    /// Opens the control service of another process, if it exists.
    pub fn existing_service(&self, name: &str) -> Result<Option<ServiceFactory>, PortError> {
        let service = self.node.service_builder(&service_name(name)?).request_response::<Request, Reply>();
        match service.open_with_attributes(&self.schema()?) {
            Ok(service) => Ok(Some(service)),
            Err(RequestResponseOpenError::DoesNotExist) => Ok(None),
            Err(RequestResponseOpenError::IncompatibleAttributes) => {
                Err(PortError::Foreign { session: self.session().into(), reason: "its wire schema differs".into() })
            }
            Err(error) => Err(PortError::failed("connecting to the control service", error)),
        }
    }

    fn schema(&self) -> Result<AttributeVerifier, PortError> {
        verifier(&[("wire schema", format!("{SCHEMA_HASH:016x}"))])
    }

    fn required(&self) -> Result<AttributeVerifier, PortError> {
        verifier(&self.attributes())
    }

    fn attributes(&self) -> Vec<(&'static str, String)> {
        self.contract.map_or(vec![], |contract| contract.attributes().into())
    }

    /// The name of the session.
    pub fn session(&self) -> &str {
        self.membership.session().name()
    }

    /// Whether the session has room for a tunnel to another machine.
    pub fn has_tunnel(&self) -> bool {
        self.contract.is_some_and(|contract| contract.tunnel)
    }

    /// Reserves the shared memory that the topics need. It must be called after all of them are open.
    pub fn reserve(&self) -> Result<(), PortError> {
        self.membership.session().reserve()
    }

    /// The first part of the contract in which the session differs.
    fn contract_difference(&self, found: &AttributeSet) -> PortError {
        let session = self.session().to_string();
        for (what, ours) in self.attributes() {
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
struct TopicSettings {
    writers: usize,
    readers: usize,
    buffer: usize,
    history: usize,
    overwrite: bool,
}

fn verifier(attributes: &[(&str, String)]) -> Result<AttributeVerifier, PortError> {
    attributes.iter().try_fold(AttributeVerifier::new(), |verifier, (key, value)| {
        let (key, value) = (AttributeKey::try_from(*key), AttributeValue::try_from(value.as_str()));
        let (key, value) =
            (key.map_err(|e| PortError::failed("naming", e))?, value.map_err(|e| PortError::failed("naming", e))?);
        verifier.require(&key, &value).map_err(|e| PortError::failed("naming", e))
    })
}

fn service_name(name: &str) -> Result<ServiceName, PortError> {
    name.try_into().map_err(|e| PortError::failed("naming", e))
}

/// Whether an existing topic is incompatible. Waiting does not change that.
fn incompatible(error: &PublishSubscribeOpenOrCreateError) -> bool {
    use Open::*;
    let kinds = [IncompatibleAttributes, IncompatibleTypes, VersionMismatch, IncompatibleOverflowBehavior];
    kinds.iter().any(|&kind| *error == kind.into())
}

/// Retries an operation until it succeeds, its error is final or the time is over. Another process may be creating or removing the
/// same topic at this moment.
fn with_retries<T, E>(mut open: impl FnMut() -> Result<T, E>, is_final: impl Fn(&E) -> bool) -> Result<T, E> {
    let start = Instant::now();
    loop {
        match open() {
            Err(error) if !is_final(&error) && start.elapsed() < OPEN_TIMEOUT => {
                std::thread::sleep(OPEN_RETRY);
            }
            result => return result,
        }
    }
}
