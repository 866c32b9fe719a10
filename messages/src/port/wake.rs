//! What a writer and a reader of a topic must know of each other, so that the writer wakes a reader that sleeps.

use iceoryx2::prelude::EventId;

/// The process at the other end of a topic. The writer decides by it whether and how to wake the reader.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peer {
    /// Until this time it is certainly awake, by the monotonic clock [ns]. After it the reader still polls for a short while. 0 if it
    /// may sleep at once.
    pub awake_ns: u64,
    /// Whether it sleeps on the bell only.
    pub hears_bell: bool,
}

/// The event that announces a new process. The event that announces a message has the number 0.
pub(super) fn arrival() -> EventId {
    EventId::new(1)
}
