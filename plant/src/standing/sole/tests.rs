//! Claims about the distribution of a wrench over a sole.

use super::*;

const MU: f64 = 0.7;

/// A sole of 200 mm by 100 mm.
fn foot() -> Sole {
    let point = |(id, (x, y)): (usize, (f64, f64))| {
        let arm = Vector3::new(0.3 + x, y - 0.2, -0.6);
        Touch::new(id, 1, arm, 0.0)
    };
    let mut sole = Sole::default();
    let corners = [(0.1, 0.05), (0.1, -0.05), (-0.1, 0.05), (-0.1, -0.05)];
    sole.set(&corners.into_iter().enumerate().map(point).collect::<Vec<_>>());
    sole.prepare().expect("a sole");
    sole
}

/// Impulses of a load at a place on the sole, with friction there and a moment about the normal.
fn spread([x, y]: [f64; 2], friction_forces: [f64; 2], twist: f64) -> (Sole, SpatialPair, Option<Vec<Vector3<f64>>>) {
    let (mut sole, mut impulses) = (foot(), vec![Vector3::zeros(); 4]);
    let (load, yaw) = (0.1, twist + x * friction_forces[1] - y * friction_forces[0]);
    let wrench = [Vector3::new(friction_forces[0], friction_forces[1], 1.0) * load, Vector3::new(y, -x, yaw) * load];
    let found = sole.distribute(&wrench, MU, &mut impulses);
    (sole, wrench, found.map(|()| impulses))
}

/// Checks that the impulses are within the law; returns how far they are from the wrench.
fn lawful(sole: &Sole, wrench: &SpatialPair, impulses: &[Vector3<f64>]) -> f64 {
    for (d, f) in sole.arms.iter().zip(impulses) {
        assert!(f.z >= 0.0 && f.xy().norm() <= MU * f.z * (1.0 + 1e-12), "{f:?} at {d:?}");
    }
    let moment = |(d, f): (&Vector3<f64>, &Vector3<f64>)| d.cross(f);
    let sum: SpatialPair = [impulses.iter().sum(), sole.arms.iter().zip(impulses).map(moment).sum()];
    sum.iter().zip(wrench).fold(0.0_f64, |most, (a, b)| most.max((a - b).amax()))
}

#[test]
fn impulses_balance_the_wrench_within_the_law() {
    for place in [[0.0, 0.0], [0.07, -0.02], [-0.095, 0.0], [0.06, 0.03]] {
        for (friction_forces, twist) in
            [([0.0, 0.0], 0.0), ([0.2, -0.3], 0.0), ([0.05, 0.1], 0.01), ([0.0, -0.1], -0.015)]
        {
            let (sole, wrench, impulses) = spread(place, friction_forces, twist);
            let impulses = impulses.unwrap_or_else(|| panic!("{place:?} {friction_forces:?} {twist}"));
            let error = lawful(&sole, &wrench, &impulses);
            assert!(error < 1e-15, "{place:?} {friction_forces:?} {twist}: {error:e}");
        }
    }
}

#[test]
fn an_edge_carries_no_moment_about_itself() {
    let ends = [Vector3::new(0.1, 0.05, -0.6), Vector3::new(-0.1, 0.03, -0.6)];
    let touch = |(id, arm): (usize, Vector3<f64>)| Touch::new(id, 1, arm, 0.0);
    let touches: Vec<_> = ends.into_iter().enumerate().map(touch).collect();
    let (mut sole, mut impulses) = (Sole::default(), vec![Vector3::zeros(); 2]);
    sole.set(&touches);
    sole.prepare().expect("an edge");
    let carries = |share: f64, sole: &mut Sole, impulses: &mut [Vector3<f64>]| {
        let force = Vector3::new(0.02, -0.01, 0.1);
        let moment = (sole.arms[0] * share + sole.arms[1] * (1.0 - share)).cross(&force);
        assert!((sole.free_axes * moment).amax() < 1e-17, "{moment:?}");
        sole.distribute(&[force, moment], MU, impulses).map(|()| [force, moment])
    };
    for share in [0.1, 0.5, 0.9] {
        let [force, moment] = carries(share, &mut sole, &mut impulses).unwrap_or_else(|| panic!("{share}"));
        let moments: Vector3<f64> = sole.arms.iter().zip(&impulses).map(|(d, f)| d.cross(f)).sum();
        let error = (impulses[0] + impulses[1] - force).amax().max((moments - moment).amax());
        assert!(error < 1e-15, "{share}: {error:e}");
    }
    assert!(carries(1.01, &mut sole, &mut impulses).is_none(), "an end pulls");
    let between = Touch::new(2, 1, (ends[0] + ends[1]) * 0.5, 0.0);
    sole.set(&[touches[0], touches[1], between]);
    assert!(sole.prepare().is_none(), "three in line");
}

#[test]
fn a_sole_that_would_tip_or_slip_has_no_distribution() {
    for (place, friction_forces, twist) in [
        ([0.101, 0.0], [0.0, 0.0], 0.0),
        ([0.0, -0.051], [0.0, 0.0], 0.0),
        ([0.0, 0.0], [0.5, 0.6], 0.0),
        ([0.0, 0.0], [0.0, 0.0], 0.08), // more than mu times the distance of the contacts
    ] {
        let (.., impulses) = spread(place, friction_forces, twist);
        assert!(impulses.is_none(), "{place:?} {friction_forces:?} {twist}: {impulses:?}");
    }
}

/// The load moves to a place at which one contact carries nothing, to the edge of the sole, and slightly beyond each.
#[test]
fn the_wrench_is_balanced_to_rounding_near_tipping() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut none = 0;
    for _ in 0..20_000 {
        let offset = 10_f64.powf(-2.0 - 12.0 * rng.f64()) * if rng.bool() { 1.0 } else { -1.0 };
        let (along, angular_gain, far) = (0.1 + 0.8 * rng.f64(), [rng.bool(), rng.bool()], rng.bool());
        // |x|/a + |y|/b = 1, where one contact of four carries nothing, or an edge of the sole
        let [x, y] = if far { [1.0, along] } else { [along, 1.0 - along] };
        let turn = |x: f64, angular_gain: bool| if angular_gain { -x } else { x } * (1.0 + offset);
        let place = [0.1 * turn(x, angular_gain[0]), 0.05 * turn(y, angular_gain[1])];
        let (sole, wrench, impulses) = spread(place, [0.02, -0.05], 0.0);
        let outside = far && offset > 0.0;
        let Some(impulses) = impulses else {
            assert!(outside, "none at {place:?}, {offset:e} from where it would tip");
            none += 1;
            continue;
        };
        assert!(!outside || offset < 1e-12, "{offset:e} beyond the edge: {impulses:?}");
        let error = lawful(&sole, &wrench, &impulses);
        assert!(error < 2e-15, "{place:?}, {offset:e}: {error:e}");
    }
    assert!(none > 1000, "{none}");
}
