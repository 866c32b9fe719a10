//! Initial guess and iterate of the methods for the round cone.

use super::super::mode::ContactMode;

/// Initial guess for Newton's method: modes, and slip velocities in scaled units.
#[derive(Clone, Debug, Default)]
pub(super) struct Guess {
    pub modes: Vec<ContactMode>,
    pub slips: Vec<[f64; 2]>,
}

/// An impulse with its velocity and residual, all scaled; and the number of linear systems solved so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Iterate {
    pub f: Vec<f64>,
    pub v: Vec<f64>,
    pub error: f64,
    pub steps: u32,
}

impl Iterate {
    /// Copies another iterate without allocation, but not its count of linear systems.
    pub fn copy(&mut self, other: &Iterate) {
        self.f.clone_from(&other.f);
        self.v.clone_from(&other.v);
        self.error = other.error;
    }
}
