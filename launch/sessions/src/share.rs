//! `--share GROUP`: serves the members of a group who may not touch the files of the session.

use crate::control::carry_out;
use clap::Args;
use messages::session::{Session, ShareListener, group};
use records::top::{POLL_INTERVAL, SharedDisplay};
use shared::exit::{Exit, Failure};
use shared::output::log;
use shared::share::{self, SharedRequest};
use shared::thread;
use std::io;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{JoinHandle, Scope};
use std::time::Duration;

/// Most requests that are served at the same time.
const MAX_REQUESTS: usize = 8;
/// Most users who run `biped top` at the same time.
const MAX_WATCHERS: usize = 32;
/// Interval at which new connections are accepted.
const ACCEPT_POLL: Duration = Duration::from_millis(20);

/// The option `--share`.
#[derive(Args, Clone, Default)]
pub struct ShareArgs {
    /// Let the members of this group look at and talk to the session: `biped top` and requests with --session OWNER/NAME
    #[arg(long, value_name = "GROUP")]
    share: Option<String>,
}

impl ShareArgs {
    /// Checks the option before anything starts.
    ///
    /// # Errors
    /// If the session has no name, or there is no such group.
    pub fn check(&self, is_named: bool) -> Result<(), Failure> {
        match &self.share {
            Some(_) if !is_named => {
                Err(Failure::new(Exit::Usage, "--share needs a session with a name: add --session NAME"))
            }
            Some(name) => Ok(group(name).map(drop)?),
            None => Ok(()),
        }
    }

    /// Opens the share of a session that this process leads, if there is to be one.
    ///
    /// # Errors
    /// If there is no such group, or this user is not in it.
    pub fn open(&self, session: &Session) -> Result<Option<ShareServer>, Failure> {
        self.share.as_deref().map(|name| ShareServer::start(session, name)).transpose()
    }
}

/// A thread that serves a share. Dropping it ends the share.
pub struct ShareServer {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl ShareServer {
    fn start(session: &Session, name: &str) -> Result<ShareServer, Failure> {
        let listener = ShareListener::open(session, group(name)?)?;
        let (stop, session) = (Arc::new(AtomicBool::new(false)), session.clone());
        let stopped = stop.clone();
        let thread = thread::start(move || serve(&listener, &session, &stopped))?;
        Ok(ShareServer { stop, thread: Some(thread) })
    }
}

impl Drop for ShareServer {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Accepts connections and sends lines to watchers. Each request has a thread of its own: it waits for the plant, and in lockstep the plant
/// may at the same time wait for this thread to read its truth.
fn serve(listener: &ShareListener, session: &Session, stop: &AtomicBool) {
    let (watching, watchers) = channel();
    let open = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let mut audience = Audience { session, watchers, streams: vec![], display: None };
        while !stop.load(Relaxed) {
            while let Some((stream, user)) = listener.accept() {
                accept(scope, session, stream, user, &watching, &open, stop);
            }
            let interval = if audience.update() { POLL_INTERVAL } else { ACCEPT_POLL };
            std::thread::sleep(interval);
        }
    });
}

/// Serves one connection in a thread of its own.
fn accept<'scope>(
    scope: &'scope Scope<'scope, '_>,
    session: &'scope Session,
    mut stream: UnixStream,
    user: u32,
    watching: &Sender<UnixStream>,
    open: &'scope AtomicUsize,
    stop: &'scope AtomicBool,
) {
    if open.fetch_add(1, Relaxed) >= MAX_REQUESTS {
        open.fetch_sub(1, Relaxed);
        let words = format!("the share serves {MAX_REQUESTS} requests at a time: try again");
        let _ = share::answer(&mut stream, Err(Failure::new(Exit::PeerMissing, words)));
        return;
    }
    let (watching, refused) = (watching.clone(), stream.try_clone());
    let started = thread::start_scoped(scope, move || {
        // It is no error if the other user has gone.
        let _ = match share::receive(&mut stream, stop) {
            Ok(SharedRequest::Top) => watching.send(stream).map_err(io::Error::other),
            Ok(request) => share::answer(&mut stream, carry_out(session, request, Some(user))),
            Err(failure) => share::answer(&mut stream, Err(failure)),
        };
        open.fetch_sub(1, Relaxed);
    });
    if let Err(failure) = started {
        open.fetch_sub(1, Relaxed);
        let _ = refused.and_then(|mut stream| share::answer(&mut stream, Err(failure)));
    }
}

/// The users who run `biped top`, with one reader of the session for all of them.
struct Audience<'a> {
    session: &'a Session,
    watchers: Receiver<UnixStream>,
    streams: Vec<UnixStream>,
    display: Option<SharedDisplay>,
}

impl Audience<'_> {
    /// Sends the next line, if it is due. Returns whether anybody watches.
    fn update(&mut self) -> bool {
        self.streams.extend(self.watchers.try_iter());
        for mut extra in self.streams.drain(self.streams.len().min(MAX_WATCHERS)..) {
            let words = format!("{MAX_WATCHERS} users watch already");
            let _ = share::answer(&mut extra, Err(Failure::new(Exit::Incompatible, words)));
        }
        if self.streams.is_empty() {
            self.display = None;
            return false;
        }
        match self.line() {
            Ok(Some(line)) => self.streams.retain_mut(|stream| share::answer(stream, Ok(line.clone())).is_ok()),
            Ok(None) => (),
            Err(failure) => {
                log(format_args!("no one can watch: {}", failure.message));
                for mut stream in self.streams.drain(..) {
                    let _ = share::answer(&mut stream, Err(Failure::new(failure.exit, &failure.message)));
                }
            }
        }
        true
    }

    /// The next line, if it is due.
    fn line(&mut self) -> Result<Option<String>, Failure> {
        let mut display = self.display.take().map_or_else(|| SharedDisplay::attach(self.session), Ok)?;
        let line = display.poll()?;
        self.display = Some(display);
        Ok(line)
    }
}
