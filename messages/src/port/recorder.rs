//! A recorder's end of the connection.

use super::contract::Contract;
use super::node::{SERVED_BUFFER, SessionNode, TRUTH, TRUTH_BUFFER};
use super::opening::unblocked;
use super::receiver::TopicReader;
use crate::error::PortError;
use crate::session::Session;
use crate::wire::{Served, Truth};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;
use std::ops::Deref;

/// A recorder's end of the connection.
#[derive(Debug)]
pub struct RecorderPort {
    truth: TopicReader<Truth>,
    served: TopicReader<Served>,
    notifier: Notifier<ipc::Service>,
    /// Run of the last message read. The plant waits for one notification in each run.
    run: Option<u64>,
    _node: SessionNode,
}

impl RecorderPort {
    /// Joins a session as a recorder.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn open(session: &Session, contract: &Contract) -> Result<RecorderPort, PortError> {
        unblocked(session, || RecorderPort::new(SessionNode::open(session, contract)?))
    }

    /// Joins a running session as a recorder, whatever its contract.
    ///
    /// # Errors
    /// [`PortError::NoSession`] if the session is not running.
    pub fn attach(session: &Session) -> Result<RecorderPort, PortError> {
        unblocked(session, || RecorderPort::new(SessionNode::attach(session)?))
    }

    fn new(node: SessionNode) -> Result<RecorderPort, PortError> {
        let truth = TopicReader::open(&node.truth()?, TRUTH_BUFFER, node.session())?;
        let served = TopicReader::open(&node.served()?, SERVED_BUFFER, node.session())?;
        let notifier = node.notifier(TRUTH)?;
        Ok(RecorderPort { truth, served, notifier, run: None, _node: node })
    }

    /// The next request with its answer, if there is one. A request that took effect before a message of truth can be read before
    /// that message.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn served(&self) -> Result<Option<Served>, PortError> {
        self.served.next()
    }

    /// The next message of truth, in order, if there is one. It stays in shared memory, so drop it before the next call.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn read(&mut self) -> Result<Option<impl Deref<Target = Truth> + use<>>, PortError> {
        let truth = self.truth.poll()?;
        let run = truth.as_ref().map(|truth| truth.stamp.run);
        if run.is_some() && run != self.run {
            self.run = run;
            self.notifier.notify().map_err(|e| PortError::failed("the wake-up", e))?;
        }
        Ok(truth)
    }
}
