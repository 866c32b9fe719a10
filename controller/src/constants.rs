//! Constants of the robot: ω_1, ω_2, γ, the nominal inertias and the limits of the zero-moment point.
//!
//! The paper uses ω = √(g/l). The true mode is slower, because the trunk rolls with the ankle and the legs have mass. Here ω
//! follows from the full inverse dynamics of the robot, so that the zero-moment point stays under the ankle.

use crate::error::ControllerError;
use crate::lean::lean;
use crate::posture::solve_posture;
use crate::rate;
use crate::support::{Chain, JointMatrix, Joints, Posture, TaskVector};
use messages::robot::CROUCH;
use messages::rounded_down;
use messages::scene::{ControllerScene, NominalInertia, PlantScene, Scene};
use messages::wire::JOINTS;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Constants of one robot at one height of its centre of gravity.
#[derive(Clone, Debug)]
pub struct Constants {
    /// ω_1, ω_2 of (31), (32) [1/s].
    pub omega: [f64; 2],
    /// γ_0 of (31): effect of the swing foot's forward acceleration on the zero-moment point [-].
    pub swing_coupling: f64,
    /// J_n, support order; a diagonal matrix if the scene asks for a number for each joint [kg·m²].
    pub nominal_inertia: JointMatrix,
    /// M + J_r 1: inertia matrix of the joints with the supporting foot fixed, including the drives, support order [kg·m²].
    pub inertia: JointMatrix,
    /// Distance of the gait's zero-moment point before the sole's centre: `lean.rs` [m].
    pub lean: f64,
    /// Largest distance of the zero-moment point from the sole's centre, along and across [m].
    pub sole_edge: [f64; 2],
}

/// Share of the sole's half-depth and half-width to which the zero-moment point may come [-]. At 1 the foot would tip.
const SOLE_SHARE: f64 = 0.95;
/// J_n over the inertia matrix [-]. A larger value makes the servo stiffer and lowers the delay that it tolerates (`stability.rs`). With 1
/// the robot cannot keep its soles flat if its drives are heavy.
pub(crate) const MATRIX_MARGIN: f64 = 1.5;
/// The same for a number for each joint, over the effective inertia of the joint while all other joints are free [-].
const DIAGONAL_MARGIN: f64 = 2.0;
/// x_2/W_2 of the posture in the middle of a step: between the turning point of the default orbit, .39, and the exchange, .5 [-].
const MID_STEP_SHARE: f64 = 0.4;
/// Number of heights, up to that of straight legs, that are tried for the range in an error [-].
const TRIED_HEIGHTS: u32 = 100;

impl Constants {
    /// Constants of a scene's robot and controller.
    ///
    /// # Errors
    /// If the scene has no controller, or one for another robot.
    pub fn of(scene: &Scene) -> Result<Self, ControllerError> {
        let settings = scene.controller.as_ref().ok_or(ControllerError::NoController)?;
        Constants::new(&Chain::new(&scene.bodies)?, settings, &scene.plant)
    }

    /// Constants of the posture in the middle of a step: height z_c, x_2 = [`MID_STEP_SHARE`] W_2, swing foot raised.
    ///
    /// # Errors
    /// If no posture with bent knees has its centre of gravity that high.
    pub fn new(chain: &Chain, scene: &ControllerScene, plant: &PlantScene) -> Result<Self, ControllerError> {
        let (width, up) = (chain.leg_width(), chain.parameters.mid_swing);
        let target = TaskVector::from([0.0, MID_STEP_SHARE * width, scene.com_height, 0.0, width, up, 0.0]);
        let (lean, s) = lean(chain, scene, plant, &target).ok_or_else(|| height_error(chain, &target))?;
        let weight = chain.total_mass * plant.gravity;
        let [along, across, swing] = [0, 1, 3].map(|k| zmp_shift(chain, &s, k, weight));
        let omega = [along[0], across[1]].map(|shift| (-1.0 / shift).sqrt());
        let inertia = inertia(chain, &s, plant.drive_inertia);
        Ok(Constants {
            omega,
            swing_coupling: swing[0] * omega[0] * omega[0],
            nominal_inertia: nominal_inertia(scene, &inertia),
            inertia,
            lean,
            sole_edge: chain.sole_half.map(|half| SOLE_SHARE * half),
        })
    }
}

/// The error for a height of the centre of gravity that no posture reaches. It names the greatest height with a posture, and the least one
/// down to which each height has one.
fn height_error(chain: &Chain, target: &TaskVector) -> ControllerError {
    let straight = chain.task(&Joints::zeros()).x[2];
    let tried = |k: u32| rounded_down(straight * f64::from(k) / f64::from(TRIED_HEIGHTS));
    let is_reached = |height: &f64| {
        let mut at = *target;
        at[2] = *height;
        solve_posture(chain, &at, &Joints::from(CROUCH)).is_some()
    };
    let mut reached =
        (1..=TRIED_HEIGHTS).rev().map(tried).skip_while(|height| !is_reached(height)).take_while(is_reached);
    match reached.next() {
        Some(high) => ControllerError::Height { height: target[2], low: reached.last().unwrap_or(high), high },
        None => ControllerError::Robot("no posture with bent knees has its centre of gravity over a foot".into()),
    }
}

/// Shift of the zero-moment point [m] along and across per unit acceleration [m/s²] of task component `k`, at rest.
///
/// At rest there are no velocity products. The moment about the sole is n = Σ r_i × m_i r̈_i + I_i α_i with q̈ from the rate QP.
fn zmp_shift(chain: &Chain, s: &Joints, k: usize, weight: f64) -> [f64; 2] {
    let task = chain.task(s);
    let mut xddot = TaskVector::zeros();
    xddot[k] = 1.0;
    let Some(qddot) = rate::resolve(&task.jacobian, &xddot, &Joints::zeros()) else { return [f64::NAN; 2] };
    let at = chain.forward_kinematics(s);
    let mut moment = Vector3::zeros();
    for i in 0..=JOINTS {
        let (linear, angular) = link_motion(&at, i);
        let tensor = link_tensor(chain, &at, i);
        moment += at.com[i].cross(&(chain.mass[i] * linear * qddot)) + tensor * (angular * qddot);
    }
    [-moment.y / weight, -moment.x / weight] // axis 2 points to negative y
}

type LinkJacobian = SMatrix<f64, 3, JOINTS>;

/// Jacobians of link `i`'s centre of mass and of its rotation.
fn link_motion(at: &Posture, i: usize) -> (LinkJacobian, LinkJacobian) {
    let (mut linear, mut angular) = (LinkJacobian::zeros(), LinkJacobian::zeros());
    for j in 0..i {
        linear.set_column(j, &at.axis[j].cross(&(at.com[i] - at.joint[j])));
        angular.set_column(j, &at.axis[j]);
    }
    (linear, angular)
}

/// Inertia of link `i` about its centre of mass, in the axes of S [kg·m²].
fn link_tensor(chain: &Chain, at: &Posture, i: usize) -> Matrix3<f64> {
    at.rotation[i] * Matrix3::from_diagonal(&chain.tensor[i]) * at.rotation[i].transpose()
}

/// M + J_r 1, where M is the inertia matrix of the joints with the supporting foot fixed.
fn inertia(chain: &Chain, s: &Joints, drive_inertia: f64) -> JointMatrix {
    let at = chain.forward_kinematics(s);
    let mut inertia = JointMatrix::identity() * drive_inertia;
    for i in 0..=JOINTS {
        let (linear, angular) = link_motion(&at, i);
        let tensor = link_tensor(chain, &at, i);
        inertia += chain.mass[i] * linear.tr_mul(&linear) + angular.tr_mul(&(tensor * angular));
    }
    inertia
}

/// J_n from M + J_r 1. With a number for each joint, coupled joints are accelerated too little: without drive inertia, the motion of the
/// whole robot about its ankle has a twelfth of the inertia that it needs, and the robot falls.
fn nominal_inertia(scene: &ControllerScene, inertia: &JointMatrix) -> JointMatrix {
    match scene.nominal_inertia() {
        NominalInertia::Matrix => inertia * MATRIX_MARGIN,
        NominalInertia::Diagonal => match inertia.cholesky() {
            Some(factor) => {
                JointMatrix::from_diagonal(&factor.inverse().diagonal().map(|inverse| DIAGONAL_MARGIN / inverse))
            }
            None => JointMatrix::repeat(f64::NAN),
        },
    }
}
