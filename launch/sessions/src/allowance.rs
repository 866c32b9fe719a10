//! What the system must allow this program: open files, memory, threads. What is missing would end it somewhere else, by a panic or a
//! signal; so it is looked at first, and told.

use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit, setrlimit};
use shared::exit::{Exit, Failure};
use std::sync::Mutex;
use std::thread::Builder;

/// Open files of the process that has most of them, which listens to a run and draws its report: 60, and as many again.
const FILES: u64 = 128;
/// Memory of a process that starts a walk is 9 MB; a long report and a page take the rest [bytes].
const MEMORY: u64 = 64 << 20;
/// The deepest call is that of a contact problem: an eighth of this [bytes].
const STACK: u64 = 1 << 20;
/// Threads besides those that compute: signals, standard errors of two children, a guard, an onlooker.
const THREADS: usize = 6;

/// Stack of a thread that does nothing [bytes].
const SMALL: usize = 1 << 16;

/// Raises the limit of open files to what the user may have, and says what is too little.
///
/// # Errors
/// If something is.
pub fn check() -> Result<(), Failure> {
    if let Ok((soft, hard)) = getrlimit(Resource::RLIMIT_NOFILE)
        && soft < hard
    {
        let _ = setrlimit(Resource::RLIMIT_NOFILE, hard, hard); // who may not has what he had
    }
    for (resource, what, needed, remedy) in [
        (Resource::RLIMIT_NOFILE, "open files", FILES, "ulimit -n 1024"),
        (Resource::RLIMIT_DATA, "memory", MEMORY, "ulimit -d unlimited"),
        (Resource::RLIMIT_AS, "address space", MEMORY, "ulimit -v unlimited"),
        (Resource::RLIMIT_STACK, "the stack", STACK, "ulimit -s 8192"),
    ] {
        let allowed = getrlimit(resource).map_or(RLIM_INFINITY, |(soft, _)| soft);
        if allowed < needed {
            let bytes = resource != Resource::RLIMIT_NOFILE;
            let [allowed, needed] =
                [allowed, needed].map(|limit| if bytes { format!("{} MB", limit >> 20) } else { limit.to_string() });
            let words = format!("the limit of {what} is {allowed}, but {needed} are needed: `{remedy}`");
            return Err(Failure::new(Exit::Fault, words));
        }
    }
    threads(THREADS + std::thread::available_parallelism().map_or(1, usize::from))
}

/// Whether so many threads can be there at once.
fn threads(count: usize) -> Result<(), Failure> {
    let gate = Mutex::new(());
    let started = std::thread::scope(|scope| {
        let _closed = gate.lock(); // until all of them have started
        let start = |_: &usize| Builder::new().stack_size(SMALL).spawn_scoped(scope, || drop(gate.lock())).is_ok();
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
