//! Combinations of values that are refused: no robot falls there, so they are neither survivors nor falls.

use super::{column, read, sweep};
use crate::common::fresh_path;

/// Areas of what survives, of what does not, and of what is refused: a cell each, and one in the legend.
const AREAS: [&str; 3] = ["#1F9D76", "#D03D78", "#8B949E"];

#[test]
fn a_refused_combination_is_a_state_of_its_own_in_table_map_and_sum() {
    let folder = fresh_path("sweep");
    // With a period of 0.9 s and 0.6 m/s a step is 0.27 m long, and a foot reaches 0.25 m.
    let axes = ["walk", "controller.period=0.6,0.9", "controller.speed=0.2,0.6", "--set", "duration=0.5"];
    let printed = sweep(&axes, &folder);
    assert!(printed.contains("3 of 3 runs survive, 1 refused: "), "{printed}");
    assert_eq!(column(&read(&folder.join("sweep.csv")), "outcome"), ["completed", "completed", "completed", "refused"]);
    let map = read(&folder.join("sweep.svg"));
    assert_eq!(areas(&map), [3 + 1, 1, 1 + 1], "{map}");
    assert_eq!([">survives<", ">does not<", ">refused<"].map(|words| texts(&map).matches(words).count()), [1, 1, 1]);
    // Two grounds on which a block slides, beside two on which it stays: nothing is refused, and nothing says so.
    let stick = ["stick", "plant.friction=0.2,0.8", "plant.incline_deg=20,21", "--set", "duration=0.2"];
    let printed = sweep(&[&stick[..], &["--survival", "distance_m<1e-6"]].concat(), &folder.join("stick"));
    let map = read(&folder.join("stick/sweep.svg"));
    assert!(printed.contains("2 of 4 runs survive: ") && !texts(&map).contains(">refused<"), "{printed}");
    assert_eq!(areas(&map), [2 + 1, 2 + 1, 0], "{map}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn survival_changes_in_the_curve_where_a_run_ends_otherwise_and_not_where_it_is_refused() {
    let folder = fresh_path("sweep");
    sweep(&["walk", "controller.speed=0.2,0.8,0.9", "--set", "duration=0.5"], &folder);
    let curve = texts(&read(&folder.join("sweep.svg")));
    assert!(
        curve.contains(">refused<") && !curve.contains("survival changes") && !curve.contains("does not"),
        "{curve}"
    );
    let edge = ["walk", "--edge", "controller.speed=0.2:0.9:2", "--tolerance", "0.01", "--set", "duration=0.5"];
    let printed = sweep(&edge, &folder.join("edge"));
    assert!(printed.contains("survives below, refused above"), "{printed}");
    assert!(!texts(&read(&folder.join("edge/sweep.svg"))).contains("survival changes"));
    let stick = ["stick", "plant.friction=0.2,0.8", "--survival", "distance_m<1e-6", "--set", "duration=0.2"];
    sweep(&stick, &folder.join("stick"));
    let curve = texts(&read(&folder.join("stick/sweep.svg")));
    assert!(curve.contains("survival changes") && !curve.contains(">refused<"), "{curve}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_row_without_a_threshold_says_so() {
    let folder = fresh_path("sweep");
    // The tangent of the slope is 0.09, 0.36 and 0.84.
    let axes = ["stick", "plant.incline_deg=5,20,40", "--edge", "plant.friction=0.2:0.6:3", "--tolerance", "0.01"];
    let printed = sweep(&[&axes[..], &["--survival", "distance_m<1e-6", "--set", "duration=0.2"]].concat(), &folder);
    for line in [
        "plant.incline_deg=5: survival does not change with plant.friction from 0.2 to 0.6\n",
        "plant.incline_deg=20: plant.friction = 0.3",
        "plant.incline_deg=40: no run with plant.friction from 0.2 to 0.6 survives\n",
    ] {
        assert!(printed.contains(line), "`{line}` is not in: {printed}");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}

fn areas(map: &str) -> [usize; 3] {
    AREAS.map(|fill| map.matches(&format!("<polygon opacity=\"0.45\" fill=\"{fill}\"")).count())
}

/// The texts of a drawing, each between `>` and `<`.
fn texts(drawing: &str) -> String {
    drawing.split_whitespace().collect::<Vec<_>>().join(" ").replace("> ", ">").replace(" <", "<")
}
