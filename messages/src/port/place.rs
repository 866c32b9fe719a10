//! One process's place in a session: its node, and the topics as the contract wants them.

use super::contract::Contract;
use super::error::{PortError, broken};
use crate::session::{Membership, Room, Session};
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
pub const ROOM: u64 = (4 * RECORDERS * TRUTH_BUFFER * (size_of::<Truth>() + 128)) as u64;
/// Others whose last messages a reader still hears after they have ended. Every look of iceoryx2 passes over the places for
/// all of them, by default 128.
const ENDED: usize = 2;
/// Time to keep trying while another process is just making or removing the same topic.
const OPENING: Duration = Duration::from_secs(2);

/// Writers of what was served: plant and controller, and whoever takes the place of one that has just been killed.
const DESKS: usize = 4;
/// Requests that a recorder may lag behind: more in a few milliseconds than people ask.
pub(super) const SERVED_BUFFER: usize = 64;

/// The topic of requests that were answered.
const SERVED: &str = "biped/served";
/// The topic of the truth, and the bell by which a recorder says that it reads.
pub(super) const TRUTH: &str = "biped/truth";

pub(super) type Topic<M> = publish_subscribe::PortFactory<ipc::Service, M, ()>;
type DeskFactory = request_response::PortFactory<ipc::Service, Request, (), Reply, ()>;

/// One process's place in a session: the node, and what it may open.
#[derive(Debug)]
pub(super) struct Place {
    // Before the membership, whose end clears away what the node leaves: fields are dropped in order.
    node: Node<ipc::Service>,
    /// Visitors have none.
    contract: Option<Contract>,
    membership: Membership,
}

impl Place {
    /// A place as one of the session's makers.
    pub fn open(session: &Session, contract: &Contract) -> Result<Place, PortError> {
        Room::demand(ROOM)?;
        Place::enter(session, Some(*contract))
    }

    /// A place in a session that others have made.
    pub fn visit(session: &Session) -> Result<Place, PortError> {
        if !session.is_running() {
            return Err(PortError::NoSession { session: session.name().into(), other: session.other_owner() });
        }
        Place::enter(session, None)
    }

    fn enter(session: &Session, contract: Option<Contract>) -> Result<Place, PortError> {
        // What goes wrong is told in our own words; IOX2_LOG_LEVEL shows iceoryx2's as well.
        set_log_level_from_env_or(LogLevel::Fatal);
        let membership = session.enter()?;
        let mut config = Config::default();
        let root = session.root().into_os_string().into_encoded_bytes();
        config.global.prefix = FileName::new(session.prefix().as_bytes()).map_err(|e| broken("naming", e))?;
        config.global.set_root_path(&iceoryx2::prelude::Path::new(&root).map_err(|e| broken("naming", e))?);
        // New nodes clear away what dead ones left; at its end a node need not, for the last one out does.
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.defaults.publish_subscribe.subscriber_expired_connection_buffer = ENDED;
        config.defaults.request_response.server_expired_connection_buffer = ENDED;
        session.clear_half_made();
        // The default handler would swallow Ctrl-C; the program has its own.
        let builder = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let node = builder.create().map_err(|e| broken("joining the session", e))?;
        session.close_to_others();
        session.clear_half_removed(); // the new node has removed those of the dead
        Ok(Place { node, contract, membership })
    }

    fn topic<M: Stamped>(&self, name: &str, shape: Shape) -> Result<Topic<M>, PortError> {
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
        let error = match patiently(open, incompatible) {
            Ok(topic) => return Ok(topic),
            Err(error) => error,
        };
        match builder().open() {
            Ok(found) if error == Open::IncompatibleAttributes.into() => Err(self.disagreement(found.attributes())),
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
        self.topic(TRUTH, Shape { writers: 1, readers: RECORDERS, buffer: TRUTH_BUFFER, history: 0, overwrite: false })
    }

    pub fn served(&self) -> Result<Topic<Served>, PortError> {
        let shape = Shape { writers: DESKS, readers: RECORDERS, buffer: SERVED_BUFFER, history: 0, overwrite: true };
        self.topic(SERVED, shape)
    }

    pub fn link<M: Stamped>(&self, name: &str) -> Result<Topic<M>, PortError> {
        self.topic(name, Shape { writers: 1, readers: LINK_READERS, buffer: 1, history: 1, overwrite: true })
    }

    pub fn event(&self, name: &str) -> Result<event::PortFactory<ipc::Service>, PortError> {
        let service = service_name(name)?;
        patiently(|| self.node.service_builder(&service).event().open_or_create(), |_| false)
            .map_err(|e| broken("the wake-up", e))
    }

    /// A desk of one's own.
    pub fn desk(&self, name: &str) -> Result<DeskFactory, PortError> {
        let service = service_name(name)?;
        let desk = || self.node.service_builder(&service).request_response::<Request, Reply>().max_servers(1);
        let schema = self.schema()?;
        patiently(|| desk().open_or_create_with_attributes(&schema), |_| false).map_err(|e| broken("opening a desk", e))
    }

    /// Somebody else's desk, if there is one.
    pub fn visited_desk(&self, name: &str) -> Result<Option<DeskFactory>, PortError> {
        let desk = self.node.service_builder(&service_name(name)?).request_response::<Request, Reply>();
        match desk.open_with_attributes(&self.schema()?) {
            Ok(desk) => Ok(Some(desk)),
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
    fn disagreement(&self, found: &AttributeSet) -> PortError {
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
struct Shape {
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
