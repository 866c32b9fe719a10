//! Equations (8)-(11) as printed do not give the motion; with the signs of `biped_plant::dynamics` they do.

use crate::reference_data::{floating, signed, state_of};
use crate::support::*;
use biped_plant::dynamics::{self, Given};
use biped_plant::state::State;
use messages::scene::Base;
use nalgebra::Vector3;

/// The signs and terms in question.
#[derive(Clone, Copy)]
struct Interpretation {
    /// Sign of the moment arm's cross product in (10).
    arm: f64,
    /// Sign of u_j f_EXTj in (9).
    external: f64,
    /// Factor of the external force's own moment, which (10) lacks.
    external_moment: f64,
    /// Whether to use the parent's w_{i-1}, wd_{i-1} where (8) omits the index.
    late_index: bool,
}

const CORRECTED: Interpretation =
    Interpretation { arm: -1.0, external: -1.0, external_moment: -1.0, late_index: false };

/// The recursion (2)-(11) on a tree with revolute joints, under one external force on `link` at `arm`.
fn recursion(case: &Case, given: &Given, reading: Interpretation) -> Vec<f64> {
    let (model, links) = (&case.model, case.model.links.len());
    let zero = vec![Vector3::zeros(); links];
    let (mut w, mut wd, mut pdd, mut f, mut n) = (zero.clone(), zero.clone(), zero.clone(), zero.clone(), zero);
    pdd[0] = -given.gravity;
    for i in 1..links {
        let (link, parent, here) = (&model.links[i], model.links[i].parent, &case.pose.links[i]);
        let (qd, qdd, z) = (given.rate[i - 1], given.acceleration[i - 1], here.column.angular);
        let p = here.origin - case.pose.links[parent].origin;
        w[i] = w[parent] + z * qd;
        wd[i] = wd[parent] + z * qdd + w[link.carrier].cross(&(z * qd));
        pdd[i] = pdd[parent] + wd[parent].cross(&p) + w[parent].cross(&w[parent].cross(&p)) + here.column.linear * 0.0;
        if z == Vector3::zeros() {
            pdd[i] += here.column.linear * qdd;
        }
    }
    let mut u = vec![0.0; links - 1];
    for i in (1..links).rev() {
        let (link, here) = (&model.links[i], &case.pose.links[i]);
        let s = here.com - here.origin;
        let rdd = pdd[i] + wd[i].cross(&s) + w[i].cross(&w[i].cross(&s));
        let k = if reading.late_index { link.parent } else { i };
        f[i] += rdd * link.mass;
        n[i] += &here.tensor * &wd[k] + w[k].cross(&(&here.tensor * &w[i]));
        for force in given.forces.iter().filter(|force| force.link == i) {
            f[i] += force.force * reading.external;
            n[i] += (force.arm - here.com).cross(&force.force) * reading.external_moment;
        }
        let total = n[i] + (here.origin - here.com).cross(&f[i]) * reading.arm;
        u[i - 1] = here.column.angular.dot(&total);
        if here.column.angular == Vector3::zeros() {
            u[i - 1] = here.column.linear.dot(&f[i]);
        }
        let force = f[i];
        let arm = here.origin - case.pose.links[link.parent].com;
        f[link.parent] += force;
        n[link.parent] += total + arm.cross(&force);
    }
    u
}

/// Greatest relative error over the reference data of inverse dynamics, for one reading of the equations.
fn worst(reading: Interpretation) -> f64 {
    let model = model(&bare_table_1(Base::Quaternion));
    let error_of = |data: &serde_json::Value| {
        let case = Case::new(&model, &state_of(&model, data));
        let acceleration = signed(&data["acc"]);
        let given = Given { rate: &case.state.xdot, acceleration: &acceleration, gravity: model.gravity, forces: &[] };
        error(&recursion(&case, &given, reading), &signed(&data["tau_id"]))
    };
    floating().iter().map(error_of).fold(0.0, f64::max)
}

#[test]
fn equation_8_needs_the_links_own_index_and_10_the_other_sign() {
    assert!(worst(CORRECTED) < 1e-11);
    assert!(worst(Interpretation { late_index: true, ..CORRECTED }) > 1e-3);
    assert!(worst(Interpretation { arm: 1.0, ..CORRECTED }) > 1e-1);
}

#[test]
fn equations_9_and_10_need_the_force_of_the_ground_on_the_link_and_its_moment() {
    let model = model(&bare_table_1(Base::Quaternion));
    let rest = vec![0.0; 14];
    for data in &floating() {
        let case = Case::new(&model, &state_of(&model, data));
        for point in &model.contact_points {
            let force =
                dynamics::Force { link: point.link, arm: case.pose.arm(point.link, &point.at), force: Vector3::z() };
            let given = Given { rate: &rest, acceleration: &rest, gravity: Vector3::zeros(), forces: &[force] };
            // with u = -K f, K is the row of the Jacobian, which the reference data confirms
            let k: Vec<f64> = case.jacobian(point.link, &point.at).row(2).iter().copied().collect();
            let map = |reading| recursion(&case, &given, reading).iter().map(|u| -u).collect::<Vec<_>>();
            close("K", &map(CORRECTED), &k, 1e-11);
            let printed = map(Interpretation { external: 1.0, external_moment: 1.0, ..CORRECTED });
            close("-K", &printed.iter().map(|k| -k).collect::<Vec<_>>(), &k, 1e-11);
            assert!(error(&map(Interpretation { external_moment: 0.0, ..CORRECTED }), &k) > 1e-3);
        }
    }
}

#[test]
fn equation_11_as_printed_would_add_energy_by_damping() {
    let mut scene = bare_table_1(Base::Fixed);
    scene.plant.gravity = 0.0;
    scene.plant.joint_damping = 0.5;
    let model = model(&scene);
    let state = random_state(&mut fastrand::Rng::with_seed(21), &model);
    let case = Case::new(&model, &state);
    let power = |sign: f64| {
        // b with D as here (+1) and as printed (-1), and the resulting change of energy
        let mut bias = case.b.clone();
        bias.iter_mut().zip(&state.xdot).for_each(|(b, rate)| *b += (sign - 1.0) * 0.5 * rate);
        let undamped = Case::new(&self::model(&bare(&scene)), &state).b;
        -bias.iter().zip(&undamped).zip(&state.xdot).map(|((b, c), rate)| (b - c) * rate).sum::<f64>()
    };
    let squares: f64 = state.xdot.iter().map(|rate| rate * rate).sum();
    close("power", &[power(1.0), power(-1.0)], &[-0.5 * squares, 0.5 * squares], 1e-12);
}

fn bare(scene: &messages::scene::Scene) -> messages::scene::Scene {
    let mut bare = scene.clone();
    bare.plant.joint_damping = 0.0;
    bare
}

#[test]
fn the_recursion_with_both_signs_corrected_equals_the_crates_recursion() {
    for_each_case(22, 2, |_, case| {
        let slides = |link: &biped_plant::model::Link| link.motion == biped_plant::model::Motion::Prismatic;
        if case.model.links[case.model.base_link + 1..].iter().any(slides) {
            return;
        }
        let rest = State::zero(&case.model).xdot;
        let given = Given { rate: &case.state.xdot, acceleration: &rest, gravity: case.model.gravity, forces: &[] };
        let damping = case.model.links[1..].iter().zip(&case.state.xdot).map(|(link, rate)| link.damping * rate);
        let damped: Vec<f64> = recursion(&case, &given, CORRECTED).iter().zip(damping).map(|(u, d)| u + d).collect();
        close("b", &damped, &dynamics::bias(&case.model, &case.pose, &case.state.xdot), 1e-12);
    });
}
