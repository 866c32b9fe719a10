//! Request and response: a service at the plant and one at the controller, and whoever comes to it.

use super::error::{PortError, broken};
use super::node::SessionNode;
use crate::action::Action;
use crate::session::Session;
use crate::wire::{Reply, Request, Served, Stamped};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::server::ServerCreateError;
use std::time::{Duration, Instant};

pub(super) const PLANT: &str = "biped/plant/desk";
pub(super) const CONTROLLER: &str = "biped/controller/desk";
/// A reply comes within a control period, or a slice of waiting.
const PATIENCE: Duration = Duration::from_secs(2);

/// Where requests come in.
#[derive(Debug)]
pub(super) struct ControlService {
    server: Server<ipc::Service, Request, (), Reply, ()>,
    served: Publisher<ipc::Service, Served, ()>,
}

impl ControlService {
    /// The service of a role, which has one node.
    pub fn open(node: &SessionNode, name: &str, role: &'static str) -> Result<ControlService, PortError> {
        match node.service(name)?.server_builder().create() {
            Ok(server) => {
                let served = node.served()?.publisher_builder().create().map_err(|e| broken("opening a desk", e))?;
                Ok(ControlService { server, served })
            }
            Err(ServerCreateError::ExceedsMaxSupportedServers) => {
                Err(PortError::Taken { session: node.session().into(), role })
            }
            Err(error) => Err(broken("opening a desk", error)),
        }
    }

    /// The next request, if there is one.
    pub fn next(&self) -> Result<Option<PendingRequest>, PortError> {
        let active = self.server.receive().map_err(|e| broken("reading a request", e))?;
        Ok(active.map(|active| PendingRequest { request: *active, active }))
    }

    /// Seals and sends the answer, and tells whoever records; somebody who has gone is no error.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn answer(&self, asked: PendingRequest, reply: Reply) -> Result<(), PortError> {
        let served = Served { stamp: reply.stamp, request: asked.request, verdict: reply.verdict };
        self.served.send_copy(served.sealed()).map_err(|e| broken("telling of a request", e))?;
        if asked.active.is_connected() {
            asked.active.send_copy(reply.sealed()).map_err(|e| broken("answering a request", e))?;
        }
        Ok(())
    }
}

/// A request that waits for its answer.
#[derive(Debug)]
pub struct PendingRequest {
    /// The request.
    pub request: Request,
    active: ActiveRequest<ipc::Service, Request, (), Reply, ()>,
}

/// Asks the plant or the controller of a running session, and waits for the answer.
///
/// # Errors
/// [`PortError::NoSession`] if there is no such session, [`PortError::Absent`] if there is nobody at the service.
pub fn ask(session: &Session, what: Action) -> Result<Reply, PortError> {
    let (name, role) = if what.is_for_controller() { (CONTROLLER, "controller") } else { (PLANT, "plant") };
    let absent = || PortError::Absent { session: session.name().into(), role };
    let node = SessionNode::attach(session)?;
    let client = node.existing_service(name)?.ok_or_else(absent)?;
    let client = client.client_builder().create().map_err(|e| broken("coming to a desk", e))?;
    let start = Instant::now();
    let request = what.encode().sealed();
    let mut pending = client.send_copy(request).map_err(|e| broken("asking", e))?;
    while start.elapsed() < PATIENCE {
        if let Some(reply) = pending.receive().map_err(|e| broken("reading an answer", e))? {
            return Ok(*reply);
        }
        std::thread::sleep(Duration::from_micros(200));
        // a service is there a little before who sits at it
        if pending.number_of_server_connections() == 0 {
            pending = client.send_copy(request).map_err(|e| broken("asking", e))?;
        }
    }
    Err(absent())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::{Contract, Pace};
    use crate::scene::Scene;

    #[test]
    fn a_request_that_comes_before_who_sits_at_the_desk_is_heard_once() {
        let session = Session::unique();
        let node = SessionNode::open(&session, &Contract::of(&Scene::default(), Pace::Lockstep)).unwrap();
        let early = node.service(PLANT).unwrap();
        let asker = std::thread::spawn(move || ask(&session, Action::Step { periods: 3 }));
        std::thread::sleep(Duration::from_millis(100));
        let service = ControlService::open(&node, PLANT, "plant").unwrap();
        let (mut heard, start) = (0, Instant::now());
        while start.elapsed() < PATIENCE && !asker.is_finished() {
            for asked in std::iter::from_fn(|| service.next().unwrap()) {
                heard += asked.request.count;
                service.answer(asked, Reply::default()).unwrap();
            }
        }
        assert!(asker.join().unwrap().is_ok());
        assert_eq!(heard, 3);
        drop(early);
    }
}
