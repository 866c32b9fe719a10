//! Scenes with known answers: each claim is an exact value, and beside it what fails to have it.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod comparison;
mod joints;
mod rolling;
mod support;
