//! A robot in the form that URDF and MJCF share: bodies, joints and contact spheres. The payload is part of its body.

use messages::robot::{Joint, JointKind, Sphere};
use messages::scene::Scene;
use nalgebra::{Matrix3, Vector3};
use plant::PlantError;
use plant::model::Model;

/// Radius of the sphere that represents a contact point [m]: small compared with a foot.
pub const POINT_RADIUS: f64 = 1e-3;

/// The bodies of a scene, in the order of the scene.
pub struct ExportRobot {
    pub bodies: Vec<ExportBody>,
    /// Index of the base body, which has no joint.
    pub base: usize,
    pub model: Model,
}

/// A body with its payload.
pub struct ExportBody {
    pub name: String,
    pub mass: f64,
    pub com: Vector3<f64>,
    /// About the centre of mass, in the body's axes [kg·m²].
    pub inertia: Matrix3<f64>,
    /// Size of the visual box [m].
    pub size: [f64; 3],
    /// Centre of the visual box [m].
    pub box_center: [f64; 3],
    pub joint: Option<Joint>,
    pub parent: Option<usize>,
    /// Spheres of the contact points, then balls.
    pub spheres: Vec<Sphere>,
    /// Number of contact points.
    pub points: usize,
}

impl ExportRobot {
    pub fn new(scene: &Scene) -> Result<ExportRobot, PlantError> {
        let model = Model::new(scene)?;
        let index = |name: &str| scene.bodies.iter().position(|body| body.name == name);
        let export = |(body, &link): (&messages::robot::Body, &usize)| {
            let link = &model.links[link];
            let arm = link.payload_arm;
            let payload = link.reduced_mass * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose());
            let frame = if body.joint.is_none() { model.base_frame } else { Vector3::zeros() };
            ExportBody {
                name: identifier(&body.name),
                mass: link.mass,
                com: link.com - frame,
                inertia: Matrix3::from_diagonal(&link.moments) + payload,
                size: body.size,
                box_center: body.com,
                parent: body.joint.as_ref().and_then(|joint| index(&joint.parent)),
                joint: body.joint.clone(),
                spheres: body.contact_spheres().map(contact_sphere).collect(),
                points: body.contacts.len(),
            }
        };
        let bodies: Vec<ExportBody> = scene.bodies.iter().zip(&model.body_link).map(export).collect();
        let base = bodies.iter().position(|body| body.joint.is_none()).unwrap_or_default();
        Ok(ExportRobot { bodies, base, model })
    }

    /// The children of a body in the kinematic tree.
    pub fn children(&self, parent: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.bodies.len()).filter(move |&child| self.bodies[child].parent == Some(parent))
    }

    /// Each joint with the body that it moves, in wire order.
    pub fn joints(&self) -> impl Iterator<Item = (&ExportBody, &Joint)> {
        self.bodies.iter().filter_map(|body| body.joint.as_ref().map(|joint| (body, joint)))
    }
}

impl ExportBody {
    /// Name of the joint between it and its parent.
    pub fn joint_name(&self) -> String {
        format!("{}_joint", self.name)
    }
}

/// The sphere that represents a contact. A contact point lies at the bottom of its sphere.
fn contact_sphere(contact: Sphere) -> Sphere {
    let [x, y, z] = contact.at;
    if contact.radius > 0.0 { contact } else { Sphere { at: [x, y, z + POINT_RADIUS], radius: POINT_RADIUS } }
}

/// A name that all readers accept: letters, digits and underscores.
pub fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

/// Numbers separated by spaces, in decimals that parse back to the same bits.
pub fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(|value| value.to_string()).collect::<Vec<_>>().join(" ")
}

/// The name of a joint's type: `revolute` or `prismatic`, as the format calls them.
pub fn joint_type<'a>(joint: &Joint, revolute: &'a str, prismatic: &'a str) -> &'a str {
    match joint.kind {
        JointKind::Revolute => revolute,
        JointKind::Prismatic => prismatic,
    }
}
