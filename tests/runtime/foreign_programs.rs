//! Foreign programs: any program that uses the wire format can take part, except with another version or in a role that is already taken.

use super::{LONG, end, fresh_folder, session, start};
use messages::port::{Contract, ControllerPort, Pace, PlantPort};
use messages::scene::{ControllerScene, Scene};
use messages::wire::{Command as Torque, Stamp, Torques};
use std::path::PathBuf;
use std::time::Instant;

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
    assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
    std::fs::remove_file(file).expect("our own file");
}

/// Runs a plant with a controller that answers by `answer` until the plant ends. Returns the plant's exit code and standard error.
fn test_controller(name: &str, answer: impl Fn(&Stamp) -> Torque) -> (Option<i32>, String) {
    let session = session(name);
    let file = fresh_folder(name).with_extension("toml");
    std::fs::write(&file, "[initial]\nclearance = 0.0\n[controller]\n").expect("a scene file");
    let path = file.to_string_lossy().into_owned();
    let scene = messages::load::load(&path, &[], &[]).expect("a good scene");
    let mut port = ControllerPort::open(&session, &Contract::of(&scene, Pace::Lockstep)).expect("controller");
    let plant = start(&["plant", &path, "--patience", "1", "--session", session.name()]);
    let begin = Instant::now();
    loop {
        assert!(begin.elapsed() < LONG, "the plant never sent its last sensors message");
        match port.wait().expect("waiting") {
            Some(sensors) if sensors.last != 0 => break,
            Some(sensors) => port.send(answer(&sensors.stamp)).expect("answering"),
            None => (),
        }
    }
    std::fs::remove_file(file).expect("our own file");
    end(plant)
}

/// The stamp of a correct answer.
fn reply(asked: &Stamp) -> Stamp {
    Stamp { run: asked.run, seq: asked.seq, ack: asked.seq, ..Stamp::default() }
}

fn limp(asked: &Stamp) -> Torque {
    Torque { stamp: reply(asked), ..Torque::default() }
}

#[test]
fn bad_commands_never_reach_the_robot_and_are_counted_by_reason() {
    type MakeCommand = fn(&Stamp) -> Torque;
    let cases: [(&str, &str, MakeCommand); 4] = [
        ("nan", "not finite", |asked| Torque { torques: Torques { torque: [f64::NAN; 8] }, ..limp(asked) }),
        ("run", "for another run", |asked| Torque { stamp: Stamp { run: 1, ..reply(asked) }, ..limp(asked) }),
        ("huge", "four times", |asked| Torque { torques: Torques { torque: [1e9; 8] }, ..limp(asked) }),
        ("early", "ahead", |asked| Torque { stamp: Stamp { ack: 9, ..reply(asked) }, ..limp(asked) }),
    ];
    for (name, words, answer) in cases {
        let (code, errors) = test_controller(name, answer);
        assert_eq!(code, Some(3), "{name}: {errors}");
        assert!(errors.contains("refused: ") && errors.contains(words), "{name}: {errors}");
    }
}

#[test]
fn any_program_that_speaks_the_messages_can_be_the_controller() {
    assert_eq!(test_controller("limp", limp), (Some(0), String::new()));
}
