//! A connection by iceoryx2 alone, without seal, check, stamp and wake-up. It serves as the reference in latency measurements.

use super::contract::Contract;
use super::node::{COMMAND, SENSORS, SessionNode};
use super::opening::unblocked;
use super::receiver::TopicReader;
use crate::error::PortError;
use crate::session::Session;
use crate::wire::{Command, Sensors, Stamped};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::*;

/// One end of a connection that adds nothing to iceoryx2.
#[derive(Debug)]
pub struct BarePort<Out: Stamped, In: Stamped> {
    writer: Publisher<ipc::Service, Out, ()>,
    reader: TopicReader<In>,
    _node: SessionNode,
}

impl BarePort<Sensors, Command> {
    /// The plant's end.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn plant(session: &Session, contract: &Contract) -> Result<Self, PortError> {
        BarePort::open(session, contract, [SENSORS, COMMAND])
    }
}

impl BarePort<Command, Sensors> {
    /// The controller's end.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn controller(session: &Session, contract: &Contract) -> Result<Self, PortError> {
        BarePort::open(session, contract, [COMMAND, SENSORS])
    }
}

impl<Out: Stamped, In: Stamped> BarePort<Out, In> {
    fn open(session: &Session, contract: &Contract, [out, back]: [&str; 2]) -> Result<Self, PortError> {
        unblocked(session, || BarePort::join(session, contract, [out, back]))
    }

    fn join(session: &Session, contract: &Contract, [out, back]: [&str; 2]) -> Result<Self, PortError> {
        let node = SessionNode::open(session, contract)?;
        let topic = node.link::<Out>(out)?;
        let writer =
            topic.publisher_builder().max_loaned_samples(1).create().map_err(|e| PortError::failed("writing", e))?;
        let reader = TopicReader::open(&node.link::<In>(back)?, 1, node.session())?;
        Ok(BarePort { writer, reader, _node: node })
    }

    /// Loans shared memory, copies the message there, and sends it.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn send(&self, message: Out) -> Result<(), PortError> {
        let sample = self.writer.loan_uninit().map_err(|e| PortError::failed("writing", e))?;
        sample.write_payload(message).send().map_err(|e| PortError::failed("writing", e))?;
        Ok(())
    }

    /// Polls once: a copy of the newest message, if there is one.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn poll(&self) -> Result<Option<In>, PortError> {
        self.reader.next()
    }
}
