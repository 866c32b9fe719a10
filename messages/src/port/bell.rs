//! The bell of a topic: a futex by which a writer in lockstep wakes its reader, at less than half the cost of an event of iceoryx2.
//!
//! A reader sleeps on the bell if the writer rings it, and on the event if the writer is a program that does not. A writer therefore signs
//! the bell with the epoch of its messages. docs/WIRE.md describes the file; docs/notes/busy-machine.md has the costs.

#![allow(unsafe_code, reason = "two processes share atomic words in a mapped file")]

use crate::error::PortError;
use crate::session::{SHARED_MEMORY, Session};
use memmap2::MmapRaw;
use rustix::io::Errno;
use rustix::thread::futex;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::time::Duration;

/// The words of a bell, in a file of the session. A new file holds zeros.
#[repr(C, align(64))]
#[derive(Debug)]
struct Words {
    /// Number of rings. A reader sleeps while it stays the same.
    rings: AtomicU32,
    /// 1 while a reader sleeps, or is about to.
    asleep: AtomicU32,
    signature: Signature,
}

/// In a cache line of its own: the other side reads it often, but it hardly ever changes.
#[repr(C, align(64))]
#[derive(Debug)]
struct Signature(AtomicU32);

/// One end of the bell of a topic.
#[derive(Debug)]
pub(super) struct Bell(MmapRaw);

impl Bell {
    /// Opens the bell of a topic.
    pub fn open(session: &Session, topic: &str) -> Result<Bell, PortError> {
        let name = format!("bell_{}", topic.rsplit('/').next().unwrap_or(topic));
        let mapped = session.reserved_file(&name, size_of::<Words>()).and_then(|file| MmapRaw::map_raw(&file));
        mapped
            .map(Bell)
            .map_err(|error| PortError::SharedMemory(format!("{SHARED_MEMORY}: the bell of {topic}: {error}")))
    }

    fn words(&self) -> &Words {
        // SAFETY: the file is as long as the words for as long as it is mapped, and all processes access it as atomic words only.
        unsafe { &*self.0.as_ptr().cast::<Words>() }
    }

    /// Writer: signs the bell with the epoch of the message that it is about to send.
    #[inline]
    pub fn sign(&self, epoch: u64) {
        let Signature(signature) = &self.words().signature;
        if signature.load(Relaxed) != epoch as u32 {
            signature.store(epoch as u32, SeqCst);
        }
    }

    /// Whether the writer of messages with this epoch rings the bell.
    #[inline]
    pub fn is_rung_by(&self, epoch: u64) -> bool {
        epoch as u32 != 0 && self.words().signature.0.load(Relaxed) == epoch as u32
    }

    /// Writer: rings after a message, and wakes the reader if it is asleep.
    #[inline]
    pub fn ring(&self) {
        let words = self.words();
        words.rings.fetch_add(1, SeqCst);
        if words.asleep.load(SeqCst) != 0 {
            let _ = futex::wake(&words.rings, futex::Flags::empty(), i32::MAX as u32); // it fails for a wrong address only
        }
    }

    /// Reader: sleeps until the bell rings, for a limited time. `poll` looks for a message once more before it sleeps, so none is missed.
    pub fn sleep<T>(
        &self,
        limit: Duration,
        poll: impl FnOnce() -> Result<Option<T>, PortError>,
    ) -> Result<Sleep<T>, PortError> {
        let words = self.words();
        words.asleep.store(1, SeqCst);
        let rings = words.rings.load(SeqCst);
        let found = poll();
        let has_rung = || match limit.try_into() {
            // The number of rings may change before the system looks at it.
            Ok(limit) => matches!(
                futex::wait(&words.rings, futex::Flags::empty(), rings, Some(&limit)),
                Ok(()) | Err(Errno::AGAIN)
            ),
            Err(_) => false,
        };
        let outcome = match found {
            Ok(Some(message)) => Ok(Sleep::Found(message)),
            Ok(None) if has_rung() => Ok(Sleep::Rung),
            Ok(None) => Ok(Sleep::Elapsed),
            Err(error) => Err(error),
        };
        words.asleep.store(0, SeqCst);
        outcome
    }
}

/// Why a reader no longer sleeps.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Sleep<T> {
    /// There was a message already.
    Found(T),
    /// The bell has rung.
    Rung,
    /// The time is over, or a signal has come.
    Elapsed,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    const LONG: Duration = Duration::from_secs(20);

    fn nothing() -> Result<Option<()>, PortError> {
        Ok(None)
    }

    /// Runs a test with the two ends of a bell.
    fn with_bell(test: impl FnOnce(Bell, Bell)) {
        let session = Session::unique();
        let member = session.join().expect("shared memory");
        let [writer, reader] = [0, 1].map(|_| Bell::open(&session, "biped/test").expect("a bell"));
        test(writer, reader);
        drop(member);
        assert_eq!(session.shm_files(), Vec::<std::path::PathBuf>::new());
    }

    #[test]
    fn a_ring_wakes_the_reader_through_another_mapping_of_the_file() {
        with_bell(|writer, reader| {
            let start = Instant::now();
            std::thread::scope(|scope| {
                let asleep = scope.spawn(|| reader.sleep(LONG, nothing).expect("sleep"));
                while reader.words().asleep.load(SeqCst) == 0 {
                    std::thread::yield_now();
                }
                writer.ring();
                assert_eq!(asleep.join().expect("no panic"), Sleep::Rung);
            });
            assert!(start.elapsed() < LONG);
            assert_eq!(
                reader.sleep(Duration::from_millis(1), nothing).expect("sleep"),
                Sleep::Elapsed,
                "without a ring"
            );
        });
    }

    #[test]
    fn a_ring_between_the_last_poll_and_the_sleep_is_not_missed() {
        with_bell(|writer, reader| {
            let rings = || {
                writer.ring();
                nothing()
            };
            assert_eq!(reader.sleep(LONG, rings).expect("sleep"), Sleep::Rung);
            assert_eq!(reader.sleep(LONG, || Ok(Some(3))).expect("sleep"), Sleep::Found(3));
        });
    }

    #[test]
    fn a_writer_rings_for_the_epoch_that_it_has_signed_and_no_other() {
        with_bell(|writer, reader| {
            assert!(
                !reader.is_rung_by(0) && !reader.is_rung_by(7),
                "a program that does not know the bell signs nothing"
            );
            writer.sign(7);
            assert!(reader.is_rung_by(7) && !reader.is_rung_by(8));
        });
    }
}
