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
mod robot;
pub mod toml;
mod urdf;

use clap::{Args, ValueEnum};
use messages::load::load;
use messages::scene::Scene;
use plant::PlantError;
use robot::Robot;
use shared::args::fitted;
use shared::exit::Failure;
use shared::list;
use shared::output::say;

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
