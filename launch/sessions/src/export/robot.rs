//! A robot as other programs describe it: bodies, joints and balls, the payload being part of its body.

use messages::robot::{Joint, JointKind, Sphere};
use messages::scene::Scene;
use nalgebra::{Matrix3, Vector3};
use plant::PlantError;
use plant::model::Model;

/// Radius of the ball that stands for a point [m].
pub const POINT: f64 = 1e-3;

/// A scene's bodies, in its order, the payload being part of them.
pub struct Robot {
    pub parts: Vec<Part>,
    pub base: usize,
    pub model: Model,
}

/// A body.
pub struct Part {
    pub name: String,
    pub mass: f64,
    pub com: Vector3<f64>,
    /// About the centre of mass, in the body's axes [kg·m²].
    pub inertia: Matrix3<f64>,
    /// The box that is drawn, and its centre [m].
    pub size: [f64; 3],
    pub middle: [f64; 3],
    pub joint: Option<Joint>,
    pub parent: Option<usize>,
    pub touching: Vec<Sphere>,
}

impl Robot {
    pub fn new(scene: &Scene) -> Result<Robot, PlantError> {
        let model = Model::new(scene)?;
        let index = |name: &str| scene.bodies.iter().position(|body| body.name == name);
        let part = |(body, &link): (&messages::robot::Body, &usize)| {
            let link = &model.links[link];
            let arm = link.payload_arm;
            let payload = link.reduced_mass * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose());
            Part {
                name: plain(&body.name),
                mass: link.mass,
                com: link.com,
                inertia: Matrix3::from_diagonal(&link.moments) + payload,
                size: body.size,
                middle: body.com,
                parent: body.joint.as_ref().and_then(|joint| index(&joint.parent)),
                joint: body.joint.clone(),
                touching: body.contact_spheres().map(ball).collect(),
            }
        };
        let parts: Vec<Part> = scene.bodies.iter().zip(&model.body_link).map(part).collect();
        let base = parts.iter().position(|part| part.joint.is_none()).unwrap_or_default();
        Ok(Robot { parts, base, model })
    }

    /// The bodies that hang from one.
    pub fn children(&self, parent: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts.len()).filter(move |&child| self.parts[child].parent == Some(parent))
    }

    /// Body and joint, in wire order.
    pub fn joints(&self) -> impl Iterator<Item = (&Part, &Joint)> {
        self.parts.iter().filter_map(|part| part.joint.as_ref().map(|joint| (part, joint)))
    }
}

impl Part {
    /// Name of the joint that carries it.
    pub fn joint_name(&self) -> String {
        format!("{}_joint", self.name)
    }
}

/// What stands for something that may touch the ground.
pub fn ball(touching: Sphere) -> Sphere {
    let [x, y, z] = touching.at;
    if touching.radius > 0.0 { touching } else { Sphere { at: [x, y, z + POINT], radius: POINT } }
}

/// A name that every reader takes.
pub fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

/// Numbers with spaces between them; they read back exactly.
pub fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(|value| value.to_string()).collect::<Vec<_>>().join(" ")
}

/// One of two words.
pub fn kind<'a>(joint: &Joint, turns: &'a str, slides: &'a str) -> &'a str {
    match joint.kind {
        JointKind::Revolute => turns,
        JointKind::Prismatic => slides,
    }
}
