//! `biped export`: the robot of a scene for other programs, as URDF or as MJCF, and as TOML to be edited.
//!
//! | | URDF | MJCF |
//! |---|---|---|
//! | base | free, or fixed to `world` | as the scene has it |
//! | J_r | `drake:rotor_inertia`, as Drake reads it: URDF has no place for it | `armature` |
//! | springs, their damping | damping alone | both |
//! | initial state | none | keyframe `start` |
//! | ground, friction, gravity, step | none: they belong to the world | as in the scene |
//!
//! A contact point becomes a ball of 1 mm that touches the ground where the point does while the body is upright; in MJCF
//! a site marks the point itself.

mod mjcf;
mod toml;
mod urdf;

use crate::exit::Failure;
use crate::output::say;
use crate::{fitted, list};
use clap::{Args, ValueEnum};
use messages::load::load;
use messages::robot::{Joint, JointKind, Sphere};
use messages::scene::Scene;
use nalgebra::{Matrix3, Vector3};
use plant::PlantError;
use plant::model::Model;

/// Radius of the ball that stands for a point [m].
const POINT: f64 = 1e-3;

/// Arguments of `biped export`.
#[derive(Args)]
pub struct ExportArgs {
    /// As what
    #[arg(value_enum)]
    format: Format,
    /// Built-in scene (see `biped list`) or path of a TOML file; the default has the robot of the paper's Table 1
    #[arg(default_value = "walk")]
    scene: String,
    /// Put the robot of this TOML or URDF file into the scene first
    #[arg(long, value_name = "FILE")]
    robot: Option<String>,
    /// Replace a value of the scene, for example plant.drive_inertia=0; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
}

/// Description of a robot.
#[derive(Clone, Copy, ValueEnum)]
enum Format {
    /// For ROS, Pinocchio, Drake
    Urdf,
    /// For MuJoCo: with the ground, motors in wire order, and the scene's gravity, friction and step
    Mjcf,
    /// For this program: to be edited and read by --robot
    Toml,
}

/// Prints it.
///
/// # Errors
/// A scene that is refused.
pub fn run(args: &ExportArgs) -> Result<(), Failure> {
    let scene = load(&args.scene, &fitted(&args.robot, &args.settings), list::SCENES)?;
    say(match args.format {
        Format::Urdf => urdf::text(&scene, &Robot::new(&scene)?),
        Format::Mjcf => mjcf(&scene)?,
        Format::Toml => toml::text(&scene),
    });
    Ok(())
}

/// The robot and its ground as MJCF.
///
/// # Errors
/// A scene that is refused.
pub fn mjcf(scene: &Scene) -> Result<String, PlantError> {
    mjcf::text(scene, &Robot::new(scene)?)
}

/// A scene's bodies, in its order, the payload being part of them.
struct Robot {
    parts: Vec<Part>,
    base: usize,
    model: Model,
}

/// A body.
struct Part {
    name: String,
    mass: f64,
    com: Vector3<f64>,
    /// About the centre of mass, in the body's axes [kg·m²].
    inertia: Matrix3<f64>,
    /// The box that is drawn, and its centre [m].
    size: [f64; 3],
    middle: [f64; 3],
    joint: Option<Joint>,
    parent: Option<usize>,
    touching: Vec<Sphere>,
}

impl Robot {
    fn new(scene: &Scene) -> Result<Robot, PlantError> {
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
    fn children(&self, parent: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts.len()).filter(move |&child| self.parts[child].parent == Some(parent))
    }

    /// Body and joint, in wire order.
    fn joints(&self) -> impl Iterator<Item = (&Part, &Joint)> {
        self.parts.iter().filter_map(|part| part.joint.as_ref().map(|joint| (part, joint)))
    }
}

impl Part {
    /// Name of the joint that carries it.
    fn joint_name(&self) -> String {
        format!("{}_joint", self.name)
    }
}

/// What stands for something that may touch the ground.
fn ball(touching: Sphere) -> Sphere {
    let [x, y, z] = touching.at;
    if touching.radius > 0.0 { touching } else { Sphere { at: [x, y, z + POINT], radius: POINT } }
}

/// A name that every reader takes.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

/// Numbers with spaces between them; they read back exactly.
fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(|value| value.to_string()).collect::<Vec<_>>().join(" ")
}

/// One of two words.
fn kind<'a>(joint: &Joint, turns: &'a str, slides: &'a str) -> &'a str {
    match joint.kind {
        JointKind::Revolute => turns,
        JointKind::Prismatic => slides,
    }
}
