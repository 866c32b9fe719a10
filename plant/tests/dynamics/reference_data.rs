//! Table 1 against data of Pinocchio 4.1.0, with which MuJoCo and Drake agree to 3e-14.
//!
//! In that data, joints count from the trunk down, so the left leg's angles have the opposite sign.

use crate::support::*;
use biped_plant::dynamics::{self, Given};
use biped_plant::kinematics::totals;
use biped_plant::model::Model;
use biped_plant::state::State;
use messages::scene::Base;
use nalgebra::{DMatrix, DVector, Vector3};
use serde_json::Value;

/// Required agreement, relative to the largest entry of a vector or matrix.
const TOLERANCE: f64 = 1e-11;

pub fn states(text: &str) -> Vec<Value> {
    let data: Value = serde_json::from_str(text).expect("reference data");
    data["states"].as_array().expect("states").clone()
}

pub fn floating() -> Vec<Value> {
    states(include_str!("../data/dynamics.json"))
}

pub fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// Sign of each degree of freedom in that data relative to ours.
const SIGN: [f64; 14] = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0];

pub fn signed(value: &Value) -> Vec<f64> {
    numbers(value).iter().zip(SIGN).map(|(number, sign)| number * sign).collect()
}

fn symmetric(lower: &Value) -> DMatrix<f64> {
    let lower = numbers(lower);
    DMatrix::from_fn(14, 14, |i, j| lower[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)] * SIGN[i] * SIGN[j])
}

pub fn state_of(model: &Model, data: &Value) -> State {
    let mut state = State::zero(model);
    let joints: Vec<f64> = numbers(&data["joint_pos"]).iter().zip(&SIGN[6..]).map(|(q, sign)| q * sign).collect();
    state.x = [numbers(&data["base_pos"]), numbers(&data["base_quat_wxyz"]), joints].concat();
    let rates: Vec<f64> = numbers(&data["joint_vel"]).iter().zip(&SIGN[6..]).map(|(q, sign)| q * sign).collect();
    state.xdot = [numbers(&data["base_linvel"]), numbers(&data["base_angvel"]), rates].concat();
    state
}

#[test]
fn joints_of_table_1_are_in_wire_order() {
    let model = model(&bare_table_1(Base::Quaternion));
    assert_eq!(model.joint_dof, [9, 8, 7, 6, 10, 11, 12, 13]);
}

#[test]
fn the_floating_robot_moves_as_in_other_engines() {
    let model = model(&bare_table_1(Base::Quaternion));
    let cases = floating();
    assert_eq!(cases.len(), 40);
    for data in &cases {
        let case = Case::new(&model, &state_of(&model, data));
        let (h, bias) = (symmetric(&data["M_lower"]), signed(&data["bias"]));
        close("H", case.inertia().as_slice(), h.as_slice(), TOLERANCE);
        close("reference H", dynamics::inertia(&model, &case.pose).as_slice(), h.as_slice(), TOLERANCE);
        close("b", &case.b, &bias, TOLERANCE);
        close("reference b", &dynamics::bias(&model, &case.pose, &case.state.xdot), &bias, TOLERANCE);
        let at_rest = State { xdot: vec![0.0; 14], ..case.state.clone() };
        close("gravity", &Case::new(&model, &at_rest).b, &signed(&data["gravity"]), TOLERANCE);

        let acceleration = signed(&data["acc"]);
        let effort = signed(&data["tau_id"]);
        let given = Given { rate: &case.state.xdot, acceleration: &acceleration, gravity: model.gravity, forces: &[] };
        close("inverse dynamics", &dynamics::inverse(&model, &case.pose, &given), &effort, TOLERANCE);
        let fast = case.inertia() * DVector::from_vec(acceleration) + DVector::from_vec(case.b.clone());
        close("H acc + b", fast.as_slice(), &effort, TOLERANCE);
        close("forward dynamics", &case.forward(&signed(&data["tau"])), &signed(&data["acc_fd"]), TOLERANCE);

        let sum = totals(&model, &case.state, &case.pose);
        close("centre of mass", sum.com.as_slice(), &numbers(&data["com"]), TOLERANCE);
        close("its velocity", sum.com_velocity.as_slice(), &numbers(&data["com_vel"]), TOLERANCE);
        close("linear momentum", sum.linear.as_slice(), &numbers(&data["lin_mom"]), TOLERANCE);
        close("angular momentum", sum.angular.as_slice(), &numbers(&data["ang_mom_com"]), TOLERANCE);
        close("kinetic energy", &[sum.kinetic], &numbers(&data["ke"]), TOLERANCE);
        close("potential energy", &[sum.potential], &numbers(&data["pe"]), TOLERANCE);
    }
}

#[test]
fn contact_points_have_the_positions_and_velocities_of_other_engines() {
    let model = model(&bare_table_1(Base::Quaternion));
    for data in &floating() {
        let case = Case::new(&model, &state_of(&model, data));
        let (corners, angular, leg) =
            (numbers(&data["corners"]), numbers(&data["corner_jac_ang"]), numbers(&data["corner_jac_leg"]));
        for (i, point) in model.contact_points.iter().enumerate() {
            let position = case.pose.point(point.link, &point.at);
            close("corner", position.as_slice(), &corners[3 * i..3 * i + 3], TOLERANCE);
            let mut expected = DMatrix::zeros(3, 14);
            let first = if i < 4 { 6 } else { 10 };
            for row in 0..3 {
                expected[(row, row)] = 1.0;
                for column in 0..3 {
                    expected[(row, 3 + column)] = angular[9 * i + 3 * row + column];
                }
                for column in 0..4 {
                    let dof = first + column;
                    expected[(row, dof)] = SIGN[dof] * leg[12 * i + 4 * row + column];
                }
            }
            let jacobian = case.jacobian(point.link, &point.at);
            close("point Jacobian", jacobian.as_slice(), expected.as_slice(), TOLERANCE);
            let velocity = case.pose.point_velocity(point.link, &point.at);
            let by_jacobian = jacobian * DVector::from_vec(case.state.xdot.clone());
            close("point velocity", velocity.as_slice(), by_jacobian.as_slice(), TOLERANCE);
            for axis in 0..3 {
                let mut force = Vector3::zeros();
                force[axis] = 1.0;
                let force = dynamics::Force { link: point.link, arm: case.pose.arm(point.link, &point.at), force };
                let column = dynamics::contact_column(&model, &case.pose, force);
                let row: Vec<f64> = expected.row(axis).iter().copied().collect();
                close("K by unit forces", &column, &row, TOLERANCE);
            }
        }
    }
}

#[test]
fn the_virtual_links_of_the_paper_move_as_in_other_engines() {
    let model = model(&bare_table_1(Base::Virtual));
    let cases = states(include_str!("../data/dynamics_virtual.json"));
    assert_eq!(cases.len(), 15);
    for data in &cases {
        let state = State { x: signed(&data["x"]), xdot: signed(&data["xd"]) };
        let case = Case::new(&model, &state);
        let (h, b) = (symmetric(&data["H_lower"]), signed(&data["b"]));
        close("H", case.inertia().as_slice(), h.as_slice(), TOLERANCE);
        close("reference H", dynamics::inertia(&model, &case.pose).as_slice(), h.as_slice(), TOLERANCE);
        close("b", &case.b, &b, TOLERANCE);
        close("reference b", &dynamics::bias(&model, &case.pose, &state.xdot), &b, TOLERANCE);
        close("forward dynamics", &case.forward(&signed(&data["u"])), &signed(&data["xdd"]), TOLERANCE);
        let sum = totals(&model, &state, &case.pose);
        close("kinetic energy", &[sum.kinetic], &numbers(&data["ke"]), TOLERANCE);
        close("potential energy", &[sum.potential], &numbers(&data["pe"]), TOLERANCE);
    }
}
