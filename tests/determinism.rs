//! Claims about determinism: the same scene gives the same bits, in one process or in two, until its end or a fall.

mod common;

use common::{run, run_two};
use std::process::Command;

fn same_bits(scene: &str, settings: &[&str]) {
    let first = run_two(scene, settings);
    for other in [run_two(scene, settings), run(scene, settings)] {
        assert_eq!(other.hash(), first.hash(), "{scene} {settings:?}");
        for key in ["duration_s", "distance_m", "lateral_max_m", "peak_force_n", "hop_max_m", "natural_map_max"] {
            assert_eq!(other.number(key).to_bits(), first.number(key).to_bits(), "{scene} {settings:?}: {key}");
        }
    }
}

#[test]
fn a_scene_without_a_controller_has_the_same_bits_in_both_modes() {
    same_bits("slide", &[]);
    same_bits("drop", &["initial.orientation_deg=[20.0, 10.0, 0.0]"]);
}

#[test]
fn random_disturbances_repeat_with_their_seed() {
    let late = ["duration=3", "plant.stale_probability=0.3", "plant.encoder_bits=14"];
    same_bits("walk", &late);
    let seeds = ["plant.seed=1", "plant.seed=2"].map(|seed| run("walk", &[&late[..], &[seed]].concat()));
    assert_ne!(seeds[0].hash(), seeds[1].hash());
}

/// The two modes detect the fall at different times, but their records end at the same control period.
#[test]
fn a_fall_ends_the_record_at_the_same_bit() {
    let push = ["plant.push_impulse=[0.0, 40.0, 0.0]", "plant.push_time=0.3", "duration=10"];
    assert!(run("stand", &push).fell());
    same_bits("stand", &push);
}

/// glibc chooses its version of `exp` and others by the processor. Without fused multiply-adds its `exp` rounds differently at 37.44 s.
#[test]
fn the_c_library_does_not_change_a_bit() {
    let hash = |tunables: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        command.args(["run", "stamp", "--in-process", "--quiet"]).env("GLIBC_TUNABLES", tunables);
        let printed = String::from_utf8(command.output().expect("the program runs").stdout).expect("text");
        printed.lines().find(|line| line.contains("trajectory hash")).map(String::from)
    };
    let plain = hash("");
    assert!(plain.is_some());
    assert_eq!(hash("glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2"), plain);
}
