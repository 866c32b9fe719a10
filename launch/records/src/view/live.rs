//! The page of a running session. A separate process subscribes to the session and serves the page. It drops frames that
//! a browser does not fetch in time, so no browser can delay a run.

use super::access::{Answer, Query, data, html, not_found, text, with};
use super::frame::{bytes, frame, run_info};
use super::page::ViewPage;
use super::server::PageServer;
use crate::analysis::{DerivedState, Extrema, KinematicTree, Peaks};
use crate::top::has_ended;
use hyper::Method;
use hyper::body::Bytes;
use hyper::header::HeaderName;
use messages::load;
use messages::port::{Action, GaitRequest, RecorderPort, Verdict, ask};
use messages::scene::Scene;
use messages::session::Session;
use messages::wire::{STATES, Truth};
use serde::Deserialize;
use shared::exit::{Exit, Failure};
use shared::output::print_text;
use shared::thread;
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Least spacing of frames [ns]: 200 Hz, as the rows of a report.
const FRAME_NS: u64 = 5_000_000;
/// Number of frames that are stored for a browser: ten seconds of simulated time.
const MAX_FRAMES: usize = 2000;
/// Duration of a push from the page [s].
const PUSH_DURATION: f64 = 0.05;
/// Time between reads of the session.
const POLL_INTERVAL: Duration = Duration::from_millis(2);
/// Headers of an answer with frames: number of the run, and number of the next frame.
const RUN: HeaderName = HeaderName::from_static("run");
const NEXT: HeaderName = HeaderName::from_static("next");

/// Serves the page until the session ends or the user stops the program.
///
/// # Errors
/// If the session does not exist or has published no scene, or the port is in use.
pub fn run(session: &Session, address: SocketAddr, stop: &AtomicBool) -> Result<(), Failure> {
    let mut truths = RecorderPort::attach(session)?;
    let name = session.name();
    let unknown = || {
        let why =
            format!("session `{name}` has published no scene, so its robot cannot be drawn: use `biped top` instead");
        Failure::new(Exit::Incompatible, why)
    };
    let scene: Scene = session.scene().and_then(|text| toml::from_str(&text).ok()).ok_or_else(unknown)?;
    let server = PageServer::open(address)?;
    print_text(format_args!("session {name}: open {}\n", server.url));
    let page_state = Arc::new(LivePage::new(session.clone(), &scene));
    let shared = page_state.clone();
    thread::start(move || server.serve(move |method, path, query, body| shared.answer(method, path, query, body)))?;
    let (mut sampler, mut received) = (FrameSampler::new(&scene), Instant::now());
    while !stop.load(Relaxed) && !has_ended(session, received) {
        while let Some(truth) = truths.read()? {
            received = Instant::now();
            sampler.push(&truth, &page_state.queue);
        }
        std::thread::sleep(POLL_INTERVAL);
    }
    Ok(())
}

/// Samples frames from the received records.
struct FrameSampler {
    robot: KinematicTree,
    peaks: Peaks,
    extrema: Extrema,
    /// Run and sampling interval of the latest frame.
    run: u64,
    slot: u64,
}

impl FrameSampler {
    fn new(scene: &Scene) -> FrameSampler {
        FrameSampler {
            robot: KinematicTree::new(scene),
            peaks: Peaks::default(),
            extrema: Extrema::default(),
            run: 0,
            slot: 0,
        }
    }

    fn push(&mut self, truth: &Truth, queue: &Mutex<FrameQueue>) {
        self.peaks = self.peaks.max(&Peaks::new(truth));
        let slot = truth.stamp.sim_ns / FRAME_NS;
        if truth.stamp.run == self.run && slot == self.slot {
            return;
        }
        let derived = DerivedState::new(&self.robot, truth, &self.robot.body_states(truth));
        if truth.stamp.run != self.run {
            self.extrema = Extrema::default();
        }
        self.extrema.push(&self.robot, truth, &derived);
        let fallen = self.extrema.fall.is_some();
        let frame = bytes(&frame(&self.robot, truth, &derived, &self.peaks, fallen)).collect();
        let mut queue = queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if truth.stamp.run != self.run {
            queue.frames.clear();
            queue.runs += 1;
        }
        queue.push(frame);
        (self.run, self.slot, self.peaks) = (truth.stamp.run, slot, Peaks::default());
    }
}

/// The latest frames. Frames are numbered consecutively.
#[derive(Default)]
struct FrameQueue {
    frames: VecDeque<Vec<u8>>,
    /// Number of the next frame.
    next: u64,
    /// Number of the current run. A reset of the simulation starts a new run.
    runs: u64,
}

impl FrameQueue {
    fn push(&mut self, frame: Vec<u8>) {
        self.frames.push_back(frame);
        self.next += 1;
        if self.frames.len() > MAX_FRAMES {
            self.frames.pop_front();
        }
    }

    /// The stored frames from a number on.
    fn from(&self, number: u64) -> Vec<u8> {
        let begin = self.next - self.frames.len() as u64;
        self.frames.iter().skip(number.saturating_sub(begin) as usize).flatten().copied().collect()
    }
}

/// The state of the server: the page, the frames, and the session that receives the requests.
struct LivePage {
    session: Session,
    page: Bytes,
    base: usize,
    queue: Mutex<FrameQueue>,
}

impl LivePage {
    fn new(session: Session, scene: &Scene) -> LivePage {
        let robot = KinematicTree::new(scene);
        let mut run_info = run_info(&robot, scene);
        run_info["live"] = true.into();
        run_info["gait"] = scene.controller.as_ref().map(|gait| [gait.speed, gait.period]).into_iter().collect();
        let page = ViewPage {
            title: &format!("biped: session {}", session.name()),
            description: &scene.description,
            run_info: &run_info,
            trajectory: "",
            below: "",
            scene: &load::text(scene),
        };
        LivePage { page: page.html().into(), base: scene.base_body(), session, queue: Mutex::default() }
    }

    fn answer(&self, method: &Method, path: &str, query: Query, body: &str) -> Answer {
        match (method, path) {
            (&Method::GET, "/") => html(&self.page),
            (&Method::GET, "/frames") => self.frames(query.value("run"), query.value("from")),
            (&Method::POST, "/ask") => self.ask(body),
            _ => not_found(),
        }
    }

    fn frames(&self, run: Option<&str>, from: Option<&str>) -> Answer {
        let queue = self.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let is_same = run == Some(&queue.runs.to_string());
        let from = from.filter(|_| is_same).and_then(|from| from.parse().ok()).unwrap_or(0);
        let answer = with(data(queue.from(from)), RUN, &queue.runs.to_string());
        with(answer, NEXT, &queue.next.to_string())
    }

    fn ask(&self, body: &str) -> Answer {
        let Ok(request) = serde_json::from_str::<PageRequest>(body) else {
            return text(400, "This request is malformed.\n");
        };
        let action = request.into_ask(self.base);
        match ask(&self.session, action) {
            Ok(reply) if reply.verdict == Verdict::Done as u64 => {
                let plant = STATES.get(reply.state as usize).filter(|_| !action.is_for_controller());
                let state = plant.map_or(String::new(), |state| format!(": {state}"));
                text(200, &format!("done at t {:.2} s{state}", reply.stamp.time()))
            }
            Ok(reply) => text(409, &format!("refused: {}", Verdict::text(reply.verdict))),
            Err(error) => text(409, &error.to_string()),
        }
    }
}

/// A request of the page.
#[derive(Deserialize)]
#[serde(tag = "what", rename_all = "lowercase", deny_unknown_fields)]
enum PageRequest {
    Pause,
    Resume,
    Step {
        periods: u64,
    },
    Reset,
    Rearm,
    Push {
        /// The base by default.
        body: Option<usize>,
        impulse: [f64; 3],
    },
    Set {
        period: f64,
        speed: f64,
    },
    Stop,
}

impl PageRequest {
    fn into_ask(self, base: usize) -> Action {
        match self {
            PageRequest::Pause => Action::Pause,
            PageRequest::Resume => Action::Resume,
            PageRequest::Step { periods } => Action::Step { periods },
            PageRequest::Reset => Action::Reset { seed: None },
            PageRequest::Rearm => Action::Rearm,
            PageRequest::Push { body, impulse } => {
                Action::Push { body: body.unwrap_or(base), impulse, duration: PUSH_DURATION }
            }
            PageRequest::Set { period, speed } => {
                Action::Gait(GaitRequest::Set { period: Some(period), speed: Some(speed) })
            }
            PageRequest::Stop => Action::Gait(GaitRequest::Stop),
        }
    }
}
