//! Opening a session within a limited time.

use messages::port::PortError;
use shared::exit::{Exit, Failure};
use shared::output::log;
use shared::thread;
use std::sync::mpsc;
use std::time::Duration;

/// Time to open a session. It normally takes milliseconds, but files that a killed process left can block it forever.
const OPEN_TIMEOUT: Duration = Duration::from_secs(3);

/// Opens a port. If that takes longer than [`OPEN_TIMEOUT`], this process exits with a message that says what to do.
///
/// # Errors
/// Those of `open`, or if no thread can watch it.
pub fn open_with_timeout<T>(open: impl FnOnce() -> Result<T, PortError>) -> Result<T, Failure> {
    let (done, waiting) = mpsc::channel::<()>();
    thread::start(move || {
        if waiting.recv_timeout(OPEN_TIMEOUT) == Err(mpsc::RecvTimeoutError::Timeout) {
            log(format_args!(
                "error: shared memory: the session could not be opened within {} s; choose another --session",
                OPEN_TIMEOUT.as_secs()
            ));
            std::process::exit(Exit::SharedMemory as i32);
        }
    })?;
    let opened = open();
    drop(done);
    Ok(opened?)
}
