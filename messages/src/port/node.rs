//! One process's node in a session: its node, and the topics as the contract wants them.

use super::contract::Contract;
use super::error::{PortError, broken};
use crate::session::{Membership, Session, ShmUsage};
use crate::wire::{Reply, Request, SCHEMA_HASH, Served, Stamped, Truth};
use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError as Open, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};
use std::time::{Duration, Instant};

/// Readers of truth: the recorder, a page and a terminal.
const RECORDERS: usize = 3;
/// Readers of a link: its other end, and room for onlookers.
const LINK_READERS: usize = 4;
/// Messages of truth that a recorder may lag behind. All their room is taken at the start: four times as many take 6 ms.
pub(super) const TRUTH_BUFFER: usize = 1024;
/// Shared memory that must be free before a session begins [bytes]: four times what its largest topic takes.
pub const REQUIRED_SHM: u64 = (4 * RECORDERS * TRUTH_BUFFER * (size_of::<Truth>() + 128)) as u64;
/// Others whose last messages a reader still hears after they have ended. Every look of iceoryx2 passes over the places for
/// all of them, by default 128.
const EXPIRED_CONNECTIONS: usize = 2;
/// Time to keep trying while another process is just making or removing the same topic.
const OPEN_TIMEOUT: Duration = Duration::from_secs(2);

/// Writers of what was served: plant and controller, and whoever takes the node of one that has just been killed.
const SERVED_WRITERS: usize = 4;
/// Requests that a recorder may lag behind: more in a few milliseconds than people ask.
pub(super) const SERVED_BUFFER: usize = 64;

/// The topic of requests that were answered.
const SERVED: &str = "biped/served";
/// The topic of the truth, and the notifier by which a recorder says that it reads.
pub(super) const TRUTH: &str = "biped/truth";

pub(super) type Topic<M> = publish_subscribe::PortFactory<ipc::Service, M, ()>;
type ServiceFactory = request_response::PortFactory<ipc::Service, Request, (), Reply, ()>;

/// One process's node in a session: the node, and what it may open.
#[derive(Debug)]
pub(super) struct SessionNode {
    // Before the membership, whose end clears away what the node leaves: fields are dropped in order.
    node: Node<ipc::Service>,
    /// Visitors have none.
    contract: Option<Contract>,
    membership: Membership,
}

impl SessionNode {
    /// A node as one of the session's makers.
    pub fn open(session: &Session, contract: &Contract) -> Result<SessionNode, PortError> {
        ShmUsage::require(REQUIRED_SHM)?;
        SessionNode::enter(session, Some(*contract))
    }

    /// A node in a session that others have made.
    pub fn attach(session: &Session) -> Result<SessionNode, PortError> {
        if !session.is_running() {
            return Err(PortError::NoSession { session: session.name().into(), other: session.other_owner() });
        }
        SessionNode::enter(session, None)
    }

    fn enter(session: &Session, contract: Option<Contract>) -> Result<SessionNode, PortError> {
        // What goes wrong is told in our own words; IOX2_LOG_LEVEL shows iceoryx2's as well.
        set_log_level_from_env_or(LogLevel::Fatal);
        let membership = session.join()?;
        let mut config = Config::default();
        let root = session.root().into_os_string().into_encoded_bytes();
        config.global.prefix = FileName::new(session.prefix().as_bytes()).map_err(|e| broken("naming", e))?;
        config.global.set_root_path(&iceoryx2::prelude::Path::new(&root).map_err(|e| broken("naming", e))?);
        // New nodes clear away what dead ones left; at its end a node need not, for the last one out does.
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.defaults.publish_subscribe.subscriber_expired_connection_buffer = EXPIRED_CONNECTIONS;
        config.defaults.request_response.server_expired_connection_buffer = EXPIRED_CONNECTIONS;
        session.remove_incomplete_files();
        // The default handler would swallow Ctrl-C; the program has its own.
        let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let node = builder.create().map_err(|e| broken("joining the session", e))?;
        session.restrict_access();
        session.remove_unused_services(); // the new node has removed those of the dead
        Ok(SessionNode { node, contract, membership })
    }

    fn topic<M: Stamped>(&self, name: &str, shape: TopicSettings) -> Result<Topic<M>, PortError> {
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
                // A visitor makes nothing: it would lack the contract.
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
            _ => Err(broken("opening a topic", error)),
        }
    }

    pub fn truth(&self) -> Result<Topic<Truth>, PortError> {
        self.topic(
            TRUTH,
            TopicSettings { writers: 1, readers: RECORDERS, buffer: TRUTH_BUFFER, history: 0, overwrite: false },
        )
    }

    pub fn served(&self) -> Result<Topic<Served>, PortError> {
        let shape = TopicSettings {
            writers: SERVED_WRITERS,
            readers: RECORDERS,
            buffer: SERVED_BUFFER,
            history: 0,
            overwrite: true,
        };
        self.topic(SERVED, shape)
    }

    pub fn link<M: Stamped>(&self, name: &str) -> Result<Topic<M>, PortError> {
        self.topic(name, TopicSettings { writers: 1, readers: LINK_READERS, buffer: 1, history: 1, overwrite: true })
    }

    pub fn event(&self, name: &str) -> Result<event::PortFactory<ipc::Service>, PortError> {
        let service = service_name(name)?;
        with_retries(|| self.node.service_builder(&service).event().open_or_create(), |_| false)
            .map_err(|e| broken("the wake-up", e))
    }

    /// A service of one's own.
    pub fn service(&self, name: &str) -> Result<ServiceFactory, PortError> {
        let service = service_name(name)?;
        let service = || self.node.service_builder(&service).request_response::<Request, Reply>().max_servers(1);
        let schema = self.schema()?;
        with_retries(|| service().open_or_create_with_attributes(&schema), |_| false)
            .map_err(|e| broken("opening a desk", e))
    }

    /// Somebody else's service, if there is one.
    pub fn existing_service(&self, name: &str) -> Result<Option<ServiceFactory>, PortError> {
        let service = self.node.service_builder(&service_name(name)?).request_response::<Request, Reply>();
        match service.open_with_attributes(&self.schema()?) {
            Ok(service) => Ok(Some(service)),
            Err(RequestResponseOpenError::DoesNotExist) => Ok(None),
            Err(RequestResponseOpenError::IncompatibleAttributes) => {
                Err(PortError::Foreign { session: self.session().into(), reason: "its wire schema is another".into() })
            }
            Err(error) => Err(broken("coming to a desk", error)),
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

    /// Whether there is room for a tunnel to another machine.
    pub fn has_tunnel(&self) -> bool {
        self.contract.is_some_and(|contract| contract.tunnel)
    }

    /// To be called when every topic is open: takes the room that they need.
    pub fn reserve(&self) -> Result<(), PortError> {
        self.membership.session().reserve()
    }

    /// The first part of the contract that the session's makers have otherwise.
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
        let (key, value) = (key.map_err(|e| broken("naming", e))?, value.map_err(|e| broken("naming", e))?);
        verifier.require(&key, &value).map_err(|e| broken("naming", e))
    })
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
fn with_retries<T, E>(mut open: impl FnMut() -> Result<T, E>, is_final: impl Fn(&E) -> bool) -> Result<T, E> {
    let start = Instant::now();
    loop {
        match open() {
            Err(error) if !is_final(&error) && start.elapsed() < OPEN_TIMEOUT => {
                std::thread::sleep(Duration::from_millis(2));
            }
            result => return result,
        }
    }
}
