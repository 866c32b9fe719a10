//! Thresholds of survival, where analysis gives them.

use crate::common::fresh_path;
use crate::{column, numbers, read, sweep};

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
fn every_change_of_survival_is_found_even_if_it_is_not_monotonic() {
    // A cube that slides at up to μgt = 0.981 m/s in either direction has come to rest after t = 0.2 s.
    let folder = fresh_path("sweep");
    let arguments = ["slide", "--edge", "initial.velocity.0=-2:2:9", "--tolerance", "0.001", "--set", "duration=0.2"];
    let printed = sweep(&[&arguments[..], &["--survival", "com_speed_end_mps<1e-6"]].concat(), &folder);
    let edges = read(&folder.join("edges.csv"));
    assert_eq!(column(&edges, "survives"), ["above", "below"]);
    let found = numbers(&edges, "initial.velocity.0");
    let exact = [-0.5 * 9.81 * 0.2, 0.5 * 9.81 * 0.2];
    assert!(found.iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 0.007), "{found:?}");
    assert!(printed.contains("need not be monotonic"), "{printed}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}
