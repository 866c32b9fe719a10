//! Claims about the integration methods.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod comparison;
mod flight;
mod ground;
mod ready;
mod support;
