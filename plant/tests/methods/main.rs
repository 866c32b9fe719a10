//! Claims about the integration methods.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod flight;
mod support;
