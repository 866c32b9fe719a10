//! The reading end of a topic. It waits by polling, by sleeping, or by one after the other.

use super::contract::Pace;
use super::node::{SessionNode, TopicFactory};
use super::sender::arrival;
use super::waiting::{SPIN, Waiting};
use crate::error::PortError;
use crate::wire::Stamped;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Number of polls, about 1 µs, between two readings of the clock.
const POLLS: u32 = 16;
/// A hybrid reader in lockstep polls for this long and yields the processor in between. This is longer than a recorder uses the
/// other side's processor. Waking a sleeping process would take longer than several periods.
const LOCKSTEP_SPIN: Duration = Duration::from_millis(1);
/// A process of this session returns a yielded processor within this time. Other processes keep it for whole time slices.
const LONGEST_YIELD: Duration = Duration::from_millis(2);
/// After a yield that took longer than [`LONGEST_YIELD`], the reader does not yield for this long.
const YIELD_BACKOFF: Duration = Duration::from_millis(100);
/// Longest wait. After it the caller can check for a stop request or for a process that was restarted.
const SLICE: Duration = Duration::from_millis(10);

/// The reading end of a topic, with an event that wakes it.
#[derive(Debug)]
pub(super) struct Receiver<M: Stamped> {
    reader: TopicReader<M>,
    /// The last message, in shared memory. It is returned at the next poll, while the other side computes.
    held: Option<Borrowed<M>>,
    listener: Listener<ipc::Service>,
    /// When the writer sent the last message, by the monotonic clock that all processes share [ns].
    pub peer_sent_ns: u64,
    /// How to wait.
    pub waiting: Waiting,
    /// In lockstep a hybrid reader yields the processor while it polls.
    pace: Pace,
    /// When a yield last took longer than [`LONGEST_YIELD`].
    long_yield_at: Cell<Option<Instant>>,
}

impl<M: Stamped> Receiver<M> {
    pub fn open(node: &SessionNode, name: &str, pace: Pace) -> Result<Receiver<M>, PortError> {
        let reader = TopicReader::open(&node.link::<M>(name)?, 1, node.session())?;
        let listener = node.listener(name)?;
        let (waiting, long_yield_at) = (Waiting::default(), Cell::new(None));
        Ok(Receiver { reader, held: None, listener, peer_sent_ns: 0, waiting, pace, long_yield_at })
    }

    /// The next message, not validated.
    #[inline]
    pub fn next(&mut self) -> Result<Option<M>, PortError> {
        self.held = None;
        self.held = self.reader.poll()?;
        Ok(self.copy())
    }

    /// Waits for a message, at most [`SLICE`].
    #[inline]
    pub fn wait(&mut self) -> Result<Option<M>, PortError> {
        self.held = None;
        self.held = self.find()?;
        Ok(self.copy())
    }

    /// A copy of the message in shared memory. The message is copied only once.
    #[inline]
    fn copy(&mut self) -> Option<M> {
        let message = **self.held.as_ref()?;
        self.peer_sent_ns = message.stamp().mono_ns;
        Some(message)
    }

    fn find(&self) -> Result<Option<Borrowed<M>>, PortError> {
        // Most answers arrive before the clock must be read, which takes as long as a poll.
        let found = self.poll(POLLS)?;
        if found.is_some() {
            return Ok(found);
        }
        let (start, mut peer_arrived) = (Instant::now(), false);
        loop {
            // The time is taken before the poll. The writer notifies of each later message, because this reader may be asleep then.
            let waited = start.elapsed();
            let found = self.poll(POLLS)?;
            if found.is_some() || waited >= SLICE {
                return Ok(found);
            }
            match self.waiting {
                Waiting::Spin => (),
                Waiting::Hybrid if self.may_yield() && waited < LOCKSTEP_SPIN => self.yield_processor(),
                Waiting::Hybrid if waited < SPIN => (),
                Waiting::Hybrid | Waiting::Event => {
                    match self.listener.timed_wait(|event| peer_arrived |= event.id == arrival(), SLICE - waited) {
                        Ok(_) if peer_arrived => return self.poll(1),
                        Ok(_) | Err(ListenerWaitError::InterruptSignal) => (),
                        Err(error) => return Err(PortError::failed("the wake-up", error)),
                    }
                }
            }
        }
    }

    /// Yields the processor, because the writer may need it. A process that then keeps the processor for long is not the writer, and
    /// would keep it again at every poll.
    fn yield_processor(&self) {
        let before = Instant::now();
        std::thread::yield_now();
        self.long_yield_at.set((before.elapsed() > LONGEST_YIELD).then(Instant::now));
    }

    fn may_yield(&self) -> bool {
        self.pace == Pace::Lockstep && self.long_yield_at.get().is_none_or(|then| then.elapsed() > YIELD_BACKOFF)
    }

    /// Polls for a message this many times, or once if the reader waits for events only.
    fn poll(&self, times: u32) -> Result<Option<Borrowed<M>>, PortError> {
        for _ in 0..if self.waiting == Waiting::Event { 1 } else { times } {
            let found = self.reader.poll()?;
            if found.is_some() {
                return Ok(found);
            }
            std::hint::spin_loop();
        }
        Ok(None)
    }
}

/// A message in shared memory.
type Borrowed<M> = Sample<ipc::Service, M, ()>;

/// The reading end of a topic, without an event.
#[derive(Debug)]
pub(super) struct TopicReader<M: Stamped>(Subscriber<ipc::Service, M, ()>);

impl<M: Stamped> TopicReader<M> {
    /// `session` names the session in an error.
    pub fn open(topic: &TopicFactory<M>, buffer: usize, session: &str) -> Result<TopicReader<M>, PortError> {
        topic.subscriber_builder().buffer_size(buffer).create().map(TopicReader).map_err(|error| match error {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => PortError::Crowded { session: session.into() },
            error => PortError::failed("reading", error),
        })
    }

    /// A copy of the next message. Its shared memory is free again at once.
    pub fn next(&self) -> Result<Option<M>, PortError> {
        Ok(self.poll()?.map(|sample| *sample))
    }

    /// The next message, in shared memory.
    pub fn poll(&self) -> Result<Option<Borrowed<M>>, PortError> {
        self.0.receive().map_err(|e| PortError::failed("reading", e))
    }
}
