//! How a process waits for messages of the other side.

use std::time::Duration;

/// A hybrid reader polls for this long before it sleeps: longer than the other side computes in a control period.
pub(super) const SPIN: Duration = Duration::from_micros(50);
/// After its own last message a hybrid reader polls at least this long [ns].
const AWAKE_NS: u64 = SPIN.as_nanos() as u64 / 2;

/// How a process waits for the other side.
///
/// Both ends of a connection should wait in the same way. A writer notifies its reader only if the reader may be asleep. A reader
/// that sleeps unexpectedly looks for messages every 10 ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Waiting {
    /// Polls without pause. It has the smallest latency but uses a whole processor. Never use it with a real-time scheduler, which
    /// it would block.
    Spin,
    /// Polls for 50 µs, in lockstep for 1 ms, then sleeps until it is notified. In lockstep on a busy machine it sleeps at once.
    #[default]
    Hybrid,
    /// Sleeps until it is notified. It uses the least processor time.
    Event,
}

impl Waiting {
    /// Whether a reader may be asleep. `since_sent_ns` is the time since the reader itself last sent a message.
    pub(super) fn may_sleep(self, since_sent_ns: impl FnOnce() -> u64) -> bool {
        match self {
            Waiting::Spin => false,
            Waiting::Hybrid => since_sent_ns() >= AWAKE_NS,
            Waiting::Event => true,
        }
    }
}
