//! Disturbances of commands on their way to the plant: delay, jitter, loss, duplicates, reordering. They depend only on a seed and on
//! simulated time, so that every run gives the same bits.
//!
//! ```text
//!   sent at the beginning of period k with the delay w   →   acts from period  k + ⌈w/T⌉
//!   w = d + j u            uniform, u in [0, 1)
//!   w = |d + j z|          normal, z standard normal
//!   w = d + j, or d        within a burst, or not
//! ```
//! Each command draws the same number of random numbers for any settings. Two runs with the same seed therefore differ only where their
//! settings do: a command that is lost at a loss of .1 is also lost at .2.

use messages::scene::{Jitter, LinkScene};
use messages::wire::Command;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Mean time from the end of a burst to the beginning of the next one [s].
pub const MEAN_BURST_INTERVAL: f64 = 0.5;
/// Mean length of a burst [s].
pub const MEAN_BURST_LENGTH: f64 = 0.05;
/// Greatest |z| that [`normal`] gives: √(2 ln 2⁵³).
const MAX_NORMAL: f64 = 8.6;
/// Capacity for commands beyond those that the settings delay: a real-time plant may receive this many at once after a stall.
const SPARE_CAPACITY: usize = 64;
/// A delay that exceeds a whole number of periods by less than this is rounding [control periods].
const ROUNDING: f64 = 1e-9;

/// The disturbed connection from controller to plant.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Injector {
    link: LinkScene,
    /// Control period [ms].
    period_ms: f64,
    /// Probabilities that a burst begins, and that one ends, in a control period [-].
    change: [f64; 2],
    in_burst: bool,
    #[serde(with = "crate::serial::random")]
    random: fastrand::Rng,
    /// Commands in order of arrival, at most `capacity`.
    in_transit: VecDeque<DelayedCommand>,
    capacity: usize,
}

impl Injector {
    /// The disturbances of a scene with the control period `period_s` [s].
    pub fn new(link: &LinkScene, period_s: f64) -> Self {
        let period_ms = 1e3 * period_s;
        let longest = ((link.delay_ms + MAX_NORMAL * link.jitter_ms) / period_ms).ceil() as usize + 2;
        let capacity = 2 * longest + SPARE_CAPACITY; // each may arrive twice
        Injector {
            link: link.clone(),
            period_ms,
            change: [MEAN_BURST_INTERVAL, MEAN_BURST_LENGTH].map(|mean| 1.0 - libm::exp(-period_s / mean)),
            in_burst: false,
            random: fastrand::Rng::with_seed(link.seed),
            in_transit: VecDeque::with_capacity(capacity),
            capacity,
        }
    }

    /// Sends a command in control period `tick`. It is lost if the capacity is exhausted.
    pub fn push(&mut self, tick: u64, command: &Command) {
        let [lost, twice, overtaken, switch, first @ .., u, v] = [(); 8].map(|()| self.random.f64());
        self.in_burst ^= switch < self.change[usize::from(self.in_burst)];
        if lost >= self.link.loss {
            self.send(tick, first, overtaken < self.link.reorder, command);
        }
        if twice < self.link.duplicate {
            self.send(tick, [u, v], false, command);
        }
    }

    /// The next command that has arrived by control period `tick`, in order of arrival.
    pub fn pop(&mut self, tick: u64) -> Option<Command> {
        let due = self.in_transit.front()?.arrival.0;
        if due > tick { None } else { self.in_transit.pop_front().map(|parcel| parcel.command) }
    }

    fn send(&mut self, tick: u64, chance: [f64; 2], overtaken: bool, command: &Command) {
        if self.in_transit.len() == self.capacity {
            return;
        }
        let delay = self.delay(chance) / self.period_ms;
        let due = tick + (delay - ROUNDING).ceil() as u64 + u64::from(overtaken);
        let arrival = (due, overtaken, tick as f64 + delay);
        let behind = self.in_transit.partition_point(|other| other.arrival <= arrival);
        self.in_transit.insert(behind, DelayedCommand { arrival, command: *command });
    }

    /// Delay of a command [ms].
    fn delay(&self, chance: [f64; 2]) -> f64 {
        let LinkScene { delay_ms, jitter_ms, .. } = self.link;
        match self.link.jitter {
            Jitter::Uniform => delay_ms + jitter_ms * chance[0],
            Jitter::Normal => (delay_ms + jitter_ms * normal(chance)).abs(),
            Jitter::Burst if self.in_burst => delay_ms + jitter_ms,
            Jitter::Burst => delay_ms,
        }
    }
}

/// A standard normal number from two uniform ones in [0, 1), by the method of Box and Muller.
fn normal([u, v]: [f64; 2]) -> f64 {
    (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(TAU * v)
}

/// A command in transit.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct DelayedCommand {
    /// Key of the order of arrival: first period in which the command may act; whether it comes after all others of that period; instant
    /// of arrival [control periods].
    arrival: (u64, bool, f64),
    command: Command,
}
