//! Kinematics of the robot from its supporting foot: x_c, x_t, x_g and their Jacobian J_aco, (25)-(27).
//!
//! The support frame S has its origin at the centre of the supporting sole, axis 1 forward, axis 2 *toward the swing foot* and axis
//! 3 up. The supporting sole is assumed to lie flat on the ground. The robot is symmetric, so the equations are written once, for
//! support by the left foot. [`mirror`] converts joint vectors between the two feet. Joints in *support order* run from the
//! supporting foot to the swing foot.

use crate::error::ControllerError;
use crate::scaled_parameters::ScaledParameters;
use messages::robot::{Body, LEFT_FOOT, RIGHT_FOOT, TRUNK};
use messages::rotation;
use messages::wire::JOINTS;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Largest deviation of a joint axis from the x or y axis that counts as rounding [-].
const AXIS_TOLERANCE: f64 = 1e-9;

/// One number per joint.
pub type Joints = SVector<f64, JOINTS>;
/// One number per pair of joints.
pub type JointMatrix = SMatrix<f64, JOINTS, JOINTS>;
/// Number of components of the task (26): the robot has one joint more.
pub const TASK: usize = 7;
/// x = [x_c1 x_c2 x_c3 x_t1 x_t2 x_t3 x_g] of (26).
pub type TaskVector = SVector<f64, TASK>;
/// J_aco of (27).
pub type TaskJacobian = SMatrix<f64, TASK, JOINTS>;

/// Converts wire order to support order of the right foot, and back: the map is its own inverse.
///
/// Reversing the chain changes the sign of every angle. Mirroring changes the sign of the two rolls again.
pub fn mirror(q: &Joints) -> Joints {
    Joints::from_fn(|i, _| if i == 0 || i == JOINTS - 1 { q[JOINTS - 1 - i] } else { -q[JOINTS - 1 - i] })
}

/// The axis of the preceding link about which joint j turns: 0 forward (roll, at the feet), 1 sideways (pitch, between them).
fn turns_about(j: usize) -> usize {
    usize::from(j != 0 && j != JOINTS - 1)
}

/// The robot as a chain from the left foot to the right foot, at zero angles. The origin is the centre of the left sole.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Mass of link 0 … 8 [kg].
    pub mass: [f64; JOINTS + 1],
    /// Centre of mass of link 0 … 8 [m].
    pub com: [Vector3<f64>; JOINTS + 1],
    /// Principal moments of inertia of link 0 … 8 about its centre of mass [kg·m²].
    pub tensor: [Vector3<f64>; JOINTS + 1],
    /// Position of joint 0 … 7 [m].
    pub joint: [Vector3<f64>; JOINTS],
    /// Centre of the right sole [m].
    pub swing_sole: Vector3<f64>,
    /// Half the depth and half the width of a sole [m].
    pub sole_half: [f64; 2],
    /// Mass of the robot [kg].
    pub total_mass: f64,
    /// Parameters at the size of the robot.
    pub parameters: ScaledParameters,
}

/// Positions and directions at one set of joint angles, in the frame of [`Chain`]. Axis 2 of S is the negative y axis of that frame.
#[derive(Clone, Debug)]
pub struct Posture {
    /// Rotation of link 0 … 8.
    pub rotation: [Matrix3<f64>; JOINTS + 1],
    /// Centre of mass of link 0 … 8 [m].
    pub com: [Vector3<f64>; JOINTS + 1],
    /// Direction of the axis of joint 0 … 7.
    pub axis: [Vector3<f64>; JOINTS],
    /// Position of joint 0 … 7 [m].
    pub joint: [Vector3<f64>; JOINTS],
    /// Centre of the swing sole [m].
    pub swing_sole: Vector3<f64>,
}

/// The task (25)-(27) at one set of joint angles.
#[derive(Clone, Debug)]
pub struct Task {
    /// x of (26), in S.
    pub x: TaskVector,
    /// J_aco of (27): dx/dt = J_aco dq/dt, joints in support order.
    pub jacobian: TaskJacobian,
    /// Pitch of the swing foot [rad].
    pub swing_pitch: f64,
    /// Cosine of the roll angle of the supporting ankle [-].
    pub roll_cosine: f64,
}

impl Chain {
    /// The chain of a scene's bodies.
    ///
    /// # Errors
    /// If the scene does not have nine bodies, listed from the left foot to the right foot and joined by eight revolute axes: roll,
    /// three times pitch, three times pitch, roll.
    pub fn new(bodies: &[Body]) -> Result<Self, ControllerError> {
        let refuse = |what: &str| Err(ControllerError::Robot(what.into()));
        if bodies.len() != JOINTS + 1 {
            return refuse("the controller needs a robot of nine bodies and eight joints");
        }
        if bodies[0].name != LEFT_FOOT || bodies[4].name != TRUNK || bodies[JOINTS].name != RIGHT_FOOT {
            return refuse("the first body must be `left foot`, the fifth `trunk` and the last `right foot`");
        }
        let mut origin = [Vector3::zeros(); JOINTS + 1];
        let mut joint = [Vector3::zeros(); JOINTS];
        // Outward from the trunk. The chain runs from the left foot upward, but the scene's joints in the left leg move the lower
        // body, so their axes have the opposite direction.
        for (child, parent, j) in
            [(3, 4, 3), (2, 3, 2), (1, 2, 1), (0, 1, 0), (5, 4, 4), (6, 5, 5), (7, 6, 6), (8, 7, 7)]
        {
            let Some(link) = bodies[child].joint.as_ref().filter(|link| link.parent == bodies[parent].name) else {
                return refuse("the parent of each body must be its neighbour toward the trunk");
            };
            origin[child] = origin[parent] + Vector3::from(link.at);
            joint[j] = origin[child];
            let axis = Vector3::from(link.axis).normalize() * if child < parent { -1.0 } else { 1.0 };
            if (axis - Vector3::ith(turns_about(j), 1.0)).norm() > AXIS_TOLERANCE {
                return refuse("the axes must be roll, pitch, pitch, pitch in each leg, as in the paper's Figure 4");
            }
        }
        let sole = |body: usize| sole_centre(&bodies[body]).map(|centre| centre + origin[body]);
        let (Some(left), Some(right)) = (sole(0), sole(JOINTS)) else {
            return refuse("each foot needs contact points at the corners of its sole");
        };
        let extent =
            |k: usize| bodies[0].contacts.iter().map(|p| (p[k] - left[k] + origin[0][k]).abs()).fold(0.0, f64::max);
        Ok(Chain {
            mass: std::array::from_fn(|i| bodies[i].mass),
            com: std::array::from_fn(|i| origin[i] + Vector3::from(bodies[i].com) - left),
            tensor: std::array::from_fn(|i| Vector3::from(bodies[i].moments())),
            joint: joint.map(|p| p - left),
            swing_sole: right - left,
            sole_half: [extent(0), extent(1)],
            total_mass: bodies.iter().map(|body| body.mass).sum(),
            parameters: ScaledParameters::of(bodies),
        })
    }

    /// Distance W_2 between the soles' centres [m].
    pub fn leg_width(&self) -> f64 {
        self.swing_sole.y.abs()
    }

    /// Forward kinematics: positions of all links at the angles `s` [rad, support order].
    pub fn forward_kinematics(&self, s: &Joints) -> Posture {
        let mut at = Posture {
            rotation: [Matrix3::identity(); JOINTS + 1],
            com: self.com,
            axis: [Vector3::zeros(); JOINTS],
            joint: self.joint,
            swing_sole: self.swing_sole,
        };
        let mut turns = [(0.0, 1.0); JOINTS];
        rotation::sin_cos_all(s.as_slice(), &mut turns);
        let mut rotation = at.rotation[0];
        for (j, &turn) in turns.iter().enumerate() {
            if j > 0 {
                at.joint[j] = at.joint[j - 1] + rotation * (self.joint[j] - self.joint[j - 1]);
            }
            let k = turns_about(j);
            at.axis[j] = if k == 0 { rotation.column(0).into() } else { rotation.column(1).into() };
            rotation = rotation::rotated_about(&rotation, k, turn);
            at.com[j + 1] = at.joint[j] + rotation * (self.com[j + 1] - self.joint[j]);
            at.rotation[j + 1] = rotation;
        }
        let last = JOINTS - 1;
        at.swing_sole = at.joint[last] + at.rotation[JOINTS] * (self.swing_sole - self.joint[last]);
        at
    }

    /// The task at the angles `s` [rad, support order]. Source: (25)-(27).
    pub fn task(&self, s: &Joints) -> Task {
        let at = self.forward_kinematics(s);
        let mut jacobian = TaskJacobian::zeros();
        // Column j for the centre of gravity: z_j × Σ_{i>j} m_i (r_i − p_j) / M, summed from the swing foot inward.
        let mut outer_mass = 0.0;
        let mut outer_moment = Vector3::zeros();
        for j in (0..JOINTS).rev() {
            outer_mass += self.mass[j + 1];
            outer_moment += self.mass[j + 1] * at.com[j + 1];
            let com = at.axis[j].cross(&(outer_moment - outer_mass * at.joint[j])) / self.total_mass;
            let swing = at.axis[j].cross(&(at.swing_sole - at.joint[j]));
            jacobian.fixed_view_mut::<3, 1>(0, j).copy_from(&toward_swing(com));
            jacobian.fixed_view_mut::<3, 1>(3, j).copy_from(&toward_swing(swing));
        }
        for j in 1..4 {
            jacobian[(6, j)] = 1.0;
        }
        let com = toward_swing((outer_moment + self.mass[0] * at.com[0]) / self.total_mass);
        let swing = toward_swing(at.swing_sole);
        let tilt = s[1] + s[2] + s[3];
        Task {
            x: TaskVector::from([com.x, com.y, com.z, swing.x, swing.y, swing.z, tilt]),
            jacobian,
            swing_pitch: tilt + s[4] + s[5] + s[6],
            roll_cosine: at.rotation[1][(1, 1)],
        }
    }
}

impl Task {
    /// x_c [m].
    pub fn com(&self) -> Vector3<f64> {
        self.x.fixed_rows::<3>(0).into()
    }

    /// x_t [m].
    pub fn swing(&self) -> Vector3<f64> {
        self.x.fixed_rows::<3>(3).into()
    }
}

/// Components in S of a vector in the frame of [`Chain`]. The right foot lies at negative y, and axis 2 of S points to it.
fn toward_swing(v: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, -v.y, v.z)
}

fn sole_centre(foot: &Body) -> Option<Vector3<f64>> {
    let sum: Vector3<f64> = foot.contacts.iter().map(|p| Vector3::from(*p)).sum();
    (!foot.contacts.is_empty()).then(|| sum / foot.contacts.len() as f64)
}
