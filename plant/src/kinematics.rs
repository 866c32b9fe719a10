//! Kinematics: poses and velocities of links and points, Jacobian columns, and sums over the robot.

use crate::model::{ContactPoint, Link, Model, Motion};
use crate::spatial::{Spatial, Symmetric};
use crate::state::State;
use messages::rotation::{rotated, sin_cos_all};
use messages::scene::Base;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Pose and velocity of one link. Axes of W; positions from the reference point O of [`Pose`].
#[derive(Clone, Copy, Debug, Default)]
pub struct LinkPose {
    /// Rotation R from the link's axes to W.
    pub rotation: Matrix3<f64>,
    /// Origin p, at the joint to the parent, from O [m].
    pub origin: Vector3<f64>,
    /// Centre of mass r, from O [m].
    pub com: Vector3<f64>,
    /// Inertia about the centre of mass, R J Rᵀ [kg·m²].
    pub tensor: Symmetric,
    /// Velocity of the link per unit rate of its joint: (z, p × z), or (0, z) if prismatic.
    pub column: Spatial,
    /// Velocity of the link: (w, velocity of its point at O).
    pub velocity: Spatial,
}

/// Pose and velocity of every link in one state.
///
/// Positions are relative to O, the origin of the base body. So they lose no digits far from the world's origin.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// Reference point O in W [m].
    pub reference: Vector3<f64>,
    /// One per link of the model.
    pub links: Vec<LinkPose>,
    /// Sine and cosine of each joint coordinate, except those of the world-aligned first links.
    turns: Vec<(f64, f64)>,
}

impl Pose {
    /// Allocates for a model, and sets the constant parts: link 0, and the axes of the world-aligned links.
    pub fn new(model: &Model) -> Self {
        let at_rest = LinkPose { rotation: model.mount_rotation, ..LinkPose::default() };
        let mut links = vec![at_rest; model.links.len()];
        set_mass_properties(&model.links[0], &mut links[0]);
        for (k, link) in links[1..=model.world_aligned()].iter_mut().enumerate() {
            let unit = |first: usize| Vector3::from_fn(|row, _| f64::from(first + row == k));
            link.column = Spatial { linear: unit(0), angular: unit(3) };
        }
        let turns = vec![(0.0, 1.0); model.dofs() - model.world_aligned()];
        Pose { reference: Vector3::zeros(), links, turns }
    }

    /// Pose and velocity of every link in a state; allocates.
    pub fn of(model: &Model, state: &State) -> Self {
        let mut found = Pose::new(model);
        pose(model, state, &mut found);
        found
    }

    /// Position in W of a point given in a link's frame [m].
    pub fn point(&self, link: usize, at: &Vector3<f64>) -> Vector3<f64> {
        self.reference + self.arm(link, at)
    }

    /// The same relative to O [m].
    #[inline]
    pub fn arm(&self, link: usize, at: &Vector3<f64>) -> Vector3<f64> {
        let link = &self.links[link];
        link.origin + link.rotation * at
    }

    /// Point at which a contact point would touch the ground, from O: the point itself, or the lowest point of its ball [m].
    #[inline]
    pub fn lowest(&self, point: &ContactPoint) -> Vector3<f64> {
        let mut arm = self.arm(point.link, &point.at);
        arm.z -= point.radius;
        arm
    }

    /// Height of a contact point above the ground [m].
    #[inline]
    pub fn height(&self, point: &ContactPoint) -> f64 {
        self.reference.z + self.lowest(point).z
    }

    /// Velocity of a link at this pose for rates `xdot`.
    pub fn twist(&self, model: &Model, link: usize, xdot: &[f64]) -> Spatial {
        let path = model.path(link).iter();
        path.fold(Spatial::default(), |sum, &dof| sum + self.links[dof + 1].column * xdot[dof])
    }

    /// Velocity in W of a point given in a link's frame [m/s].
    pub fn point_velocity(&self, link: usize, at: &Vector3<f64>) -> Vector3<f64> {
        self.links[link].velocity.at(&self.arm(link, at))
    }

    /// Orientation of a link in W: unit quaternion w, x, y, z with w >= 0.
    pub fn orientation(&self, link: usize) -> [f64; 4] {
        quaternion(&self.links[link].rotation)
    }
}

/// Unit quaternion w, x, y, z with w >= 0 of a rotation.
pub(crate) fn quaternion(rotation: &Matrix3<f64>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation)).into_inner();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [q.w, q.i, q.j, q.k].map(|component| sign * component)
}

/// Rotation of a unit quaternion w, x, y, z.
fn rotation(q: &[f64]) -> Matrix3<f64> {
    let (w, x, y, z) = (q[0], q[1], q[2], q[3]);
    Matrix3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

/// Computes the pose and velocity of every link, from the base outwards.
///
/// The world-aligned first links have one common motion: O translates, and the last of these links has their total velocity.
pub fn pose(model: &Model, state: &State, pose: &mut Pose) {
    let Pose { reference, links, turns } = pose;
    let aligned = model.world_aligned();
    let joints = &state.x[aligned + model.coordinates() - model.dofs()..];
    *reference = model.mount_position;
    if aligned > 0 {
        *reference += Vector3::from_column_slice(&state.x[..3]);
        links[aligned].velocity = aligned_velocity(aligned, &state.xdot);
    }
    if model.base == Base::Quaternion {
        links[aligned].rotation = rotation(&state.x[3..7]);
        set_mass_properties(&model.links[aligned], &mut links[aligned]);
    }
    sin_cos_all(joints, turns);
    for (i, link) in model.links.iter().enumerate().skip(1 + aligned) {
        let virtual_link = i <= model.base_link;
        let (x, turn) = (joints[i - 1 - aligned], turns[i - 1 - aligned]);
        let (before, rest) = links.split_at_mut(i);
        let (parent, here) = (&before[link.parent], &mut rest[0]);
        let axis = match link.along {
            Some(k) => before[link.carrier].rotation.column(k) * link.axis[k],
            None => before[link.carrier].rotation * link.axis,
        };
        here.rotation = match link.motion {
            Motion::Revolute | Motion::Spin => rotated(&parent.rotation, &link.axis, link.along, turn),
            Motion::Prismatic => parent.rotation,
        };
        here.column = match link.motion {
            Motion::Revolute | Motion::Spin => Spatial { angular: axis, linear: Vector3::zeros() },
            Motion::Prismatic => Spatial { angular: Vector3::zeros(), linear: axis },
        };
        // virtual links have no length: their joints stay at O, and O moves instead
        match (virtual_link, link.motion) {
            (true, Motion::Prismatic) => *reference += axis * x,
            (true, _) => {}
            (false, Motion::Prismatic) => here.origin = parent.origin + parent.rotation * link.at + axis * x,
            (false, _) => {
                here.origin = parent.origin + parent.rotation * link.at;
                here.column.linear = here.origin.cross(&axis);
            }
        }
        here.velocity = parent.velocity + here.column * state.xdot[i - 1];
        set_mass_properties(link, here);
    }
}

/// Computes the velocity of every link at this pose for rates `xdot`.
pub fn velocities(model: &Model, xdot: &[f64], pose: &mut Pose) {
    let aligned = model.world_aligned();
    pose.links[aligned].velocity = aligned_velocity(aligned, xdot);
    for (i, link) in model.links.iter().enumerate().skip(1 + aligned) {
        pose.links[i].velocity = pose.links[link.parent].velocity + pose.links[i].column * xdot[i - 1];
    }
}

/// Velocity of the world-aligned first links, which move as one: they translate and turn, translate only, or there are none
/// ([`Model::world_aligned`]).
fn aligned_velocity(aligned: usize, xdot: &[f64]) -> Spatial {
    let part =
        |from: usize| if aligned > from { Vector3::from_column_slice(&xdot[from..from + 3]) } else { Vector3::zeros() };
    Spatial { angular: part(3), linear: part(0) }
}

/// Computes centre of mass and inertia tensor from the link's rotation and origin.
#[inline(always)]
fn set_mass_properties(link: &Link, here: &mut LinkPose) {
    if link.mass > 0.0 {
        here.com = here.origin + here.rotation * link.com;
        here.tensor = Symmetric::principal(&link.moments, &here.rotation);
        if link.reduced_mass > 0.0 {
            let arm = here.rotation * link.payload_arm;
            here.tensor = here.tensor + Symmetric::of_point(link.reduced_mass, &arm);
        }
    }
}

/// Column of K (1): the effort on each degree of freedom of the path to `link` of a unit force along `direction` at `arm` (from O) on that
/// link.
///
/// By virtual work it is also the row of the Jacobian: velocity of the point along `direction` = column · xdot. `column` has one entry per
/// degree of freedom of [`Model::path`], base first; all others are zero.
pub fn contact_column(
    model: &Model,
    pose: &Pose,
    link: usize,
    arm: &Vector3<f64>,
    direction: &Vector3<f64>,
    column: &mut [f64],
) {
    let unit = Spatial::force_at(arm, direction);
    for (k, &dof) in column.iter_mut().zip(model.path(link)) {
        *k = pose.links[dof + 1].column.dot(&unit);
    }
}

/// Sums over the whole robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Mass [kg].
    pub mass: f64,
    /// Centre of mass in W [m].
    pub com: Vector3<f64>,
    /// Velocity [m/s].
    pub com_velocity: Vector3<f64>,
    /// Linear momentum [kg·m/s].
    pub linear: Vector3<f64>,
    /// Angular momentum about the centre of mass [kg·m²/s].
    pub angular: Vector3<f64>,
    /// Kinetic energy, including that of the drives [J].
    pub kinetic: f64,
    /// Potential energy of gravity, zero at the world's origin [J].
    pub potential: f64,
}

/// Sums mass, momentum and energy over the bodies.
pub fn totals(model: &Model, state: &State, pose: &Pose) -> Totals {
    let mut sum = Totals::default();
    for (link, pose) in model.links.iter().zip(&pose.links).filter(|(link, _)| link.mass > 0.0) {
        let spin = pose.velocity.angular;
        let velocity = pose.velocity.at(&pose.com);
        let own = &pose.tensor * &spin;
        sum.mass += link.mass;
        sum.com += pose.com * link.mass;
        sum.linear += velocity * link.mass;
        sum.angular += own + pose.com.cross(&velocity) * link.mass;
        sum.kinetic += 0.5 * (link.mass * velocity.norm_squared() + spin.dot(&own));
    }
    sum.com /= sum.mass;
    sum.com_velocity = sum.linear / sum.mass;
    sum.angular -= sum.com.cross(&sum.linear);
    sum.com += pose.reference;
    sum.potential = -sum.mass * model.gravity.dot(&sum.com);
    let drives = model.links[1..].iter().zip(&state.xdot);
    sum.kinetic += 0.5 * drives.map(|(link, rate)| link.drive_inertia * rate * rate).sum::<f64>();
    sum
}
