//! The laboratory: speed against accuracy, latency, faults, conformance, robustness, sweeps, studies.

pub mod batch;
pub mod chart;
pub mod conform;
pub mod contact;
pub mod faults;
pub mod hashes;
pub mod latency;
pub mod robustness;
pub mod soak;
pub mod study;
pub mod subject;
pub mod sweep;
