//! The plant: a tree of rigid bodies in contact with the ground, after Fujimoto & Kawamura (1995).
//!
//! [`Plant`] is the robot with its ground and drives: torques in, encoder counts out, one control period at a time. Each step assembles the
//! equations of motion (1), finds the contact points that may touch, and solves for the impulse that makes the velocity after the step obey
//! Coulomb's law; [`step`] lists the stages and the ten integration methods. A step reads no clock, repeats to the bit, and allocates nothing,
//! except under some laws for comparison. [`Simulation`] adds what stands between a controller and the drives: delay, validation, watchdog.
//! [`process`] is the process around it.
//!
//! A brick slides on level ground until friction stops it, after v²/(2 μ g):
//!
//! ```
//! use biped_plant::{Plant, messages::load};
//!
//! let scene = load::parse(r#"
//!     plant = { friction = 0.5 }
//!     initial = { clearance = 0.0, velocity = [2.0, 0.0, 0.0] }
//!     [[bodies]]
//!     name = "brick"
//!     mass = 1.0
//!     size = [0.2, 0.1, 0.06]
//!     contacts = [[0.1, 0.05, -0.03], [0.1, -0.05, -0.03], [-0.1, 0.05, -0.03], [-0.1, -0.05, -0.03]]
//! "#, "brick")?;
//! let mut plant = Plant::new(&scene)?;
//! for _period in 0..500 {
//!     plant.advance(&Default::default())?; // no motors: the torques are zero
//! }
//! let exact = 2.0 * 2.0 / (2.0 * 0.5 * 9.81);
//! assert!((plant.truth().base_position[0] - exact).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | where |
//! |---|---|
//! | links, joints and base as a tree | [`model`] |
//! | x and xdot | [`state`], `initial` |
//! | poses, points, momentum, energy | [`kinematics`], [`spatial`] |
//! | (2)-(11) as the paper has them | [`dynamics`] |
//! | H and b, fast | [`composite`] |
//! | H = LᵀDL | [`factor`] |
//! | one integration step | [`step`] |
//! | springs and dampers on joints | [`springs`] |
//! | which points can touch | [`detect`] |
//! | the height of the ground under each of them | [`ground`] |
//! | K, the Delassus matrix and (12)-(14) | [`delassus`] |
//! | the contact laws, (14)-(22) | [`contact`] |
//! | standing feet: six equations each | [`standing`] |
//! | drives and encoders | [`drive`] |
//! | from commands to torques of the drives | [`command_pipeline`], [`validation`], [`watchdog`], [`handover`] |
//! | truth of a control period | [`truth`] |
//! | parts of a snapshot as bytes | `serial` |
//! | delay, jitter and loss of commands | [`inject`] |
//! | a run of a scene: plant, command pipeline, control periods | [`simulation`] |
//! | the plant as a process | [`process`] |
//! | the smallest sufficient model of a scene | [`smallest`] |
//! | errors of a plant | [`error`] |
//! | MuJoCo as the plant | [`foreign`] |

#![cfg_attr(not(test), deny(clippy::disallowed_methods))] // the same bits everywhere: clippy.toml

pub mod command_pipeline;
pub mod composite;
pub mod contact;
pub mod delassus;
pub mod detect;
pub mod drive;
pub mod dynamics;
pub mod error;
pub mod factor;
pub mod foreign;
pub mod ground;
pub mod handover;
mod initial;
pub mod inject;
pub mod kinematics;
pub mod model;
pub mod process;
mod serial;
pub mod simulation;
pub mod smallest;
pub mod spatial;
pub mod springs;
pub mod standing;
pub mod state;
pub mod step;
pub mod truth;
pub mod validation;
pub mod watchdog;

pub use error::PlantError;
#[doc(no_inline)]
pub use messages;
pub use simulation::{Simulation, SimulationSnapshot};
pub use step::Plant;
