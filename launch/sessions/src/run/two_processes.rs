//! Plant and controller as two processes, each of which may be somebody else's program, watched until both have ended.

use super::args::RunArgs;
use super::watch::{Watch, goes_on};
use crate::children::{self, Role, Swept};
use crate::opening::guarded;
use crate::swap::Succession;
use messages::peer_environment::PeerEnvironment;
use messages::port::{Contract, RecorderPort};
use messages::scene::Scene;
use messages::session::Session;
use shared::args::fitted;
use shared::exit::{Exit, Failure};
use shared::output::tell;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// A look at children and progress this often; the truth's buffer holds longer.
const LOOK: Duration = Duration::from_millis(2);
/// The session's files are looked for this often.
const LOOK_AT_FILES: Duration = Duration::from_millis(200);
/// What it means that they are not there.
const GONE: &str = "nobody can join the session any more, for its files are gone from /dev/shm: somebody removed them, or logind did at the \
    end of the last login (RemoveIPC, docs/DEPLOY.md)";
/// Time for the controller to hear the plant's goodbye, or for the plant to end after it.
const GOODBYE: Duration = Duration::from_secs(1);

/// Two processes, started, recorded and reaped; nothing of them is left when this returns.
///
/// # Errors
/// The first failure of either, or of what is watched.
pub fn run(args: &RunArgs, scene: &Scene, watch: &mut Watch, stop: &AtomicBool) -> Result<(), Failure> {
    let session = args.session.as_deref().map_or_else(|| Ok(Session::unique()), Session::named)?;
    let taken = |session: &Session| {
        let words = format!("session `{}` is running already: use another --session", session.name());
        Failure::new(Exit::Incompatible, words)
    };
    if session.is_running() {
        return Err(taken(&session));
    }
    let swept = Swept(session);
    let contract = Contract::of(scene, args.pace.pace());
    let bar = watch.progress.bar.clone();
    let patience = args.pace.patience();
    let invitation =
        PeerEnvironment { session: swept.0.clone(), contract, patience, scene: scene.clone(), takes_over: false };
    let arguments = |child| [child_arguments(args, &swept.0), args.system.of_child(child).arguments()].concat();
    let start = |child: usize| {
        let name = ["plant", "controller"][child];
        match [&args.plant, &args.controller][child] {
            Some(command) => Role::foreign(name, command, &children::environment(&invitation)?, &bar),
            None => Role::start(name, &arguments(child), &bar),
        }
    };
    // Before there are any files: if we are killed at once, they clear up. Ours get ready while we do, the plant first, which
    // takes longest; it speaks, and anybody else's begins, when we listen.
    let held = args.plant.is_none().then(|| Role::hold("plant", &arguments(0), &bar)).transpose()?;
    // Of those who start this session at once, one goes on.
    let member = swept.0.join()?;
    if !member.try_lead() {
        return Err(taken(&swept.0));
    }
    let controller = scene.controller.is_some().then(|| start(1)).transpose()?;
    let mut port = guarded(|| RecorderPort::open(&swept.0, &contract))?;
    invitation.publish()?;
    let mut roles = vec![held.map_or_else(|| start(0), Ok)?];
    roles[0].begin();
    roles.extend(controller);
    let mut lives = args.respawn;
    let mut succession = Succession::new(&args.swap, &swept.0, &contract, patience);
    let succeed = |command: &str| {
        let heir = PeerEnvironment { takes_over: true, ..invitation.clone() };
        Role::foreign("controller", command, &children::environment(&heir)?, &bar)
    };
    let mut left_alone: Option<Instant> = None;
    let (mut is_gone, mut looked) = (false, Instant::now());
    let outcome = loop {
        watch.drain(&mut port)?;
        if let Err(failure) = goes_on(&watch.recorder, stop) {
            break Err(failure);
        }
        if let Some(incumbent) = roles.get_mut(1) {
            let now = watch.latest;
            if let Err(failure) = succession.look(&now, incumbent, succeed, || drop(watch.drain(&mut port))) {
                break Err(failure);
            }
        }
        for (child, role) in roles.iter_mut().enumerate() {
            if let Some(cause) = role.death().filter(|_| lives > 0) {
                if !member.can_be_joined() {
                    tell(format_args!("the {} died ({cause}) and cannot be started anew: {GONE}", role.name));
                    lives = 0;
                    continue;
                }
                lives -= 1;
                bar.suspend(|| {
                    tell(format_args!("the {} died ({cause}): starting it anew; times left: {lives}", role.name))
                });
                *role = start(child)?;
            }
        }
        if !is_gone && looked.elapsed() > LOOK_AT_FILES {
            (is_gone, looked) = (!member.can_be_joined(), Instant::now());
            if is_gone {
                bar.suspend(|| tell(format_args!("the run goes on, but {GONE}")));
            }
        }
        // No second look: who has died since is started anew next time.
        // A controller that fails leaves the plant waiting, and the other way round: the first to fail is to blame.
        if let Some(failure) = roles.iter_mut().find_map(|role| role.verdict().err()) {
            break Err(failure);
        }
        if roles[0].status().is_some() {
            children::wait(&mut roles, GOODBYE, || ());
            break Ok(());
        }
        let is_alone = roles.get(1).is_some_and(|controller| controller.status().is_some());
        left_alone = is_alone.then(|| left_alone.unwrap_or_else(Instant::now));
        if left_alone.is_some_and(|since| since.elapsed() > GOODBYE) {
            let words = "the controller ended, with code 0, before the run did: it has to answer until it is told that all is over";
            break Err(Failure::new(Exit::PeerMissing, words));
        }
        children::rest(&roles, LOOK);
    };
    if let Some(rest) = succession.rest() {
        bar.suspend(|| tell(rest));
    }
    children::end(&mut roles, || drop(watch.drain(&mut port)));
    watch.drain(&mut port)?;
    outcome
}

fn child_arguments(args: &RunArgs, session: &Session) -> Vec<String> {
    let settings = fitted(&args.scene.robot, &args.scene.settings);
    let settings = settings.into_iter().flat_map(|setting| ["--set".to_string(), setting]);
    let mut arguments = vec![args.scene.scene.clone(), "--session".into(), session.name().into()];
    arguments.extend(["--patience".into(), args.pace.patience.to_string()]);
    if args.pace.realtime {
        arguments.extend(["--realtime".into(), "--speed".into(), args.pace.speed.to_string()]);
    }
    arguments.extend(settings);
    arguments
}
