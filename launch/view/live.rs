//! `biped view`: the page of a running session, served to a browser on this machine. A process of its own that only listens; what a
//! browser does not fetch in time is dropped here, so that no browser ever holds up a run.

use super::film::{about, bytes, frame};
use super::page::Page;
use crate::desk::SessionArgs;
use crate::exit::{Exit, Failure};
use crate::record::{Robot, Sample, Worst};
use crate::say;
use crate::top::has_ended;
use clap::Args;
use messages::load;
use messages::port::{Ask, RecorderPort, Verdict, ask};
use messages::scene::Scene;
use messages::session::Session;
use messages::wire::{STATES, Truth};
use serde::Deserialize;
use std::collections::VecDeque;
use std::io::{Cursor, Read};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tiny_http::{Header, Method, Request, Response, Server};

/// Frames come no closer than this [ns].
const FRAME_NS: u64 = 5_000_000;
/// Frames that are kept for a browser: ten seconds in real time.
const KEPT: usize = 2000;
/// A request is shorter [bytes].
const LONGEST: u64 = 4096;
/// Who answer: one may wait at a desk while another hands out frames.
const HANDS: usize = 3;

/// Arguments of `biped view`.
#[derive(Args)]
pub struct ViewArgs {
    #[command(flatten)]
    session: SessionArgs,
    /// Port on this machine's own address; 0 takes one that is free
    #[arg(long, default_value_t = 8642)]
    port: u16,
}

/// Serves the page until the session or the user's patience ends.
///
/// # Errors
/// If there is no such session, or the port is in use.
pub fn run(args: &ViewArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let session = args.session.find()?;
    let mut port = RecorderPort::visit(&session)?;
    let name = session.name().to_string();
    let unknown = || Failure::new(Exit::Incompatible, format!("session `{name}` does not say what its scene is"));
    let scene: Scene = session.scene().and_then(|text| toml::from_str(&text).ok()).ok_or_else(unknown)?;
    let server = Server::http(("127.0.0.1", args.port)).map_err(|error| {
        let advice = format!("port {} cannot be taken ({error}): choose another by --port, or 0 for any", args.port);
        Failure::new(Exit::Usage, advice)
    })?;
    let token = format!("{:016x}", messages::clock::random());
    let at = server.server_addr().to_ip().map_or(args.port, |address| address.port());
    let desk = Arc::new(Desk::new(session.clone(), &scene, token.clone()));
    let server = Arc::new(server);
    for _ in 0..HANDS {
        let (server, desk) = (server.clone(), desk.clone());
        std::thread::spawn(move || server.incoming_requests().for_each(|request| desk.answer(request)));
    }
    say(format_args!("session {name}: open http://127.0.0.1:{at}/?token={token}\n"));
    let (mut film, mut heard) = (Camera::new(&scene), Instant::now());
    while !stop.load(Relaxed) && !has_ended(&session, heard) {
        while let Some(truth) = port.read()? {
            heard = Instant::now();
            film.take(&truth, &desk.reel);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(())
}

/// Makes frames of what is heard.
struct Camera {
    robot: Robot,
    worst: Worst,
    run: u64,
    slot: u64,
}

impl Camera {
    fn new(scene: &Scene) -> Camera {
        Camera { robot: Robot::new(scene), worst: Worst::default(), run: 0, slot: 0 }
    }

    fn take(&mut self, truth: &Truth, reel: &Mutex<Reel>) {
        self.worst = self.worst.and(&Worst::of(truth));
        let slot = truth.stamp.sim_ns / FRAME_NS;
        if truth.stamp.run == self.run && slot == self.slot {
            return;
        }
        let sample = Sample::new(&self.robot, truth, &self.robot.place(truth));
        let frame = bytes(&frame(&self.robot, truth, &sample, &self.worst)).collect();
        let mut reel = reel.lock().unwrap_or_else(|broken| broken.into_inner());
        if truth.stamp.run != self.run {
            reel.frames.clear();
            reel.runs += 1;
        }
        reel.push(frame);
        (self.run, self.slot, self.worst) = (truth.stamp.run, slot, Worst::default());
    }
}

/// The last frames; each has a number.
#[derive(Default)]
struct Reel {
    frames: VecDeque<Vec<u8>>,
    /// Number of the frame to come.
    next: u64,
    /// Runs so far: a reset begins another.
    runs: u64,
}

impl Reel {
    fn push(&mut self, frame: Vec<u8>) {
        self.frames.push_back(frame);
        self.next += 1;
        if self.frames.len() > KEPT {
            self.frames.pop_front();
        }
    }

    /// All from a number on that are still there.
    fn from(&self, number: u64) -> Vec<u8> {
        let begin = self.next - self.frames.len() as u64;
        self.frames.iter().skip(number.saturating_sub(begin) as usize).flatten().copied().collect()
    }
}

/// Where browsers come to.
struct Desk {
    session: Session,
    token: String,
    page: String,
    trunk: usize,
    reel: Mutex<Reel>,
}

impl Desk {
    fn new(session: Session, scene: &Scene, token: String) -> Desk {
        let robot = Robot::new(scene);
        let mut about = about(&robot, scene);
        about["live"] = true.into();
        about["gait"] = scene.controller.as_ref().map(|gait| [gait.speed, gait.period]).into_iter().collect();
        let page = Page {
            title: &format!("biped: session {}", session.name()),
            description: &scene.description,
            about: &about,
            film: "",
            below: "",
            scene: &load::text(scene),
        };
        Desk { page: page.html(), trunk: robot.trunk, session, token, reel: Mutex::default() }
    }

    /// Answers; a browser that has gone is no error.
    fn answer(&self, mut request: Request) {
        let url = request.url().to_string();
        let (path, query) = url.split_once('?').unwrap_or((&url, ""));
        let value = |key: &str| query.split('&').find_map(|part| part.strip_prefix(key)?.strip_prefix('='));
        let response = match (request.method(), path) {
            (_, "/favicon.ico") => text(204, ""),
            _ if value("token") != Some(&self.token) => {
                text(403, "This address is not, or no longer, good: open the one that `biped view` printed last.\n")
            }
            (Method::Get, "/") => with(text(200, &self.page), "Content-Type", "text/html; charset=utf-8"),
            (Method::Get, "/frames") => self.frames(value("run"), value("from")),
            (Method::Post, "/ask") => self.ask(&mut request),
            _ => text(404, "There is nothing here.\n"),
        };
        let _ = request.respond(with(response, "Cache-Control", "no-store"));
    }

    fn frames(&self, run: Option<&str>, from: Option<&str>) -> Response<Cursor<Vec<u8>>> {
        let reel = self.reel.lock().unwrap_or_else(|broken| broken.into_inner());
        let is_same = run == Some(&reel.runs.to_string());
        let from = from.filter(|_| is_same).and_then(|from| from.parse().ok()).unwrap_or(0);
        let response = with(Response::from_data(reel.from(from)), "Run", &reel.runs.to_string());
        with(response, "Next", &reel.next.to_string())
    }

    fn ask(&self, request: &mut Request) -> Response<Cursor<Vec<u8>>> {
        let mut words = String::new();
        let read = request.as_reader().take(LONGEST).read_to_string(&mut words);
        let wish = read.ok().and_then(|_| serde_json::from_str::<Wish>(&words).ok());
        let Some(wish) = wish else { return text(400, "This request cannot be read.\n") };
        match ask(&self.session, wish.ask(self.trunk)) {
            Ok(reply) if reply.verdict == Verdict::Done as u64 => {
                let state = STATES.get(reply.state as usize).copied().unwrap_or("?");
                text(200, &format!("done at t {:.2} s: {state}", reply.stamp.sim_ns as f64 * 1e-9))
            }
            Ok(reply) => text(409, &format!("refused: {}", Verdict::words(reply.verdict))),
            Err(error) => text(409, &error.to_string()),
        }
    }
}

/// What the page may ask for.
#[derive(Deserialize)]
#[serde(tag = "what", rename_all = "lowercase", deny_unknown_fields)]
enum Wish {
    Pause,
    Resume,
    Step { periods: u64 },
    Reset,
    Rearm,
    Push { impulse: [f64; 3] },
    Set { period: f64, speed: f64 },
}

impl Wish {
    fn ask(self, body: usize) -> Ask {
        match self {
            Wish::Pause => Ask::Pause,
            Wish::Resume => Ask::Resume,
            Wish::Step { periods } => Ask::Step { periods },
            Wish::Reset => Ask::Reset { seed: None },
            Wish::Rearm => Ask::Rearm,
            Wish::Push { impulse } => Ask::Push { body, impulse, duration: 0.05 },
            Wish::Set { period, speed } => Ask::Set { period: Some(period), speed: Some(speed) },
        }
    }
}

fn text(status: u16, words: &str) -> Response<Cursor<Vec<u8>>> {
    Response::from_string(words).with_status_code(status)
}

/// With one header more, of plain ASCII.
fn with(response: Response<Cursor<Vec<u8>>>, name: &str, value: &str) -> Response<Cursor<Vec<u8>>> {
    match Header::from_bytes(name, value) {
        Ok(header) => response.with_header(header),
        Err(()) => response,
    }
}
