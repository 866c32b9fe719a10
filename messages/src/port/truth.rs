//! The topic of the truth, for recorders. In lockstep no message is lost; in real time the plant never waits.

use super::contract::Pace;
use super::node::{SessionNode, TRUTH, TRUTH_BUFFER, TopicFactory};
use crate::error::PortError;
use crate::log;
use crate::wire::{Stamped, Truth};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Longest wait for a recorder whose buffer is full, or that has not begun to read at the end of a run.
const RECORDER_TIMEOUT: Duration = Duration::from_secs(3);
/// The same once the process has been asked to stop: a recorder that lives reads within milliseconds, and one that was killed never does.
const RECORDER_TIMEOUT_AT_STOP: Duration = Duration::from_millis(200);
/// A plant that waits for a recorder to begin looks this often whether it has been asked to stop.
const STOP_POLL: Duration = Duration::from_millis(50);

/// The writing end of the topic.
#[derive(Debug)]
pub(super) struct TruthSender {
    topic: TopicFactory<Truth>,
    writer: Publisher<ipc::Service, Truth, ()>,
    /// A recorder notifies the plant when it begins to read.
    listener: Listener<ipc::Service>,
    lost: Arc<AtomicU64>,
    stop: Arc<AtomicBool>,
    pace: Pace,
    sent: Cell<usize>,
    /// Whether a recorder has begun to read.
    is_read: Cell<bool>,
}

impl TruthSender {
    /// Opens the topic. Both waits for a recorder are short once `stop` is true.
    pub fn open(node: &SessionNode, pace: Pace, stop: Arc<AtomicBool>) -> Result<TruthSender, PortError> {
        let lost = Arc::new(AtomicU64::new(0));
        let (lost_counter, stops, timed_out) = (lost.clone(), stop.clone(), AtomicBool::new(false));
        // Called while the buffer of a recorder is full. After one timeout the plant never waits again.
        let when_full = move |full: &BackpressureInfo| {
            if pace == Pace::Lockstep && full.elapsed_time < recorder_timeout(&stops) && !timed_out.load(Relaxed) {
                return BackpressureAction::Retry;
            }
            if pace == Pace::Lockstep && !timed_out.swap(true, Relaxed) && !stops.load(Relaxed) {
                log(format_args!(
                    "the recorder has not read for {} s: the run continues without it",
                    RECORDER_TIMEOUT.as_secs()
                ));
            }
            lost_counter.fetch_add(1, Relaxed);
            BackpressureAction::DiscardData
        };
        let topic = node.truth()?;
        let builder = topic.publisher_builder().max_loaned_samples(1).set_backpressure_handler(when_full);
        let writer = builder.create().map_err(|e| PortError::failed("writing", e))?;
        let listener = node.listener(TRUTH)?;
        Ok(TruthSender { topic, writer, listener, lost, stop, pace, sent: Cell::new(0), is_read: Cell::new(false) })
    }

    /// Number of messages that a recorder did not receive.
    pub fn lost(&self) -> u64 {
        self.lost.load(Relaxed)
    }

    pub fn send(&self, truth: Truth) -> Result<(), PortError> {
        // iceoryx2 counts a recorder as connected only when it has begun to read. Until then it would drop messages silently.
        if self.pace == Pace::Lockstep && self.sent.replace(self.sent.get() + 1) == TRUTH_BUFFER {
            self.wait_for_recorder();
        }
        let loan = self.writer.loan_uninit().map_err(|e| PortError::failed("writing", e))?;
        let mut sample = loan.write_payload(truth);
        sample.payload_mut().seal();
        sample.send().map_err(|e| PortError::failed("writing", e))?;
        Ok(())
    }

    /// Waits until a recorder has begun to read. From then on it can read all messages, even after the plant has ended.
    pub fn wait_for_recorder(&self) {
        if self.is_read.get() || self.topic.dynamic_config().number_of_subscribers() == 0 {
            return;
        }
        let start = Instant::now();
        while !self.is_read.get() && start.elapsed() < recorder_timeout(&self.stop) {
            self.is_read.set(self.listener.timed_wait(|_| (), STOP_POLL).is_ok_and(|events| events > 0));
        }
    }
}

/// Longest wait for a recorder now.
fn recorder_timeout(stop: &AtomicBool) -> Duration {
    if stop.load(Relaxed) { RECORDER_TIMEOUT_AT_STOP } else { RECORDER_TIMEOUT }
}
