//! Symmetry under mirroring, rotation and renumbering: scene 21. A thrown foot lands on a corner, tumbles, slides and comes to rest.

use crate::support::{pose, scene};
use messages::scene::Scene;
use nalgebra::{Matrix3, Rotation3, Vector3};
use plant::Plant;

/// Position, orientation and velocities of the base at every step.
fn path(scene: &Scene, steps: usize) -> Vec<[Vector3<f64>; 6]> {
    let mut plant = Plant::new(scene).expect("a foot");
    (0..steps)
        .map(|_| {
            plant.step().expect("a step");
            let pose = pose(&plant);
            let base = &pose.links[plant.model().base_link];
            let axes = [0, 1, 2].map(|k| base.rotation.column(k).into_owned());
            [pose.reference, axes[0], axes[1], axes[2], base.velocity.linear, base.velocity.angular]
        })
        .collect()
}

/// Largest difference between one path and the other one after `map`, and whether all bits are equal.
fn difference(
    one: &[[Vector3<f64>; 6]],
    other: &[[Vector3<f64>; 6]],
    map: impl Fn(&[Vector3<f64>; 6]) -> [Vector3<f64>; 6],
) -> (f64, bool) {
    let pairs = || one.iter().zip(other).map(|(a, b)| (map(a), *b));
    let same = pairs().all(|(a, b)| a == b);
    let worst = pairs().flat_map(|(a, b)| (0..6).map(move |k| (a[k] - b[k]).norm())).fold(0.0, f64::max);
    (worst, same)
}

#[test]
fn a_mirrored_world_moves_as_its_mirror_image_to_the_last_bit() {
    let scene = scene("tumbling-foot", &[]);
    let mut mirrored = scene.clone();
    let initial = &mut mirrored.initial;
    for i in [0, 2] {
        initial.orientation_deg[i] = -initial.orientation_deg[i];
        initial.angular_velocity[i] = -initial.angular_velocity[i];
    }
    initial.velocity[1] = -initial.velocity[1];
    mirrored.bodies[0].contacts.iter_mut().for_each(|point| point[1] = -point[1]);
    let flip = |v: &Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
    // mirroring reverses rotation axes and the body's own y axis
    let map = |s: &[Vector3<f64>; 6]| [flip(&s[0]), flip(&s[1]), -flip(&s[2]), flip(&s[3]), flip(&s[4]), -flip(&s[5])];
    let (worst, same) = difference(&path(&scene, 1500), &path(&mirrored, 1500), map);
    assert!(same, "mirrored: off by {worst:e}");
}

#[test]
fn the_numbering_of_contacts_does_not_change_a_bit() {
    let scene = scene("tumbling-foot", &[]);
    let reference = path(&scene, 1500);
    let mut random = fastrand::Rng::with_seed(21);
    for _ in 0..5 {
        let mut renumbered = scene.clone();
        random.shuffle(&mut renumbered.bodies[0].contacts);
        let (worst, same) = difference(&reference, &path(&renumbered, 1500), |s| *s);
        assert!(same, "renumbered: off by {worst:e}");
    }
}

#[test]
fn a_world_turned_by_37_degrees_moves_as_before() {
    let scene = scene("tumbling-foot", &[]);
    let turn: Matrix3<f64> = *Rotation3::from_axis_angle(&Vector3::z_axis(), 37f64.to_radians()).matrix();
    let mut turned = scene.clone();
    turned.initial.orientation_deg[2] += 37.0;
    turned.initial.velocity = (turn * Vector3::from(scene.initial.velocity)).into();
    turned.initial.angular_velocity = (turn * Vector3::from(scene.initial.angular_velocity)).into();
    let reference = path(&scene, 1500);
    let (worst, _) = difference(&reference, &path(&turned, 1500), |s| s.map(|v| turn * v));
    let greatest = reference.iter().flatten().map(|v| v.norm()).fold(0.0, f64::max); // the foot spins at 12 rad/s
    println!("turned: {worst:e} of {greatest}");
    assert!(worst < 3e-13 * greatest);
}
