//! `biped export`: the robot of a scene as URDF or MJCF for other programs, or as TOML for editing.
//!
//! | | URDF | MJCF |
//! |---|---|---|
//! | base | free, or fixed to `world` | as in the scene |
//! | J_r | `drake:rotor_inertia`, an extension of Drake; URDF itself has no rotor inertia | `armature` |
//! | springs and their damping | damping only | both |
//! | initial state | none | keyframe `start` |
//! | ground, friction, gravity, step | none: URDF describes robots only | as in the scene |
//!
//! A contact point becomes a sphere with a radius of 1 mm. While the body is upright, the sphere touches the ground exactly at the point.
//! In MJCF a site marks the point itself. A sentence on standard error names what the scene says and the file does not.

mod format;
mod lost;
mod mjcf;
mod robot;
pub mod toml;
mod urdf;

use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use format::RobotFormat;
use messages::load::load;
use messages::scene::Scene;
use plant::PlantError;
use robot::ExportRobot;
use shared::args::settings_with_robot;
use shared::exit::{Exit, Failure};
use shared::list;
use shared::output::{log, print_text};

/// Arguments of `biped export`.
#[derive(Args)]
pub struct ExportArgs {
    /// Output format
    #[arg(value_enum)]
    format: RobotFormat,
    /// Built-in scene (see `biped list`) or path of a TOML file; the default scene has the robot of the paper's Table 1
    #[arg(default_value = "walk")]
    scene: String,
    /// Use the robot of this TOML or URDF file
    #[arg(long, value_name = "FILE", value_parser = NonEmptyStringValueParser::new())]
    robot: Option<String>,
    /// Replace a value of the scene, for example plant.drive_inertia=0; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
}

/// Prints the robot.
///
/// # Errors
/// If the scene is invalid, or if the format has no uneven ground.
pub fn run(args: &ExportArgs) -> Result<(), Failure> {
    let scene = load(&args.scene, &settings_with_robot(&args.robot, &args.settings), list::SCENES)?;
    let robot = ExportRobot::new(&scene)?;
    let text = match args.format {
        RobotFormat::Urdf => urdf::text(&scene, &args.scene, &robot),
        RobotFormat::Mjcf if !scene.plant.ground.is_plane() => {
            let words = "plant.ground: tiles are not exported to MJCF; the ground must be the plane z = 0";
            return Err(Failure::new(Exit::Usage, words));
        }
        RobotFormat::Mjcf => mjcf(&scene)?,
        RobotFormat::Toml => toml::text(&scene),
    };
    lost::sentences(&scene, &robot, args.format).iter().for_each(log);
    print_text(text);
    Ok(())
}

/// The robot and its ground as MJCF. The ground is the plane z = 0, whatever `plant.ground` says.
///
/// # Errors
/// If the scene is invalid.
pub fn mjcf(scene: &Scene) -> Result<String, PlantError> {
    mjcf::text(scene, &ExportRobot::new(scene)?)
}
