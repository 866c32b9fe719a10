//! The connection between plant, controller and recorders.
//!
//! Only these files use iceoryx2, except for the marker trait of messages.
//!
//! | topic | from → to | buffer | when the buffer is full |
//! |---|---|---|---|
//! | `biped/sensors` | plant → controller | 1 | the newest message replaces the oldest |
//! | `biped/command` | controller → plant | 1 | the newest message replaces the oldest |
//! | `biped/truth` | plant → recorders | 1024 | lockstep: the plant waits; real time: the message is dropped and counted |
//! | `biped/served` | plant, controller → recorders | 64 | the newest message replaces the oldest |
//! | `biped/plant/desk`, `biped/controller/desk` | any process → plant, controller | 2 | request and response |
//!
//! A recorder notifies the plant when it begins to read a run. At the end of the run the plant waits for that notification, so that no
//! message is lost.
//!
//! Each of the topics for sensors and commands has an event of the same name that wakes the reader, and a bell, which costs less and
//! serves in lockstep if both sides know it. A topic has one writer: a second plant or controller is refused. The first process creates
//! the topics with the [`Contract`] as attributes. A process with another contract is refused, and the error shows both values.

mod bare;
mod bell;
mod busy_detector;
mod contract;
mod controller;
mod node;
mod opening;
mod placement;
mod plant;
mod receiver;
mod recorder;
mod sender;
mod service;
mod truth;
mod waiting;
mod wake;

pub use crate::action::{Action, GaitRequest};
pub use crate::error::PortError;
pub use crate::wire::Verdict;
pub use bare::BarePort;
pub use contract::{Contract, Pace};
pub use controller::ControllerPort;
pub use node::REQUIRED_SHM;
pub use plant::PlantPort;
pub use recorder::RecorderPort;
pub use service::{PendingRequest, ask, ask_for};
pub use waiting::Waiting;

/// Transport of the messages. All processes of a session need this version.
pub const TRANSPORT: &str = "iceoryx2 0.10.0";
