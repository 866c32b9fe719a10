//! Theorems that hold for every robot in every state.

use crate::support::*;
use biped_plant::kinematics::{Totals, totals};
use biped_plant::model::Model;
use biped_plant::state::State;
use messages::scene::{Base, Scene};
use nalgebra::{DVector, Vector3};

/// The state a short time later or earlier, to second order.
fn after(model: &Model, state: &State, acceleration: &[f64], time: f64) -> State {
    let faster = |time: f64| state.xdot.iter().zip(acceleration).map(|(v, a)| v + time * a).collect();
    let mut later = State { xdot: faster(0.5 * time), ..state.clone() };
    later.advance(model, time);
    State { xdot: faster(time), ..later }
}

/// Derivative in time of a quantity along the motion under constant acceleration, by Richardson's extrapolation.
fn rate(case: &Case, acceleration: &[f64], quantity: impl Fn(&Totals) -> f64) -> f64 {
    let at = |time| {
        let case = Case::new(&case.model, &after(&case.model, &case.state, acceleration, time));
        quantity(&totals(&case.model, &case.state, &case.pose))
    };
    let slope = |h: f64| (at(h) - at(-h)) / (2.0 * h);
    let h = 2e-4;
    (4.0 * slope(0.5 * h) - slope(h)) / 3.0
}

#[test]
fn inertia_is_symmetric_positive_and_twice_the_kinetic_energy() {
    for_each_case(11, 10, |_, case| {
        let reference = biped_plant::dynamics::inertia(&case.model, &case.pose);
        close("transpose", reference.transpose().as_slice(), reference.as_slice(), 1e-13);
        assert!(case.inertia().symmetric_eigenvalues().min() > 0.0);
        let xdot = DVector::from_vec(case.state.xdot.clone());
        let energy = 0.5 * xdot.dot(&(case.inertia() * &xdot));
        close("½ xdotᵀH xdot", &[energy], &[totals(&case.model, &case.state, &case.pose).kinetic], 1e-13);
    });
}

#[test]
fn energy_changes_by_the_power_of_the_efforts_less_that_of_damping() {
    for_each_case(12, 10, |rng, case| {
        let u = random_efforts(rng, case.model.dofs());
        let acceleration = case.forward(u.as_slice());
        let xdot = &case.state.xdot;
        let lost: f64 = case.model.links[1..].iter().zip(xdot).map(|(link, rate)| link.damping * rate * rate).sum();
        assert!(lost > 0.0 || case.model.joint_dof.is_empty());
        let power = u.dot(&DVector::from_vec(xdot.clone())) - lost;
        let found = rate(&case, &acceleration, |sum| sum.kinetic + sum.potential);
        let scale: f64 = u.iter().zip(xdot).map(|(u, v)| (u * v).abs()).sum();
        assert!((found - power).abs() < 1e-7 * scale, "dE/dt is {found}, the power {power}");
    });
}

#[test]
fn only_gravity_moves_a_free_robot_and_nothing_turns_it() {
    for_each_case(13, 10, |rng, case| {
        if !matches!(case.model.base, Base::Virtual | Base::Quaternion) {
            return;
        }
        let mut u = random_efforts(rng, case.model.dofs());
        u.rows_mut(0, 6).fill(0.0);
        let acceleration = case.forward(u.as_slice());
        let weight = case.model.gravity * case.model.mass();
        for axis in 0..3 {
            // the momentum of the bodies does not contain the drives' inertia, and u_d - J_r qdd acts between two bodies
            let linear = rate(&case, &acceleration, |sum| sum.linear[axis]);
            let angular = rate(&case, &acceleration, |sum| sum.angular[axis]);
            assert!((linear - weight[axis]).abs() < 1e-6 * weight.norm(), "force {linear}, weight {}", weight[axis]);
            assert!(angular.abs() < 1e-6 * weight.norm(), "moment {angular}");
        }
    });
}

#[test]
fn virtual_joints_and_quaternion_give_the_same_motion() {
    let seed = 14;
    println!("seed {seed}");
    let mut rng = fastrand::Rng::with_seed(seed);
    for _ in 0..20 {
        let mut scene = random_tree(&mut rng, Base::Virtual);
        scene.initial.position = vector(&mut rng, 1.0);
        scene.initial.orientation_deg = vector(&mut rng, 70.0);
        scene.initial.velocity = vector(&mut rng, 2.0);
        scene.initial.angular_velocity = vector(&mut rng, 2.0);
        scene.initial.joints = (0..11).map(|_| rng.f64() - 0.5).collect();
        scene.initial.joint_rates = (0..11).map(|_| rng.f64() - 0.5).collect();
        let torques = random_efforts(&mut rng, 11);
        let motion = |scene: &Scene| {
            let model = model(scene);
            let case = Case::new(&model, &State::initial(&model, &scene.initial).expect("a good state"));
            let mut u = DVector::zeros(model.dofs());
            u.rows_mut(6, 11).copy_from(&torques);
            let acceleration = case.forward(u.as_slice());
            let sum = totals(&model, &case.state, &case.pose);
            let point = case.pose.point_velocity(model.contact_points[3].link, &model.contact_points[3].at);
            let joints = acceleration[6..].to_vec();
            [joints, acceleration[..3].to_vec(), point.as_slice().to_vec(), vec![sum.kinetic, sum.potential]]
        };
        let by_virtual_joints = motion(&scene);
        scene.plant.base = Base::Quaternion;
        for (found, expected) in motion(&scene).iter().zip(&by_virtual_joints) {
            close("motion", found, expected, 1e-10);
        }
    }
}

#[test]
fn a_planar_base_is_a_free_one_that_stays_in_its_plane() {
    let mut scene = bare_table_1(Base::Planar);
    scene.initial.position = [0.3, 0.0, 0.6];
    scene.initial.orientation_deg = [0.0, 20.0, 0.0];
    scene.initial.velocity = [0.4, 0.0, -0.2];
    scene.initial.angular_velocity = [0.0, 0.7, 0.0];
    // both legs alike and no ankle roll: the motion stays in the plane
    scene.initial.joints = vec![0.0, 0.5, -1.2, 0.7, -0.7, 1.2, -0.5, 0.0];
    scene.initial.joint_rates = vec![0.0, 1.0, 0.3, -0.6, 0.6, -0.3, -1.0, 0.0];
    let accelerations = [Base::Planar, Base::Quaternion].map(|base| {
        scene.plant.base = base;
        let model = model(&scene);
        let state = State::initial(&model, &scene.initial).expect("a good state");
        Case::new(&model, &state).forward(&vec![0.0; model.dofs()])
    });
    let [planar, free] = accelerations;
    let kept: Vec<f64> = [0, 2, 4].into_iter().chain(6..14).map(|dof| free[dof]).collect();
    close("acceleration", &planar, &kept, 1e-11);
    assert!([1, 3, 5].iter().all(|&dof: &usize| free[dof].abs() < 1e-10), "{free:?}");
}

#[test]
fn a_fixed_base_is_a_free_one_that_is_held() {
    let mut rng = fastrand::Rng::with_seed(15);
    let mut scene = random_tree(&mut rng, Base::Fixed);
    scene.initial.orientation_deg = [10.0, 40.0, -70.0];
    scene.initial.position = [1.0, 2.0, 3.0];
    scene.initial.joints = (0..11).map(|_| rng.f64() - 0.5).collect();
    scene.initial.joint_rates = (0..11).map(|_| rng.f64() - 0.5).collect();
    let [fixed, free] = [Base::Fixed, Base::Quaternion].map(|base| {
        scene.plant.base = base;
        let model = model(&scene);
        Case::new(&model, &State::initial(&model, &scene.initial).expect("a good state"))
    });
    close(
        "H of the joints",
        fixed.inertia().as_slice(),
        free.inertia().view((6, 6), (11, 11)).into_owned().as_slice(),
        1e-12,
    );
    close("b of the joints", &fixed.b, &free.b[6..], 1e-12);
}

#[test]
fn points_move_with_the_velocity_of_their_jacobian() {
    for_each_case(16, 5, |_, case| {
        let rest = vec![0.0; case.model.dofs()];
        for point in &case.model.contact_points {
            let at = |time: f64| {
                let later = Case::new(&case.model, &after(&case.model, &case.state, &rest, time));
                later.pose.point(point.link, &point.at)
            };
            let slope = |h: f64| (at(h) - at(-h)) / (2.0 * h);
            let found: Vector3<f64> = (slope(1e-4) * 4.0 - slope(2e-4)) / 3.0;
            let xdot = DVector::from_vec(case.state.xdot.clone());
            let expected = case.jacobian(point.link, &point.at) * xdot;
            let error = (found - &expected).amax();
            assert!(error < 1e-9 * (1.0 + expected.amax()), "{found} instead of {expected}");
        }
    });
}

#[test]
fn drive_inertia_and_damping_enter_at_the_joints_alone() {
    for base in BASES {
        let mut scene = bare_table_1(base);
        let model_without = model(&scene);
        let state = random_state(&mut fastrand::Rng::with_seed(17), &model_without);
        let without = Case::new(&model_without, &state);
        scene.plant.drive_inertia = 0.1;
        scene.plant.joint_damping = 0.4;
        let with = Case::new(&model(&scene), &state);
        let (h, b) = (with.inertia() - without.inertia(), &with.b);
        for i in 0..model_without.dofs() {
            let joint = model_without.joint_dof.contains(&i);
            for j in 0..model_without.dofs() {
                let expected = if joint && i == j { 0.1 } else { 0.0 };
                assert!((h[(i, j)] - expected).abs() < 1e-14, "J_r in H: {h}");
            }
            let expected = if joint { 0.4 * state.xdot[i] } else { 0.0 };
            assert!((b[i] - without.b[i] - expected).abs() < 1e-13 * (1.0 + b[i].abs()), "D in b");
        }
    }
}

#[test]
fn the_dynamics_have_the_same_bits_far_from_the_origin() {
    for base in [Base::Planar, Base::Virtual, Base::Quaternion] {
        let model = model(&bare_table_1(base));
        let state = random_state(&mut fastrand::Rng::with_seed(18), &model);
        let mut far = state.clone();
        far.x[0] += 1e6;
        let (near, far) = (Case::new(&model, &state), Case::new(&model, &far));
        assert_eq!((near.h, near.b), (far.h, far.b));
    }
}

#[test]
fn a_quaternion_turns_exactly_under_constant_angular_velocity() {
    let model = model(&bare_table_1(Base::Quaternion));
    let mut state = random_state(&mut fastrand::Rng::with_seed(19), &model);
    let spin = Vector3::new(state.xdot[3], state.xdot[4], state.xdot[5]);
    let start = Case::new(&model, &state).pose.links[model.base_link].rotation;
    for _ in 0..1000 {
        state.advance(&model, 1e-3);
    }
    let expected = nalgebra::Rotation3::from_scaled_axis(spin).into_inner() * start;
    let found = Case::new(&model, &state).pose.links[model.base_link].rotation;
    assert!((found - expected).amax() < 1e-12, "{found} instead of {expected}");
    assert!((state.x[3..7].iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-15);
    // and a rotation whose square underflows is not lost
    let mut slow = State::zero(&model);
    slow.xdot[4] = 1e-170;
    slow.advance(&model, 1.0);
    assert_eq!(slow.x[3..7], [1.0, 0.0, 0.5e-170, 0.0]);
}
