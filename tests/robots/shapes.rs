//! Claims about robots of other sizes and shapes.

use crate::common::{RobotFile, run, run_two, scene, shanks, similar};
use controller::Controller;
use messages::robot::{Body, DriveParameters, Robot, SimilarityScale, table_1};
use messages::scene::Scene;
use plant::Plant;

pub const LENGTH: f64 = 1.5;

#[test]
fn a_robot_one_and_a_half_times_as_large_walks_as_dynamic_similarity_says() {
    let file = RobotFile::new(&similar(LENGTH));
    let (small, large) = (run("walk", &[]), run_two("walk", &[&file.setting()]));
    let time = LENGTH.sqrt();
    let near = |value: f64, share: f64| value * (1.0 - share)..=value * (1.0 + share);
    large.assert_ranges(&[
        ("speed_mps", near(small.number("speed_mps") * time, 0.01)),
        ("period_s", near(small.number("period_s") * time, 1e-3)),
        ("x2_min_m", near(small.number("x2_min_m") * LENGTH, 0.01)),
        ("foot_tilt_max_deg", 0.0..=0.2),
        ("fallbacks", 0.0..=0.0),
    ]);
}

/// Joint angles in each control period.
fn angles(scene: &Scene) -> Vec<[f64; 8]> {
    let mut plant = Plant::new(scene).expect("a good scene");
    let mut controller = Controller::new(scene).expect("a controller");
    let mut encoders = plant.encoders();
    let periods = (scene.duration * scene.rate).round() as usize;
    let period = |_| {
        let torques = controller.tick(&encoders).expect("a task that can be resolved");
        encoders = plant.advance(&torques).expect("a period");
        plant.truth().angle
    };
    (0..periods).map(period).collect()
}

/// Largest difference between the joint angles of the robot of Table 1 and those of another robot at the same scaled time: over the first
/// 2.5 s, which have four steps, and over the whole walk [rad].
fn difference(robot: &Robot, settings: &[&str]) -> [f64; 2] {
    let file = RobotFile::new(robot);
    let time = SimilarityScale::between(&table_1(), &robot.bodies).time();
    let clocks =
        [format!("rate={}", 1000.0 / time), format!("plant.dt={}", time / 1000.0), format!("duration={}", 14.0 * time)];
    let own = [&[file.setting()], &clocks[..]].concat();
    let settings: Vec<&str> = own.iter().map(String::as_str).chain(settings.iter().copied()).collect();
    let (small, large) = (angles(&scene("walk", &[])), angles(&scene("walk", &settings)));
    assert_eq!(small.len(), large.len());
    [2500, small.len()].map(|count| {
        let pairs = small.iter().take(count).flatten().zip(large.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    })
}

/// A length ratio of 4 gives a time ratio of 2, so scaling causes no rounding and every phase starts at the same scaled control period. The two
/// walks are equal bit for bit for 1.1 s. Then absolute tolerances of the contact solver cause a small difference, which grows until a foot
/// lands one period earlier or later. After that, the observer keeps the two walks close together.
#[test]
fn a_similar_robot_moves_like_the_small_one_in_scaled_time() {
    let same = difference(&similar(4.0), &[]);
    let lighter = difference(&similar(4.0), &["plant.drive_inertia=80"]);
    println!("joint angles differ by {same:?} rad at most; {lighter:?} rad with drives a little lighter");
    assert!(same[0] < 1e-8 && same[1] < 5e-3, "{same:?} rad");
    assert!(lighter[0] > 1e5 * same[0] && lighter[1] > 2.0 * same[1], "{lighter:?} beside {same:?} rad");
}

#[test]
fn a_robot_with_shanks_a_fifth_longer_walks() {
    let robot = shanks(1.2);
    let file = RobotFile::new(&robot);
    let time = SimilarityScale::between(&table_1(), &robot.bodies).time();
    run("walk", &[&file.setting()]).assert_ranges(&[
        ("speed_mps", 0.199 * time..=0.202 * time),
        ("period_s", 0.599 * time..=0.601 * time),
        ("yaw_deg", -0.1..=0.1),
        ("foot_tilt_max_deg", 0.0..=0.2),
    ]);
}

/// The robot of Table 1 with changes to some bodies.
fn changed(bodies: &[usize], change: impl Fn(&mut Body)) -> Robot {
    let mut robot = similar(1.0);
    bodies.iter().for_each(|&body| change(&mut robot.bodies[body]));
    robot
}

pub fn thighs(length: f64) -> Robot {
    let mut robot = changed(&[3, 5], |thigh| (thigh.size[2], thigh.com[2]) = (0.2 * length, -0.1 * length));
    for shank in [2, 6] {
        robot.bodies[shank].joint.as_mut().expect("a knee").at[2] = -0.2 * length;
    }
    robot
}

fn hips(width: f64) -> Robot {
    changed(&[3, 5], |thigh| thigh.joint.as_mut().expect("a hip").at[1] *= width)
}

fn soles(length: f64) -> Robot {
    changed(&[0, 8], |foot| foot.contacts.iter_mut().for_each(|corner| corner[0] *= length))
}

fn trunk(mass: f64) -> Robot {
    changed(&[4], |trunk| trunk.mass *= mass)
}

fn trunk_on_weak_drives(mass: f64) -> Robot {
    let drives = DriveParameters { inertia: Some(0.1), torque_limit: Some(40.0), ..DriveParameters::default() };
    Robot { drives, ..trunk(mass) }
}

fn legs(mass: f64) -> Robot {
    changed(&[2, 3, 5, 6], |bone| bone.mass *= mass)
}

/// The limits in the table of docs/SCENES.md.
#[test]
fn robots_walk_within_a_documented_distance_from_table_1() {
    type Kind = (&'static str, fn(f64) -> Robot, &'static [f64], &'static [f64]);
    let kinds: [Kind; 8] = [
        ("all lengths", similar, &[0.02, 0.03, 0.1, 0.5, 2.0, 10.0, 50.0], &[0.01]),
        ("length of the shanks", shanks, &[0.25, 0.35, 0.5, 1.2, 2.0, 3.0], &[]),
        ("length of the thighs", thighs, &[0.4, 0.5, 0.8, 1.2, 2.0, 3.0], &[]),
        ("distance of the hips", hips, &[0.2, 0.35, 0.5, 0.7, 1.5, 2.0, 3.0, 4.5], &[5.5]),
        ("length of the soles", soles, &[0.25, 0.35, 0.5, 0.7, 2.0, 3.0], &[0.1, 0.15, 0.2]),
        ("mass of the trunk", trunk, &[0.1, 0.5, 2.0, 3.0, 5.0, 8.0, 15.0, 30.0], &[]),
        ("the same, drives as they are", trunk_on_weak_drives, &[2.5, 5.0, 8.0, 11.0], &[12.0]),
        ("mass of thighs and shanks", legs, &[0.1, 0.5, 2.0, 8.0, 20.0], &[]),
    ];
    let mut wrong = Vec::new();
    for (what, robot, walk, fall) in kinds {
        println!("{what:<28} walks at {walk:?} times Table 1's, falls at {fall:?}");
        for (factors, falls) in [(walk, false), (fall, true)] {
            for &factor in factors {
                let fell = run("walk", &[&RobotFile::new(&robot(factor)).setting()]).fell();
                if fell != falls {
                    wrong.push(format!("{what} times {factor}: falls: {fell}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
