//! The walking controller: it computes joint torques from encoder counts at a fixed rate.
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
//! | top | ankle torques for a zero-moment point | `ankle` |
//! | | constants of the robot | [`constants`] |
//! | | parameters scaled to the size of the robot | [`scaled_parameters`] |
//! | | start in the middle of a step | [`resume`] |
//! | | encoders | [`encoder`] |
//! | | the controller as a process | [`process`] |
//!
//! [`tick`] is pure: it uses no clock, no thread and no communication, allocates nothing and does not panic.

mod ankle;
pub mod constants;
pub mod encoder;
pub mod error;
pub mod gait;
pub mod pendulum;
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
pub use tick::Controller;
