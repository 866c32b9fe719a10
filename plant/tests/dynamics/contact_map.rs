//! The contact problem of a step: its rows are velocities of points, and its columns are the effects of unit impulses.

use crate::support::*;
use biped_plant::Plant;
use biped_plant::composite::Composite;
use biped_plant::delassus::{ContactMap, Free};
use biped_plant::detect::Touch;
use biped_plant::factor::Factor;
use biped_plant::kinematics::{self, Pose};
use biped_plant::model::ContactPoint;
use messages::robot::Body;
use messages::scene::{Base, Law, Method, Scene};
use messages::wire::Torques;
use nalgebra::{DVector, Vector3};

/// All contact points of a robot.
fn touches(case: &Case) -> Vec<Touch> {
    let corners = case.model.contact_points.iter().enumerate();
    corners.map(|(id, c)| Touch::new(id, c.link, case.pose.arm(c.link, &c.at), 0.0)).collect()
}

/// An impulse of one row acts along that row's direction, and changes every row as A predicts, along the free slip or the axes of W.
#[test]
fn a_unit_impulse_along_a_row_changes_the_velocity_along_every_row_by_its_column() {
    for_each_case(20, 3, |rng, case| {
        let Case { model, pose, .. } = &case;
        let factor = Factor::of(model, &case.h).expect("a positive H");
        let rate: Vec<f64> = (0..model.dofs()).map(|_| 2.0 * rng.f64() - 1.0).collect();
        let (free, touches) = (Free { pose, factor: &factor, rate: &rate }, touches(&case));
        let velocity = |i: usize, rate: &[f64]| {
            let point = &model.contact_points[touches[i].id];
            let v = case.jacobian(point.link, &point.at) * DVector::from_column_slice(rate);
            Vector3::new(v[0], v[1], v[2])
        };
        for law in [Law::Cone, Law::Aligned] {
            let mut map = ContactMap::new(model);
            map.drift(model, &free, &touches, law, |_, drift| drift);
            let problem = map.assemble(model, &free, &touches).clone();
            let (rows, stride) = (problem.rows(), 1 + problem.tangents);
            assert_eq!(problem.tangents, model.directions);
            let responses: Vec<(Vector3<f64>, Vec<f64>)> = (0..rows)
                .map(|row| {
                    let unit: Vec<f64> = (0..rows).map(|k| f64::from(u8::from(k == row))).collect();
                    let response = map.respond(model, &factor, &unit);
                    let elsewhere = response.impulses.iter().enumerate().filter(|(i, _)| *i != row / stride);
                    elsewhere.for_each(|(_, f)| assert_eq!(*f, Vector3::zeros()));
                    (response.impulses[row / stride], response.change.to_vec())
                })
                .collect();
            // A point may be unable to move along an axis, so errors are relative to the largest entry of all columns.
            let same = |what: &str, found: &[f64], exact: &[f64], scale: f64| {
                let error = found.iter().zip(exact).fold(0.0_f64, |error, (a, b)| error.max((a - b).abs()));
                assert!(error <= 1e-11 * scale, "{law}: {what} differs by {error:e} of {scale:e}");
            };
            let greatest = |x: &[f64]| x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let quick = responses.iter().map(|(_, change)| greatest(change)).fold(0.0, f64::max);
            for (i, touch) in touches.iter().enumerate() {
                let v = velocity(i, &rate);
                let slip = v.xy().norm();
                let along =
                    if law == Law::Cone || slip == 0.0 { Vector3::x() } else { Vector3::new(v.x, v.y, 0.0) / slip };
                let axes = [Vector3::z(), along, Vector3::z().cross(&along)];
                for (k, axis) in axes[..stride].iter().enumerate() {
                    let row = i * stride + k;
                    close("direction of a row", responses[row].0.as_slice(), axis.as_slice(), 1e-12);
                    assert!((problem.drift[row] - v.dot(axis)).abs() < 1e-12 * (1.0 + v.norm()), "{law}: drift");
                    let effort = case.jacobian(touch.link, &model.contact_points[touch.id].at).transpose() * axis;
                    same("H⁻¹Kf", &responses[row].1, &case.solve(effort.as_slice()), quick);
                }
            }
            for (row, (_, change)) in responses.iter().enumerate() {
                let column: Vec<f64> = (0..rows).map(|k| problem.delassus[k * rows + row]).collect();
                let moved: Vec<f64> = (0..rows).map(|k| velocity(k / stride, change).dot(&responses[k].0)).collect();
                same("column of A", &column, &moved, greatest(&problem.delassus));
            }
        }
    });
}

/// A plate that slides and turns: each point has the velocity v + ω × r along the axes z, x, y of W, minus a step of free fall.
#[test]
fn rows_of_round_cones_are_the_axes_of_the_world() {
    let corners = [[0.1, 0.05, -0.02], [0.1, -0.05, -0.02], [-0.1, 0.05, -0.02], [-0.1, -0.05, -0.02]];
    let plate =
        Body { name: "plate".into(), mass: 2.0, size: [0.2, 0.1, 0.04], contacts: corners.into(), ..Body::default() };
    let mut scene = Scene { bodies: vec![plate], ..Scene::default() };
    (scene.plant.base, scene.plant.method, scene.plant.law) = (Base::Quaternion, Method::SemiImplicitEuler, Law::Cone);
    (scene.plant.dt, scene.rate, scene.plant.gravity) = (1e-3, 1e3, 9.81);
    scene.initial.clearance = Some(0.0);
    (scene.initial.velocity, scene.initial.angular_velocity) = ([0.3, -0.4, 0.0], [0.0, 0.0, 2.0]);
    let mut plant = Plant::new(&scene).expect("a plate");
    plant.advance(&Torques::default()).expect("a step");
    let problem = plant.problem();
    assert_eq!((problem.contacts, problem.tangents), (4, 2));
    for (id, drift) in problem.id.iter().zip(problem.drift.chunks_exact(3)) {
        let [x, y, _] = corners[*id];
        for (found, exact) in drift.iter().zip([-9.81e-3, 0.3 - 2.0 * y, -0.4 + 2.0 * x]) {
            assert!((found - exact).abs() < 1e-15, "point {id}: {drift:?}");
        }
    }
}

/// K̇ᵀẋ is the rate of Kᵀẋ at constant ẋ. That includes a ball, whose lowest point moves on its surface.
#[test]
fn the_bias_acceleration_is_the_change_of_contact_velocity_at_constant_rates() {
    let step = 1e-5;
    for_each_case(21, 8, |rng, case| {
        let Case { mut model, state, .. } = case;
        model.contact_points.iter_mut().for_each(|point| point.radius = 0.2 * rng.f64());
        let velocities = |time: f64| {
            let mut moved = state.clone();
            moved.advance(&model, time);
            let Case { pose, .. } = Case::new(&model, &moved);
            let velocity = |point: &ContactPoint| pose.links[point.link].velocity.at(&pose.lowest(point));
            model.contact_points.iter().map(velocity).collect::<Vec<_>>()
        };
        let [before, after] = [-step, step].map(velocities);
        let changes: Vec<f64> =
            after.iter().zip(&before).flat_map(|(b, a)| ((b - a) / (2.0 * step)).data.0[0]).collect();
        let (mut composite, mut pose, mut b) = (Composite::new(&model), Pose::new(&model), vec![0.0; model.dofs()]);
        kinematics::pose(&model, &state, &mut pose);
        composite.bias(&model, &pose, &state.xdot, &mut b);
        let swept: Vec<f64> = model
            .contact_points
            .iter()
            .flat_map(|point| composite.bias_acceleration(&model, &pose, point).data.0[0])
            .collect();
        close("K̇ᵀẋ", &swept, &changes, 1e-7);
    });
}
