//! Claims about bad input: one clear sentence, its exit code, and nothing left behind.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod usage;
mod values;
mod warnings;

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::process::{Command, Output};

/// Exit code and standard error of `biped ARGUMENTS`.
fn biped(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_biped")).args(arguments).output().expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn refused(arguments: &[&str], words: &[&str]) {
    let (code, errors) = biped(arguments);
    assert_eq!(code, Some(2), "{arguments:?}: {errors}");
    for word in words {
        assert!(errors.contains(word), "{arguments:?} said {errors:?}, but not {word:?}");
    }
    assert!(!errors.contains("panicked"), "{errors}");
}

#[test]
fn a_bad_value_is_refused_with_its_key_in_every_role() {
    let [long, description] = [("bodies.trunk.name", 101), ("description", 10_001)]
        .map(|(key, length)| format!("{key}={}", "b".repeat(length)));
    for role in ["run", "plant", "controller"] {
        refused(&[role, "walk", "--set", "plant.dt=0"], &["plant.dt = 0", "greater than 0"]);
        refused(&[role, "walk", "--set", "plant.dt=1e-12"], &["plant.dt = 1e-12", "at most 1000000 steps"]);
        refused(&[role, "walk", "--set", "plant.dt=5e-324"], &["plant.dt = 5e-324", "at most 1000000 steps"]);
        refused(&[role, "walk", "--set", "duration=1e20"], &["duration = 1e20", "at most 1e9 s"]);
        refused(&[role, "walk", "--set", "plant.friction=1\nrate=5"], &["plant.friction=1", "expected a number"]);
        refused(&[role, "walk", "--set", "plant.friction=0,3"], &["expected a number", "the decimal sign is a point"]);
        refused(&[role, "walk", "--set", "plant.law=cone"], &["did you mean `Cone`?"]);
        refused(&[role, "wlk"], &["no scene or file `wlk`; the built-in scenes are ", "; did you mean `walk`?\n"]);
        refused(&[role, "walk", "--set", "plant.method=RK4"], &["did you mean `Rk4`?"]);
        refused(&[role, "walk", "--set", "plant.friction=nan"], &["plant.friction = NaN", "finite"]);
        refused(&[role, "walk", "--set", "bodies.trunk.mass=-3"], &["bodies.trunk.mass = -3", "greater than 0"]);
        refused(&[role, "walk", "--set", "plant.fricton=1"], &["--set plant.fricton=1", "`friction`"]);
        refused(&[role, "walk", "--set", "plant=1"], &["--set plant=1", "expected a table"]);
        refused(&[role, "walk", "--set", "bodies.trunk.name=\"\""], &["bodies.4.name", "a body needs a name"]);
        refused(&[role, "walk", "--set", &long], &["bodies.4.name = \"bbbb", "at most 100 characters"]);
        refused(&[role, "walk", "--set", &description], &["description", "at most 10000 bytes"]);
        refused(&[role, "missing.toml"], &["missing.toml", "walk-literal"]);
    }
}

#[test]
fn a_scene_that_the_controller_or_plant_refuses_starts_nothing_and_leaves_no_folder() {
    let folder = std::env::temp_dir().join(format!("biped-test-{}-refused", std::process::id()));
    let out = folder.to_string_lossy().into_owned();
    for (scene, setting) in
        [("walk", "controller.speed=0.9"), ("walk", "controller.com_height=0.5"), ("drop", "plant.law=ConeQp")]
    {
        let run = ["run", scene, "--quiet", "--set", setting, "--out", &out];
        let [two, one] = [&[][..], &["--in-process"]].map(|processes: &[&str]| biped(&[&run[..], processes].concat()));
        assert!(one.0 == Some(2) && one.1.lines().count() == 1 && !folder.exists(), "{setting}: {one:?}");
        assert!(two == one || scene == "drop" && two.0 == Some(2), "{setting}: {two:?}, but in one process {one:?}");
        assert!(!two.1.contains("exit status") || scene == "drop", "{two:?}");
    }
}

#[test]
fn ground_that_cannot_be_is_refused() {
    let ground = |setting: &str, words: &[&str]| {
        refused(&["run", "slide", "--in-process", "--quiet", "--set", &format!("plant.ground.{setting}")], words);
    };
    ground("tiles=[{x=[1.0, 1.0], height=0.1}]", &["plant.ground.tiles.0.x = [1.0, 1.0]", "must be less"]);
    ground("tiles=[{y=[nan, 1.0], height=0.1}]", &["plant.ground.tiles.0.y", "finite"]);
    ground("tiles=[{height=inf}]", &["plant.ground.tiles.0.height = inf", "finite"]);
    ground("tiles=[{height=0.1}, {x=[0.0, 1.0], height=0.2}]", &["plant.ground.tiles.1", "must not overlap"]);
    ground("random.height=-0.1", &["plant.ground.random.height = -0.1", "must not be negative"]);
    ground("random.size=[0.1, 0.0]", &["plant.ground.random.size = 0", "at least 1e-9 m"]);
    ground("random.size=[1e-300, 0.1]", &["plant.ground.random.size = 1e-300", "at least 1e-9 m"]);
    ground("random.seed=-1", &["seed", "expected a whole number of 0 or more"]);
    let tiles = |count: usize| {
        let tiles: Vec<_> = (0..count).map(|i| format!("{{x=[{i}.0, {}.0], height=0.1}}", i + 1)).collect();
        format!("tiles=[{}]", tiles.join(","))
    };
    ground(&tiles(501), &["number of plant.ground.tiles = 501", "at most 500 tiles"]);
}

#[test]
fn an_argument_that_is_no_text_is_shown_with_escapes_in_a_sentence() {
    let run = |arguments: &[&[u8]]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        command.args(arguments.iter().map(|argument| OsStr::from_bytes(argument)));
        let output = command.output().expect("the program starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let sentence =
        |shown: &str| (Some(2), format!("error: an argument must be UTF-8 text, and this is not: {shown}\n"));
    let help = Command::new(env!("CARGO_BIN_EXE_biped")).arg("--help").output().expect("the program starts").stdout;
    let help = String::from_utf8(help).expect("text");
    let commands =
        help.lines().filter_map(|line| line.strip_prefix("  ")?.split_once("  ")).map(|(name, _)| name.trim());
    let commands: Vec<&str> = commands.filter(|name| name.starts_with(char::is_alphabetic)).collect(); // without exit codes and options
    assert!(commands.len() > 25 && commands.contains(&"sweep"), "{commands:?}");
    for command in commands {
        assert_eq!(run(&[command.as_bytes(), b"--no\xff"]), sentence("--no\\xff"), "{command}");
    }
    for command in ["run", "plant", "controller", "push", "list", "doctor", "study", "model", "export", "sweep"] {
        assert_eq!(run(&[command.as_bytes(), b"\xff\xc3"]), sentence("\\xff\\xc3"), "{command}");
    }
    assert_eq!(run(&[b"r\xc3\xa9\xff"]), sentence("ré\\xff"));
    assert_eq!(run(&[b"run", b"walk", b"--set=\xffa"]), sentence("--set=\\xffa"));
    // Other mistakes get their own messages, also beside a path of any bytes.
    let (code, errors) = run(&[b"run", b"walk", b"--out", b"/tmp/\xff", b"--bogus"]);
    assert!(code == Some(2) && errors.contains("unexpected argument '--bogus'"), "{errors}");
}

/// Reading /dev/zero to its end would use all memory.
#[test]
fn an_endless_file_is_not_read_forever() {
    let endless = "/dev/zero";
    for arguments in [&["run", endless][..], &["run", "walk", "--robot", endless], &["contact", endless]] {
        refused(arguments, &[endless, "this is not a file but a device"]);
    }
}

#[test]
fn an_error_in_a_file_is_shown_with_line_and_caret() {
    let path = std::env::temp_dir().join(format!("biped-test-{}-bad.toml", std::process::id()));
    let name = path.to_string_lossy().into_owned();
    for (text, words) in [
        ("[plant]\nfricton = 0.5\n", &["line 2", "^", "`friction`"][..]),
        ("[plant]\nlaw = \"Coulomb\"\n", &["line 2", "^", "`Aligned`"]),
        ("duration = \n", &["line 1", "^"]),
        ("duration = inf\n", &["duration = inf", "finite"]),
        ("[controller]\n[[bodies]]\nname = \"a\"\nmass = 1\nsize = [1, 1, 1]\n", &["joints = 0", "Table 1"]),
    ] {
        std::fs::write(&path, text).expect("a file");
        refused(&["run", &name], &[words, &[name.as_str()]].concat());
    }
    std::fs::write(&path, format!("duration = [{}", "[0.1, 0.05], ".repeat(10_000))).expect("a file");
    let (code, errors) = biped(&["run", &name]);
    assert!(code == Some(2) && errors.contains("line 1") && errors.len() < 1000, "{code:?}, {} bytes", errors.len());
    std::fs::remove_file(&path).expect("our own file");
    let robot = Command::new(env!("CARGO_BIN_EXE_biped")).args(["export", "toml"]).output().expect("a robot").stdout;
    std::fs::write(&path, robot).expect("a file");
    refused(&["run", &name], &["this is a robot", "--robot"]);
    let urdf = Command::new(env!("CARGO_BIN_EXE_biped")).args(["export", "urdf"]).output().expect("a robot").stdout;
    let urdf = String::from_utf8_lossy(&urdf).replacen("axis xyz=\"", "axis xyz=\"0 0 0\" was=\"", 1);
    std::fs::write(&path, urdf).expect("a file");
    refused(&["run", "walk", "--robot", &name], &["the axis of joint", "0 0 0"]);
    std::fs::remove_file(path).expect("our own file");
}

#[test]
fn a_report_folder_has_only_the_figures_of_its_last_run() {
    let folder = std::env::temp_dir().join(format!("biped-test-{}-figures", std::process::id()));
    let figures = |name: &str| -> Vec<_> {
        let out = folder.join(name);
        let run = |arguments: &[&str]| {
            let (code, errors) = biped(&[&["run", "--quiet", "--out", &out.display().to_string()], arguments].concat());
            assert_eq!(code, Some(0), "{errors}");
        };
        if name == "used" {
            run(&["walk", "--in-process", "--set", "duration=0.1"]);
        }
        run(&["slide"]);
        let files = std::fs::read_dir(out.join("figures")).expect("figures");
        let mut names: Vec<_> = files.map(|file| file.expect("a file").file_name()).collect();
        names.sort();
        names
    };
    assert_eq!(figures("used"), figures("fresh"));
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_file_of_the_user_in_the_output_folder_is_refused_before_the_work() {
    let folder = std::env::temp_dir().join(format!("biped-test-{}-own-files", std::process::id()));
    std::fs::create_dir(&folder).expect("a folder");
    let out = folder.display().to_string();
    for (command, file) in [
        (&["run", "slide"][..], "summary.json"),
        (&["chart", "--quick"], "chart.csv"),
        (&["chart", "--quick"], "step-slide.svg"),
        (&["chart", "--growth"], "growth.csv"),
        (&["chart", "--orders"], "orders.csv"),
        (&["latency"], "latency.html"),
        (&["study", "laws"], "laws.md"),
        (&["study", "problems"], "problems.csv"),
        (&["study", "pushes"], "pushes-walks.csv"),
        (&["soak"], "soak.csv"),
        (&["faults"], "faults.md"),
    ] {
        let path = folder.join(file);
        std::fs::write(&path, "notes of mine").expect("a file");
        let output = Command::new(env!("CARGO_BIN_EXE_biped")).args(command).args(["--out", &out]).output();
        let Output { status, stdout, stderr } = output.expect("the program starts");
        let errors = String::from_utf8_lossy(&stderr);
        assert_eq!(status.code(), Some(2), "{command:?}: {errors}");
        assert!(errors.lines().count() == 1 && errors.contains(file) && errors.contains("it is kept"), "{errors}");
        assert!(stdout.is_empty(), "{command:?}: {}", String::from_utf8_lossy(&stdout));
        assert_eq!(std::fs::read_to_string(&path).expect("it is kept"), "notes of mine");
        std::fs::remove_file(&path).expect("our own file");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_controller_that_exits_at_once_is_reported_before_the_patience_of_the_plant_ends() {
    let (code, errors) = biped(&["run", "walk", "--quiet", "--patience", "600", "--controller", "true"]);
    assert!(code == Some(3) && errors.contains("the controller exited with code 0"), "{code:?}: {errors}");
}

#[test]
fn an_infeasible_gait_falls_or_walks_without_a_panic() {
    let gait = ["--in-process", "--quiet", "--set", "duration=3", "--set", "controller.release_x2=0.101"];
    let (code, errors) = biped(&[&["run", "walk"], &gait[..]].concat());
    assert!(code == Some(0) || code == Some(7), "{code:?} {errors}");
}

#[test]
fn write_errors_are_reported_at_once() {
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
    let mut print = Command::new(env!("CARGO_BIN_EXE_biped"));
    let output = print.args(["export", "toml"]).stdout(full).output().expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(4) && errors.contains("cannot be written"), "{errors}");
    let scene = std::env::temp_dir().join(format!("biped-test-{}-own.toml", std::process::id()));
    std::fs::copy("messages/scenes/stand.toml", &scene).expect("a file");
    let name = scene.display().to_string();
    refused(&["run", &name, "--record", &name], &["is the input file"]);
    assert_eq!(std::fs::read(&scene).ok(), std::fs::read("messages/scenes/stand.toml").ok());
    std::fs::remove_file(scene).expect("our own file");
    for long in [
        &["run", "walk", "--realtime", "--set", "duration=1e6"][..],
        &["study", "endurance"],
        &["soak"],
        &["faults"],
        &["latency"],
        &["robustness"],
        &["chart"],
    ] {
        let (code, errors) = biped(&[long, &["--out", "README.md/x"]].concat());
        assert!(code == Some(4) && errors.contains("README.md/x cannot be written"), "{long:?}: {code:?} {errors}");
    }
}

#[test]
fn control_characters_of_arguments_do_not_reach_the_terminal() {
    for arguments in [
        &["run\rerror: none\u{8}"][..],
        &["run", "walk", "--\u{7}bell"],
        &["study", "\u{1b}[2J\r"],
        &["run", "\u{9b}2J"],
    ] {
        let (code, errors) = biped(arguments);
        let is_plain = !errors.contains(|character: char| character.is_control() && character != '\n');
        assert!(code == Some(2) && errors.starts_with("error: ") && is_plain, "{arguments:?}: {errors:?}");
    }
}

#[test]
fn help_documents_the_exit_codes() {
    let output = Command::new(env!("CARGO_BIN_EXE_biped")).arg("--help").output().expect("the program starts");
    let help = String::from_utf8_lossy(&output.stdout);
    for word in ["2  wrong arguments", "3  the other process", "7  the robot fell", "130  interrupted"] {
        assert!(help.contains(word), "{help}");
    }
}
