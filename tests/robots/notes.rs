//! Claims about robot files of other origin: the program says what it does not read of them, doubts units, reads a pipe once, and ends at once
//! with files that are far too large.

use crate::common::RobotFile;
use crate::{biped, export};
use std::process::Command;
use std::time::{Duration, Instant};

/// Runs `biped export toml --robot` with a file. Returns its exit code and standard error.
fn read(kind: &str, text: &str) -> (Option<i32>, String) {
    let file = RobotFile::of(kind, text);
    let output = biped(&["export", "toml", "--robot", file.path()]);
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn parts_of_a_urdf_file_that_are_not_read_are_noted_once_for_each_kind() {
    let plain = export("urdf", &[]);
    let typo = plain.replace("<dynamics", "<dynamic").replace("</robot>", "<gazebo/><gazebo/></robot>");
    let dynamic =
        "`dynamic` in joint `left_foot_joint` is not read, nor are 7 others like it; did you mean `dynamics`?\n";
    let gazebo = "`gazebo` in robot is not read, nor is another one\n";
    assert_eq!(read("urdf", &typo), (Some(0), [dynamic, gazebo].concat()));
    assert_eq!(read("urdf", &plain), (Some(0), String::new()));
}

#[test]
fn lengths_in_millimetres_and_masses_in_grams_are_doubted() {
    let robot = export("toml", &[]);
    let grams: String = robot
        .lines()
        .map(|line| if line.starts_with("mass = ") { format!("{line}e3\n") } else { format!("{line}\n") })
        .collect();
    let (code, errors) = read("toml", &grams);
    assert!(code == Some(0) && errors.starts_with("the robot weighs 14000 kg, more than a cube of lead"), "{errors}");
    let (code, errors) = read("toml", &robot.replace("-0.2]", "-200.0]"));
    assert!(
        code == Some(0) && errors.starts_with("the legs are 400 m long: are the lengths in millimetres?"),
        "{errors}"
    );
}

#[test]
fn a_robot_or_a_scene_from_a_pipe_is_read_once() {
    let robots = [RobotFile::of("toml", &export("toml", &[])), RobotFile::of("urdf", &export("urdf", &[]))];
    for robot in &robots {
        for processes in ["", "--in-process"] {
            let command =
                format!("\"$0\" run walk --quiet --set duration=0.1 {processes} --robot <(cat {})", robot.path());
            let output =
                Command::new("bash").args(["-c", &command, env!("CARGO_BIN_EXE_biped")]).output().expect("bash");
            assert!(
                output.status.success() && output.stderr.is_empty(),
                "{command}: {}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
        let command = format!("\"$0\" run <(cat {})", robot.path());
        let output = Command::new("bash").args(["-c", &command, env!("CARGO_BIN_EXE_biped")]).output().expect("bash");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && errors.contains("this is a robot, not a scene"), "{errors}");
    }
}

/// Work that grows with the square of the number of links would take hours.
#[test]
fn robots_with_far_too_many_parts_are_refused_at_once() {
    let many = 20_000;
    let link = |k: usize| {
        format!(
            "<link name='a{k}'/><joint name='j{k}' type='revolute'><parent link='a{}'/><child link='a{k}'/></joint>",
            k - 1
        )
    };
    let urdf = format!("<robot name='r'><link name='a0'/>{}</robot>", (1..many).map(link).collect::<String>());
    let body = |k: usize, joint: &str| format!("[[bodies]]\nname = \"a{k}\"\nmass = 1\nsize = [1, 1, 1]\n{joint}\n");
    let joint = |k: usize| format!("joint = {{ parent = \"a{}\", axis = [0, 1, 0], at = [0, 0, 1] }}", k - 1);
    let chain: String = (1..many).map(|k| body(k, &joint(k))).collect();
    let bases: String = (0..many).map(|k| body(k, "")).collect();
    let points = format!("{}contacts = [{}]", body(0, ""), "[0, 0, 0],".repeat(many));
    let nested = format!("<robot>{}{}</robot>", "<link name='a'>".repeat(many), "</link>".repeat(many));
    for (kind, text, words) in [
        ("urdf", &urdf, "there are 19999 joints that move, but a robot here is a trunk with two legs"),
        ("urdf", &nested, "error: "),
        (
            "toml",
            &(body(0, "") + &chain),
            "there are 19999 joints that move, but a robot here is a trunk with two legs",
        ),
        ("toml", &bases, "and 19994 more"),
        ("toml", &points, "number of contact points and balls = 20000, but"),
        ("toml", &format!("bodies = {}", "[".repeat(many)), "error: "),
    ] {
        let file = RobotFile::of(kind, text);
        for command in [&["run", "walk", "--robot"][..], &["run"]] {
            let start = Instant::now();
            let output = biped(&[command, &[file.path()]].concat());
            let errors = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{errors}");
            assert!(start.elapsed() < Duration::from_secs(10), "{words}: {:?}", start.elapsed());
            assert!(command.len() == 1 || errors.contains(words), "{errors}");
        }
    }
}
