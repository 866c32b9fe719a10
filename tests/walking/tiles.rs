//! Claims about walking over tiles of different heights, which the controller does not know.

use crate::common::{run, run_all};

/// The controller does not know the ground. The heights of neighbouring tiles differ by up to 2 mm. `docs/notes/gait.md` says where it falls.
#[test]
fn it_walks_blind_over_low_tiles() {
    let level = "plant.ground.tiles=[{x = [-1.0, 0.15], height = 0.0}]"; // where it starts
    let seeds: Vec<String> = (1..=3).map(|seed| format!("plant.ground.random.seed={seed}")).collect();
    let cases: Vec<[&str; 4]> =
        seeds.iter().map(|seed| ["duration=30", level, "plant.ground.random.height=0.001", seed.as_str()]).collect();
    let plane = run("walk", &["duration=30"]);
    for summary in run_all("walk", &cases) {
        summary.assert_ranges(&[("speed_mps", 0.18..=0.22), ("yaw_deg", -20.0..=20.0)]);
        assert_ne!(summary.hash(), plane.hash(), "the tiles have to have an effect");
    }
}

/// Tiles of ±4 and ±5 mm. A foot that lands on a higher place keeps its height (`controller/src/gait/touch.rs`). Each fall is chaotic, so the
/// claim counts: 9 of these 16 walks survive, and 2 without that rule. The seeds are not those that chose it.
#[test]
fn a_foot_that_keeps_its_height_where_it_lands_survives_higher_tiles() {
    let level = "plant.ground.tiles=[{x = [-1.0, 0.15], height = 0.0}]"; // where it starts
    let heights = ["0.004", "0.005"].map(|height| format!("plant.ground.random.height={height}"));
    let seeds: Vec<String> = (301..=308).map(|seed| format!("plant.ground.random.seed={seed}")).collect();
    let cases: Vec<[&str; 4]> = heights
        .iter()
        .flat_map(|height| seeds.iter().map(move |seed| ["duration=40", level, height.as_str(), seed.as_str()]))
        .collect();
    let summaries = run_all("walk", &cases);
    let survivors = summaries.iter().filter(|summary| !summary.fell()).count();
    assert!(survivors >= 5, "{survivors} of {} walks survive", cases.len());
}
