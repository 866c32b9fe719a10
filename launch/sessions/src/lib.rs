//! Sessions: starting plant and controller as processes, watching, controlling, swapping and ending them.

pub mod children;
pub mod control;
pub mod doctor;
pub mod environment;
pub mod export;
pub mod host_environment;
pub mod model;
pub mod open;
pub mod process;
pub mod realtime;
pub mod resource_limits;
pub mod roles;
pub mod run;
pub mod scaffold;
pub mod share;
pub mod swap;
pub mod tunnel;
pub mod wire;
