//! When a process ends in any way, the others report it, exit in order, and leave no files.

use super::{assert_all_gone, end, eventually, fresh_folder, roles_of, send, session, start, walking};
use nix::sys::signal::Signal;
use std::path::PathBuf;
use std::process::{Command, Output};

#[test]
fn a_run_that_ends_by_itself_leaves_nothing_behind() {
    let launcher = start(&["run", "walk", "--realtime", "--quiet", "--set", "duration=1"]);
    let mut roles = vec![];
    eventually("two processes", || {
        roles = roles_of(launcher.id());
        roles.len() == 2
    });
    assert_eq!(end(launcher).0, Some(0));
    assert_all_gone(&roles);
}

#[test]
fn sigint_and_sigterm_end_a_run_in_order() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let (launcher, roles) = walking();
        send(launcher.id() as i32, signal);
        let (code, errors) = end(launcher);
        assert_eq!(code, Some(130), "{errors}");
        assert!(errors.contains("interrupted"), "{errors}");
        assert_all_gone(&roles);
    }
}

#[test]
fn children_of_a_killed_launcher_exit_and_the_last_one_removes_the_session_files() {
    let (mut launcher, roles) = walking();
    launcher.kill().expect("our own child");
    launcher.wait().expect("the launcher ends");
    assert_all_gone(&roles);
}

#[test]
fn a_killed_child_is_named_and_the_other_child_is_terminated() {
    for role in ["plant", "controller"] {
        let (launcher, roles) = walking();
        let victim = roles.iter().find(|child| child.name == role).expect("the role is there");
        send(victim.pid, Signal::SIGKILL);
        let (code, errors) = end(launcher);
        assert_eq!(code, Some(4), "{errors}");
        assert!(errors.contains(&format!("the {role} failed")) && errors.contains("SIGKILL"), "{errors}");
        assert_all_gone(&roles);
    }
}

#[test]
fn descendants_of_a_foreign_program_end_with_it() {
    let file = fresh_folder("orphan").with_extension("pid");
    let script = format!("sh -c 'sleep 600 & echo $! > {}; exit 3'", file.display());
    let (code, errors) = end(start(&["run", "stand", "--quiet", "--controller", &script]));
    assert!(code == Some(3) && errors.contains("the controller failed (exit status: 3)"), "{code:?} {errors}");
    let orphan = std::fs::read_to_string(&file).expect("its process ID");
    let stat = PathBuf::from(format!("/proc/{}/stat", orphan.trim()));
    let is_dead = || std::fs::read_to_string(&stat).map_or(true, |stat| stat.contains(") Z "));
    eventually("the end of its descendant", is_dead);
    std::fs::remove_file(file).expect("our own file");
}

#[test]
fn a_stopped_controller_is_a_fault_in_real_time() {
    let (launcher, roles) = walking();
    let victim = roles.iter().find(|child| child.name == "controller").expect("a controller");
    send(victim.pid, Signal::SIGSTOP);
    let (code, errors) = end(launcher);
    assert!(code == Some(4) || code == Some(7), "{code:?} {errors}");
    assert!(errors.contains("silent") && errors.contains("damped"), "{errors}");
    assert_all_gone(&roles);
}

#[test]
fn a_missing_peer_is_reported_each_second_until_the_patience_ends() {
    for (role, missing) in [("plant", "controller"), ("controller", "plant")] {
        let session = session(&format!("lonely-{role}"));
        let (code, errors) = end(start(&[role, "walk", "--patience", "2.5", "--session", session.name()]));
        assert_eq!(code, Some(3), "{errors}");
        for second in 1..=2 {
            assert!(errors.contains(&format!("waiting for the {missing}: {second} of 2.5 s")), "{errors}");
        }
        assert!(errors.contains(&format!("no {missing}")), "{errors}");
        assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
    }
}

#[test]
fn a_controller_does_not_wait_for_a_plant_that_cannot_start() {
    let session = session("cannot");
    let bad = ["--set", "plant.law=EnergyQp", "--set", "plant.method=EventDriven", "--session", session.name()];
    let controller = start(&[&["controller", "walk", "--patience", "50"], &bad[..]].concat());
    eventually("the controller's session", || session.shm_files().len() > 5);
    let (code, errors) = end(start(&[&["plant", "walk"], &bad[..]].concat()));
    assert!(code == Some(2) && errors.contains("plant.law of the method EventDriven"), "{errors}");
    let (code, errors) = end(controller);
    assert!(code == Some(0) && !errors.contains("no plant"), "it waited until its patience ended: {errors}");
    assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
}

/// A plant that shuts down slowly, as a simulator in Python may. Its controller leaves as soon as the end is announced.
#[test]
fn a_plant_that_exits_long_after_the_end_of_its_run_is_waited_for() {
    let plant = ["--plant", "sh -c 'biped plant; sleep 2.5'"];
    let (code, errors) = end(start(&[&["run", "walk", "--quiet", "--set", "duration=0.1"], &plant[..]].concat()));
    assert_eq!((code, errors.as_str()), (Some(0), ""));
}

/// A pipe can be read only once, so its reader hands the scene to the other processes.
#[test]
fn a_scene_from_a_pipe_runs_in_two_processes_with_the_same_bits() {
    let scene = "
        duration = 0.30000000000000004
        [plant]
        friction = 0.70000000000000007
        [initial]
        clearance = 0.0
        joints = [0.0, 0.4943, -1.5177, 1.0234, -1.0234, 1.5177, -0.4943, 0.0]
        [controller]
        speed = 0.12345678901234568";
    let hash = |kind: &str| {
        let script = format!("printf %s \"$2\" | \"$1\" run /dev/stdin --quiet {kind}");
        let Output { status, stdout, stderr } = Command::new("sh")
            .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_biped"), scene])
            .output()
            .expect("a shell");
        assert!(status.success(), "{kind}: {}", String::from_utf8_lossy(&stderr));
        let summary = String::from_utf8_lossy(&stdout).into_owned();
        summary.lines().find(|line| line.contains("hash")).expect("a hash").to_string()
    };
    assert_eq!(hash(""), hash("--in-process"));
}

#[test]
fn a_duration_that_is_no_whole_number_of_periods_is_named_in_one_process_and_in_two() {
    for (duration, extra, said) in [
        ("0.2055", &["--in-process"][..], true),
        ("0.2055", &[], true),
        ("0.21", &["--in-process"], false),
        ("0.21", &[], false),
    ] {
        let duration = format!("duration={duration}");
        let arguments = ["run", "slide", "--quiet", "--set", "rate=100", "--set", &duration, "--set", "plant.dt=0.001"];
        let session = session("duration");
        let named = ["--session", session.name()];
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        command.args(arguments).args(extra).args(if extra.is_empty() { &named[..] } else { &[] });
        let Output { status, stderr, .. } = command.output().expect("the program runs");
        let errors = String::from_utf8_lossy(&stderr);
        assert!(status.success(), "{errors}");
        assert_eq!(errors.matches("the run lasts 0.21 s, not 0.2055 s").count(), usize::from(said), "{errors}");
    }
}
