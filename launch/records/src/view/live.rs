//! The page of a running session. A process of its own that only listens; what a browser does not fetch in time is dropped here, so
//! that no browser ever holds up a run.

use super::admission::{Answer, Query, data, html, nothing, text, with};
use super::film::{about, bytes, frame};
use super::page::Page;
use super::server::Door;
use crate::record::{Extremes, Robot, Sample, Worst};
use crate::top::has_ended;
use hyper::Method;
use hyper::body::Bytes;
use hyper::header::HeaderName;
use messages::load;
use messages::port::{Ask, RecorderPort, Verdict, ask};
use messages::scene::Scene;
use messages::session::Session;
use messages::wire::{STATES, Truth};
use serde::Deserialize;
use shared::exit::{Exit, Failure};
use shared::output::print_text;
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Frames come no closer than this [ns].
const FRAME_NS: u64 = 5_000_000;
/// Frames that are kept for a browser: ten seconds in real time.
const KEPT: usize = 2000;
const RUN: HeaderName = HeaderName::from_static("run");
const NEXT: HeaderName = HeaderName::from_static("next");

/// Serves the page until the session or the user's patience ends.
///
/// # Errors
/// If there is no such session, it does not say what its scene is, or the port is in use.
pub fn run(session: &Session, place: SocketAddr, stop: &AtomicBool) -> Result<(), Failure> {
    let mut truths = RecorderPort::visit(session)?;
    let name = session.name();
    let unknown = || {
        let why =
            format!("session `{name}` does not say what its scene is, so there is no robot to draw: see `biped top`");
        Failure::new(Exit::Incompatible, why)
    };
    let scene: Scene = session.scene().and_then(|text| toml::from_str(&text).ok()).ok_or_else(unknown)?;
    let door = Door::open(place)?;
    print_text(format_args!("session {name}: open {}\n", door.address));
    let desk = Arc::new(Desk::new(session.clone(), &scene));
    let behind = desk.clone();
    std::thread::spawn(move || door.serve(move |method, path, query, body| behind.answer(method, path, query, body)));
    let (mut film, mut heard) = (Camera::new(&scene), Instant::now());
    while !stop.load(Relaxed) && !has_ended(session, heard) {
        while let Some(truth) = truths.read()? {
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
    extremes: Extremes,
    run: u64,
    slot: u64,
}

impl Camera {
    fn new(scene: &Scene) -> Camera {
        Camera { robot: Robot::new(scene), worst: Worst::default(), extremes: Extremes::default(), run: 0, slot: 0 }
    }

    fn take(&mut self, truth: &Truth, reel: &Mutex<Reel>) {
        self.worst = self.worst.and(&Worst::of(truth));
        let slot = truth.stamp.sim_ns / FRAME_NS;
        if truth.stamp.run == self.run && slot == self.slot {
            return;
        }
        let sample = Sample::new(&self.robot, truth, &self.robot.place(truth));
        if truth.stamp.run != self.run {
            self.extremes = Extremes::default();
        }
        self.extremes.push(&self.robot, truth, &sample);
        let fallen = self.extremes.fall.is_some();
        let frame = bytes(&frame(&self.robot, truth, &sample, &self.worst, fallen)).collect();
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
    page: Bytes,
    trunk: usize,
    reel: Mutex<Reel>,
}

impl Desk {
    fn new(session: Session, scene: &Scene) -> Desk {
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
        Desk { page: page.html().into(), trunk: robot.trunk, session, reel: Mutex::default() }
    }

    fn answer(&self, method: &Method, path: &str, query: Query, body: &str) -> Answer {
        match (method, path) {
            (&Method::GET, "/") => html(&self.page),
            (&Method::GET, "/frames") => self.frames(query.value("run"), query.value("from")),
            (&Method::POST, "/ask") => self.ask(body),
            _ => nothing(),
        }
    }

    fn frames(&self, run: Option<&str>, from: Option<&str>) -> Answer {
        let reel = self.reel.lock().unwrap_or_else(|broken| broken.into_inner());
        let is_same = run == Some(&reel.runs.to_string());
        let from = from.filter(|_| is_same).and_then(|from| from.parse().ok()).unwrap_or(0);
        let answer = with(data(reel.from(from)), RUN, &reel.runs.to_string());
        with(answer, NEXT, &reel.next.to_string())
    }

    fn ask(&self, body: &str) -> Answer {
        let Ok(wish) = serde_json::from_str::<Wish>(body) else { return text(400, "This request cannot be read.\n") };
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
    Step {
        periods: u64,
    },
    Reset,
    Rearm,
    Push {
        /// The trunk, if none is named.
        body: Option<usize>,
        impulse: [f64; 3],
    },
    Set {
        period: f64,
        speed: f64,
    },
}

impl Wish {
    fn ask(self, trunk: usize) -> Ask {
        match self {
            Wish::Pause => Ask::Pause,
            Wish::Resume => Ask::Resume,
            Wish::Step { periods } => Ask::Step { periods },
            Wish::Reset => Ask::Reset { seed: None },
            Wish::Rearm => Ask::Rearm,
            Wish::Push { body, impulse } => Ask::Push { body: body.unwrap_or(trunk), impulse, duration: 0.05 },
            Wish::Set { period, speed } => Ask::Set { period: Some(period), speed: Some(speed) },
        }
    }
}
