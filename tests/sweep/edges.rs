//! Thresholds of survival.

use super::{biped, column, numbers, output, read, sweep};
use crate::common::fresh_path;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::time::{Duration, Instant};

#[test]
fn the_edge_of_a_block_on_a_slope_is_the_tangent_of_its_angle() {
    let folder = fresh_path("sweep");
    let arguments = ["stick", "plant.incline_deg=20,26", "--edge", "plant.friction=0.2:0.8:7", "--set", "duration=0.5"];
    let survival = ["--survival", "distance_m<1e-6", "--tolerance", "1e-5"];
    let printed = sweep(&[&arguments[..], &survival].concat(), &folder);
    let edges = read(&folder.join("edges.csv"));
    assert_eq!(column(&edges, "survives"), ["above", "above"]);
    let exact = [20f64, 26.0].map(|degrees| degrees.to_radians().tan());
    for (found, exact) in numbers(&edges, "plant.friction").iter().zip(exact) {
        assert!((found - exact).abs() <= 1.1e-5, "{found} is not {exact}");
    }
    assert!(numbers(&edges, "half_width").iter().all(|half| *half <= 1e-5), "{edges}");
    assert!(
        printed.contains("plant.incline_deg=20: plant.friction = 0.36") && printed.contains("survives above"),
        "{printed}"
    );
    // On the rough side alone nothing changes.
    let rough = ["stick", "--edge", "plant.friction=0.6:0.8", "--survival", "distance_m<1e-6", "--set", "duration=0.1"];
    let printed = sweep(&rough, &folder.join("rough"));
    assert!(printed.contains("survival does not change with plant.friction from 0.6 to 0.8"), "{printed}");
    assert!(column(&read(&folder.join("rough/edges.csv")), "survives").is_empty());
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_killed_search_for_thresholds_goes_on_where_it_stopped() {
    let folder = fresh_path("sweep");
    let inclines = "plant.incline_deg=20,21,22,23,24,25,26,27";
    let ranges = ["sweep", "stick", inclines, "--edge", "plant.friction=0.2:0.8:3", "--set", "duration=0.5"];
    let ranges = [&ranges[..], &["--survival", "distance_m<1e-6", "--tolerance", "1e-9"]].concat();
    let (killed, found) = (folder.join("killed"), folder.join("killed/edges-found.csv"));
    let mut child = biped(&ranges).arg("--out").arg(&killed).spawn().expect("the program starts");
    let start = Instant::now();
    while read(&found).lines().count() < 4 && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    kill(Pid::from_raw(child.id() as i32), Signal::SIGKILL).expect("our own child");
    child.wait().expect("an end");
    let lines: Vec<String> = read(&found).split_inclusive('\n').map(String::from).collect();
    assert!((4..10).contains(&lines.len()), "killed too early or too late to tell anything: {lines:?}");
    // A threshold that was found is not searched for again, so its false value stays.
    let cells: Vec<&str> = lines[2].split(',').collect();
    let false_row = [&cells[..2], &["0.75"], &cells[3..]].concat().join(",");
    std::fs::write(&found, [&lines[..2], &[false_row], &lines[3..]].concat().concat()).expect("a table");
    sweep(&ranges[1..], &killed);
    sweep(&ranges[1..], &folder.join("whole"));
    let [resumed, whole] =
        [&killed, &folder.join("whole")].map(|folder| numbers(&read(&folder.join("edges.csv")), "plant.friction"));
    assert_eq!((resumed.len(), whole.len()), (8, 8));
    assert_eq!(
        resumed.iter().zip(&whole).filter(|(resumed, whole)| resumed != whole).count(),
        1,
        "{resumed:?} {whole:?}"
    );
    assert!(resumed.contains(&0.75) && !found.exists());
    let map = read(&folder.join("whole/sweep.svg"));
    assert!(map.contains("survival changes"), "a map of two keys shows the thresholds");
    // Another tolerance is another search.
    std::fs::write(&found, lines.concat()).expect("a table");
    let other = output(&[&ranges[1..8], &["distance_m<1e-5"]].concat(), &killed);
    let words = String::from_utf8_lossy(&other.stderr);
    assert!(other.status.code() == Some(2) && words.contains("is the table of another sweep"), "{words}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_rigid_robot_tips_over_where_its_weight_leaves_the_sole() {
    // Two feet on a stiff hip each: the soles end 0.1 m downhill, and the centre of mass is 0.25 m above them.
    let foot = |name: &str, y: f64| {
        format!(
            "[[bodies]]\nname = \"{name} foot\"\nmass = 1.0\nsize = [0.2, 0.1, 0.1]\n\
             joint = {{ parent = \"trunk\", axis = [1.0, 0.0, 0.0], at = [0.0, {y}, -0.25], stiffness = 1e5, damping = 1e3, rest = 0.0 }}\n\
             contacts = [[0.1, 0.05, -0.05], [0.1, -0.05, -0.05], [-0.1, 0.05, -0.05], [-0.1, -0.05, -0.05]]\n"
        )
    };
    let text = format!(
        "duration = 6.0\n[plant]\ndt = 0.001\nfriction = 1.5\nincline_deg = 10.0\n[initial]\nclearance = 0.0\n\
         [[bodies]]\nname = \"trunk\"\nmass = 8.0\nsize = [0.1, 0.1, 0.3]\n{}{}",
        foot("left", 0.1),
        foot("right", -0.1)
    );
    let folder = fresh_path("sweep");
    std::fs::create_dir_all(&folder).expect("a folder");
    let scene = folder.join("tips.toml");
    std::fs::write(&scene, text).expect("a scene");
    let scene = scene.to_str().expect("a name");
    sweep(&[scene, "--edge", "plant.incline_deg=5:40:8", "--tolerance", "0.01"], &folder);
    let edges = read(&folder.join("edges.csv"));
    // Feet: 2 kg at 0.05 m; trunk: 8 kg at 0.3 m.
    let exact = (0.1_f64 / ((2.0 * 0.05 + 8.0 * 0.3) / 10.0)).atan().to_degrees();
    let found = numbers(&edges, "plant.incline_deg");
    assert!(found.len() == 1 && (found[0] - exact).abs() < 0.1, "{found:?} is not {exact}");
    assert_eq!(column(&edges, "survives"), ["below"]);
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn the_border_to_scenes_that_are_refused_is_no_threshold_of_survival() {
    let folder = fresh_path("sweep");
    let arguments = ["walk", "--edge", "controller.com_height=0.27:0.4:5", "--tolerance", "0.005"];
    let printed = sweep(&[&arguments[..], &["--set", "duration=1"]].concat(), &folder);
    assert!(printed.contains(": survives below, refused above\n") && !printed.contains("not above"), "{printed}");
    let edges = read(&folder.join("edges.csv"));
    assert_eq!([column(&edges, "survives"), column(&edges, "refused")].concat(), ["below", "true"]);
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn every_change_of_survival_is_found_even_if_it_is_not_monotonic() {
    // A cube that slides at up to μgt = 0.981 m/s in either direction has come to rest after t = 0.2 s.
    let folder = fresh_path("sweep");
    let arguments = ["slide", "--edge", "initial.velocity.0=-2:2:9", "--tolerance", "0.001", "--set", "duration=0.2"];
    let printed = sweep(&[&arguments[..], &["--survival", "com_speed_end_mps<1e-6"]].concat(), &folder);
    let edges = read(&folder.join("edges.csv"));
    assert_eq!(column(&edges, "survives"), ["above", "below"]);
    assert_eq!(column(&edges, "refused"), ["false", "false"]);
    let found = numbers(&edges, "initial.velocity.0");
    let exact = [-0.5 * 9.81 * 0.2, 0.5 * 9.81 * 0.2];
    assert!(found.iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 0.007), "{found:?}");
    assert!(printed.contains("need not be monotonic"), "{printed}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}
