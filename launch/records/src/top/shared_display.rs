//! `biped top` of a session that another user shares: the owner's process sends the lines.

use super::display::{Display, LINE_INTERVAL};
use messages::session::{Session, SharedSession};
use shared::exit::Failure;
use shared::output::printable;
use shared::share::{self, SharedRequest};
use std::io::Write;
use std::sync::atomic::AtomicBool;

/// Prints the lines of a session that another user shares: one per second.
pub(super) fn show_shared(shared: &SharedSession, stop: &AtomicBool) -> Result<(), Failure> {
    let mut stream = share::send(shared, &SharedRequest::Top)?;
    while let Some(line) = share::read_answer(shared, &mut stream, stop)? {
        if writeln!(std::io::stdout(), "{}", printable(&line)).is_err() {
            break; // the reader of a pipe has closed it
        }
    }
    Ok(())
}

/// The lines of `biped top` for other users.
pub struct SharedDisplay(Display);

impl SharedDisplay {
    /// Joins a running session.
    ///
    /// # Errors
    /// If it is not running, or has as many observers as it allows.
    pub fn attach(session: &Session) -> Result<SharedDisplay, Failure> {
        Ok(SharedDisplay(Display::attach(session)?))
    }

    /// Reads the session, and returns a line once a second. Call it every [`POLL_INTERVAL`](super::display::POLL_INTERVAL), because in
    /// lockstep the plant waits for it.
    ///
    /// # Errors
    /// If the session cannot be read.
    pub fn poll(&mut self) -> Result<Option<String>, Failure> {
        Ok(self.0.poll(LINE_INTERVAL)?.map(|statistics| statistics.line()))
    }
}
