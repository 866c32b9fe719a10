//! Sessions: plant and controller as processes, started, watched, asked and ended.

pub mod allowance;
pub mod children;
pub mod desk;
pub mod doctor;
pub mod environment;
pub mod export;
pub mod model;
pub mod opening;
pub mod place;
pub mod process;
pub mod realtime;
pub mod roles;
pub mod run;
pub mod scaffold;
pub mod swap;
pub mod tunnel;
pub mod wire;
