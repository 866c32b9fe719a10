//! The plant: a tree of rigid bodies in contact with the ground, after Fujimoto & Kawamura (1995).
//!
//! | what | where |
//! |---|---|
//! | links, joints and base as a tree | [`model`] |
//! | x and xdot | [`state`], `initial` |
//! | poses, points, momentum, energy | [`kinematics`], [`spatial`] |
//! | (2)-(11) as the paper has them | [`dynamics`] |
//! | H and b, fast | [`composite`] |
//! | H = LᵀDL | [`factor`] |
//! | one step, the story | [`step`] |
//! | springs and dampers on joints | [`springs`] |
//! | which points can touch | [`detect`] |
//! | K, the Delassus matrix and (12)-(14) | [`delassus`] |
//! | the contact laws, (14)-(22) | [`contact`] |
//! | standing feet: six equations each | [`standing`] |
//! | drives and encoders | [`drive`] |
//! | from commands to torques of the drives | [`command_pipeline`], [`validation`], [`watchdog`], [`handover`] |
//! | truth of a control period | [`truth`] |
//! | delay, jitter and loss of commands | [`inject`] |
//! | a run of a scene: plant, command pipeline, control periods | [`simulation`] |
//! | the plant as a process | [`process`] |
//! | the smallest sufficient model of a scene | [`smallest`] |
//! | what can go wrong | [`error`] |

pub mod command_pipeline;
pub mod composite;
pub mod contact;
pub mod delassus;
pub mod detect;
pub mod drive;
pub mod dynamics;
pub mod error;
pub mod factor;
pub mod handover;
mod initial;
pub mod inject;
pub mod kinematics;
pub mod model;
pub mod process;
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
pub use simulation::Simulation;
pub use step::Plant;
