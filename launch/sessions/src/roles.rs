//! `biped plant` and `biped controller`: the two roles, started by hand, by `biped run`, or in somebody else's place.

use crate::children;
use crate::opening::guarded;
use crate::realtime;
use clap::Args;
use messages::peer_environment::PeerEnvironment;
use messages::port::{Contract, ControllerPort, Pace, PlantPort};
use messages::session::Session;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use shared::args::PaceArgs;
use shared::args::SceneArgs;
use shared::exit::{Failure, unless};
use shared::output::tell;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Arguments of `biped plant` and `biped controller`.
#[derive(Args)]
pub struct RoleArgs {
    /// Built-in scene (see `biped list`) or path of a TOML file; without it, all is as in the environment that
    /// `--controller` and `--plant` of another biped made
    scene: Option<String>,
    /// Put the robot of this TOML or URDF file into the scene, which is fitted to it
    #[arg(long, value_name = "FILE", requires = "scene")]
    robot: Option<String>,
    /// Replace a value of the scene, for example plant.friction=0.3 (see `biped list --keys`); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scene")]
    settings: Vec<String>,
    #[command(flatten)]
    pace: PaceArgs,
    #[command(flatten)]
    system: realtime::RealtimeArgs,
    /// Name of the session that plant and controller share [biped]; without a scene, a running session to attach to
    #[arg(long)]
    session: Option<String>,
    /// Leave room for a tunnel to another machine, which `biped tunnel` opens
    #[arg(long, requires = "scene")]
    tunnel: bool,
    /// Process to die with
    #[arg(long, hide = true)]
    parent: Option<i32>,
}

impl RoleArgs {
    /// Where to take part: as the arguments say, as the session of this name has published, or as the environment says.
    fn invitation(&self, stop: &AtomicBool) -> Result<PeerEnvironment, Failure> {
        let keeps_waiting = || !stop.load(Relaxed);
        let environment = match (&self.scene, &self.session) {
            (None, None) => PeerEnvironment::from_env(keeps_waiting),
            (None, Some(session)) => PeerEnvironment::attach(session, self.pace.patience(), keeps_waiting),
            (Some(scene), session) => {
                let (robot, settings) = (self.robot.clone(), self.settings.clone());
                let scene = SceneArgs { scene: scene.clone(), robot, settings }.load()?;
                let contract = Contract::of(&scene, self.pace.pace()).with_tunnel(self.tunnel);
                let session = Session::named(session.as_deref().unwrap_or(SESSION))?;
                Ok(PeerEnvironment { session, contract, patience: self.pace.patience(), scene, takes_over: false })
            }
        };
        unless(stop)?;
        Ok(environment?)
    }
}

/// Name of the session, unless another one is given.
const SESSION: &str = "biped";

/// `biped plant`.
///
/// # Errors
/// A sentence and an exit code.
pub fn plant(args: &RoleArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let environment = begin(args, 0, stop)?;
    let PeerEnvironment { session, contract, patience, scene, .. } = &environment;
    let port = guarded(|| PlantPort::open(session, contract))?;
    environment.publish()?;
    ready(args)?;
    if args.parent.is_some() {
        held(stop);
    }
    let options = plant::process::Options { pace: contract.pace, speed: args.pace.speed, patience: *patience };
    let (tally, result) = plant::process::run(scene, port, options, stop);
    let remarks = tally.to_string();
    if !remarks.is_empty() {
        tell(remarks);
    }
    Ok(result?)
}

/// `biped controller`.
///
/// # Errors
/// A sentence and an exit code.
pub fn controller(args: &RoleArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let PeerEnvironment { session, contract, patience, scene, takes_over } = begin(args, 1, stop)?;
    let port = match takes_over {
        true => ControllerPort::open_when_free(&session, &contract, || !stop.load(Relaxed))?,
        false => guarded(|| ControllerPort::open(&session, &contract))?,
    };
    ready(args)?;
    Ok(controller::process::run(&scene, port, patience, stop)?)
}

/// What both roles begin with: plant (0) and controller (1).
fn begin(args: &RoleArgs, side: usize, stop: &AtomicBool) -> Result<PeerEnvironment, Failure> {
    let invitation = args.invitation(stop)?;
    if let Some(parent) = args.parent {
        // Nobody else may be left to clear up after it.
        children::die_with(parent).inspect_err(|_| invitation.session.remove_files())?;
    }
    args.system.suits(invitation.contract.pace)?;
    match invitation.contract.pace {
        Pace::RealTime => realtime::wake_on_time(),
        Pace::Lockstep => realtime::keep_apart(side), // at once: moved later, it waits for whoever is where it comes to
    }
    Ok(invitation)
}

/// What both roles ask of the system, now that all their shared memory is there.
fn ready(args: &RoleArgs) -> Result<(), Failure> {
    args.system.prepare()?.iter().for_each(tell);
    Ok(())
}

/// Waits for the end of the standard input: whoever started us then listens, or has ended.
fn held(stop: &AtomicBool) {
    let limit = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
    let input = std::io::stdin();
    let is_open = || poll(&mut [PollFd::new(&input, PollFlags::IN)], Some(&limit)).map_or(true, |ends| ends == 0);
    while !stop.load(Relaxed) && is_open() {}
}
