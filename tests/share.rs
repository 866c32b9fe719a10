//! Claims about `--share GROUP`: the members of a group reach the session of another user, and nobody else does.

#![expect(clippy::expect_used, reason = "a test may panic")]

use nix::sys::signal::{Signal, kill};
use nix::unistd::{Pid, getuid};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A group, and numbers of users that no system gives to anybody.
const GROUP: u32 = 61_777;
const OWNER: u32 = 61_001;
const MEMBER: u32 = 61_002;
const STRANGER: u32 = 61_003;
/// Longest wait for any condition: far more than a busy machine needs.
const LONG: Duration = Duration::from_secs(60);

/// A folder with a copy of the program, which every user can enter.
struct Place {
    folder: PathBuf,
}

impl Place {
    /// `None` if this test may not act as other users.
    fn new(name: &str) -> Option<Place> {
        if !getuid().is_root() {
            println!("NOT CHECKED: only root can take the part of several users");
            return None;
        }
        let folder = std::env::temp_dir().join(format!("biped-share-{}-{name}", std::process::id()));
        std::fs::create_dir(&folder).expect("a folder");
        chown(&folder, Some(OWNER), Some(OWNER)).expect("root may");
        std::fs::set_permissions(&folder, PermissionsExt::from_mode(0o755)).expect("root may");
        // Another process copies the file. If this process had it open for writing, a child of another test could inherit the open file,
        // and Linux does not execute a file that is open for writing.
        let copied = Command::new("cp").arg(env!("CARGO_BIN_EXE_biped")).arg(&folder).status().expect("cp runs");
        assert!(copied.success());
        Some(Place { folder })
    }

    /// The program, as this user in this group.
    fn biped(&self, (user, group): (u32, u32), arguments: &[&str]) -> Command {
        let mut command = Command::new(self.folder.join("biped"));
        command.args(arguments).uid(user).gid(group).current_dir(&self.folder);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Exit code and printed text of the program.
    fn run(&self, user: (u32, u32), arguments: &[&str]) -> (Option<i32>, String) {
        let Output { status, stdout, stderr } = self.biped(user, arguments).output().expect("the program runs");
        (status.code(), String::from_utf8_lossy(&[stdout, stderr].concat()).into_owned())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.folder).expect("our own");
    }
}

/// Names of the owner's files in shared memory.
fn files_of_owner() -> Vec<PathBuf> {
    let entries = std::fs::read_dir("/dev/shm").expect("shared memory").flatten().map(|entry| entry.path());
    entries.filter(|path| path.symlink_metadata().is_ok_and(|found| found.uid() == OWNER)).collect()
}

fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < LONG, "{what}: not within {LONG:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn signal(child: &Child, signal: Signal) {
    kill(Pid::from_raw(child.id() as i32), signal).expect("a signal to our own child");
}

/// Ends a program in order, and returns its exit code and standard error.
fn interrupt(child: Child) -> (Option<i32>, String) {
    signal(&child, Signal::SIGINT);
    let Output { status, stderr, .. } = child.wait_with_output().expect("the program ends");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

/// The answer to a request that no program of this version sends.
fn answer_to(socket: &Path, line: &[u8]) -> String {
    let mut stream = UnixStream::connect(socket).expect("root may enter");
    let _ = stream.write_all(line); // the other side may refuse before it has read everything
    let mut answer = String::new();
    let _ = stream.read_to_string(&mut answer);
    answer
}

/// The claims share users and their files, so they are made one after the other.
#[test]
fn members_of_the_group_reach_a_shared_session_and_nobody_else_does() {
    let Some(place) = Place::new("walk") else { return };
    let (owner, member, stranger) = ((OWNER, GROUP), (MEMBER, GROUP), (STRANGER, STRANGER));
    let group = GROUP.to_string();
    let name = format!("share-{}", std::process::id());
    let full = format!("{OWNER}/{name}");
    let walk = ["run", "walk", "--realtime", "--quiet", "--set", "duration=600", "--session", &name];
    let shared = [&walk[..], &["--share", &group, "--out", "out", "--record", "walk.mcap"]].concat();
    let launcher = place.biped(owner, &shared).spawn().expect("the program starts");
    eventually("a shared session", || {
        ["resume", "set --speed 0.2"].iter().all(|command| {
            let command: Vec<&str> = command.split(' ').chain(["--session", &full]).collect();
            place.run(member, &command).0 == Some(0)
        })
    });
    for (command, words) in [
        ("push 0,0.1,0 --body trunk", "trunk gets 0,0.1,0 N·s"),
        ("pause", ", paused"),
        ("step 3", ", paused"),
        ("resume", "t "),
        ("rearm", "t "),
        ("set --speed 0.1", "set at t "),
    ] {
        for session in [&full, &name] {
            let command: Vec<&str> = command.split(' ').chain(["--session", session]).collect();
            let (code, printed) = place.run(member, &command);
            assert!(code == Some(0) && printed.contains(words), "{command:?}: {code:?} {printed}");
            let (code, printed) = place.run(stranger, &command);
            let sentence = format!(
                "error: session `{name}` belongs to {OWNER}, who shares it with group {GROUP}; {STRANGER} is not a member\n"
            );
            assert_eq!((code, printed), (Some(2), sentence));
        }
    }
    for (command, words) in [
        ("push 0,1,0 --body torso", "the scene has no body `torso`; its bodies are "),
        ("push 5000,0,0", "from -1000 to 1000 N·s"),
        ("set --speed 99", "the controller of session"),
    ] {
        let command: Vec<&str> = command.split(' ').chain(["--session", &full]).collect();
        let (code, printed) = place.run(member, &command);
        assert!(code == Some(2) && printed.contains(words) && printed.lines().count() == 1, "{command:?}: {printed}");
    }
    // Files of the session stay private, and the socket is for the group.
    let modes = |end: &str| {
        let found = files_of_owner().into_iter().find(|path| path.to_string_lossy().ends_with(end)).expect(end);
        (found.clone(), found.metadata().expect("there").mode() & 0o777, found.metadata().expect("there").gid())
    };
    assert_eq!(modes("members").1, 0o600);
    let (folder, mode, gid) = modes("share");
    assert_eq!((mode, gid), (0o750, GROUP));
    // Several users watch at the same time. In lockstep the plant waits for its observers, so this also claims that the lines are read.
    let mut watchers = [0, 1, 2, 3].map(|_| {
        let mut watcher = place.biped(member, &["top", "--session", &full]).spawn().expect("the program starts");
        let lines = BufReader::new(watcher.stdout.take().expect("a pipe")).lines();
        (watcher, lines)
    });
    for (_, lines) in &mut watchers {
        let line = lines.find(|line| line.as_ref().is_ok_and(|line| line.starts_with("t "))).expect("a line");
        assert!(line.expect("text").contains(" m/s"));
    }
    let socket = folder.join("desk");
    for (line, words) in [
        (b"{\"schema\":1,\"wanted\":\"pause\"}\n".to_vec(), "use the same version"),
        (b"push 0,1,0\n".to_vec(), "the request cannot be read"),
        (vec![b'x'; 100_000], "no line of at most 4096 bytes"),
        (vec![0xff, b'\n'], "it is not text"),
    ] {
        let answer = answer_to(&socket, &line);
        assert!(answer.contains(words), "{answer}");
    }
    // Connections that send nothing do not block others for ever.
    let silent: Vec<_> = (0..8).map(|_| UnixStream::connect(&socket).expect("root may enter")).collect();
    eventually("a free place", || place.run(member, &["rearm", "--session", &full]).0 == Some(0));
    drop(silent);
    // Ctrl-C ends the wait for an answer that cannot come.
    let owners_process = launcher.id().to_string();
    signal(&launcher, Signal::SIGSTOP);
    let waiting = place.biped(member, &["rearm", "--session", &full]).spawn().expect("the program starts");
    std::thread::sleep(Duration::from_millis(500)); // until it has installed its handler
    let (code, errors) = interrupt(waiting);
    assert_eq!((code, errors.as_str()), (Some(130), "error: interrupted\n"));
    signal(&launcher, Signal::SIGCONT);
    // The system refuses the thread of a request.
    let mut limit = Command::new("prlimit");
    limit.args(["--nproc=1:", "--pid", &owners_process]).uid(OWNER).gid(GROUP); // root may lack the right
    assert!(limit.status().expect("prlimit runs").success());
    let (code, printed) = place.run(member, &["rearm", "--session", &full]);
    assert!(code == Some(4) && printed.contains("a thread cannot be started"), "{code:?} {printed}");
    let (code, errors) = interrupt(launcher);
    assert_eq!(code, Some(130), "{errors}");
    for (mut watcher, _) in watchers {
        assert_eq!(watcher.wait().expect("our own child").code(), Some(0));
    }
    assert_eq!(files_of_owner(), Vec::<PathBuf>::new());
    let summary = std::fs::read_to_string(place.folder.join("out/summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    let requests = summary["requests"].as_array().expect("a list");
    assert!(requests.len() > 12, "{requests:?}");
    let by = MEMBER.to_string();
    assert!(requests.iter().all(|request| request["user"] == by.as_str()), "{requests:?}");
    let (code, printed) = place.run(owner, &["convert", "walk.mcap", "--csv", "csv"]);
    assert_eq!(code, Some(0), "{printed}");
    let served = std::fs::read_to_string(place.folder.join("csv/served.csv")).expect("a table");
    assert!(served.contains(&format!(",{},", MEMBER + 1)), "{served}");

    // Commands that need the shared memory itself.
    for command in ["view", "controller", "session"] {
        let arguments = if command == "session" { vec![command, &full] } else { vec![command, "--session", &full] };
        let (code, printed) = place.run(member, &arguments);
        assert!(code == Some(2) && printed.contains("only `biped top` and requests"), "{command}: {printed}");
    }

    // a session that is not shared
    let launcher = place.biped(owner, &walk).spawn().expect("the program starts");
    eventually("a session", || place.run(owner, &["pause", "--session", &name]).0 == Some(0));
    for session in [&full, &name] {
        let sentence = format!("error: session `{name}` belongs to {OWNER}; ask them for --share GROUP\n");
        assert_eq!(place.run(member, &["pause", "--session", session]), (Some(2), sentence));
    }
    assert_eq!(interrupt(launcher).0, Some(130));

    // A plant that was started by hand has a share too. In lockstep it waits for nobody except the observer, whose lines are read.
    let plant = ["plant", "walk", "--set", "duration=100000", "--session", &name, "--share", &group];
    let plant = place.biped(owner, &plant).spawn().expect("the program starts");
    let controller = place.biped(owner, &["controller", "--session", &name]).spawn().expect("the program starts");
    eventually("an answer", || place.run(member, &["rearm", "--session", &name]).0 == Some(0));
    let mut watcher = place.biped(member, &["top", "--session", &name]).spawn().expect("the program starts");
    let mut lines = BufReader::new(watcher.stdout.take().expect("a pipe")).lines();
    assert!(lines.any(|line| line.is_ok_and(|line| line.contains(" Hz "))));
    let (code, printed) = place.run(member, &["pause", "--session", &name]);
    assert_eq!(code, Some(0), "{printed}");
    interrupt(plant);
    interrupt(controller);
    assert_eq!(watcher.wait().expect("our own child").code(), Some(0));
    assert_eq!(files_of_owner(), Vec::<PathBuf>::new());
}

#[test]
fn a_group_that_cannot_be_shared_with_is_refused_in_a_sentence() {
    let walk = ["run", "walk", "--quiet", "--share"];
    let named = ["--session", &format!("refused-{}", std::process::id())];
    let refused = |command: &mut Command, words: &str| {
        let Output { status, stderr, .. } = command.output().expect("the program runs");
        let errors = String::from_utf8_lossy(&stderr);
        assert_eq!((status.code(), errors.as_ref()), (Some(2), format!("error: {words}\n").as_str()));
    };
    let ours = |arguments: &[&[&str]]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        command.args(arguments.concat()).stdout(Stdio::null());
        command
    };
    let unknown = "there is no group `no-such-group`: `getent group` lists them";
    refused(&mut ours(&[&walk, &["no-such-group"], &named]), unknown);
    refused(&mut ours(&[&["plant", "walk", "--share", "no-such-group"], &named]), unknown);
    refused(&mut ours(&[&walk, &["0"]]), "--share needs a session with a name: add --session NAME");
    refused(&mut ours(&[&["pause", "--session", "no-such-user/lab"]]), "there is no user `no-such-user`");
    let Some(place) = Place::new("group") else { return };
    let arguments = [&walk[..], &["61777"], &named].concat();
    let words = format!("user {STRANGER} cannot share with group {GROUP}, because only a member of a group can");
    refused(&mut place.biped((STRANGER, STRANGER), &arguments), &words);
}
