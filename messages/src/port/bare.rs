//! iceoryx2 alone, as its own examples use it: what our messages cost without seal, check, stamp and wake-up. For measuring.

use super::contract::Contract;
use super::error::{PortError, broken};
use super::link::TopicReader;
use super::node::SessionNode;
use super::{COMMAND, SENSORS};
use crate::session::Session;
use crate::wire::{Command, Sensors, Stamped};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::*;

/// One end of a link that adds nothing to iceoryx2.
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
        let node = SessionNode::open(session, contract)?;
        let topic = node.link::<Out>(out)?;
        let writer = topic.publisher_builder().max_loaned_samples(1).create().map_err(|e| broken("writing", e))?;
        let reader = TopicReader::open(&node.link::<In>(back)?, 1)?;
        Ok(BarePort { writer, reader, _node: node })
    }

    /// Loan, copy, send.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn send(&self, message: Out) -> Result<(), PortError> {
        let sample = self.writer.loan_uninit().map_err(|e| broken("writing", e))?;
        sample.write_payload(message).send().map_err(|e| broken("writing", e))?;
        Ok(())
    }

    /// One look: a copy of the newest message, if there is one.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn poll(&self) -> Result<Option<In>, PortError> {
        self.reader.next()
    }
}
