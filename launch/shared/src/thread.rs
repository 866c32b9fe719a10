//! Threads. The system can refuse one at any time, because its limits of processes also count threads; `std::thread::spawn` would panic.

use crate::exit::{Exit, Failure};
use std::io;
use std::thread::{Builder, JoinHandle, Scope, ScopedJoinHandle};

/// Starts a thread.
///
/// # Errors
/// If the system refuses it.
pub fn start<T: Send + 'static>(job: impl FnOnce() -> T + Send + 'static) -> Result<JoinHandle<T>, Failure> {
    Builder::new().spawn(job).map_err(|error| refused(&error))
}

/// Starts a thread that may borrow values that outlive a scope.
///
/// # Errors
/// If the system refuses it.
pub fn start_scoped<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    job: impl FnOnce() -> T + Send + 'scope,
) -> Result<ScopedJoinHandle<'scope, T>, Failure> {
    Builder::new().spawn_scoped(scope, job).map_err(|error| refused(&error))
}

fn refused(error: &io::Error) -> Failure {
    let words = "the limit of processes and threads is `ulimit -u`, in a container its pids limit";
    Failure::new(Exit::Fault, format!("a thread cannot be started ({error}): {words}"))
}
