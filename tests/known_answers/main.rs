//! Scenes with known answers. Each claim is an exact value, with a case (a law or a method) that does not reach it.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod comparison;
mod energy;
mod flight;
mod impact;
mod joints;
mod laws;
mod rolling;
mod sliding;
mod smooth;
mod springs;
mod standing;
mod steps;
mod support;
mod symmetry;
mod walkers;
