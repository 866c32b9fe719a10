//! `biped conform` accepts the Python programs, and names the rule that a changed program breaks.

use crate::common::fresh_path;
use crate::languages::{python, python_with_package};
use std::path::Path;
use std::process::Command;

/// Runs `biped conform` on a Python program. Returns its exit code and output.
fn conform(python: &Path, role: &str, arguments: &str) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["conform", role, &format!("{} {arguments}", python.display())])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("OPENBLAS_NUM_THREADS", "1")
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), printed)
}

#[test]
fn the_python_programs_obey_the_rules_of_the_wire_format() {
    for controller in ["stand.py", "walk.py"] {
        let (code, printed) = conform(python(), "--controller", &format!("controller/foreign/python/{controller}"));
        assert!(code == Some(0) && printed.contains("32 rules kept"), "{controller}: {printed}");
    }
    let (code, printed) = conform(python_with_package(), "--plant", "plant/foreign/mujoco/plant.py");
    assert!(code == Some(0) && printed.contains("37 rules kept") && printed.contains("lockstep alone"), "{printed}");
}

/// A piece of session.py or ports.py, its replacement, and the expected message.
type Flaw = [&'static str; 3];

#[test]
fn a_broken_rule_is_named() {
    let programs: [&[Flaw]; 4] = [
        &[
            ["stamp.seq + 1, asked.seq,", "stamp.seq + 1, asked.seq - 1,", "ack is the number of the sensors answered"],
            ["sys.exit(INTERRUPTED))", "None)", "TERM ends it in order within 3 s: it was still there"],
        ],
        &[
            [
                "controller.tick(sensors.encoders.counts[:], answer.telemetry)",
                "[float('nan')] * 8",
                "torques are finite: torque[0]",
            ],
            ["if sensors.last:", "if False:", "`last` = 1 ends it in order within 3 s"],
            ["stamp.ack = asked.run, 0, 0", "stamp.ack = asked.run, 5, 0", "seq counts its messages of a run from 1"],
        ],
        &[
            [
                "sensors is None or not is_sound(sensors)",
                "sensors is None",
                "whose check sum is wrong are not answered",
            ],
            ["secrets.randbits(64)", "7", "it answers under another epoch"],
            ["                if stamp.run:\n", "                if False:\n", "takes a new run as a new robot"],
        ],
        &[
            ["sealed(message))", "message)", "every message is sealed"],
            ["fail(PEER_MISSING, f\"no plant", "print(PEER_MISSING, f\"no plant", "gives up without a plant"],
        ],
    ];
    let ours = Path::new("controller/foreign/python");
    let try_one = move |flaws: &[Flaw]| {
        let folder = fresh_path("flawed");
        std::fs::create_dir_all(&folder).expect("a folder");
        for file in ["stand.py", "wire.py"] {
            std::fs::copy(ours.join(file), folder.join(file)).expect("a copy");
        }
        let text = |file: &str| std::fs::read_to_string(ours.join(file)).expect("our own file");
        let mut texts = ["session.py", "ports.py"].map(|file| (file, text(file)));
        for [good, bad, _] in flaws {
            let found = texts.iter_mut().find(|(_, text)| text.contains(good));
            let (_, text) = found.unwrap_or_else(|| panic!("neither session.py nor ports.py has {good}"));
            *text = text.replacen(good, bad, 1);
        }
        for (file, text) in texts {
            std::fs::write(folder.join(file), text).expect("a file");
        }
        let (code, printed) = conform(python(), "--controller", &folder.join("stand.py").display().to_string());
        let broken = printed.lines().filter(|line| line.starts_with("FAILED")).collect::<Vec<_>>().join("\n");
        for [_, bad, rule] in flaws {
            assert!(code == Some(10) && broken.contains(rule), "{bad}: {rule}: {printed}");
        }
        std::fs::remove_dir_all(folder).expect("our own folder");
    };
    // in parallel, because most of the time is spent waiting for messages that must not come
    std::thread::scope(|scope| {
        for flaws in programs {
            scope.spawn(move || try_one(flaws));
        }
    });
}
