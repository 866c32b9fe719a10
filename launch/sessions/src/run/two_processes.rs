//! Plant and controller as two processes, watched until both have exited. Either may be a foreign program.

use super::args::RunArgs;
use super::monitor::{RunMonitor, check_run};
use super::role_starter::{CONTROLLER, PLANT, RoleStarter};
use crate::children::{self, RoleProcess, SessionCleanup};
use crate::open::open_with_timeout;
use crate::swap::SwapSchedule;
use messages::peer_environment::PeerEnvironment;
use messages::port::{Contract, RecorderPort};
use messages::scene::Scene;
use messages::session::{Membership, Session};
use shared::exit::{Exit, Failure};
use shared::output::log;
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
    if session.is_running() {
        return Err(already_running(&session));
    }
    let cleanup = SessionCleanup(session);
    let contract = Contract::of(scene, args.pace.pace());
    let bar = &monitor.progress.bar.clone();
    let patience = args.pace.patience();
    let environment =
        &PeerEnvironment { session: cleanup.0.clone(), contract, patience, scene: scene.clone(), takes_over: false };
    let starter = RoleStarter { args, environment, bar };
    // Processes start before this one creates any files: if this one is killed at once, they remove the files. Own processes initialize in
    // parallel with this one. The plant is first, because it takes longest; it is held until the recorder is ready. A foreign plant
    // cannot be held, so it starts only then.
    let held = starter.start_held_plant()?;
    // If several processes start this session at the same time, one of them becomes its leader and continues.
    let member = cleanup.0.join()?;
    if !member.try_lead() {
        return Err(already_running(&cleanup.0));
    }
    let _share = args.share.open(&cleanup.0)?;
    let controller = scene.controller.is_some().then(|| starter.start(CONTROLLER)).transpose()?;
    let mut port = open_with_timeout(|| RecorderPort::open(&cleanup.0, &contract))?;
    environment.publish()?;
    let mut roles = vec![held.map_or_else(|| starter.start(PLANT), Ok)?];
    roles[PLANT].release();
    roles.extend(controller);
    let mut swaps = SwapSchedule::new(&args.swap, &cleanup.0, &contract, patience);
    let mut watch = Watch::new(&starter, &member, scene);
    let outcome = loop {
        monitor.drain(&mut port)?;
        if let Err(failure) = check_run(&monitor.recorder, stop) {
            break Err(failure);
        }
        if let Some(controller) = roles.get_mut(CONTROLLER) {
            let (now, start) = (monitor.latest, |command: &str| starter.start_successor(command));
            if let Err(failure) = swaps.poll(&now, controller, start, || drop(monitor.drain(&mut port))) {
                break Err(failure);
            }
        }
        let command = monitor.recorder.last.as_ref().map(|last| last.truth.command).unwrap_or_default();
        if let Some(sentence) = monitor.set_points.pass_on(monitor.latest.run, &command, &cleanup.0) {
            watch.print(sentence);
        }
        watch.restart_crashed(&mut roles)?;
        watch.report_missing_files();
        if let Some(outcome) = watch.outcome(&mut roles, monitor.latest.seq) {
            break outcome;
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

fn already_running(session: &Session) -> Failure {
    let words = format!("session `{}` is already running: choose another --session", session.name());
    Failure::new(Exit::Incompatible, words)
}

/// Watches the processes of a run and the files of its session.
struct Watch<'a> {
    starter: &'a RoleStarter<'a>,
    member: &'a Membership,
    /// Number of control periods of the scene.
    periods: u64,
    restarts_left: u32,
    /// Whether the files of the session have been removed, and when that was last checked.
    is_gone: bool,
    last_poll: Instant,
    /// When the controller was first seen to have exited.
    controller_exit: Option<Instant>,
}

impl<'a> Watch<'a> {
    fn new(starter: &'a RoleStarter<'a>, member: &'a Membership, scene: &Scene) -> Watch<'a> {
        let (restarts_left, last_poll) = (starter.args.respawn, Instant::now());
        let periods = scene.periods();
        Watch { starter, member, periods, restarts_left, is_gone: false, last_poll, controller_exit: None }
    }

    /// Restarts crashed processes, as often as the user allows.
    fn restart_crashed(&mut self, roles: &mut [RoleProcess]) -> Result<(), Failure> {
        for (index, role) in roles.iter_mut().enumerate() {
            let Some(cause) = role.crash().filter(|_| self.restarts_left > 0) else { continue };
            if !self.member.can_be_joined() {
                log(format_args!("the {} died ({cause}) and cannot be restarted: {FILES_GONE}", role.name));
                self.restarts_left = 0;
                continue;
            }
            self.restarts_left -= 1;
            let left = self.restarts_left;
            self.print(format!("the {} died ({cause}): restarting it; restarts left: {left}", role.name));
            *role = self.starter.start(index)?;
        }
        Ok(())
    }

    /// Reports once that the files of the session have been removed.
    fn report_missing_files(&mut self) {
        if !self.is_gone && self.last_poll.elapsed() > FILES_POLL {
            (self.is_gone, self.last_poll) = (!self.member.can_be_joined(), Instant::now());
            if self.is_gone {
                self.print(format!("the run continues, but {FILES_GONE}"));
            }
        }
    }

    /// The outcome of the run if it has ended. `latest` is the number of the latest truth.
    fn outcome(&mut self, roles: &mut [RoleProcess], latest: u64) -> Option<Result<(), Failure>> {
        // `RoleProcess::outcome` does not check again, so a crash since the check for crashes is handled by a restart in the next round.
        // After a failure of one role the other one only waits, so the first failure is the cause.
        if let Some(failure) = roles.iter_mut().find_map(|role| role.outcome().err()) {
            return Some(Err(failure));
        }
        if roles[PLANT].status().is_some() {
            children::wait_for_all(roles, EXIT_TIMEOUT, || ());
            return Some(Ok(()));
        }
        let has_exited = roles.get(CONTROLLER).is_some_and(|controller| controller.status().is_some());
        self.controller_exit = has_exited.then(|| self.controller_exit.unwrap_or_else(Instant::now));
        let waited = self.controller_exit.map_or(Duration::ZERO, |since| since.elapsed());
        let is_over = latest > self.periods;
        if waited > EXIT_TIMEOUT && !is_over {
            let words = "the controller exited with code 0 before the run was over: it has to answer until the last sensors message";
            return Some(Err(Failure::new(Exit::PeerMissing, words)));
        }
        if waited > PLANT_EXIT_TIMEOUT {
            let limit = PLANT_EXIT_TIMEOUT.as_secs();
            self.print(format!("the run is complete, but the plant did not exit within {limit} s: it is terminated"));
            return Some(Ok(()));
        }
        None
    }

    /// Prints a line above the progress bar.
    fn print(&self, line: String) {
        self.starter.bar.suspend(|| log(line));
    }
}
