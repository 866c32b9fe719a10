//! Lower limits for the latency of any link. One processor writes a word in shared memory, and another reads it. The reader either
//! spins, or sleeps and is woken.

use super::terms::{LOST, PATIENCE};
use nix::sys::memfd::{MFdFlags, memfd_create};
use nix::sys::mman::{MapFlags, ProtFlags, mmap};
use nix::unistd::ftruncate;
use rustix::thread::futex;
use shared::exit::{Exit, Failure};
use std::fs::File;
use std::num::NonZeroUsize;
use std::os::fd::{OwnedFd, RawFd};
use std::sync::atomic::{AtomicU32, Ordering::Acquire, Ordering::Release};
use std::time::Instant;

/// Polls between two readings of the clock.
const POLLS: u32 = 1 << 14;

/// The value that announces the end.
const END: u32 = u32::MAX;

/// Two cache lines, far enough apart that no processor prefetches both.
#[repr(C)]
pub struct Lines {
    ask: Line,
    answer: Line,
}

#[repr(C, align(128))]
struct Line(AtomicU32);

/// How a process waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Wake {
    /// Polls without pause.
    Spin,
    /// Sleeps on a futex.
    Futex,
}

/// Lines in an anonymous memory file. A child that is started later inherits the file number and opens them by it.
///
/// # Errors
/// If the system has no memory.
pub fn create() -> Result<(OwnedFd, &'static Lines), Failure> {
    let file = memfd_create(c"biped-latency", MFdFlags::empty()).map_err(unshared)?;
    ftruncate(&file, size_of::<Lines>() as i64).map_err(unshared)?;
    let lines = map(&file)?;
    Ok((file, lines))
}

/// The lines of the parent.
///
/// # Errors
/// No memory file with this number.
pub fn open(number: RawFd) -> Result<&'static Lines, Failure> {
    let path = format!("/proc/self/fd/{number}");
    map(&File::options().read(true).write(true).open(path).map_err(unshared)?.into())
}

#[expect(unsafe_code, reason = "nothing maps a file that another process writes without; atomics alone touch it")]
fn map(file: &OwnedFd) -> Result<&'static Lines, Failure> {
    let size = NonZeroUsize::new(size_of::<Lines>()).unwrap_or(NonZeroUsize::MIN);
    let access = ProtFlags::PROT_READ | ProtFlags::PROT_WRITE;
    // SAFETY: a new mapping, aligned to pages, as long as `Lines`, which holds nothing but atomics, for which any bytes
    // are valid and any process may write; it is never unmapped.
    let place = unsafe { mmap(None, size, access, MapFlags::MAP_SHARED, file, 0) };
    let place = place.map_err(unshared)?.cast::<Lines>();
    // SAFETY: as above.
    Ok(unsafe { place.as_ref() })
}

fn unshared(error: impl std::fmt::Display) -> Failure {
    Failure::new(Exit::SharedMemory, format!("shared memory for the comparison: {error}"))
}

impl Lines {
    /// Resets both lines before a run.
    pub fn clear(&self) {
        self.ask.0.store(0, Release);
        self.answer.0.store(0, Release);
    }

    /// Sends request `seq`, counted from 1, and waits for the answer.
    ///
    /// # Errors
    /// No answer in time.
    pub fn ask(&self, seq: u32, wake: Wake) -> Result<(), Failure> {
        self.ask.set(seq, wake);
        self.answer.wait(seq - 1, wake).map(drop)
    }

    /// Announces the end.
    pub fn end(&self, wake: Wake) {
        self.ask.set(END, wake);
    }

    /// Answers every question until the end.
    ///
    /// # Errors
    /// No question in time.
    pub fn serve(&self, wake: Wake) -> Result<(), Failure> {
        let mut seq = 0;
        loop {
            seq = self.ask.wait(seq, wake)?;
            if seq == END {
                return Ok(());
            }
            self.answer.set(seq, wake);
        }
    }
}

impl Line {
    fn set(&self, value: u32, wake: Wake) {
        self.0.store(value, Release);
        if wake == Wake::Futex {
            let _ = futex::wake(&self.0, futex::Flags::empty(), 1);
        }
    }

    /// Waits until the value differs from `before`.
    fn wait(&self, before: u32, wake: Wake) -> Result<u32, Failure> {
        let start = Instant::now();
        let limit = futex::Timespec { tv_sec: 1, tv_nsec: 0 };
        for polls in 1_u32.. {
            let found = self.0.load(Acquire);
            if found != before {
                return Ok(found);
            }
            match wake {
                Wake::Spin => std::hint::spin_loop(),
                // woken, changed or timed out: the next poll decides
                Wake::Futex => drop(futex::wait(&self.0, futex::Flags::empty(), found, Some(&limit))),
            }
            if (wake == Wake::Futex || polls % POLLS == 0) && start.elapsed() > PATIENCE {
                break;
            }
        }
        Err(Failure::new(Exit::PeerMissing, LOST))
    }
}
