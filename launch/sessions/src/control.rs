//! The client of the control services of a running session: `biped pause|resume|step|reset|push|rearm|set`.

use clap::{ArgGroup, Args, Subcommand};
use controller::Controller;
use messages::legible;
use messages::load::parse;
use messages::port::{Action, GaitRequest, Verdict, ask_for};
use messages::scene::Scene;
use messages::session::{Session, SharedSession};
use messages::wire::{Reply, STATES};
use plant::process::{MAX_PUSH_DURATION, MAX_PUSH_IMPULSE, is_push_accepted};
use shared::args::{Reachable, SessionArgs, parse_finite};
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::print_text;
use shared::share::{self, SharedRequest};
use std::sync::atomic::AtomicBool;

/// Arguments of `biped pause`, `resume` and `rearm`.
#[derive(Args)]
pub struct PlainRequestArgs {
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped step`.
#[derive(Args)]
pub struct StepRequestArgs {
    /// Number of control periods to run before the session pauses again
    #[arg(default_value_t = 1)]
    periods: u64,
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped reset`.
#[derive(Args)]
pub struct ResetRequestArgs {
    /// Seed of all random numbers of the new run; by default the seed stays the same
    #[arg(value_parser = clap::value_parser!(u64).range(1..))]
    seed: Option<u64>,
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped push`.
#[derive(Args)]
pub struct PushRequestArgs {
    /// Impulse x,y,z in the world frame: forward, left, up [N·s]
    #[arg(value_parser = parse_vector, allow_hyphen_values = true)]
    impulse: [f64; 3],
    /// Body to push: its name or its number in the scene; by default the base, which is the trunk of a biped
    #[arg(long)]
    body: Option<String>,
    /// Duration of the push [s]
    #[arg(long, default_value_t = 0.05, value_parser = parse_finite)]
    duration: f64,
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped set`.
#[derive(Args)]
#[command(group = ArgGroup::new("either").args(["period", "speed", "stop"]).required(true).multiple(true))]
pub struct SetRequestArgs {
    /// Period of two steps [s]
    #[arg(long, value_parser = parse_finite, allow_hyphen_values = true)]
    period: Option<f64>,
    /// Walking speed [m/s]
    #[arg(long, value_parser = parse_finite, allow_hyphen_values = true)]
    speed: Option<f64>,
    /// End the walk: the robot stops at the end of the step under way
    #[arg(long, conflicts_with_all = ["period", "speed"])]
    stop: bool,
    #[command(flatten)]
    session: SessionArgs,
}

fn parse_vector(text: &str) -> Result<[f64; 3], String> {
    let parts: Option<Vec<f64>> = text.split(',').map(|part| parse_finite(part.trim()).ok()).collect();
    let parts = parts.and_then(|parts| <[f64; 3]>::try_from(parts).ok());
    parts.ok_or_else(|| "three finite numbers x,y,z separated by commas are needed, such as 0,3,0".into())
}

/// The commands that send a request.
#[derive(Subcommand)]
pub enum ControlCommand {
    /// Pause a running session
    Pause(PlainRequestArgs),
    /// Resume a paused session
    Resume(PlainRequestArgs),
    /// Run a paused session for a few control periods; one that runs pauses after them
    Step(StepRequestArgs),
    /// Restart a running session from its initial state
    Reset(ResetRequestArgs),
    /// Push a body of the robot
    Push(PushRequestArgs),
    /// Switch the drives on again after a fault
    Rearm(PlainRequestArgs),
    /// Change speed and period of the gait, or end the walk
    Set(SetRequestArgs),
}

/// Sends the request, waits for the reply, and prints it.
///
/// # Errors
/// If the session or its control service is missing, or the request is refused.
pub fn run(command: ControlCommand, stop: &AtomicBool) -> Result<(), Failure> {
    let reachable = command.session().reach(SessionArgs::find_named)?;
    let wanted = match command {
        ControlCommand::Pause(_) => SharedRequest::Pause,
        ControlCommand::Resume(_) => SharedRequest::Resume,
        ControlCommand::Rearm(_) => SharedRequest::Rearm,
        ControlCommand::Step(args) => SharedRequest::Step { periods: args.periods },
        ControlCommand::Reset(args) => SharedRequest::Reset { seed: args.seed },
        ControlCommand::Set(args) if args.stop => SharedRequest::Stop,
        ControlCommand::Set(args) => SharedRequest::Set { period: args.period, speed: args.speed },
        ControlCommand::Push(args) => {
            SharedRequest::Push { body: args.body, impulse: args.impulse, duration: args.duration }
        }
    };
    let answer = match reachable {
        Reachable::Own(session) => carry_out(&session, wanted, None),
        Reachable::Shared(shared) => carry_out_shared(&shared, &wanted, stop),
    };
    let answer = answer.or_else(|failure| check_interrupt(stop).and(Err(failure)))?;
    print_text(format_args!("{answer}\n"));
    Ok(())
}

/// Sends a request to a session of another user. Returns the answer in words.
fn carry_out_shared(shared: &SharedSession, request: &SharedRequest, stop: &AtomicBool) -> Result<String, Failure> {
    let mut stream = share::send(shared, request)?;
    let none = || Failure::new(Exit::PeerMissing, format!("session {} ended without an answer", shared.name()));
    share::read_answer(shared, &mut stream, stop)?.ok_or_else(none)
}

/// Sends a request to a session of this user. `user` is the number of the other user who makes the request, if there is one. Returns the
/// answer in words.
///
/// # Errors
/// As [`run`].
pub fn carry_out(session: &Session, request: SharedRequest, user: Option<u32>) -> Result<String, Failure> {
    let name = session.name();
    let scene = || session.scene().and_then(|text| parse(&text, name).ok());
    let what = match request {
        SharedRequest::Pause => Action::Pause,
        SharedRequest::Resume => Action::Resume,
        SharedRequest::Rearm => Action::Rearm,
        SharedRequest::Step { periods } => Action::Step { periods },
        SharedRequest::Reset { seed } => Action::Reset { seed },
        SharedRequest::Set { period, speed } => Action::Gait(GaitRequest::Set { period, speed }),
        SharedRequest::Stop => Action::Gait(GaitRequest::Stop),
        SharedRequest::Push { body, impulse, duration } => {
            Action::Push { body: body_index(body.as_deref(), session, scene)?, impulse, duration }
        }
        SharedRequest::Top => return Err(Failure::new(Exit::Usage, "top is not a request")),
    };
    let reply = ask_for(session, what, user)?;
    if reply.verdict != Verdict::Done as u64 {
        let role = if what.is_for_controller() { "controller" } else { "plant" };
        let words = refusal(what, scene, &reply).unwrap_or_else(|| Verdict::text(reply.verdict).into());
        return Err(Failure::new(Exit::Usage, format!("the {role} of session `{name}` refuses: {words}")));
    }
    let time = reply.stamp.time();
    let state = STATES.get(reply.state as usize).copied().unwrap_or("?");
    let result = match what {
        Action::Gait(GaitRequest::Set { .. }) => format!("set at t {time:.3} s"),
        Action::Gait(GaitRequest::Stop) => format!("stop at t {time:.3} s"),
        Action::Push { body, impulse, duration } => {
            let effect = scene().map_or(String::new(), |scene| push_effect(&scene, body, impulse, duration));
            format!("t {time:.3} s, {state}{effect}")
        }
        _ => format!("t {time:.3} s, {state}"),
    };
    Ok(format!("session {name}: {result}"))
}

impl ControlCommand {
    /// The session that the request is for.
    fn session(&self) -> &SessionArgs {
        match self {
            ControlCommand::Pause(args) | ControlCommand::Resume(args) | ControlCommand::Rearm(args) => &args.session,
            ControlCommand::Step(args) => &args.session,
            ControlCommand::Reset(args) => &args.session,
            ControlCommand::Set(args) => &args.session,
            ControlCommand::Push(args) => &args.session,
        }
    }
}

/// The effect of a push on the robot as a whole, in words.
fn push_effect(scene: &Scene, body: usize, [x, y, z]: [f64; 3], duration: f64) -> String {
    let mass: f64 = scene.bodies.iter().map(|body| body.mass).sum();
    let speed = (x * x + y * y + z * z).sqrt() / mass;
    let body = scene.bodies.get(body).map_or("?", |body| &body.name);
    format!(
        "; {body} gets {} N·s within {} s, which changes the speed of {mass:.1} kg by {speed:.2} m/s",
        [x, y, z].map(legible).join(","),
        legible(duration)
    )
}

/// Number of a body that is given by number or name; of the scene's base by default.
fn body_index(body: Option<&str>, session: &Session, scene: impl Fn() -> Option<Scene>) -> Result<usize, Failure> {
    if let Some(number) = body.and_then(|body| body.parse().ok()) {
        return Ok(number);
    }
    session.require_running()?;
    let unknown = || format!("session `{}` has published no scene: give the body by its number", session.name());
    let scene = scene().ok_or_else(|| Failure::new(Exit::Usage, unknown()))?;
    let Some(body) = body else { return Ok(scene.base_body()) };
    let names = names_of(&scene);
    names.iter().position(|name| name == body).ok_or_else(|| Failure::new(Exit::Usage, no_such_body(body, &names)))
}

fn no_such_body(body: &str, names: &[String]) -> String {
    format!("the scene has no body `{body}`; its bodies are {}", names.join(", "))
}

fn names_of(scene: &Scene) -> Vec<String> {
    scene.bodies.iter().map(|body| body.name.clone()).collect()
}

/// Why a request got this reply, which is a refusal, and what would be accepted; `None` if the verdict says it all.
fn refusal(what: Action, scene: impl Fn() -> Option<Scene>, reply: &Reply) -> Option<String> {
    match what {
        Action::Gait(GaitRequest::Set { period, speed }) => {
            let mut controller = Controller::new(&scene()?).ok()?;
            if reply.verdict == Verdict::OutOfRange as u64 {
                return Some(controller.out_of_range(period, speed).to_string());
            }
            if reply.verdict != Verdict::NoEffect as u64 {
                return None;
            }
            controller.begin_at(reply.stamp.time());
            let has_stopped =
                "the walk has ended by request, so another period or speed has no effect before `biped reset`";
            Some(controller.set(period, speed).map_or_else(|error| error.to_string(), |()| has_stopped.into()))
        }
        Action::Push { impulse, duration, .. } if !is_push_accepted(&impulse, duration) => Some(format!(
            "each part of an impulse must be from -{MAX_PUSH_IMPULSE} to {MAX_PUSH_IMPULSE} N·s, and its duration greater than 0 and at most {MAX_PUSH_DURATION} s"
        )),
        Action::Push { body, .. } => {
            let names = names_of(&scene()?);
            (body >= names.len()).then(|| no_such_body(&body.to_string(), &names))
        }
        _ => None,
    }
}
