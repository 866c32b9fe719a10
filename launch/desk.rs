//! At the desk of a running session: `biped pause|resume|step|reset|push|rearm|set`.

use crate::exit::{Exit, Failure};
use crate::output::say;
use clap::{ArgGroup, Args, Subcommand};
use messages::port::{Ask, Verdict, ask};
use messages::session::Session;
use messages::wire::STATES;

/// Which session.
#[derive(Args, Clone)]
pub struct SessionArgs {
    /// Name of the session; without it, the one that is running
    #[arg(long)]
    session: Option<String>,
}

impl SessionArgs {
    /// The session named, or the only one that is running.
    ///
    /// # Errors
    /// If there is none, or more than one to choose from.
    pub fn find(&self) -> Result<Session, Failure> {
        if let Some(name) = &self.session {
            return Ok(Session::named(name)?);
        }
        let mut running = Session::running();
        match running.len() {
            1 => Ok(running.remove(0)),
            0 => Err(Failure::new(
                Exit::PeerMissing,
                "no session is running: start one with `biped run walk --realtime`",
            )),
            _ => {
                let names: Vec<&str> = running.iter().map(Session::name).collect();
                let which =
                    format!("{} sessions are running: choose one by --session {}", names.len(), names.join(" | "));
                Err(Failure::new(Exit::Usage, which))
            }
        }
    }
}

/// Arguments of `biped pause`, `resume` and `rearm`.
#[derive(Args)]
pub struct PlainArgs {
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped step`.
#[derive(Args)]
pub struct StepArgs {
    /// Control periods to run before time stands still again
    #[arg(default_value_t = 1)]
    periods: u64,
    #[command(flatten)]
    session: SessionArgs,
}

/// Arguments of `biped reset`.
#[derive(Args)]
pub struct ResetArgs {
    /// Seed of everything random in the new run; without it, as before
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
    /// Body that is pushed, by its number in the scene; 4 is the trunk of the paper's robot
    #[arg(long, default_value_t = 4)]
    body: usize,
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
    /// Let time stand still in a running session
    Pause(PlainArgs),
    /// Let it go on
    Resume(PlainArgs),
    /// Let it go on for a few control periods
    Step(StepArgs),
    /// Begin a running session anew
    Reset(ResetArgs),
    /// Push a body of a running session
    Push(PushArgs),
    /// Switch the drives of a running session on again after a fault
    Rearm(PlainArgs),
    /// Change speed and period of the gait in a running session
    Set(SetArgs),
}

/// Asks for it, and says what the answer was.
///
/// # Errors
/// If nobody is there, or it cannot be done.
pub fn run(wish: Wish) -> Result<(), Failure> {
    let (what, session) = match wish {
        Wish::Pause(args) => (Ask::Pause, args.session),
        Wish::Resume(args) => (Ask::Resume, args.session),
        Wish::Rearm(args) => (Ask::Rearm, args.session),
        Wish::Step(args) => (Ask::Step { periods: args.periods }, args.session),
        Wish::Reset(args) => (Ask::Reset { seed: args.seed }, args.session),
        Wish::Set(args) => (Ask::Set { period: args.period, speed: args.speed }, args.session),
        Wish::Push(PushArgs { body, impulse, duration, session }) => (Ask::Push { body, impulse, duration }, session),
    };
    let session = session.find()?;
    let reply = ask(&session, what)?;
    if reply.verdict != Verdict::Done as u64 {
        let role = if what.is_for_controller() { "controller" } else { "plant" };
        let words = Verdict::words(reply.verdict);
        return Err(Failure::new(Exit::Usage, format!("the {role} of session `{}` refuses: {words}", session.name())));
    }
    let time = reply.stamp.sim_ns as f64 * 1e-9;
    let state = STATES.get(reply.state as usize).copied().unwrap_or("?");
    match what.is_for_controller() {
        true => say(format_args!("session {}: set at t {time:.3} s\n", session.name())),
        false => say(format_args!("session {}: t {time:.3} s, {state}\n", session.name())),
    }
    Ok(())
}
