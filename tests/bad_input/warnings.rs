//! Claims about scenes that run, but hardly as intended: one sentence on standard error, and the run goes on.

use super::biped;

/// Runs a scene to its end. Its standard error is to have one line for each of the warnings, with these words.
fn warns(scene: &str, settings: &[&str], warnings: &[&[&str]]) {
    let settings = settings.iter().flat_map(|setting| ["--set", setting]);
    let arguments: Vec<&str> = ["run", scene, "--quiet", "--in-process"].into_iter().chain(settings).collect();
    let (code, errors) = biped(&arguments);
    assert!(code == Some(0) && errors.lines().count() == warnings.len(), "{arguments:?}: {code:?}, {errors}");
    for (line, words) in errors.lines().zip(warnings) {
        assert!(words.iter().all(|word| line.contains(word)), "{arguments:?} said {line:?}, not {words:?}");
    }
}

#[test]
fn energy_from_the_ground_that_pushes_out_a_robot_is_not_blamed_on_the_step() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/inside-ground.toml");
    let inside = "10.000 mm inside the ground";
    let (pushed_out, gained) = ("which pushes it out", "the ground pushed out the robot, which started inside it");
    warns(scene, &[], &[&[inside, pushed_out], &["the run gained", gained]]);
    warns(scene, &["plant.gravity=0"], &[&[inside, "proportional to plant.gravity = 0"]]);
    warns(scene, &["plant.gravity=0", "plant.law=SpringDamper", "plant.dt=1e-4"], &[&[inside, pushed_out]]);
    // a depth that is not worth a warning
    warns(scene, &["initial.position=[0, 0, 0.099999999]"], &[&["the run gained", gained]]);
    // on the ground, a spin by the paper's step
    let spin = ["initial.clearance=1", "plant.gravity=0", "plant.method=SemiImplicitEuler", "plant.dt=0.01"];
    let spin = [&spin[..], &["initial.angular_velocity=[9, 30, 20]", "bodies.box.size=[0.05, 0.2, 0.45]"]].concat();
    warns(scene, &spin, &[&["the run", "plant.dt is too long for plant.method"]]);
}

#[test]
fn a_robot_that_stays_inside_the_ground_is_not_said_to_be_pushed_out() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/inside-ground.toml");
    let micrometre = "initial.position=[0, 0, 0.099999]";
    let stays = ["0.001 mm inside the ground", "does not push it out", "plant.method = MoreauJean", "up to 0.049 mm"];
    warns(scene, &[micrometre, "plant.method=MoreauJean"], &[&stays]);
    let gained = ["the run gained", "the ground pushed out the robot"];
    warns(scene, &[micrometre], &[&["0.001 mm inside the ground, which pushes it out:"], &gained]);
    let rest = ["10.000 mm inside the ground, which pushes it out, up to the 0.049 mm that plant.method = MoreauJean"];
    warns(scene, &["plant.method=MoreauJean"], &[&rest, &gained]);
}

#[test]
fn a_push_that_does_not_happen_wholly_is_told() {
    let push = "plant.push_impulse=[0, 0, 1]";
    let at = |time: &'static str, duration: &'static str| ["duration=0.1", push, time, duration];
    warns("free", &at("plant.push_time=0.05", "plant.push_duration=0.05"), &[]);
    let late = ["does not happen", "plant.push_time = 0.1 s", "ends at 0.1 s"];
    warns("free", &at("plant.push_time=0.1", "plant.push_duration=0.01"), &[&late]);
    let cut = ["cut off", "begins at 0.08 s", "plant.push_duration = 0.06 s", "the run ends at 0.1 s"];
    warns("free", &at("plant.push_time=0.08", "plant.push_duration=0.06"), &[&cut]);
}

#[test]
fn a_processor_that_is_refused_is_told_with_those_that_are_permitted() {
    let status = std::fs::read_to_string("/proc/self/status").expect("this process");
    let permitted = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:")).expect("a list").trim();
    let (code, errors) = biped(&["run", "walk", "--quiet", "--set", "duration=0.1", "--cpu", "1000"]);
    let tell = |line: &str| line.ends_with(&format!("--cpu with one of the processors {permitted}"));
    assert!(code == Some(0) && errors.lines().count() == 2 && errors.lines().all(tell), "{permitted}: {errors}");
}

#[test]
fn a_stop_that_does_not_happen_is_told() {
    let late = ["does not stop", "controller.stop_time = 100 s", "ends at 0.1 s"];
    warns("walk", &["duration=0.1", "controller.stop_time=100"], &[&late]);
    warns("walk", &["duration=0.1", "controller.stop_time=0.05"], &[]); // it stands until then
}

#[test]
fn a_stop_that_the_end_of_the_run_cuts_off_is_told() {
    let cut = |stop, end| ["the stop is cut off", stop, end, "before the robot rests"];
    for (stop, duration, words) in [
        ("controller.stop_time=3.9", "duration=4", cut("controller.stop_time = 3.9 s", "ends at 4 s")),
        ("controller.stop_time=3.999", "duration=4", cut("controller.stop_time = 3.999 s", "ends at 4 s")),
        ("controller.stop_time=3", "duration=3.5", cut("controller.stop_time = 3 s", "ends at 3.5 s")),
    ] {
        warns("walk", &[stop, duration], &[&words]);
    }
    warns("walk", &["controller.stop_time=3", "duration=5"], &[]);
}

/// A built-in scene may have such a key: only a key that the user names is told.
#[test]
fn a_key_without_effect_is_told_if_the_user_names_it() {
    let short = "duration=0.1";
    for (scene, idle, reason, used) in [
        ("stand", "controller.speed=0.1", "controller.gait = \"stand\"", "controller.gait=walk"),
        ("stand", "controller.period=0.7", "controller.gait = \"stand\"", "controller.gait=walk"),
        ("walk", "controller.sagittal_energy_gain=2", "controller.sagittal = \"energy\"", "controller.sagittal=energy"),
        ("walk", "plant.payload_offset=[0, 0, 0.1]", "plant.payload_kg = 0", "plant.payload_kg=1"),
        ("walk", "plant.payload_body=left foot", "plant.payload_kg = 0", "plant.payload_kg=1"),
        ("free", "plant.push_time=0.01", "plant.push_impulse = 0", "plant.push_impulse=[0, 0, 1]"),
        ("free", "plant.push_duration=0.01", "plant.push_impulse = 0", "plant.push_impulse=[0, 0, 1]"),
        ("walk", "plant.ground.random.seed=3", "plant.ground.random.height = 0", "plant.ground.random.height=0.001"),
        ("walk", "plant.contact_stiffness=2e5", "plant.law = \"SpringDamper\"", "plant.law=SpringDamper"),
        ("walk", "plant.tolerance_step=1e-9", "EventDriven", "plant.method=StepDoubling"),
        ("walk", "link.jitter=burst", "link.jitter_ms = 0", "link.jitter_ms=1"),
    ] {
        let key = idle.split('=').next().expect("a key");
        warns(scene, &[short, idle], &[&[key, "has no effect", reason]]);
        let (code, errors) =
            biped(&["run", scene, "--quiet", "--in-process", "--set", short, "--set", idle, "--set", used]);
        assert!(code == Some(0) && !errors.contains("has no effect"), "{idle} with {used}: {code:?}, {errors}");
        warns(scene, &[short], &[]);
    }
    let stand = concat!(env!("CARGO_MANIFEST_DIR"), "/messages/scenes/stand.toml");
    let stand = std::fs::read_to_string(stand).expect("a scene");
    let file = std::env::temp_dir().join(format!("biped-idle-{}.toml", std::process::id()));
    let path = file.to_str().expect("a path");
    for (speed, warnings) in [("0", &[][..]), ("0.2", &[&["controller.speed has no effect"][..]][..])] {
        let text = stand.replace("gait = \"stand\"", &format!("gait = \"stand\"\nspeed = {speed}\nperiod = 0.6"));
        assert_ne!(text, stand);
        std::fs::write(&file, text).expect("a file");
        warns(path, &[short], warnings); // a default that is written out is no wish
    }
    std::fs::remove_file(&file).expect("our own file");
}

#[test]
fn a_push_of_a_fixed_base_is_told_and_one_of_a_body_on_a_fixed_base_is_none() {
    let push =
        ["duration=0.1", "plant.push_impulse=[1, 0, 0]", "plant.base=fixed", "initial.angular_velocity=[0, 0, 0]"];
    let of = |body: &'static str| [&push[..], &[body]].concat();
    let held = ["moves nothing", "plant.base = \"fixed\""];
    warns("free", &push, &[&held]);
    warns("free", &of("plant.push_body=trunk"), &[&held]);
    warns("free", &of("plant.push_body=left shank"), &[]);
}

#[test]
fn disturbances_of_commands_without_a_controller_are_told() {
    let delay = ["duration=0.1", "link.delay_ms=2"];
    warns("free", &delay, &[&["[link] has no effect", "no [controller]"]]);
    warns("walk", &delay, &[]);
}

#[test]
fn contact_points_that_no_joint_moves_are_told() {
    let still = "never touch the ground";
    warns("stick", &["duration=0.1", "plant.base=fixed"], &[&[still]]);
    warns("stick", &["duration=0.1"], &[]);
}
