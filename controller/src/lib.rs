//! The walking controller: it computes joint torques from encoder counts at a fixed rate.
//!
//! [`Controller`] is the walking controller of Fujimoto & Kawamura (1995). Once per control period it estimates joint angles and rates, plans the
//! motion of the centre of gravity as that of two pendulums, places the swing foot, resolves both into joint rates, and drives the joints by a
//! sliding-mode servo with disturbance observer. It sees encoders alone. Its gains follow from the robot by dynamic similarity, so a robot of
//! another size needs no tuning; a controller that is started in mid-step finds the phase from two readings and continues.
//!
//! At the first tick the robot stands with bent knees, and the servo has to carry its weight:
//!
//! ```
//! use biped_controller::{Controller, messages::{load, wire::Encoders}};
//! use std::f64::consts::TAU;
//!
//! let posture = [0.0, 0.4943, -1.5177, 1.0234, -1.0234, 1.5177, -0.4943, 0.0]; // [rad], from the left foot to the right one
//! let scene = load::parse("controller = { gait = \"stand\" }", "stand")?;
//! let mut controller = Controller::new(&scene)?;
//! let count = |angle: f64| (angle / TAU * 2f64.powi(scene.plant.encoder_bits as i32)).round() as i64;
//! let torques = controller.tick(&Encoders { counts: posture.map(count) })?.torque; // [N·m]
//! assert!(torques[2].abs() > 1.0, "the left knee");
//! assert!(torques.iter().all(|torque| torque.abs() <= scene.plant.torque_limit));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | level of the paper | what | where |
//! |---|---|---|
//! | all | one control period: read, observe, plan, resolve, drive | [`tick`] |
//! | bottom (23), (24) | sliding-mode servo with disturbance observer | [`servo`] |
//! | | delay tolerance of the servo | [`stability`] |
//! | middle (25)-(27) | task and Jacobian from the supporting foot | [`support`] |
//! | middle (28)-(30) | resolved motion rate as a QP | [`rate`] |
//! | top (31)-(42) | pendulum energies | [`pendulum`] |
//! | top (43) | swing foot | [`swing`] |
//! | top | phases, exchange of support, foot placement | [`gait`] |
//! | top | load of the swing foot | `load` |
//! | top | ankle torques for a zero-moment point | `ankle` |
//! | top | zero-moment point of robots with weak drives | `lean` |
//! | | constants of the robot | [`constants`] |
//! | | joint angles of a task | `posture` |
//! | | parameters scaled to the size of the robot | [`scaled_parameters`] |
//! | | start in the middle of a step | [`resume`] |
//! | | encoders | [`encoder`] |
//! | | the controller as a process | [`process`] |
//! | | controllers in other languages | [`foreign`] |
//!
//! [`tick`] is pure: it uses no clock, no thread and no communication, allocates nothing and does not panic.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))] // the same bits everywhere: clippy.toml

mod ankle;
pub mod constants;
pub mod encoder;
pub mod error;
pub mod foreign;
pub mod gait;
mod lean;
mod load;
pub mod pendulum;
mod posture;
pub mod process;
pub mod rate;
pub mod resume;
pub mod scaled_parameters;
pub mod servo;
pub mod stability;
pub mod support;
pub mod swing;
pub mod tick;

pub use error::ControllerError;
#[doc(no_inline)]
pub use messages;
pub use tick::{Controller, ControllerSnapshot};
