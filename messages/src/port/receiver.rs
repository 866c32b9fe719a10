//! The reading end of a topic. It waits by polling, by sleeping, or by one after the other.

use super::bell::{Bell, Sleep};
use super::busy_detector::{BusyDetector, LONG_PERIOD, Machine};
use super::contract::Pace;
use super::node::{SessionNode, TopicFactory};
use super::placement::Placement;
use super::waiting::{SPIN, Waiting};
use super::wake::{Peer, arrival};
use crate::error::PortError;
use crate::wire::Stamped;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use std::time::{Duration, Instant};

/// Number of polls, about 1 µs, between two readings of the clock.
const POLLS: u32 = 16;
/// Longest wait. After it the caller can check for a stop request or for a process that was restarted.
const SLICE: Duration = Duration::from_millis(10);
/// Shortest wait for an event. A socket cuts its time-out to whole microseconds, and takes zero as a wait without end.
const LEAST_WAIT: Duration = Duration::from_micros(1);

/// The reading end of a topic, with a bell and an event that wake it.
#[derive(Debug)]
pub(super) struct Receiver<M: Stamped> {
    reader: TopicReader<M>,
    /// The last message, in shared memory. It is returned at the next poll, while the other side computes.
    held: Option<Borrowed<M>>,
    listener: Listener<ipc::Service>,
    bell: Option<Bell>,
    /// When the writer sent the last message, by the monotonic clock that all processes share [ns].
    peer_sent_ns: u64,
    /// Epoch of the last message: it tells whether the writer rings the bell.
    peer_epoch: u64,
    /// How to wait.
    pub waiting: Waiting,
    /// In lockstep a hybrid reader yields the processor while it polls, and sleeps at once on a busy machine.
    pace: Pace,
    detector: BusyDetector,
    /// `None` if this process must stay where it is.
    pub placement: Option<Placement>,
}

impl<M: Stamped> Receiver<M> {
    pub fn open(node: &SessionNode, name: &str, pace: Pace) -> Result<Receiver<M>, PortError> {
        let reader = TopicReader::open(&node.link::<M>(name)?, 1, node.session())?;
        let (listener, bell) = (node.listener(name)?, node.bell(name)?);
        let (waiting, detector) = (Waiting::default(), BusyDetector::default());
        let (peer_sent_ns, peer_epoch) = (0, 0);
        Ok(Receiver {
            reader,
            held: None,
            listener,
            bell,
            peer_sent_ns,
            peer_epoch,
            waiting,
            pace,
            detector,
            placement: None,
        })
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
        let sent_ns = message.stamp().mono_ns;
        if self.pace == Pace::Lockstep && self.waiting == Waiting::Hybrid && self.peer_sent_ns != 0 {
            self.update_detector(Duration::from_nanos(sent_ns.saturating_sub(self.peer_sent_ns)));
        }
        (self.peer_sent_ns, self.peer_epoch) = (sent_ns, message.stamp().epoch);
        Some(message)
    }

    /// Tells the detector the time between two messages, which is a control period.
    #[inline]
    fn update_detector(&mut self, period: Duration) {
        let change = self.detector.update(period);
        if let (Some(machine), Some(placement)) = (change, self.placement.as_mut()) {
            placement.apply(machine);
        }
    }

    /// How to wake the writer of this topic, which reads the other one.
    #[inline]
    pub fn peer(&self) -> Peer {
        let awake_ns = if self.detector.peer_may_sleep() { 0 } else { self.peer_sent_ns };
        Peer { awake_ns, hears_bell: self.present_bell().is_some() }
    }

    /// The bell, if the writer rings it. Such a writer also hears the bell of the other topic.
    fn present_bell(&self) -> Option<&Bell> {
        self.bell.as_ref().filter(|bell| bell.is_rung_by(self.peer_epoch))
    }

    /// How to wait now.
    #[inline]
    fn waiting_now(&self) -> Waiting {
        match self.detector.machine() {
            Machine::Idle => self.waiting,
            Machine::Busy => Waiting::Event,
        }
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
            match self.waiting_now() {
                Waiting::Spin => (),
                // The writer, or a recorder, may need the processor. Waking a sleeping process would take longer than several periods.
                Waiting::Hybrid if self.pace == Pace::Lockstep && waited < LONG_PERIOD => std::thread::yield_now(),
                Waiting::Hybrid if waited < SPIN => (),
                Waiting::Hybrid | Waiting::Event => {
                    if let Some(bell) = self.present_bell() {
                        match bell.sleep(rest(waited), || self.poll(1))? {
                            Sleep::Found(message) => return Ok(Some(message)),
                            Sleep::Rung => return self.poll(1), // a ring without a message announces another process
                            Sleep::Elapsed => continue,
                        }
                    }
                    match self.listener.timed_wait(|event| peer_arrived |= event.id == arrival(), rest(waited)) {
                        Ok(_) if peer_arrived => return self.poll(1),
                        Ok(_) | Err(ListenerWaitError::InterruptSignal) => (),
                        Err(error) => return Err(PortError::failed("the wake-up", error)),
                    }
                }
            }
        }
    }

    /// Polls for a message this many times, or once if the reader waits for events only.
    fn poll(&self, times: u32) -> Result<Option<Borrowed<M>>, PortError> {
        for _ in 0..if self.waiting_now() == Waiting::Event { 1 } else { times } {
            let found = self.reader.poll()?;
            if found.is_some() {
                return Ok(found);
            }
            std::hint::spin_loop();
        }
        Ok(None)
    }
}

/// The rest of [`SLICE`], at least [`LEAST_WAIT`].
fn rest(waited: Duration) -> Duration {
    SLICE.saturating_sub(waited).max(LEAST_WAIT)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::Contract;
    use crate::port::node::SessionNode;
    use crate::scene::Scene;
    use crate::session::Session;
    use std::sync::mpsc;

    const LONG: Duration = Duration::from_secs(20);

    /// With a time-out of zero the socket of the event would wait until a notification comes, for ever if the peer is missing.
    #[test]
    fn the_last_nanoseconds_of_a_wait_for_an_event_end() {
        let contract = Contract::of(&Scene::default(), Pace::Lockstep);
        let (ended, end) = mpsc::channel();
        for left in [0, 1, 999] {
            let ended = ended.clone();
            std::thread::spawn(move || {
                let node = SessionNode::open(&Session::unique(), &contract).expect("a node");
                let listener = node.listener("biped/test").expect("an event");
                let waited = SLICE - Duration::from_nanos(left);
                let ends = listener.timed_wait(|_| (), rest(waited)).is_ok_and(|events| events == 0);
                drop((listener, node)); // the session's files go before the test ends
                ended.send(ends).expect("a test");
            });
            assert_eq!(end.recv_timeout(LONG), Ok(true), "{left} ns were left");
        }
    }
}
