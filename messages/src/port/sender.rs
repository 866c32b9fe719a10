//! The writing end of a topic, with a bell or an event that wakes the reader.

use super::bell::Bell;
use super::node::SessionNode;
use super::waiting::Waiting;
use super::wake::{Peer, arrival};
use crate::clock::now_ns;
use crate::error::PortError;
use crate::wire::Stamped;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample_mut::SampleMut;
use std::cell::RefCell;
use std::time::Duration;

/// A successor tries this often to become the writer.
const TAKEOVER_RETRY: Duration = Duration::from_micros(500);

/// The writing end of a topic.
#[derive(Debug)]
pub(super) struct Sender<M: Stamped> {
    /// Shared memory for the next message.
    loan: RefCell<Option<SampleMut<ipc::Service, M, ()>>>,
    writer: Publisher<ipc::Service, M, ()>,
    notifier: Notifier<ipc::Service>,
    bell: Option<Bell>,
    /// How the reader waits.
    pub waiting: Waiting,
}

impl<M: Stamped> Sender<M> {
    /// Becomes the only writer of a topic. While another process is the writer, it waits as long as `keep_waiting` returns true.
    pub fn open(
        node: &SessionNode,
        name: &str,
        role: &'static str,
        keep_waiting: impl Fn() -> bool,
    ) -> Result<Sender<M>, PortError> {
        let topic = node.link::<M>(name)?;
        let (notifier, bell) = (node.notifier(name)?, node.bell(name)?);
        let writer = loop {
            match topic.publisher_builder().max_loaned_samples(1).create() {
                Ok(writer) => break writer,
                Err(PublisherCreateError::ExceedsMaxSupportedPublishers) if keep_waiting() => {
                    std::thread::sleep(TAKEOVER_RETRY)
                }
                Err(PublisherCreateError::ExceedsMaxSupportedPublishers) => {
                    return Err(PortError::Taken { session: node.session().into(), role });
                }
                Err(error) => return Err(PortError::failed("writing", error)),
            }
        };
        Ok(Sender { loan: RefCell::new(None), writer, notifier, bell, waiting: Waiting::default() })
    }

    /// Seals and writes a message, and wakes the reader if it may be asleep. A notification is a system call and takes longer than the
    /// controller's computation.
    #[inline]
    pub fn send(&self, message: M, peer: Peer) -> Result<(), PortError> {
        self.write(message, M::seal, peer)
    }

    /// Writes a message after `finish` has changed it in place, and wakes the reader as [`Sender::send`].
    #[inline]
    pub fn write(&self, message: M, finish: impl FnOnce(&mut M), peer: Peer) -> Result<(), PortError> {
        let mut sample = self.loan.take().map_or_else(|| self.loan_sample(), Ok)?;
        *sample.payload_mut() = message;
        finish(sample.payload_mut());
        let bell = self.bell.as_ref();
        let _ = bell.map(|bell| bell.sign(sample.payload().stamp().epoch));
        sample.send().map_err(|e| PortError::failed("writing", e))?;
        let _ = bell.map(Bell::ring);
        // A damaged message may hold a time in the future. Then the reader is notified.
        let may_sleep = || self.waiting.may_sleep(|| now_ns().checked_sub(peer.awake_ns).unwrap_or(u64::MAX));
        if !peer.hears_bell && may_sleep() {
            self.notify()?;
        }
        Ok(())
    }

    /// Loans shared memory for the next message in advance and writes to it, which fetches its cache lines from the other
    /// processor. This halves the time of sending.
    pub fn prepare(&self) -> Result<(), PortError> {
        let mut loan = self.loan.borrow_mut();
        if loan.is_none() {
            *loan = Some(self.loan_sample()?);
        }
        Ok(())
    }

    fn loan_sample(&self) -> Result<SampleMut<ipc::Service, M, ()>, PortError> {
        Ok(self.writer.loan_uninit().map_err(|e| PortError::failed("writing", e))?.write_payload(M::zeroed()))
    }

    fn notify(&self) -> Result<(), PortError> {
        self.notifier.notify().map_err(|e| PortError::failed("the wake-up", e)).map(drop)
    }

    /// Notifies the reader that this process has joined. The reader then repeats its own last message.
    pub fn notify_arrival(&self) -> Result<(), PortError> {
        let _ = self.bell.as_ref().map(Bell::ring);
        self.notifier.notify_with_custom_event_id(arrival()).map_err(|e| PortError::failed("the wake-up", e)).map(drop)
    }

    /// Delivers the last message to a reader that has joined since, and wakes it.
    pub fn catch_up(&self) -> Result<(), PortError> {
        self.writer.update_connections().map_err(|e| PortError::failed("connecting", e))?;
        self.notify()
    }
}
