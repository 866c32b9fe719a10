//! The limits that no link can beat: a word in shared memory that another processor writes, and one that a sleeping
//! process is woken for.

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

/// Looks at the clock once in so many looks at the line.
const LOOKS: u32 = 1 << 14;

/// In place of a question: there will be no more.
const END: u32 = u32::MAX;

/// Two cache lines, far enough apart that no processor fetches both at once.
#[repr(C)]
pub struct Lines {
    ask: Line,
    answer: Line,
}

#[repr(C, align(128))]
struct Line(AtomicU32);

/// How one waits for the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Wake {
    /// Looks without pause.
    Spin,
    /// Sleeps until it is woken.
    Futex,
}

/// Lines that a child can open by the number of the file, which it inherits if it is started later; they have no name
/// and leave nothing.
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
/// If there are none of this number.
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
    /// Before each run.
    pub fn clear(&self) {
        self.ask.0.store(0, Release);
        self.answer.0.store(0, Release);
    }

    /// Asks question `seq`, counted from 1, and waits for the answer.
    ///
    /// # Errors
    /// If nobody answers for long.
    pub fn ask(&self, seq: u32, wake: Wake) -> Result<(), Failure> {
        self.ask.set(seq, wake);
        self.answer.wait(seq - 1, wake).map(drop)
    }

    /// Says that there are no more questions.
    pub fn end(&self, wake: Wake) {
        self.ask.set(END, wake);
    }

    /// Answers every question until the end.
    ///
    /// # Errors
    /// If nobody asks for long.
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

    /// Waits until it is no longer `before`.
    fn wait(&self, before: u32, wake: Wake) -> Result<u32, Failure> {
        let start = Instant::now();
        let limit = futex::Timespec { tv_sec: 1, tv_nsec: 0 };
        for looks in 1_u32.. {
            let found = self.0.load(Acquire);
            if found != before {
                return Ok(found);
            }
            match wake {
                Wake::Spin => std::hint::spin_loop(),
                // Woken, changed meanwhile, or nobody came: the next look tells.
                Wake::Futex => drop(futex::wait(&self.0, futex::Flags::empty(), found, Some(&limit))),
            }
            if (wake == Wake::Futex || looks % LOOKS == 0) && start.elapsed() > PATIENCE {
                break;
            }
        }
        Err(Failure::new(Exit::PeerMissing, LOST))
    }
}
