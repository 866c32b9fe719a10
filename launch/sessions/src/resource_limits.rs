//! The resource limits of this process: open files, memory, threads. They are checked at the start, because a limit that is too low
//! would later end the program by a panic or a signal.

use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit, setrlimit};
use shared::exit::{Exit, Failure};
use std::sync::Mutex;
use std::thread::Builder;

/// Open files. The process that records a run and draws its report needs the most, 60; the limit is twice that.
pub(crate) const MIN_OPEN_FILES: u64 = 128;
/// Memory [bytes]. A process that starts a walk uses 9 MB; a long report and its page need the rest.
const MIN_MEMORY: u64 = 64 << 20;
/// Stack [bytes]. The deepest call chain, that of a contact problem, uses an eighth of it.
const MIN_STACK: u64 = 1 << 20;
/// Threads in addition to those that compute: one for signals, two for the standard error of two children, one for the timeout while a
/// session is opened, one for an observer, one spare.
const EXTRA_THREADS: usize = 6;

/// Stack of a thread that only waits [bytes].
const PROBE_STACK: usize = 1 << 16;

/// Checks the limit of the stack. This comes first of all, because parsing the arguments already needs one.
///
/// # Errors
/// If it is too low; the message names it and the command that raises it.
pub fn check_stack() -> Result<(), Failure> {
    check_limit(Resource::RLIMIT_STACK, "the stack", MIN_STACK, "ulimit -s 8192")
}

/// Raises the limit of open files as far as the user may, then checks all other limits.
///
/// # Errors
/// If a limit is too low; the message names it and the command that raises it.
pub fn check() -> Result<(), Failure> {
    if let Ok((soft, hard)) = getrlimit(Resource::RLIMIT_NOFILE)
        && soft < hard
    {
        let _ = setrlimit(Resource::RLIMIT_NOFILE, hard, hard); // after a refusal, the soft limit is checked below
    }
    check_limit(Resource::RLIMIT_NOFILE, "open files", MIN_OPEN_FILES, "ulimit -n 1024")?;
    check_limit(Resource::RLIMIT_DATA, "memory", MIN_MEMORY, "ulimit -d unlimited")?;
    check_limit(Resource::RLIMIT_AS, "address space", MIN_MEMORY, "ulimit -v unlimited")?;
    check_threads(EXTRA_THREADS + std::thread::available_parallelism().map_or(1, usize::from))
}

fn check_limit(resource: Resource, what: &str, needed: u64, remedy: &str) -> Result<(), Failure> {
    let allowed = getrlimit(resource).map_or(RLIM_INFINITY, |(soft, _)| soft);
    if allowed >= needed {
        return Ok(());
    }
    let text = |limit: u64| match resource {
        Resource::RLIMIT_NOFILE => limit.to_string(),
        _ => format!("{} kB", limit >> 10),
    };
    let words = format!("the limit of {what} is {}, but {} are needed: `{remedy}`", text(allowed), text(needed));
    Err(Failure::new(Exit::Fault, words))
}

/// Checks by trial that `count` threads can exist at the same time.
fn check_threads(count: usize) -> Result<(), Failure> {
    let barrier = Mutex::new(());
    let started = std::thread::scope(|scope| {
        let _closed = barrier.lock(); // no thread ends before all have started
        let start =
            |_: &usize| Builder::new().stack_size(PROBE_STACK).spawn_scoped(scope, || drop(barrier.lock())).is_ok();
        (0..count).take_while(start).count()
    });
    match started == count {
        true => Ok(()),
        false => {
            let words = format!(
                "this user may start no more than {started} further threads, but {count} are needed: `ulimit -u` is the limit of \
                 processes and threads, in a container its pids limit"
            );
            Err(Failure::new(Exit::Fault, words))
        }
    }
}
