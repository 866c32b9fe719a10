//! The acceleration of the step before, and its extrapolation to the middle of the next one.

use crate::model::Model;
use serde::{Deserialize, Serialize};

/// Steps in flight from which the acceleration is extrapolated, at most [-]. With four, one evaluation of b finds the mean velocity in most
/// steps of 1 ms.
const STEPS: usize = 4;

/// Acceleration of the step before, including contact, and how it changed in flight.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct LastAcceleration {
    /// Backward differences: the acceleration, its change from step to step, the change of that, …
    differences: [Vec<f64>; STEPS],
    /// Number of last steps in flight, at most [`STEPS`], and their length [s]. In contact the acceleration may jump, so it is not
    /// extrapolated there.
    flights: usize,
    h: f64,
    /// False at the start and after an impact.
    pub known: bool,
    /// Factor by which an iteration of the mean velocity reduces its error, relative to the length of the step [1/s].
    pub contraction: f64,
}

impl LastAcceleration {
    pub fn new(model: &Model) -> LastAcceleration {
        LastAcceleration {
            differences: [(); STEPS].map(|()| vec![0.0; model.dofs()]),
            flights: 0,
            h: 0.0,
            known: false,
            contraction: f64::INFINITY,
        }
    }

    /// Copies another acceleration without allocation.
    pub fn copy(&mut self, other: &LastAcceleration) {
        for (own, other) in self.differences.iter_mut().zip(&other.differences) {
            own.copy_from_slice(other);
        }
        (self.flights, self.h, self.contraction) = (other.flights, other.h, other.contraction);
        self.known = other.known;
    }

    /// Marks the acceleration as unknown.
    pub fn forget(&mut self) {
        (self.known, self.flights) = (false, 0);
    }

    /// Sets the acceleration from a step of `h`: the velocities before and after it.
    pub fn set(&mut self, before: &[f64], after: &[f64], h: f64, in_flight: bool) {
        let comparable = if in_flight && h == self.h { self.flights } else { 0 };
        for (i, (before, after)) in before.iter().zip(after).enumerate() {
            let mut newest = (after - before) / h;
            for difference in self.differences.iter_mut().take(comparable + 1) {
                newest -= std::mem::replace(&mut difference[i], newest);
            }
        }
        (self.flights, self.h) = (if in_flight { (comparable + 1).min(STEPS) } else { 0 }, h);
        self.known = true;
    }

    /// Adds the velocity that the acceleration causes until the middle of a step of `h`.
    pub fn add(&self, h: f64, velocity: &mut [f64]) {
        let (time, count) = (0.5 * h, if h == self.h { self.flights.max(1) } else { 1 });
        for difference in &self.differences[..count] {
            velocity.iter_mut().zip(difference).for_each(|(v, rate)| *v += time * rate);
        }
    }
}
