//! Claims about the integration methods.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod account;
mod bounces;
mod cases;
mod comparison;
mod cone;
mod contact_cases;
mod flat_landings;
mod flight;
mod ground;
mod inside_ground;
mod jams;
mod landings;
mod lasting_stick;
mod linked_throws;
mod preparation;
mod springs;
mod stability;
mod step_size;
mod support;
mod throws;
mod tiles;
mod tolerance;
mod wheels;
