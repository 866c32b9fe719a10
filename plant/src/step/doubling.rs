//! Step doubling: error control by comparison with two half steps.

use super::Plant;
use super::step_size::{MIN_FACTOR, SAFETY, SHORTEST_DOUBLED};
use super::workspace::Workspace;
use crate::error::PlantError;
use crate::state::State;
use crate::truth::Record;

/// Greatest factor from one step to the next [-].
const MAX_FACTOR: f64 = 4.0;
/// The last step may be longer than planned by this factor [-], so that no tiny step remains.
const LAST_STEP_STRETCH: f64 = 1.01;
/// Difference of one step and two half steps, divided by the error of the two [-]: 2^p − 1 for a method of order p = 2.
const RICHARDSON: f64 = 3.0;

impl Plant {
    /// Integrates over `h` in steps of [`Plant::midpoint_contact`] whose error stays below the tolerance.
    ///
    /// For a method of order 2, one step and two half steps differ by three times the error of the two half steps. The next step is as long
    /// as the tolerance allows, assuming an error of order h³. Where contact forces jump, that assumption fails, and the shortest step,
    /// dt/256, is accepted in any case. A part in which a contact point passes the edge of a tile is shortened likewise, and so is one that
    /// fails, for example because its iteration does not converge.
    ///
    /// # Errors
    /// Those of the shortest step.
    ///
    /// # Source
    /// Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, II.4.
    pub(super) fn step_doubling(&mut self, h: f64) -> Result<(), PlantError> {
        let (tolerance, shortest) = (self.world.settings.tolerance_step, h * SHORTEST_DOUBLED);
        let (mut done, mut step) = (0.0, self.state.next_step.min(h));
        while done < h {
            // a tiny last step would cost as much as a full one
            let last = done + LAST_STEP_STRETCH * step >= h;
            let part = if last { h - done } else { step };
            let record = self.state.record;
            self.work.start.copy(&self.state.now.state);
            self.work.doubling.memory.copy(&self.state.memory);
            self.work.doubling.last_acceleration.copy(&self.state.last_acceleration);
            self.work.doubling.events = self.events;
            self.work.doubling.ground.copy(&self.world.input.ground);
            let error = match self.double(part, record) {
                Ok(error) => error,
                Err(failure) if step <= shortest => return Err(failure),
                Err(_) => f64::INFINITY, // a shorter part may succeed
            };
            let factor = (SAFETY * libm::cbrt(tolerance / error)).clamp(MIN_FACTOR, MAX_FACTOR);
            if error <= tolerance || step <= shortest {
                done = if last { h } else { done + part };
                step = (part * factor).clamp(shortest, h);
                self.state.next_step = step;
            } else {
                self.rejected += 1;
                step = (part * factor).max(shortest);
                self.restore_start(record)?;
            }
        }
        Ok(())
    }

    /// Advances by two halves of a part. Returns their error: infinite if a contact point passes the edge of a tile.
    fn double(&mut self, part: f64, record: Record) -> Result<f64, PlantError> {
        self.midpoint_contact(part)?;
        self.work.doubling.coarse.copy(&self.state.now.state);
        self.restore_start(record)?;
        self.midpoint_contact(0.5 * part)?;
        self.midpoint_contact(0.5 * part)?;
        self.find_ground();
        let passes_edge = self.world.input.ground != self.work.doubling.ground;
        let difference = distance(&self.work.doubling.coarse, &self.state.now.state);
        Ok(if passes_edge { f64::INFINITY } else { difference / RICHARDSON })
    }

    /// Restores the beginning of the step.
    fn restore_start(&mut self, record: Record) -> Result<(), PlantError> {
        let Workspace { start, doubling, .. } = &self.work;
        self.state.now.state.copy(start);
        self.state.memory.copy(&doubling.memory);
        self.state.last_acceleration.copy(&doubling.last_acceleration);
        self.world.input.ground.copy(&doubling.ground);
        (self.state.record, self.events) = (record, doubling.events);
        self.state.now.update_pose(&self.world)
    }
}

/// Greatest difference of two states, each entry relative to 1 + |entry|.
fn distance(a: &State, b: &State) -> f64 {
    let pairs = a.x.iter().zip(&b.x).chain(a.xdot.iter().zip(&b.xdot));
    pairs.map(|(a, b)| (a - b).abs() / (1.0 + b.abs())).fold(0.0, f64::max)
}
