//! Opening a port while other processes may be killed.

use crate::session::Session;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;

/// Opening a port normally takes milliseconds. While it takes longer, incomplete files are looked for at this interval.
const CHECK_INTERVAL: Duration = Duration::from_millis(200);

/// Opens a port. If that takes long, another thread removes the incomplete files of processes that were killed meanwhile: iceoryx2 0.10
/// of root waits for ever for a segment without a size.
pub(super) fn unblocked<T>(session: &Session, open: impl FnOnce() -> T) -> T {
    let (done, opening) = channel::<()>();
    let session = session.clone();
    let watch = move || {
        while opening.recv_timeout(CHECK_INTERVAL) == Err(RecvTimeoutError::Timeout) {
            session.remove_incomplete_files();
        }
    };
    let _ = Builder::new().name("opening".into()).spawn(watch); // without a thread, it may wait
    let opened = open();
    drop(done);
    opened
}
