//! Opening a session within a limited time.

use messages::port::PortError;
use shared::exit::Exit;
use shared::output::tell;
use std::sync::mpsc;
use std::time::Duration;

/// Opening a session takes milliseconds; but the remains of a process killed at the wrong instant can block it for
/// ever, so it gets 3 s before this process ends itself with advice.
pub fn guarded<T>(open: impl FnOnce() -> Result<T, PortError>) -> Result<T, PortError> {
    let (done, waiting) = mpsc::channel::<()>();
    std::thread::spawn(move || {
        if waiting.recv_timeout(Duration::from_secs(3)) == Err(mpsc::RecvTimeoutError::Timeout) {
            tell(format_args!(
                "error: shared memory: the session could not be opened within 3 s; another --session will work"
            ));
            std::process::exit(Exit::SharedMemory as i32);
        }
    });
    let opened = open();
    drop(done);
    opened
}
