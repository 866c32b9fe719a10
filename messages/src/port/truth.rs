//! The topic that recorders listen to: in lockstep nothing is lost, in real time the plant never waits.

use super::contract::Pace;
use super::error::{PortError, broken};
use super::node::{SessionNode, TRUTH, TRUTH_BUFFER, Topic};
use crate::log;
use crate::wire::{Stamped, Truth};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

/// Timeout with a recorder whose buffer is full, or that has not begun to read when all is said.
const RECORDER_PATIENCE: Duration = Duration::from_secs(3);

/// Writing end of the truth.
#[derive(Debug)]
pub(super) struct TruthSender {
    topic: Topic<Truth>,
    writer: Publisher<ipc::Service, Truth, ()>,
    /// A recorder rings once it has read something.
    notifier: Listener<ipc::Service>,
    lost: Arc<AtomicU64>,
    pace: Pace,
    sent: Cell<usize>,
    /// Whether a recorder has begun to read.
    is_read: Cell<bool>,
}

impl TruthSender {
    pub fn open(node: &SessionNode, pace: Pace) -> Result<TruthSender, PortError> {
        let lost = Arc::new(AtomicU64::new(0));
        let (counter, gave_up) = (lost.clone(), AtomicBool::new(false));
        // Called while a recorder's buffer is full. One that has once been given up is not waited for again.
        let when_full = move |full: &BackpressureInfo| {
            if pace == Pace::Lockstep && full.elapsed_time < RECORDER_PATIENCE && !gave_up.load(Relaxed) {
                return BackpressureAction::Retry;
            }
            if pace == Pace::Lockstep && !gave_up.swap(true, Relaxed) {
                log(format_args!(
                    "the recorder has not read for {} s: going on without it",
                    RECORDER_PATIENCE.as_secs()
                ));
            }
            counter.fetch_add(1, Relaxed);
            BackpressureAction::DiscardData
        };
        let topic = node.truth()?;
        let builder = topic.publisher_builder().max_loaned_samples(1).set_backpressure_handler(when_full);
        let writer = builder.create().map_err(|e| broken("writing", e))?;
        let notifier = node.event(TRUTH)?.listener_builder().create().map_err(|e| broken("the wake-up", e))?;
        Ok(TruthSender { topic, writer, notifier, lost, pace, sent: Cell::new(0), is_read: Cell::new(false) })
    }

    /// Messages that a recorder did not get.
    pub fn lost(&self) -> u64 {
        self.lost.load(Relaxed)
    }

    pub fn send(&self, truth: Truth) -> Result<(), PortError> {
        // One that has not begun to read does not count as connected: what no longer fits would be dropped in silence.
        if self.pace == Pace::Lockstep && self.sent.replace(self.sent.get() + 1) == TRUTH_BUFFER {
            self.wait_for_recorder();
        }
        let room = self.writer.loan_uninit().map_err(|e| broken("writing", e))?;
        let mut sample = room.write_payload(truth);
        sample.payload_mut().seal();
        sample.send().map_err(|e| broken("writing", e))?;
        Ok(())
    }

    /// Waits until a recorder has begun to read: it then reads the rest also after the plant has gone.
    pub fn wait_for_recorder(&self) {
        if !self.is_read.get() && self.topic.dynamic_config().number_of_subscribers() > 0 {
            self.is_read.set(self.notifier.timed_wait(|_| (), RECORDER_PATIENCE).is_ok_and(|rings| rings > 0));
        }
    }
}
