//! The two ends of a topic: written at once, waited for by spinning, sleeping, or one after the other.

use super::contract::Pace;
use super::error::{PortError, broken};
use super::node::{SessionNode, Topic};
use crate::clock::now_ns;
use crate::wire::Stamped;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;
use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

/// A reader that spins looks so often, about 1 µs, before it does anything else.
const POLLS: u32 = 16;
/// A waiting reader spins for this long before it sleeps: longer than a tick of the other side takes.
const SPIN: Duration = Duration::from_micros(50);
/// The same in lockstep, while it gives way: longer than a recorder takes the other side's processor for. To wake a sleeper would
/// take longer than several periods.
const LOCKSTEP_SPIN: Duration = Duration::from_millis(1);
/// For so long after its own last message a reader is surely still spinning [ns].
const AWAKE_NS: u64 = SPIN.as_nanos() as u64 / 2;
/// Whoever has a message to write, or to record, gives the processor back within this time; others take it for whole slices.
const LONGEST_YIELD: Duration = Duration::from_millis(2);
/// For so long nobody is given way to after one who kept it longer.
const YIELD_BACKOFF: Duration = Duration::from_millis(100);
/// A sleeping reader looks around this often, so that a stop request or a restarted peer is noticed.
const SLICE: Duration = Duration::from_millis(10);
/// A successor tries its node this often.
const TAKEOVER_RETRY: Duration = Duration::from_micros(500);

/// The ring of somebody who has come; that for a message is 0.
fn arrival() -> EventId {
    EventId::new(1)
}

/// How a process waits for the other side. Both ends of a link should wait alike: a writer rings only for a reader that
/// may be asleep, and one that sleeps unexpectedly looks around every 10 ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Waiting {
    /// Looks without pause: soonest, but takes a processor; never under a real-time scheduler, which it would block.
    Spin,
    /// Looks without pause for 50 µs, in lockstep for 1 ms if the processor is free, then sleeps until it is woken.
    #[default]
    Hybrid,
    /// Sleeps until it is woken: spares the processor.
    Event,
}

impl Waiting {
    /// Whether a reader may be asleep that sent its own last message `since_peer_sent_ns` ago.
    fn may_sleep(self, since_peer_sent_ns: impl FnOnce() -> u64) -> bool {
        match self {
            Waiting::Spin => false,
            Waiting::Hybrid => since_peer_sent_ns() >= AWAKE_NS,
            Waiting::Event => true,
        }
    }
}

/// Writing end of a topic with a wake-up.
#[derive(Debug)]
pub(super) struct Sender<M: Stamped> {
    /// ShmUsage for the next message.
    loan: RefCell<Option<SampleMut<ipc::Service, M, ()>>>,
    writer: Publisher<ipc::Service, M, ()>,
    notifier: Notifier<ipc::Service>,
    /// How the reader waits.
    pub waiting: Waiting,
}

impl<M: Stamped> Sender<M> {
    /// Takes the one node of a writer; while somebody else has it, `waits` is asked whether to wait on.
    pub fn open(
        node: &SessionNode,
        name: &str,
        role: &'static str,
        waits: impl Fn() -> bool,
    ) -> Result<Sender<M>, PortError> {
        let topic = node.link::<M>(name)?;
        let notifier = node.event(name)?.notifier_builder().create().map_err(|e| broken("the wake-up", e))?;
        let writer = loop {
            match topic.publisher_builder().max_loaned_samples(1).create() {
                Ok(writer) => break writer,
                Err(PublisherCreateError::ExceedsMaxSupportedPublishers) if waits() => {
                    std::thread::sleep(TAKEOVER_RETRY)
                }
                Err(PublisherCreateError::ExceedsMaxSupportedPublishers) => {
                    return Err(PortError::Taken { session: node.session().into(), role });
                }
                Err(error) => return Err(broken("writing", error)),
            }
        };
        Ok(Sender { loan: RefCell::new(None), writer, notifier, waiting: Waiting::default() })
    }

    /// Writes, and rings unless the reader is surely awake: it sent its own last message at `peer_sent_ns` and has spun for
    /// this one since. A ring is a system call and costs more than a tick.
    #[inline]
    pub fn send(&self, message: M, peer_sent_ns: u64) -> Result<(), PortError> {
        self.write(message, M::seal, peer_sent_ns)
    }

    /// The same, after `finish` on the message in its node.
    #[inline]
    pub fn write(&self, message: M, finish: impl FnOnce(&mut M), peer_sent_ns: u64) -> Result<(), PortError> {
        let mut sample = self.loan.take().map_or_else(|| self.loan_sample(), Ok)?;
        *sample.payload_mut() = message;
        finish(sample.payload_mut());
        sample.send().map_err(|e| broken("writing", e))?;
        // what a damaged message says of the future is not believed
        if self.waiting.may_sleep(|| now_ns().checked_sub(peer_sent_ns).unwrap_or(u64::MAX)) {
            self.notify()?;
        }
        Ok(())
    }

    /// Takes room for the next message beforehand, and writes there, so that its cache lines need not be fetched from the
    /// other processor when the message is there: that is half of what sending costs.
    pub fn prepare(&self) -> Result<(), PortError> {
        let mut room = self.loan.borrow_mut();
        if room.is_none() {
            *room = Some(self.loan_sample()?);
        }
        Ok(())
    }

    fn loan_sample(&self) -> Result<SampleMut<ipc::Service, M, ()>, PortError> {
        Ok(self.writer.loan_uninit().map_err(|e| broken("writing", e))?.write_payload(M::zeroed()))
    }

    fn notify(&self) -> Result<(), PortError> {
        self.notifier.notify().map_err(|e| broken("the wake-up", e)).map(drop)
    }

    /// Rings without a message: somebody has come, and wants to hear the other side's last one.
    pub fn notify_arrival(&self) -> Result<(), PortError> {
        self.notifier.notify_with_custom_event_id(arrival()).map_err(|e| broken("the wake-up", e)).map(drop)
    }

    /// Gives the last message to a reader that has come since, and wakes it.
    pub fn catch_up(&self) -> Result<(), PortError> {
        self.writer.update_connections().map_err(|e| broken("connecting", e))?;
        self.notify()
    }
}

/// Reading end of a topic with a wake-up.
#[derive(Debug)]
pub(super) struct Receiver<M: Stamped> {
    reader: TopicReader<M>,
    /// What was read last, in its slot: given back when the next is looked for, while the other side computes.
    held: Option<Borrowed<M>>,
    notifier: Listener<ipc::Service>,
    /// When the writer sent what was read last, by its monotonic clock, which is ours [ns].
    pub peer_sent_ns: u64,
    /// How to wait.
    pub waiting: Waiting,
    /// In lockstep a hybrid gives way while it spins.
    pace: Pace,
    /// When somebody who was given way to last kept the processor for long.
    long_yield_at: Cell<Option<Instant>>,
}

impl<M: Stamped> Receiver<M> {
    pub fn open(node: &SessionNode, name: &str, pace: Pace) -> Result<Receiver<M>, PortError> {
        let reader = TopicReader::open(&node.link::<M>(name)?, 1)?;
        let notifier = node.event(name)?.listener_builder().create().map_err(|e| broken("the wake-up", e))?;
        let (waiting, long_yield_at) = (Waiting::default(), Cell::new(None));
        Ok(Receiver { reader, held: None, notifier, peer_sent_ns: 0, waiting, pace, long_yield_at })
    }

    /// The next message, as it came.
    #[inline]
    pub fn next(&mut self) -> Result<Option<M>, PortError> {
        self.held = None;
        self.held = self.reader.poll()?;
        Ok(self.copy())
    }

    /// Spins first and sleeps then, as `waiting` says; gives up after a slice.
    #[inline]
    pub fn wait(&mut self) -> Result<Option<M>, PortError> {
        self.held = None;
        self.held = self.find()?;
        Ok(self.copy())
    }

    /// The only copy.
    #[inline]
    fn copy(&mut self) -> Option<M> {
        let message = **self.held.as_ref()?;
        self.peer_sent_ns = message.stamp().mono_ns;
        Some(message)
    }

    fn find(&self) -> Result<Option<Borrowed<M>>, PortError> {
        // Most answers come before a clock need be read, which takes as long as a look.
        let found = self.poll(POLLS)?;
        if found.is_some() {
            return Ok(found);
        }
        let (start, mut peer_arrived) = (Instant::now(), false);
        loop {
            let waited = start.elapsed(); // before the look: what comes after it is rung for, once we may sleep
            let found = self.poll(POLLS)?;
            if found.is_some() || waited >= SLICE {
                return Ok(found);
            }
            match self.waiting {
                Waiting::Spin => (),
                Waiting::Hybrid if self.may_yield() && waited < LOCKSTEP_SPIN => self.yield_processor(),
                Waiting::Hybrid if waited < SPIN => (),
                Waiting::Hybrid | Waiting::Event => {
                    match self.notifier.timed_wait(|ring| peer_arrived |= ring.id == arrival(), SLICE - waited) {
                        Ok(_) if peer_arrived => return self.poll(1),
                        Ok(_) | Err(ListenerWaitError::InterruptSignal) => (),
                        Err(error) => return Err(broken("the wake-up", error)),
                    }
                }
            }
        }
    }

    /// Lets others have the processor: the writer may be waiting for this very one. Whoever keeps it for long is not the writer, and
    /// would do so at every look.
    fn yield_processor(&self) {
        let before = Instant::now();
        std::thread::yield_now();
        self.long_yield_at.set((before.elapsed() > LONGEST_YIELD).then(Instant::now));
    }

    fn may_yield(&self) -> bool {
        self.pace == Pace::Lockstep && self.long_yield_at.get().is_none_or(|then| then.elapsed() > YIELD_BACKOFF)
    }

    /// Looks for a message, a few times if it may come any moment.
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

/// A message in its slot.
type Borrowed<M> = Sample<ipc::Service, M, ()>;

/// Reading end of a topic.
#[derive(Debug)]
pub(super) struct TopicReader<M: Stamped>(Subscriber<ipc::Service, M, ()>);

impl<M: Stamped> TopicReader<M> {
    pub fn open(topic: &Topic<M>, buffer: usize) -> Result<TopicReader<M>, PortError> {
        topic.subscriber_builder().buffer_size(buffer).create().map(TopicReader).map_err(|e| broken("reading", e))
    }

    /// A copy of the next message; its slot is free again at once.
    pub fn next(&self) -> Result<Option<M>, PortError> {
        Ok(self.poll()?.map(|sample| *sample))
    }

    /// The next message in its slot.
    pub fn poll(&self) -> Result<Option<Borrowed<M>>, PortError> {
        self.0.receive().map_err(|e| broken("reading", e))
    }
}
