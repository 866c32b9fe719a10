//! The formats of an exported robot.

use clap::ValueEnum;

/// File format of the exported robot.
#[derive(Clone, Copy, ValueEnum)]
pub enum RobotFormat {
    /// For ROS, Pinocchio and Drake
    Urdf,
    /// For MuJoCo: with ground, motors in wire order, and the gravity, friction and step of the scene
    Mjcf,
    /// For this program: edit it and pass it to --robot; a robot that is no biped becomes a scene for `biped run`
    Toml,
}
