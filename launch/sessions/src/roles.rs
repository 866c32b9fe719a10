//! `biped plant` and `biped controller`: the two roles, started by hand, by `biped run`, or in place of a foreign program.

use crate::children;
use crate::open::open_with_timeout;
use crate::realtime;
use crate::run::warn_of_duration;
use crate::share::ShareArgs;
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use controller::process::ProcessError;
use messages::controller_session::ControllerSessionError;
use messages::legible;
use messages::peer_environment::PeerEnvironment;
use messages::port::{Contract, ControllerPort, Pace, PlantPort, PortError};
use messages::session::Session;
use messages::wire::Truth;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use shared::args::PaceArgs;
use shared::args::SceneArgs;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::interrupt::UnderWay;
use shared::output::{log, print_text};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Arguments of `biped plant`.
#[derive(Args)]
pub struct PlantArgs {
    #[command(flatten)]
    role: RoleArgs,
    #[command(flatten)]
    share: ShareArgs,
}

/// Arguments of `biped controller`, and most of those of `biped plant`.
#[derive(Args)]
pub struct RoleArgs {
    /// Built-in scene (see `biped list`) or path of a TOML file. Without it, session and scene come from the environment
    /// variables that `biped run --controller` and `--plant` set
    scene: Option<String>,
    /// Use the robot of this TOML or URDF file; the scene is scaled to it
    #[arg(long, value_name = "FILE", requires = "scene", value_parser = NonEmptyStringValueParser::new())]
    robot: Option<String>,
    /// Replace a value of the scene, for example plant.friction=0.3 (see `biped list --keys`); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scene")]
    settings: Vec<String>,
    #[command(flatten)]
    pace: PaceArgs,
    #[command(flatten)]
    system: realtime::RealtimeArgs,
    /// Name of the session that plant and controller share, `biped` by default; without a scene, a running session to attach to
    #[arg(long)]
    session: Option<String>,
    /// Prepare the session for `biped tunnel`, which connects it with another machine
    #[arg(long, requires = "scene")]
    tunnel: bool,
    /// ID of the parent process: this process dies with it
    #[arg(long, hide = true)]
    parent: Option<i32>,
}

impl RoleArgs {
    /// Whether somebody started this process in a terminal, and no launcher reports how the run ends.
    fn is_by_hand(&self) -> bool {
        self.parent.is_none() && (self.scene.is_some() || self.session.is_some())
    }

    /// Whether a run started this process by a command, as any other program, and asks it by TERM to leave.
    fn is_a_program_of_a_run(&self) -> bool {
        self.parent.is_none() && !self.is_by_hand()
    }

    /// The session and the scene: from the arguments, from a running session of that name, or from the environment variables. A child of
    /// `biped run` gets the scene that its launcher has read, which may have come through a pipe.
    fn environment(&self, stop: &AtomicBool) -> Result<PeerEnvironment, Failure> {
        let keeps_waiting = || !stop.load(Relaxed);
        let is_given = self.parent.is_some() && PeerEnvironment::is_given();
        let environment = match (self.scene.as_ref().filter(|_| !is_given), self.session.as_ref().filter(|_| !is_given))
        {
            (None, None) if std::env::var_os("BIPED_SESSION").is_none() => {
                return Err(Failure::new(Exit::Usage, NO_SCENE));
            }
            (None, None) => PeerEnvironment::from_env(keeps_waiting),
            (None, Some(session)) => PeerEnvironment::attach(session, self.pace.patience(), keeps_waiting),
            (Some(scene), session) => {
                let (robot, settings) = (self.robot.clone(), self.settings.clone());
                let scene = SceneArgs { scene: scene.clone(), robot, settings }.load()?;
                warn_of_duration(&scene);
                let contract = Contract::of(&scene, self.pace.pace()).with_tunnel(self.tunnel);
                let session = Session::named(session.map_or(SESSION, String::as_str))?;
                Ok(PeerEnvironment { session, contract, patience: self.pace.patience(), scene, takes_over: false })
            }
        };
        check_interrupt(stop)?;
        Ok(environment?)
    }
}

const NO_SCENE: &str = "there is no scene: `biped plant walk` and `biped controller walk`, in two terminals, run the scene `walk`; \
                        --session NAME without a scene attaches to a running session";

/// Default name of the session.
const SESSION: &str = "biped";

/// `biped plant`.
///
/// # Errors
/// Why the role failed, with an exit code.
pub fn plant(PlantArgs { role: args, share }: &PlantArgs, stop: &Arc<AtomicBool>) -> Result<(), Failure> {
    share.check(true)?;
    let (environment, shared) = prepare(args, 0, stop)?;
    let PeerEnvironment { session, contract, patience, scene, .. } = &environment;
    let rival = if args.parent.is_some() { RIVAL_TIMEOUT } else { Duration::ZERO };
    let port = open_with_timeout(|| open_plant(session, contract, rival, stop))?.sharing(shared);
    environment.publish()?;
    let _share = share.open(session)?;
    apply_realtime(args)?;
    if args.parent.is_some() {
        wait_for_release(stop);
    }
    let options = plant::process::Options { pace: contract.pace, speed: args.pace.speed, patience: *patience };
    let under_way = UnderWay::begin("`biped clean` has to remove the files of its session");
    let (tally, result) = plant::process::run(scene, port, options, stop);
    drop(under_way);
    let counts = tally.to_string();
    if !counts.is_empty() {
        log(counts);
    }
    let end = result?;
    if args.is_by_hand() {
        print_text(outcome(&end));
    }
    Ok(())
}

/// What somebody who started the plant by hand sees at its end.
fn outcome(end: &Truth) -> String {
    let ([x, y, z], time) = (end.base_position, legible(Duration::from_nanos(end.stamp.sim_ns).as_secs_f64()));
    format!("the scene ended at {time} s: base at {x:.3}, {y:.3}, {z:.3} m, trajectory hash {:016x}\n", end.hash)
}

/// Time that the plant of a rival launcher has to end. It takes milliseconds.
const RIVAL_TIMEOUT: Duration = Duration::from_secs(2);
/// Interval at which this plant tries again meanwhile.
const RIVAL_POLL: Duration = Duration::from_millis(2);

/// Opens the plant's port. If several launchers start one session at the same time, each starts a plant. All but one launcher are refused,
/// and end theirs. The remaining plant waits for that, for at most `timeout`. It opens the session anew each time, because only a new
/// node removes the files of a plant that was killed.
fn open_plant(
    session: &Session,
    contract: &Contract,
    timeout: Duration,
    stop: &Arc<AtomicBool>,
) -> Result<PlantPort, PortError> {
    let start = Instant::now();
    loop {
        match PlantPort::open_with_stop(session, contract, stop.clone()) {
            Err(PortError::Taken { .. }) if start.elapsed() < timeout => std::thread::sleep(RIVAL_POLL),
            opened => return opened,
        }
    }
}

/// `biped controller`.
///
/// # Errors
/// Why the role failed, with an exit code.
pub fn controller(args: &RoleArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let (environment, shared) = prepare(args, 1, stop)?;
    let PeerEnvironment { session, contract, patience, scene, takes_over } = environment;
    let port = match takes_over {
        true => ControllerPort::open_when_free(&session, &contract, || !stop.load(Relaxed))?,
        false => open_with_timeout(|| ControllerPort::open(&session, &contract))?,
    };
    apply_realtime(args)?;
    match controller::process::run(&scene, port.sharing(shared), patience, stop) {
        Err(ProcessError::Session(ControllerSessionError::Interrupted)) if args.is_a_program_of_a_run() => {
            return Err(Failure::silent_interruption());
        }
        ended => ended?,
    }
    if args.is_by_hand() {
        print_text("the plant has ended the run\n");
    }
    Ok(())
}

/// The common start of both roles, plant (0) and controller (1): session, scene, parent, processors. Also returns the processor that
/// both sides share while the machine is busy.
fn prepare(args: &RoleArgs, side: usize, stop: &AtomicBool) -> Result<(PeerEnvironment, Option<usize>), Failure> {
    let environment = args.environment(stop)?;
    if let Some(parent) = args.parent {
        // If the parent is already dead, this process may be the last one that can remove the files.
        children::die_with_parent(parent).inspect_err(|_| environment.session.remove_files())?;
    }
    args.system.check_pace(environment.contract.pace)?;
    let shared = match environment.contract.pace {
        Pace::RealTime => {
            realtime::minimize_timer_slack();
            None
        }
        Pace::Lockstep if args.system.names_processor() => None,
        // First, because a thread that moves later has to wait.
        Pace::Lockstep => realtime::pin_to_half(side, &environment.session),
    };
    Ok((environment, shared))
}

/// Applies the real-time settings. Call it when all shared memory is mapped, so that it is locked too.
fn apply_realtime(args: &RoleArgs) -> Result<(), Failure> {
    args.system.apply()?.iter().for_each(log);
    Ok(())
}

/// Interval at which a held plant checks whether the user has interrupted it: 100 ms.
const STOP_POLL: Timespec = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };

/// Waits until standard input is closed: the parent is then ready to record, or has exited.
fn wait_for_release(stop: &AtomicBool) {
    let input = std::io::stdin();
    let is_open = || poll(&mut [PollFd::new(&input, PollFlags::IN)], Some(&STOP_POLL)).map_or(true, |ready| ready == 0);
    while !stop.load(Relaxed) && is_open() {}
}
