//! At the desk of a running session: `biped pause|resume|step|reset|push|rearm|set`.

use clap::{ArgGroup, Args, Subcommand};
use controller::Controller;
use messages::load::parse;
use messages::port::{Action, Verdict, ask};
use messages::scene::Scene;
use messages::wire::STATES;
use shared::args::SessionArgs;
use shared::exit::{Exit, Failure};
use shared::output::say;

/// Arguments of `biped pause`, `resume` and `rearm`.
#[derive(Args)]
pub struct PlainArgs {
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped step`.
#[derive(Args)]
pub struct StepArgs {
    /// Control periods to run before the session is paused again
    #[arg(default_value_t = 1)]
    periods: u64,
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped reset`.
#[derive(Args)]
pub struct ResetArgs {
    /// Seed of all random numbers of the new run; without it, the seed stays
    #[arg(value_parser = clap::value_parser!(u64).range(1..))]
    seed: Option<u64>,
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped push`.
#[derive(Args)]
pub struct PushArgs {
    /// Impulse x,y,z in the world: forward, left, up [N·s]
    #[arg(value_parser = vector, allow_hyphen_values = true)]
    impulse: [f64; 3],
    /// Body that is pushed, by its number in the scene or its name; 4 is the trunk of the paper's robot
    #[arg(long, default_value = "4")]
    body: String,
    /// Time over which the impulse is spread [s]
    #[arg(long, default_value_t = 0.05, allow_negative_numbers = true)]
    duration: f64,
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped set`.
#[derive(Args)]
#[command(group = ArgGroup::new("either").args(["period", "speed"]).required(true).multiple(true))]
pub struct SetArgs {
    /// Period of two steps [s]
    #[arg(long, allow_negative_numbers = true)]
    period: Option<f64>,
    /// Walking speed [m/s]
    #[arg(long, allow_negative_numbers = true)]
    speed: Option<f64>,
    #[command(flatten)]
    session: SessionArgs,
}

fn vector(text: &str) -> Result<[f64; 3], String> {
    let parts: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let parts = parts.and_then(|parts| <[f64; 3]>::try_from(parts).ok());
    parts.ok_or_else(|| "three numbers x,y,z with commas between are needed, such as 0,3,0".into())
}

/// What can be said at a desk.
#[derive(Subcommand)]
pub enum Wish {
    /// Pause a running session
    Pause(PlainArgs),
    /// Resume a paused session
    Resume(PlainArgs),
    /// Run a paused session for a few control periods
    Step(StepArgs),
    /// Start a running session again from its initial state
    Reset(ResetArgs),
    /// Push a body of the robot
    Push(PushArgs),
    /// Switch the drives on again after a fault
    Rearm(PlainArgs),
    /// Change speed and period of the gait
    Set(SetArgs),
}

/// Asks for it, and says what the answer was.
///
/// # Errors
/// If nobody is there, or it cannot be done.
pub fn run(wish: Wish) -> Result<(), Failure> {
    let session = wish.session().find_named()?;
    let name = session.name();
    let scene = || session.scene().and_then(|text| parse(&text, name).ok());
    let what = match &wish {
        Wish::Pause(_) => Action::Pause,
        Wish::Resume(_) => Action::Resume,
        Wish::Rearm(_) => Action::Rearm,
        Wish::Step(args) => Action::Step { periods: args.periods },
        Wish::Reset(args) => Action::Reset { seed: args.seed },
        Wish::Set(args) => Action::Set { period: args.period, speed: args.speed },
        Wish::Push(args) => {
            let body = number(&args.body, scene)?;
            Action::Push { body, impulse: args.impulse, duration: args.duration }
        }
    };
    let reply = ask(&session, what)?;
    if reply.verdict != Verdict::Done as u64 {
        let role = if what.is_for_controller() { "controller" } else { "plant" };
        let words = refusal(what, scene).unwrap_or_else(|| Verdict::text(reply.verdict).into());
        return Err(Failure::new(Exit::Usage, format!("the {role} of session `{name}` refuses: {words}")));
    }
    let time = reply.stamp.sim_ns as f64 * 1e-9;
    let state = STATES.get(reply.state as usize).copied().unwrap_or("?");
    let told = match what {
        Action::Set { .. } => format!("set at t {time:.3} s"),
        Action::Push { body, impulse, duration } => {
            let given = scene().map_or(String::new(), |scene| given(&scene, body, impulse, duration));
            format!("t {time:.3} s, {state}{given}")
        }
        _ => format!("t {time:.3} s, {state}"),
    };
    say(format_args!("session {name}: {told}\n"));
    Ok(())
}

impl Wish {
    /// Whom it is for.
    fn session(&self) -> &SessionArgs {
        match self {
            Wish::Pause(args) | Wish::Resume(args) | Wish::Rearm(args) => &args.session,
            Wish::Step(args) => &args.session,
            Wish::Reset(args) => &args.session,
            Wish::Set(args) => &args.session,
            Wish::Push(args) => &args.session,
        }
    }
}

/// What a push gives the robot, in words.
fn given(scene: &Scene, body: usize, [x, y, z]: [f64; 3], duration: f64) -> String {
    let mass: f64 = scene.bodies.iter().map(|body| body.mass).sum();
    let speed = (x * x + y * y + z * z).sqrt() / mass;
    let body = scene.bodies.get(body).map_or("?", |body| &body.name);
    format!("; {body} is pushed by {x},{y},{z} N·s within {duration} s, which gives all {mass:.1} kg {speed:.2} m/s")
}

/// Number of a body, which may be named.
fn number(body: &str, scene: impl Fn() -> Option<Scene>) -> Result<usize, Failure> {
    if let Ok(number) = body.parse() {
        return Ok(number);
    }
    let names: Vec<String> = scene().map_or(vec![], |scene| scene.bodies.into_iter().map(|body| body.name).collect());
    names.iter().position(|name| name == body).ok_or_else(|| {
        let words = format!("the scene has no body `{body}`; its bodies are {}", names.join(", "));
        Failure::new(Exit::Usage, words)
    })
}

/// What the controller would say of set-points that it refuses: what is possible.
fn refusal(what: Action, scene: impl Fn() -> Option<Scene>) -> Option<String> {
    let Action::Set { period, speed } = what else { return None };
    let refused = Controller::new(&scene()?).ok()?.set(period, speed).err()?;
    Some(refused.to_string())
}
