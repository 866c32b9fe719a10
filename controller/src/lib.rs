//! The robot's computer: encoder counts in, joint torques out, at a fixed rate.
//!
//! | level of the paper | what | where |
//! |---|---|---|
//! | story of one period | read, observe, plan, resolve, drive | [`tick`] |
//! | bottom (23), (24) | sliding-mode servo with disturbance observer | [`servo`] |
//! | | how much delay it bears | [`stability`] |
//! | middle (25)-(27) | task and Jacobian from the supporting foot | [`support`] |
//! | middle (28)-(30) | resolved motion rate as a QP | [`rate`] |
//! | top (31)-(42) | pendulum energies | [`pendulum`] |
//! | top (43) | swing foot | [`swing`] |
//! | top | phases, exchange of support, foot placement | [`gait`] |
//! | | constants of the robot | [`constants`] |
//! | | choices that go with its size | [`scaled_parameters`] |
//! | | taking over amid a step | [`resume`] |
//! | | encoders | [`encoder`] |
//! | | the process around it | [`process`] |
//!
//! [`tick`] is pure: no clock, thread, messages between processes, allocation (but for the bounded QP) or panic.

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
