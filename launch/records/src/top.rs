//! `biped top`: monitors a running session in the terminal. On a terminal it updates the display in place. Otherwise it
//! prints a line per second.

mod display;
mod shared_display;

use clap::Args;
use console::{Term, truncate_str};
pub use display::POLL_INTERVAL;
use display::{Display, LINE_INTERVAL};
use messages::session::Session;
use shared::args::{Reachable, SessionArgs};
use shared::exit::Failure;
pub use shared_display::SharedDisplay;
use shared_display::show_shared;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Update interval on a terminal.
const DISPLAY_INTERVAL: Duration = Duration::from_millis(250);
/// A session without other members has ended after this time without records.
const END_TIMEOUT: Duration = Duration::from_secs(1);

/// Arguments of `biped top`.
#[derive(Args)]
pub struct TopArgs {
    #[command(flatten)]
    session: SessionArgs,
}

/// Monitors until the session ends or the user stops the program.
///
/// # Errors
/// If the session does not exist.
pub fn run(args: &TopArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let session = match args.session.reach(SessionArgs::find)? {
        Reachable::Own(session) => session,
        Reachable::Shared(shared) => return show_shared(&shared, stop),
    };
    let mut display = Display::attach(&session)?;
    let mut term = Term::stdout();
    let interval = if term.is_term() { DISPLAY_INTERVAL } else { LINE_INTERVAL };
    let mut shown_lines = 0;
    while !stop.load(Relaxed) && !has_ended(&session, display.statistics.received) {
        let Some(statistics) = display.poll(interval)? else {
            std::thread::sleep(POLL_INTERVAL);
            continue;
        };
        let written = if term.is_term() {
            let lines = statistics.lines(&session);
            let width = usize::from(term.size().1); // a wrapped line would count as two when it is cleared
            let text: String = lines.iter().map(|line| format!("{}\n", truncate_str(line, width, "…"))).collect();
            let written = term.clear_last_lines(shown_lines).and_then(|()| term.write_all(text.as_bytes()));
            shown_lines = lines.len();
            written
        } else {
            writeln!(term, "{}", statistics.line())
        };
        if written.is_err() {
            break; // the reader of a pipe has closed it
        }
    }
    Ok(())
}

/// True if a session has no other members and has sent no record for [`END_TIMEOUT`].
pub fn has_ended(session: &Session, received: Instant) -> bool {
    received.elapsed() > END_TIMEOUT && session.members().iter().all(|member| *member == std::process::id())
}
