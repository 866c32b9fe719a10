//! Claims about the integration methods.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod bounces;
mod cases;
mod comparison;
mod control;
mod flight;
mod ground;
mod promise;
mod ready;
mod support;
mod throws;
