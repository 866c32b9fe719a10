//! Claims about the processes: same results however they are started, an orderly end however they end.

#![expect(clippy::expect_used, reason = "a test may panic")]

use messages::port::{Contract, ControllerPort, Pace, PlantPort};
use messages::scene::{ControllerScene, Scene};
use messages::session::Session;
use messages::wire::{Command as Torque, Stamp, Torques};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for anything here: far more than it takes on a busy machine.
const LONG: Duration = Duration::from_secs(60);

fn biped(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn start(arguments: &[&str]) -> Child {
    biped(arguments).spawn().expect("the program starts")
}

/// Exit code and what was written to standard error.
fn end(child: Child) -> (Option<i32>, String) {
    let Output { status, stderr, .. } = child.wait_with_output().expect("the program ends");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < LONG, "{what} did not come true");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn fresh_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("biped-test-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// A session that only this test uses.
fn session(name: &str) -> Session {
    Session::named(&format!("test-{}-{name}", std::process::id())).expect("a good name")
}

/// A child of `biped run`.
struct Role {
    name: String,
    number: i32,
    session: Session,
}

/// The running children of a process that are already plant or controller.
fn roles_of(launcher: u32) -> Vec<Role> {
    let list = std::fs::read_to_string(format!("/proc/{launcher}/task/{launcher}/children")).unwrap_or_default();
    let role = |number: &str| {
        let line = std::fs::read_to_string(format!("/proc/{number}/cmdline")).ok()?;
        let words: Vec<_> = line.split('\0').collect();
        let session = words.iter().position(|word| *word == "--session")?;
        let session = Session::named(words.get(session + 1)?).ok()?;
        Some(Role { name: words[1].into(), number: number.parse().ok()?, session })
    };
    list.split_whitespace().filter_map(role).collect()
}

fn is_running(number: i32) -> bool {
    // A zombie has ended, even if nobody in this container reaps orphans.
    let stat = std::fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.trim().starts_with('Z'))
}

/// A long real-time run that has begun to walk, with its two children.
fn walking() -> (Child, Vec<Role>) {
    let launcher = start(&["run", "walk", "--realtime", "--quiet", "--set", "duration=300"]);
    let mut roles = vec![];
    eventually("two processes that speak", || {
        roles = roles_of(launcher.id());
        roles.len() == 2 && roles[0].session.leftovers().len() > 10
    });
    std::thread::sleep(Duration::from_millis(200));
    (launcher, roles)
}

fn all_gone(roles: &[Role]) {
    eventually("the end of the processes", || !roles.iter().any(|role| is_running(role.number)));
    assert_eq!(roles[0].session.leftovers(), Vec::<PathBuf>::new());
}

fn send(number: i32, signal: Signal) {
    kill(Pid::from_raw(number), signal).expect("a signal to our own child");
}

fn trajectory_hash(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    json["trajectory_hash"].as_str().expect("a hash").to_string()
}

#[test]
fn two_processes_walk_bit_for_bit_like_one_and_like_themselves() {
    let run = |name: &str, extra: &[&str]| {
        let folder = fresh_folder(name);
        let out = folder.to_string_lossy().into_owned();
        let arguments = ["run", "walk", "--quiet", "--set", "duration=3", "--out", out.as_str()];
        assert_eq!(end(start(&[&arguments, extra].concat())), (Some(0), String::new()), "{name}");
        let hash = trajectory_hash(&folder);
        std::fs::remove_dir_all(folder).expect("our own folder");
        hash
    };
    let two = run("two", &[]);
    assert_eq!(run("again", &[]), two);
    assert_eq!(run("one", &["--in-process"]), two);
    assert_ne!(run("other", &["--set", "plant.friction=0.69"]), two, "the hash must see a difference");
}

#[test]
fn sessions_side_by_side_never_meet_and_a_name_is_taken_once() {
    let folders = ["alone", "left", "right"].map(fresh_folder);
    let walk = |folder: &Path, extra: &[&str]| {
        let out = folder.to_string_lossy().into_owned();
        start(&[&["run", "walk", "--quiet", "--set", "duration=100", "--out", &out], extra].concat())
    };
    assert_eq!(end(walk(&folders[0], &["--in-process"])), (Some(0), String::new()));
    let (left, right) = (session("left"), session("right"));
    let runs = [walk(&folders[1], &["--session", left.name()]), walk(&folders[2], &["--session", right.name()])];
    eventually("both sessions", || left.members().len() == 3 && right.members().len() == 3);
    let (code, errors) = end(start(&["run", "walk", "--quiet", "--session", left.name()]));
    assert_eq!(code, Some(5), "{errors}");
    assert!(errors.contains(left.name()) && errors.contains("running already"), "{errors}");
    for run in runs {
        assert_eq!(end(run), (Some(0), String::new()));
    }
    let hashes = folders.each_ref().map(|folder| trajectory_hash(folder));
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    assert_eq!((left.leftovers(), right.leftovers()), (vec![], vec![]));
    folders.iter().for_each(|folder| std::fs::remove_dir_all(folder).expect("our own folder"));
}

#[test]
fn a_run_that_ends_by_itself_leaves_nothing_behind() {
    let launcher = start(&["run", "walk", "--realtime", "--quiet", "--set", "duration=1"]);
    let mut roles = vec![];
    eventually("two processes", || {
        roles = roles_of(launcher.id());
        roles.len() == 2
    });
    assert_eq!(end(launcher).0, Some(0));
    all_gone(&roles);
}

#[test]
fn the_written_scene_is_the_same_run_again() {
    let (first, second) = (fresh_folder("first"), fresh_folder("second"));
    let paths = [&first, &second].map(|folder| folder.to_string_lossy().into_owned());
    let scene = format!("{}/scene.toml", paths[0]);
    let settings = ["--in-process", "--quiet", "--set", "duration=1", "--set", "plant.payload_kg=1"];
    assert_eq!(end(start(&[&["run", "walk", "--out", &paths[0]], &settings[..]].concat())).0, Some(0));
    assert_eq!(end(start(&["run", &scene, "--in-process", "--quiet", "--out", &paths[1]])).0, Some(0));
    assert_eq!(trajectory_hash(&first), trajectory_hash(&second));
    [first, second].iter().for_each(|folder| std::fs::remove_dir_all(folder).expect("our own folder"));
}

#[test]
fn plant_and_controller_start_by_hand_in_either_order() {
    for roles in [["plant", "controller"], ["controller", "plant"]] {
        let session = session(roles[0]);
        let arguments = |role| [role, "walk", "--set", "duration=0.5", "--session", session.name()];
        let first = start(&arguments(roles[0]));
        eventually("the first process's session", || session.leftovers().len() > 5);
        let second = start(&arguments(roles[1]));
        assert_eq!(end(first), (Some(0), String::new()), "{} first", roles[0]);
        assert_eq!(end(second), (Some(0), String::new()), "{} second", roles[1]);
        assert_eq!(session.leftovers(), Vec::<PathBuf>::new());
    }
}

#[test]
fn a_controller_does_not_wait_for_a_plant_that_cannot_begin() {
    let session = session("cannot");
    let bad = ["--set", "plant.law=EnergyQp", "--set", "plant.method=EventDriven", "--session", session.name()];
    let controller = start(&[&["controller", "walk", "--patience", "50"], &bad[..]].concat());
    eventually("the controller's session", || session.leftovers().len() > 5);
    let begun = Instant::now();
    let (code, errors) = end(start(&[&["plant", "walk"], &bad[..]].concat()));
    assert!(code == Some(4) && errors.contains("plant.law of the method EventDriven"), "{errors}");
    assert_eq!(end(controller).0, Some(0));
    assert!(begun.elapsed() < Duration::from_secs(40), "it waited out its patience");
    assert_eq!(session.leftovers(), Vec::<PathBuf>::new());
}

#[test]
fn ctrl_c_and_term_end_everything_in_order() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let (launcher, roles) = walking();
        send(launcher.id() as i32, signal);
        let (code, errors) = end(launcher);
        assert_eq!(code, Some(130), "{errors}");
        assert!(errors.contains("interrupted"), "{errors}");
        all_gone(&roles);
    }
}

#[test]
fn children_die_with_a_killed_launcher_and_the_last_one_clears_up() {
    let (mut launcher, roles) = walking();
    launcher.kill().expect("our own child");
    launcher.wait().expect("the launcher ends");
    all_gone(&roles);
}

#[test]
fn a_killed_child_is_named_and_the_other_is_ended() {
    for role in ["plant", "controller"] {
        let (launcher, roles) = walking();
        let victim = roles.iter().find(|child| child.name == role).expect("the role is there");
        send(victim.number, Signal::SIGKILL);
        let (code, errors) = end(launcher);
        assert_eq!(code, Some(4), "{errors}");
        assert!(errors.contains(&format!("the {role} failed")) && errors.contains("SIGKILL"), "{errors}");
        all_gone(&roles);
    }
}

#[test]
fn a_stopped_controller_is_a_fault_in_real_time() {
    let (launcher, roles) = walking();
    let victim = roles.iter().find(|child| child.name == "controller").expect("a controller");
    send(victim.number, Signal::SIGSTOP);
    let (code, errors) = end(launcher);
    assert!(code == Some(4) || code == Some(7), "{code:?} {errors}");
    assert!(errors.contains("silent") && errors.contains("damped"), "{errors}");
    all_gone(&roles);
}

#[test]
fn a_peer_that_never_comes_is_named_each_second_and_then_given_up() {
    for (role, missing) in [("plant", "controller"), ("controller", "plant")] {
        let session = session(&format!("lonely-{role}"));
        let (code, errors) = end(start(&[role, "walk", "--patience", "2.5", "--session", session.name()]));
        assert_eq!(code, Some(3), "{errors}");
        for second in 1..=2 {
            assert!(errors.contains(&format!("waiting for the {missing}: {second} of 2.5 s")), "{errors}");
        }
        assert!(errors.contains(&format!("no {missing}")), "{errors}");
        assert_eq!(session.leftovers(), Vec::<PathBuf>::new());
    }
}

#[test]
fn a_second_controller_and_a_wrong_wire_version_are_refused() {
    let session = session("taken");
    let scene = Scene { controller: Some(ControllerScene::default()), ..Scene::default() };
    let ours = Contract::of(&scene, Pace::Lockstep);
    let file = fresh_folder("scene").with_extension("toml");
    std::fs::write(&file, "[controller]\n").expect("a scene file");
    let path = file.to_string_lossy().into_owned();
    let port = ControllerPort::open(&session, &ours).expect("controller");
    let (code, errors) = end(start(&["controller", &path, "--session", session.name()]));
    assert_eq!(code, Some(5), "{errors}");
    assert!(errors.contains("already has a controller"), "{errors}");
    drop(port);
    let port = PlantPort::open(&session, &Contract { schema: ours.schema ^ 1, ..ours }).expect("plant");
    let (code, errors) = end(start(&["controller", &path, "--session", session.name()]));
    assert_eq!(code, Some(5), "{errors}");
    for word in ["wire schema", &format!("{:016x}", ours.schema), &format!("{:016x}", ours.schema ^ 1)] {
        assert!(errors.contains(word), "{errors} does not say {word}");
    }
    drop(port);
    assert_eq!(session.leftovers(), Vec::<PathBuf>::new());
    std::fs::remove_file(file).expect("our own file");
}

/// A controller of somebody else's making, which answers as `answer` says, until the plant gives it up.
fn odd_controller(name: &str, answer: impl Fn(&Stamp) -> Torque) -> (Option<i32>, String) {
    let session = session(name);
    let file = fresh_folder(name).with_extension("toml");
    std::fs::write(&file, "[initial]\nclearance = 0.0\n[controller]\n").expect("a scene file");
    let path = file.to_string_lossy().into_owned();
    let scene = messages::load::load(&path, &[], &[]).expect("a good scene");
    let mut port = ControllerPort::open(&session, &Contract::of(&scene, Pace::Lockstep)).expect("controller");
    let plant = start(&["plant", &path, "--patience", "1", "--session", session.name()]);
    let begin = Instant::now();
    loop {
        assert!(begin.elapsed() < LONG, "the plant never said goodbye");
        match port.wait().expect("waiting") {
            Some(sensors) if sensors.last != 0 => break,
            Some(sensors) => port.send(answer(&sensors.stamp)).expect("answering"),
            None => (),
        }
    }
    std::fs::remove_file(file).expect("our own file");
    end(plant)
}

/// The stamp of a right answer.
fn reply(asked: &Stamp) -> Stamp {
    Stamp { run: asked.run, seq: asked.seq, ack: asked.seq, ..Stamp::default() }
}

fn limp(asked: &Stamp) -> Torque {
    Torque { stamp: reply(asked), ..Torque::default() }
}

#[test]
fn bad_commands_never_reach_the_robot_and_are_told_by_reason() {
    type Answer = fn(&Stamp) -> Torque;
    let cases: [(&str, &str, Answer); 4] = [
        ("nan", "not finite", |asked| Torque { torques: Torques { torque: [f64::NAN; 8] }, ..limp(asked) }),
        ("run", "for another run", |asked| Torque { stamp: Stamp { run: 1, ..reply(asked) }, ..limp(asked) }),
        ("huge", "four times", |asked| Torque { torques: Torques { torque: [1e9; 8] }, ..limp(asked) }),
        ("early", "ahead", |asked| Torque { stamp: Stamp { ack: 9, ..reply(asked) }, ..limp(asked) }),
    ];
    for (name, words, answer) in cases {
        let (code, errors) = odd_controller(name, answer);
        assert_eq!(code, Some(3), "{name}: {errors}");
        assert!(errors.contains("refused: ") && errors.contains(words), "{name}: {errors}");
    }
}

#[test]
fn any_program_that_speaks_the_messages_can_be_the_controller() {
    assert_eq!(odd_controller("limp", limp), (Some(0), String::new()));
}

#[test]
fn a_scene_without_a_controller_runs_in_one_process() {
    let folder = fresh_folder("slide");
    let out = folder.to_string_lossy().into_owned();
    assert_eq!(end(start(&["run", "slide", "--quiet", "--out", &out])), (Some(0), String::new()));
    let two = trajectory_hash(&folder);
    assert_eq!(end(start(&["run", "slide", "--quiet", "--in-process", "--out", &out])), (Some(0), String::new()));
    assert_eq!(trajectory_hash(&folder), two);
    std::fs::remove_dir_all(folder).expect("our own folder");
}
