//! The two ends of a topic: written at once, waited for by spinning, sleeping, or one after the other.

use super::contract::Pace;
use super::error::{PortError, broken};
use super::place::{Place, Topic};
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
const LOOKS: u32 = 16;
/// A waiting reader spins for this long before it sleeps: longer than a tick of the other side takes.
const SPIN: Duration = Duration::from_micros(50);
/// The same in lockstep, while it gives way: longer than a recorder takes the other side's processor for. To wake a sleeper would
/// take longer than several periods.
const LOCKSTEP_SPIN: Duration = Duration::from_millis(1);
/// For so long after its own last message a reader is surely still spinning [ns].
const AWAKE_NS: u64 = SPIN.as_nanos() as u64 / 2;
/// Whoever has a message to write, or to record, gives the processor back within this time; others take it for whole slices.
const IMPOSITION: Duration = Duration::from_millis(2);
/// For so long nobody is given way to after one who kept it longer.
const GRUDGE: Duration = Duration::from_millis(100);
/// A sleeping reader looks around this often, so that a stop request or a restarted peer is noticed.
const SLICE: Duration = Duration::from_millis(10);
/// A successor tries its place this often.
const SUCCESSION: Duration = Duration::from_micros(500);

/// The ring of somebody who has come; that for a message is 0.
fn knock() -> EventId {
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
    /// Whether a reader may be asleep that sent its own last message `since_heard_ns` ago.
    fn may_sleep(self, since_heard_ns: impl FnOnce() -> u64) -> bool {
        match self {
            Waiting::Spin => false,
            Waiting::Hybrid => since_heard_ns() >= AWAKE_NS,
            Waiting::Event => true,
        }
    }
}

/// Writing end of a topic with a wake-up.
#[derive(Debug)]
pub(super) struct Outlet<M: Stamped> {
    /// Room for the next message.
    room: RefCell<Option<SampleMut<ipc::Service, M, ()>>>,
    writer: Publisher<ipc::Service, M, ()>,
    bell: Notifier<ipc::Service>,
    /// How the reader waits.
    pub waiting: Waiting,
}

impl<M: Stamped> Outlet<M> {
    /// Takes the one place of a writer; while somebody else has it, `waits` is asked whether to wait on.
    pub fn open(
        place: &Place,
        name: &str,
        role: &'static str,
        waits: impl Fn() -> bool,
    ) -> Result<Outlet<M>, PortError> {
        let topic = place.link::<M>(name)?;
        let bell = place.event(name)?.notifier_builder().create().map_err(|e| broken("the wake-up", e))?;
        let writer = loop {
            match topic.publisher_builder().max_loaned_samples(1).create() {
                Ok(writer) => break writer,
                Err(PublisherCreateError::ExceedsMaxSupportedPublishers) if waits() => std::thread::sleep(SUCCESSION),
                Err(PublisherCreateError::ExceedsMaxSupportedPublishers) => {
                    return Err(PortError::Taken { session: place.session().into(), role });
                }
                Err(error) => return Err(broken("writing", error)),
            }
        };
        Ok(Outlet { room: RefCell::new(None), writer, bell, waiting: Waiting::default() })
    }

    /// Writes, and rings unless the reader is surely awake: it sent its own last message at `heard_ns` and has spun for
    /// this one since. A ring is a system call and costs more than a tick.
    #[inline]
    pub fn send(&self, message: M, heard_ns: u64) -> Result<(), PortError> {
        self.write(message, M::seal, heard_ns)
    }

    /// The same, after `finish` on the message in its place.
    #[inline]
    pub fn write(&self, message: M, finish: impl FnOnce(&mut M), heard_ns: u64) -> Result<(), PortError> {
        let mut sample = self.room.take().map_or_else(|| self.take_room(), Ok)?;
        *sample.payload_mut() = message;
        finish(sample.payload_mut());
        sample.send().map_err(|e| broken("writing", e))?;
        // what a damaged message says of the future is not believed
        if self.waiting.may_sleep(|| now_ns().checked_sub(heard_ns).unwrap_or(u64::MAX)) {
            self.ring()?;
        }
        Ok(())
    }

    /// Takes room for the next message beforehand, and writes there, so that its cache lines need not be fetched from the
    /// other processor when the message is there: that is half of what sending costs.
    pub fn prepare(&self) -> Result<(), PortError> {
        let mut room = self.room.borrow_mut();
        if room.is_none() {
            *room = Some(self.take_room()?);
        }
        Ok(())
    }

    fn take_room(&self) -> Result<SampleMut<ipc::Service, M, ()>, PortError> {
        Ok(self.writer.loan_uninit().map_err(|e| broken("writing", e))?.write_payload(M::zeroed()))
    }

    fn ring(&self) -> Result<(), PortError> {
        self.bell.notify().map_err(|e| broken("the wake-up", e)).map(drop)
    }

    /// Rings without a message: somebody has come, and wants to hear the other side's last one.
    pub fn knock(&self) -> Result<(), PortError> {
        self.bell.notify_with_custom_event_id(knock()).map_err(|e| broken("the wake-up", e)).map(drop)
    }

    /// Gives the last message to a reader that has come since, and wakes it.
    pub fn catch_up(&self) -> Result<(), PortError> {
        self.writer.update_connections().map_err(|e| broken("connecting", e))?;
        self.ring()
    }
}

/// Reading end of a topic with a wake-up.
#[derive(Debug)]
pub(super) struct Inlet<M: Stamped> {
    reader: Reader<M>,
    /// What was read last, in its slot: given back when the next is looked for, while the other side computes.
    held: Option<Found<M>>,
    bell: Listener<ipc::Service>,
    /// When the writer sent what was read last, by its monotonic clock, which is ours [ns].
    pub heard_ns: u64,
    /// How to wait.
    pub waiting: Waiting,
    /// In lockstep a hybrid gives way while it spins.
    pace: Pace,
    /// When somebody who was given way to last kept the processor for long.
    imposed_on: Cell<Option<Instant>>,
}

impl<M: Stamped> Inlet<M> {
    pub fn open(place: &Place, name: &str, pace: Pace) -> Result<Inlet<M>, PortError> {
        let reader = Reader::open(&place.link::<M>(name)?, 1)?;
        let bell = place.event(name)?.listener_builder().create().map_err(|e| broken("the wake-up", e))?;
        let (waiting, imposed_on) = (Waiting::default(), Cell::new(None));
        Ok(Inlet { reader, held: None, bell, heard_ns: 0, waiting, pace, imposed_on })
    }

    /// The next message, as it came.
    #[inline]
    pub fn next(&mut self) -> Result<Option<M>, PortError> {
        self.held = None;
        self.held = self.reader.look()?;
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
        self.heard_ns = message.stamp().mono_ns;
        Some(message)
    }

    fn find(&self) -> Result<Option<Found<M>>, PortError> {
        // Most answers come before a clock need be read, which takes as long as a look.
        let found = self.look(LOOKS)?;
        if found.is_some() {
            return Ok(found);
        }
        let (start, mut knocked) = (Instant::now(), false);
        loop {
            let waited = start.elapsed(); // before the look: what comes after it is rung for, once we may sleep
            let found = self.look(LOOKS)?;
            if found.is_some() || waited >= SLICE {
                return Ok(found);
            }
            match self.waiting {
                Waiting::Spin => (),
                Waiting::Hybrid if self.is_polite() && waited < LOCKSTEP_SPIN => self.give_way(),
                Waiting::Hybrid if waited < SPIN => (),
                Waiting::Hybrid | Waiting::Event => {
                    match self.bell.timed_wait(|ring| knocked |= ring.id == knock(), SLICE - waited) {
                        Ok(_) if knocked => return self.look(1),
                        Ok(_) | Err(ListenerWaitError::InterruptSignal) => (),
                        Err(error) => return Err(broken("the wake-up", error)),
                    }
                }
            }
        }
    }

    /// Lets others have the processor: the writer may be waiting for this very one. Whoever keeps it for long is not the writer, and
    /// would do so at every look.
    fn give_way(&self) {
        let before = Instant::now();
        std::thread::yield_now();
        self.imposed_on.set((before.elapsed() > IMPOSITION).then(Instant::now));
    }

    fn is_polite(&self) -> bool {
        self.pace == Pace::Lockstep && self.imposed_on.get().is_none_or(|then| then.elapsed() > GRUDGE)
    }

    /// Looks for a message, a few times if it may come any moment.
    fn look(&self, times: u32) -> Result<Option<Found<M>>, PortError> {
        for _ in 0..if self.waiting == Waiting::Event { 1 } else { times } {
            let found = self.reader.look()?;
            if found.is_some() {
                return Ok(found);
            }
            std::hint::spin_loop();
        }
        Ok(None)
    }
}

/// A message in its slot.
type Found<M> = Sample<ipc::Service, M, ()>;

/// Reading end of a topic.
#[derive(Debug)]
pub(super) struct Reader<M: Stamped>(Subscriber<ipc::Service, M, ()>);

impl<M: Stamped> Reader<M> {
    pub fn open(topic: &Topic<M>, buffer: usize) -> Result<Reader<M>, PortError> {
        topic.subscriber_builder().buffer_size(buffer).create().map(Reader).map_err(|e| broken("reading", e))
    }

    /// A copy of the next message; its slot is free again at once.
    pub fn next(&self) -> Result<Option<M>, PortError> {
        Ok(self.look()?.map(|sample| *sample))
    }

    /// The next message in its slot.
    pub fn look(&self) -> Result<Option<Found<M>>, PortError> {
        self.0.receive().map_err(|e| broken("reading", e))
    }
}
