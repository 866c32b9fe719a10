//! Hostile environments: strange output, foreign files, missing resources and bad commands are reported, and neither stop nor block a run.

use super::{LONG, biped, end, eventually, fresh_folder, session, start};
use messages::session::Session;
use nix::sys::stat::Mode;
use nix::unistd::{mkdtemp, mkfifo};
use std::io::Read;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Instant;

/// Path of a session file in shared memory.
fn file_of(session: &Session, name: &str) -> PathBuf {
    Path::new("/dev/shm").join(session.prefix() + name)
}

/// Exit code and standard error of a process that has to exit by itself.
fn exits(mut child: Child) -> (Option<i32>, String) {
    let begin = Instant::now();
    while child.try_wait().expect("our own child").is_none() {
        if begin.elapsed() > LONG {
            child.kill().expect("our own child");
            let (_, errors) = end(child);
            unreachable!("it hung: {errors}");
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    end(child)
}

#[test]
fn any_output_of_a_controller_is_shown_and_does_not_block_it() {
    let folder = mkdtemp(&std::env::temp_dir().join("biped-test-XXXXXX")).expect("a folder");
    let script = folder.join("loud.sh");
    // invalid UTF-8, a line that looks like an error, a terminal escape, a very long line, and then the real controller
    let ours = env!("CARGO_BIN_EXE_biped");
    let words = format!(
        "#!/bin/sh\nprintf 'error: early\\n\\377\\376\\n\\033[2J\\n' >&2\nhead -c 3000000 /dev/zero | tr '\\0' x >&2\necho >&2\n\
         echo late >&2\nexec '{ours}' controller\n"
    );
    std::fs::write(&script, words).expect("a script");
    std::fs::set_permissions(&script, PermissionsExt::from_mode(0o755)).expect("ours");
    let command = script.to_string_lossy().into_owned();
    let (code, errors) = exits(start(&["run", "walk", "--quiet", "--set", "duration=0.2", "--controller", &command]));
    std::fs::remove_dir_all(folder).expect("our own");
    assert_eq!(code, Some(0), "{errors}");
    for line in ["error: early", "\u{fffd}\u{fffd}", "\\u{1b}[2J", "xxx …", "late"] {
        assert!(errors.contains(line), "{line:?} is not shown: {errors}");
    }
    assert!(errors.len() < 5000 && !errors.contains('\u{1b}'), "{} bytes", errors.len());
}

#[test]
fn pipes_and_links_in_place_of_session_files_are_refused_without_blocking() {
    let session = session("pipes");
    let list = file_of(&session, "members");
    let target = fresh_folder("target");
    std::fs::write(&target, "untouched").expect("a file");
    let pipe = |path: &Path| mkfifo(path, Mode::S_IRWXU).expect("a pipe");
    let link = |path: &Path| symlink(&target, path).expect("a link");
    for create in [&pipe as &dyn Fn(&Path), &link] {
        create(&list);
        let named = ["--session", session.name()];
        for command in [&["run", "walk", "--quiet"][..], &["plant", "walk"], &["controller", "walk"]] {
            let (code, errors) = exits(start(&[command, &named].concat()));
            assert_eq!(code, Some(6), "{command:?}: {errors}");
            assert!(errors.contains("is not a regular file: remove it"), "{command:?}: {errors}");
        }
        for command in [&["push", "0,1,0"][..], &["top"], &["view"]] {
            let (code, errors) = exits(start(&[command, &named].concat()));
            assert!(code == Some(3) && errors.contains("no session"), "{command:?}: {code:?} {errors}");
        }
        for command in ["doctor", "clean"] {
            let (code, errors) = exits(start(&[command]));
            assert!(code.is_some() && errors.len() < 500, "{command}: {errors}");
        }
        std::fs::remove_file(&list).expect("our own");
    }
    assert_eq!(std::fs::read_to_string(&target).expect("there"), "untouched");
    std::fs::remove_file(target).expect("our own");
    assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
}

#[test]
fn clean_removes_only_files_of_this_program() {
    let others = ["biped_of_somebody_", "biped_notes", "biped_ABCDEF01_members", "biped_0123456_x"];
    let mine = others.map(|name| Path::new("/dev/shm").join(format!("{name}{}", std::process::id())));
    mine.iter().for_each(|path| std::fs::write(path, "mine").expect("a file"));
    let (code, errors) = exits(start(&["clean"]));
    let kept = mine.iter().filter(|path| std::fs::remove_file(path).is_ok()).count();
    assert!(code == Some(0) && kept == mine.len(), "{kept} are left: {errors}");
}

#[test]
fn session_files_in_shared_memory_are_private_to_the_user() {
    let (mut launcher, session) = (None, session("closed"));
    let arguments = ["run", "walk", "--realtime", "--quiet", "--set", "duration=300", "--session", session.name()];
    launcher.replace(start(&arguments));
    eventually("a session", || session.shm_files().len() > 10);
    eventually("no permissions for others", || {
        let rights =
            session.shm_files().into_iter().filter_map(|path| Some((path.symlink_metadata().ok()?.mode(), path)));
        rights.filter(|(mode, _)| mode & 0o077 != 0).count() == 0
    });
    let mut launcher = launcher.expect("started");
    launcher.kill().expect("our own child");
    launcher.wait().expect("it ends");
    eventually("an empty shared memory", || session.shm_files().is_empty());
}

#[test]
fn of_several_launchers_of_one_session_exactly_one_runs() {
    for round in 0..5 {
        let session = session(&format!("race{round}"));
        let arguments = ["run", "walk", "--quiet", "--set", "duration=2", "--session", session.name()];
        let racers: Vec<Child> = (0..3).map(|_| start(&arguments)).collect();
        let mut ends: Vec<_> = racers.into_iter().map(exits).collect();
        ends.sort();
        let codes: Vec<_> = ends.iter().map(|(code, _)| *code).collect();
        // on a busy machine, a late one may find the session free again
        assert!(codes[0] == Some(0) && codes[1..].iter().all(|code| matches!(code, Some(0 | 5))), "{ends:?}");
        let refused = ends.iter().filter(|(code, _)| *code == Some(5));
        refused.for_each(|(_, errors)| assert!(errors.contains("is already running"), "{errors}"));
        assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
    }
}

#[test]
fn results_are_written_even_if_standard_output_and_error_fail() {
    let folder = fresh_folder("deaf");
    let out = folder.to_string_lossy().into_owned();
    let arguments = ["run", "walk", "--in-process", "--set", "duration=0.2", "--out", &out];
    let files = ["summary.json", "trajectory.csv", "report.html"];
    let written = || files.iter().all(|name| std::fs::metadata(folder.join(name)).is_ok_and(|file| file.len() > 0));
    // standard error is closed at once
    let mut child = biped(&arguments).stdout(Stdio::null()).spawn().expect("the program starts");
    drop(child.stderr.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
    assert!(written());
    std::fs::remove_dir_all(&folder).expect("our own");
    // standard output is a full device
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
    let (code, errors) = exits(biped(&arguments).stdout(full).spawn().expect("the program starts"));
    assert!(code == Some(4) && errors.contains("standard output cannot be written"), "{code:?} {errors}");
    assert!(written());
    std::fs::remove_dir_all(&folder).expect("our own");
}

#[test]
fn resource_limits_that_are_too_low_are_reported_at_the_start() {
    let ours = env!("CARGO_BIN_EXE_biped");
    for (limit, words) in [
        ("-n 40", "the limit of open files is 40, but 128 are needed"),
        ("-d 9000", "the limit of memory is 9000 kB, but 65536 kB are needed"),
        ("-v 60000", "the limit of address space is 60000 kB, but 65536 kB are needed"),
        ("-s 200", "the limit of the stack is 200 kB, but 1024 kB are needed"),
        ("-s 64", "the limit of the stack is 64 kB, but 1024 kB are needed"),
    ] {
        for how in ["", "--in-process"] {
            let script = format!("ulimit {limit}; exec '{ours}' run walk --quiet --set duration=0.2 {how}");
            let mut shell = std::process::Command::new("sh");
            shell.args(["-c", &script]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
            let (code, errors) = exits(shell.spawn().expect("a shell"));
            assert!(code == Some(4) && errors.contains(words), "{limit} {how}: {code:?} {errors}");
        }
    }
    // the files of a session are in memory, and count
    for blocks in [1, 40, 8000] {
        let script = format!("ulimit -f {blocks}; exec '{ours}' run walk --quiet --set duration=0.2");
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", &script]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let (code, errors) = exits(shell.spawn().expect("a shell"));
        assert!(code == Some(6) && errors.contains("the limit of the size of files is"), "{code:?} {errors}");
        assert!(errors.contains("`ulimit -f unlimited`"), "{errors}");
    }
    // doctor asks for no more than the program needs
    let doctor =
        std::process::Command::new("sh").args(["-c", &format!("ulimit -n 130; exec '{ours}' doctor")]).output();
    let told = String::from_utf8_lossy(&doctor.expect("a shell").stdout).into_owned();
    assert!(told.lines().any(|line| line.starts_with("ok") && line.contains("limit nofile")), "{told}");
    // a soft limit below the hard limit is raised
    let script = format!("ulimit -Sn 40; exec '{ours}' run walk --quiet --set duration=0.2");
    let shell = std::process::Command::new("sh").args(["-c", &script]).stdin(Stdio::null()).output().expect("a shell");
    assert!(shell.status.success(), "{}", String::from_utf8_lossy(&shell.stderr));
}

#[test]
fn refused_commands_are_reported_long_before_the_patience_ends() {
    let folder = mkdtemp(&std::env::temp_dir().join("biped-test-XXXXXX")).expect("a folder");
    // this controller sends torques far beyond the limit
    let session = session("refused");
    let scene =
        messages::load::load("walk", &[], &[("walk", "[initial]\nclearance = 0.0\n[controller]\n")]).expect("a scene");
    let file = folder.join("scene.toml");
    std::fs::write(&file, "[initial]\nclearance = 0.0\n[controller]\n").expect("a scene file");
    let contract = messages::port::Contract::of(&scene, messages::port::Pace::Lockstep);
    let mut port = messages::port::ControllerPort::open(&session, &contract).expect("controller");
    let path = file.to_string_lossy().into_owned();
    let mut plant = start(&["plant", &path, "--patience", "100", "--session", session.name()]);
    let mut errors = plant.stderr.take().expect("a pipe");
    let reader = std::thread::spawn(move || {
        let (mut words, mut piece) = (String::new(), [0; 256]);
        while !words.contains("refused: beyond four times the torque limit") {
            match errors.read(&mut piece) {
                Ok(0) | Err(_) => break,
                Ok(count) => words += &String::from_utf8_lossy(&piece[..count]),
            }
        }
        words
    });
    let begin = Instant::now();
    while !reader.is_finished() && begin.elapsed() < LONG {
        if let Some(sensors) = port.wait().expect("waiting") {
            let stamp = messages::wire::Stamp { ack: sensors.stamp.seq, ..sensors.stamp };
            let torques = messages::wire::Torques { torque: [1e6; 8] };
            port.send(messages::wire::Command { stamp, torques, ..Default::default() }).expect("answering");
        }
    }
    plant.kill().expect("our own child");
    plant.wait().expect("it ends");
    let words = reader.join().expect("read");
    drop(port);
    session.remove_files();
    std::fs::remove_dir_all(folder).expect("our own");
    assert!(words.contains("refused: beyond four times the torque limit"), "{words}");
}

#[test]
fn a_run_without_its_session_files_continues_and_reports_that_no_process_can_join() {
    for respawn in [&[][..], &["--respawn", "3"]] {
        let session = session(&format!("gone{}", respawn.len()));
        let walk = ["run", "walk", "--realtime", "--speed", "0.2", "--quiet", "--set", "duration=0.6"];
        let launcher = start(&[&walk[..], &["--session", session.name()], respawn].concat());
        let mut roles = vec![];
        eventually("two connected processes", || {
            roles = super::roles_of(launcher.id());
            roles.len() == 2 && session.shm_files().len() > 10
        });
        std::thread::sleep(std::time::Duration::from_millis(300));
        for path in session.shm_files() {
            let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
        }
        if !respawn.is_empty() {
            let plant = roles.iter().find(|role| role.name == "plant").expect("a plant");
            super::send(plant.pid, nix::sys::signal::Signal::SIGKILL);
        }
        let (code, errors) = exits(launcher);
        let expected =
            if respawn.is_empty() { (Some(0), "the run continues") } else { (Some(4), "cannot be restarted") };
        assert!(code == expected.0 && errors.contains(expected.1), "{code:?}: {errors}");
        assert!(errors.contains("gone from /dev/shm"), "{errors}");
        eventually("an empty shared memory", || session.shm_files().is_empty());
    }
}
