//! The control services: requests to the plant and to the controller, and their replies.

use super::node::SessionNode;
use super::opening::unblocked;
use crate::action::Action;
use crate::error::PortError;
use crate::session::Session;
use crate::wire::{Reply, Request, Served, Stamped};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::server::ServerCreateError;
use std::time::{Duration, Instant};

/// Name of the plant's control service.
pub(super) const PLANT: &str = "biped/plant/desk";
/// Name of the controller's control service.
pub(super) const CONTROLLER: &str = "biped/controller/desk";
/// Longest wait for a reply. A process checks for requests once each control period, or every 10 ms while it waits.
const REPLY_TIMEOUT: Duration = Duration::from_secs(2);
/// Interval at which a client checks for the reply.
const REPLY_POLL: Duration = Duration::from_micros(200);

/// The server of a control service.
#[derive(Debug)]
pub(super) struct ControlService {
    server: Server<ipc::Service, Request, (), Reply, ()>,
    served: Publisher<ipc::Service, Served, ()>,
}

impl ControlService {
    /// Opens the control service of a role. Only one process can do so.
    pub fn open(node: &SessionNode, name: &str, role: &'static str) -> Result<ControlService, PortError> {
        match node.service(name)?.server_builder().create() {
            Ok(server) => {
                let served = node
                    .served()?
                    .publisher_builder()
                    .create()
                    .map_err(|e| PortError::failed("opening a control service", e))?;
                Ok(ControlService { server, served })
            }
            Err(ServerCreateError::ExceedsMaxSupportedServers) => {
                Err(PortError::Taken { session: node.session().into(), role })
            }
            Err(error) => Err(PortError::failed("opening a control service", error)),
        }
    }

    /// The next request, if there is one.
    pub fn next(&self) -> Result<Option<PendingRequest>, PortError> {
        let active = self.server.receive().map_err(|e| PortError::failed("reading a request", e))?;
        Ok(active.map(|active| PendingRequest { request: *active, active }))
    }

    /// Seals and sends the reply, and reports it to the recorders. It is no error if the client has gone.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, pending: PendingRequest, reply: Reply) -> Result<(), PortError> {
        let served = Served { stamp: reply.stamp, request: pending.request, verdict: reply.verdict };
        self.served.send_copy(served.sealed()).map_err(|e| PortError::failed("recording a request", e))?;
        if pending.active.is_connected() {
            pending.active.send_copy(reply.sealed()).map_err(|e| PortError::failed("answering a request", e))?;
        }
        Ok(())
    }
}

/// A request that has not been answered yet.
#[derive(Debug)]
pub struct PendingRequest {
    /// The request.
    pub request: Request,
    active: ActiveRequest<ipc::Service, Request, (), Reply, ()>,
}

/// Sends a request to the plant or the controller of a running session, and waits for the reply.
///
/// # Errors
/// [`PortError::NoSession`] if the session is not running, [`PortError::Absent`] if the control service does not answer.
pub fn ask(session: &Session, what: Action) -> Result<Reply, PortError> {
    ask_for(session, what, None)
}

/// As [`ask`], on behalf of the other user with this number.
///
/// # Errors
/// As [`ask`].
pub fn ask_for(session: &Session, what: Action, user: Option<u32>) -> Result<Reply, PortError> {
    let (name, role) = if what.is_for_controller() { (CONTROLLER, "controller") } else { (PLANT, "plant") };
    let no_answer = || PortError::Absent { session: session.name().into(), role };
    let (_node, client) = unblocked(session, || {
        let node = SessionNode::attach(session)?;
        let client = node.existing_service(name)?.ok_or_else(no_answer)?.client_builder().create();
        Ok::<_, PortError>((node, client.map_err(|e| PortError::failed("connecting to a control service", e))?))
    })?;
    let start = Instant::now();
    let request = what.encode().on_behalf_of(user).sealed();
    let mut pending = client.send_copy(request).map_err(|e| PortError::failed("sending a request", e))?;
    while start.elapsed() < REPLY_TIMEOUT {
        if let Some(reply) = pending.receive().map_err(|e| PortError::failed("reading a reply", e))? {
            return Ok(*reply);
        }
        std::thread::sleep(REPLY_POLL);
        // The service exists a short time before its server. Then the request must be sent again.
        if pending.number_of_server_connections() == 0 {
            pending = client.send_copy(request).map_err(|e| PortError::failed("sending a request", e))?;
        }
    }
    Err(no_answer())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::{Contract, Pace};
    use crate::scene::Scene;

    #[test]
    fn a_request_sent_before_the_server_exists_is_served_exactly_once() {
        let session = Session::unique();
        let node = SessionNode::open(&session, &Contract::of(&Scene::default(), Pace::Lockstep)).unwrap();
        let early = node.service(PLANT).unwrap();
        let client = std::thread::spawn(move || ask(&session, Action::Step { periods: 3 }));
        std::thread::sleep(Duration::from_millis(100));
        let service = ControlService::open(&node, PLANT, "plant").unwrap();
        let (mut served_periods, start) = (0, Instant::now());
        while start.elapsed() < REPLY_TIMEOUT && !client.is_finished() {
            for pending in std::iter::from_fn(|| service.next().unwrap()) {
                served_periods += pending.request.count;
                service.answer(pending, Reply::default()).unwrap();
            }
        }
        assert!(client.join().unwrap().is_ok());
        assert_eq!(served_periods, 3);
        drop(early);
    }
}
