//! Plant and controller as two processes, watched until both have exited. Either may be a foreign program.

use super::args::RunArgs;
use super::monitor::{RunMonitor, check_run};
use crate::children::{self, RoleProcess, SessionCleanup};
use crate::open::open_with_timeout;
use crate::swap::SwapSchedule;
use messages::peer_environment::PeerEnvironment;
use messages::port::{Contract, RecorderPort};
use messages::scene::Scene;
use messages::session::Session;
use shared::args::settings_with_robot;
use shared::exit::{Exit, Failure};
use shared::output::log;
use std::process::Stdio;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Interval at which processes and messages are checked. The buffer of the truth lasts longer.
const POLL_INTERVAL: Duration = Duration::from_millis(2);
/// Interval at which the run checks that the files of the session exist.
const FILES_POLL: Duration = Duration::from_millis(200);
/// Explains missing files of the session.
const FILES_GONE: &str = "no process can join the session any more, because its files are gone from /dev/shm: a user removed them, or logind did \
    at the end of the last login (RemoveIPC, docs/DEPLOY.md)";
/// Time that one role has to exit after the other one has exited with code 0.
const EXIT_TIMEOUT: Duration = Duration::from_secs(1);
/// The same for a plant that has simulated its whole run: a simulator in Python may take seconds to shut down.
const PLANT_EXIT_TIMEOUT: Duration = Duration::from_secs(10);

/// Starts both processes, monitors the run, and reaps them. No process or session file is left when this returns.
///
/// # Errors
/// The first failure of a process, a swap or the monitor.
pub fn run(args: &RunArgs, scene: &Scene, monitor: &mut RunMonitor, stop: &AtomicBool) -> Result<(), Failure> {
    let session = args.session.as_deref().map_or_else(|| Ok(Session::unique()), Session::named)?;
    let already_running = |session: &Session| {
        let words = format!("session `{}` is already running: choose another --session", session.name());
        Failure::new(Exit::Incompatible, words)
    };
    if session.is_running() {
        return Err(already_running(&session));
    }
    let cleanup = SessionCleanup(session);
    let contract = Contract::of(scene, args.pace.pace());
    let bar = monitor.progress.bar.clone();
    let patience = args.pace.patience();
    let environment =
        PeerEnvironment { session: cleanup.0.clone(), contract, patience, scene: scene.clone(), takes_over: false };
    let variables = environment.variables();
    let arguments = |child| [child_arguments(args, &cleanup.0), args.system.for_child(child).arguments()].concat();
    let start = |child: usize| {
        let name = ["plant", "controller"][child];
        match [&args.plant, &args.controller][child] {
            Some(command) => {
                RoleProcess::start_foreign(name, command, &children::environment_variables(&environment)?, &bar)
            }
            None => RoleProcess::start(name, &arguments(child), &variables, Stdio::null(), &bar),
        }
    };
    // Processes start before this one creates any files: if this one is killed at once, they remove the files. Own processes initialize in
    // parallel with this one. The plant is first, because it takes longest; it is held until the recorder is ready. A foreign plant
    // cannot be held, so it starts only then.
    let held = args
        .plant
        .is_none()
        .then(|| RoleProcess::start("plant", &arguments(0), &variables, Stdio::piped(), &bar))
        .transpose()?;
    // If several processes start this session at the same time, one of them becomes its leader and continues.
    let member = cleanup.0.join()?;
    if !member.try_lead() {
        return Err(already_running(&cleanup.0));
    }
    let _share = args.share.open(&cleanup.0)?;
    let controller = scene.controller.is_some().then(|| start(1)).transpose()?;
    let mut port = open_with_timeout(|| RecorderPort::open(&cleanup.0, &contract))?;
    environment.publish()?;
    let mut roles = vec![held.map_or_else(|| start(0), Ok)?];
    roles[0].release();
    roles.extend(controller);
    let mut restarts_left = args.respawn;
    let mut swaps = SwapSchedule::new(&args.swap, &cleanup.0, &contract, patience);
    let start_successor = |command: &str| {
        let environment = PeerEnvironment { takes_over: true, ..environment.clone() };
        RoleProcess::start_foreign("controller", command, &children::environment_variables(&environment)?, &bar)
    };
    let mut controller_exit: Option<Instant> = None;
    let (mut is_gone, mut last_poll) = (false, Instant::now());
    let outcome = loop {
        monitor.drain(&mut port)?;
        if let Err(failure) = check_run(&monitor.recorder, stop) {
            break Err(failure);
        }
        if let Some(controller) = roles.get_mut(1) {
            let now = monitor.latest;
            if let Err(failure) = swaps.poll(&now, controller, start_successor, || drop(monitor.drain(&mut port))) {
                break Err(failure);
            }
        }
        for (child, role) in roles.iter_mut().enumerate() {
            if let Some(cause) = role.crash().filter(|_| restarts_left > 0) {
                if !member.can_be_joined() {
                    log(format_args!("the {} died ({cause}) and cannot be restarted: {FILES_GONE}", role.name));
                    restarts_left = 0;
                    continue;
                }
                restarts_left -= 1;
                bar.suspend(|| {
                    log(format_args!("the {} died ({cause}): restarting it; restarts left: {restarts_left}", role.name))
                });
                *role = start(child)?;
            }
        }
        if !is_gone && last_poll.elapsed() > FILES_POLL {
            (is_gone, last_poll) = (!member.can_be_joined(), Instant::now());
            if is_gone {
                bar.suspend(|| log(format_args!("the run continues, but {FILES_GONE}")));
            }
        }
        // `outcome` does not check again, so a crash since the check above is handled by a restart in the next round.
        // After a failure of one role the other one only waits, so the first failure is the cause.
        if let Some(failure) = roles.iter_mut().find_map(|role| role.outcome().err()) {
            break Err(failure);
        }
        if roles[0].status().is_some() {
            children::wait_for_all(&mut roles, EXIT_TIMEOUT, || ());
            break Ok(());
        }
        let has_exited = roles.get(1).is_some_and(|controller| controller.status().is_some());
        controller_exit = has_exited.then(|| controller_exit.unwrap_or_else(Instant::now));
        let waited = controller_exit.map_or(Duration::ZERO, |since| since.elapsed());
        let is_over = monitor.latest.seq > scene.periods();
        if waited > EXIT_TIMEOUT && !is_over {
            let words = "the controller exited with code 0 before the run was over: it has to answer until the last sensors message";
            break Err(Failure::new(Exit::PeerMissing, words));
        }
        if waited > PLANT_EXIT_TIMEOUT {
            let limit = PLANT_EXIT_TIMEOUT.as_secs();
            let words = format!("the run is complete, but the plant did not exit within {limit} s: it is terminated");
            bar.suspend(|| log(words));
            break Ok(());
        }
        children::sleep_until_exit(&roles, POLL_INTERVAL);
    };
    if let Some(message) = swaps.unfinished() {
        bar.suspend(|| log(message));
    }
    children::terminate_all(&mut roles, || drop(monitor.drain(&mut port)));
    monitor.drain(&mut port)?;
    outcome
}

fn child_arguments(args: &RunArgs, session: &Session) -> Vec<String> {
    let settings = settings_with_robot(&args.scene.robot, &args.scene.settings);
    let settings = settings.into_iter().flat_map(|setting| ["--set".to_string(), setting]);
    let mut arguments = vec![args.scene.scene.clone(), "--session".into(), session.name().into()];
    arguments.extend(["--patience".into(), args.pace.patience.to_string()]);
    if args.pace.realtime {
        arguments.extend(["--realtime".into(), "--speed".into(), args.pace.speed.to_string()]);
    }
    arguments.extend(settings);
    arguments
}
