//! What a link does to commands on their way to the plant: delay, jitter, loss, duplicates, reordering. All by seeded
//! chance and simulated time, so that a run repeats to the bit.
//!
//! ```text
//!   sent at the beginning of period k, under way for w   →   acts from period  k + ⌈w/T⌉
//!   w = d + j u            uniform, u in [0, 1)
//!   w = |d + j z|          normal, z standard normal
//!   w = d + j, or d        within a burst, or not
//! ```
//! Each command takes the same number of chances whatever the settings are. So two runs of one seed meet the same fate
//! but for what their settings change: what is lost at a loss of .1 is lost at .2 too.

use messages::scene::{Jitter, LinkScene};
use messages::wire::Command;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Mean time from the end of one burst to the next [s].
pub const MEAN_BURST_INTERVAL: f64 = 0.5;
/// Mean length of a burst [s].
pub const MEAN_BURST_LENGTH: f64 = 0.05;
/// Greatest |z| that [`normal`] gives: √(2 ln 2⁵³).
const MAX_NORMAL: f64 = 8.6;
/// Commands beyond those that the settings keep under way: what a real-time plant may find at once after a stall.
const SPARE_CAPACITY: usize = 64;
/// A travel time this little beyond a whole number of periods is rounding.
const ROUNDING: f64 = 1e-9;

/// The link between controller and plant.
#[derive(Clone, Debug)]
pub struct Injector {
    link: LinkScene,
    /// Control period [ms].
    period_ms: f64,
    /// Probabilities that a burst begins or ends with a period [-].
    change: [f64; 2],
    in_burst: bool,
    random: fastrand::Rng,
    /// In order of arrival; never longer than its capacity of `room`.
    under_way: VecDeque<DelayedCommand>,
    room: usize,
}

impl Injector {
    /// The link of a scene whose control period is `period_s`.
    pub fn new(link: &LinkScene, period_s: f64) -> Self {
        let period_ms = 1e3 * period_s;
        let longest = ((link.delay_ms + MAX_NORMAL * link.jitter_ms) / period_ms).ceil() as usize + 2;
        let room = 2 * longest + SPARE_CAPACITY; // each may come twice
        Injector {
            link: link.clone(),
            period_ms,
            change: [MEAN_BURST_INTERVAL, MEAN_BURST_LENGTH].map(|mean| 1.0 - (-period_s / mean).exp()),
            in_burst: false,
            random: fastrand::Rng::with_seed(link.seed),
            under_way: VecDeque::with_capacity(room),
            room,
        }
    }

    /// A command is sent in control period `tick`. What finds no room is lost.
    pub fn push(&mut self, tick: u64, command: &Command) {
        let [lost, twice, overtaken, turn, first @ .., u, v] = [(); 8].map(|()| self.random.f64());
        self.in_burst ^= turn < self.change[usize::from(self.in_burst)];
        if lost >= self.link.loss {
            self.send(tick, first, overtaken < self.link.reorder, command);
        }
        if twice < self.link.duplicate {
            self.send(tick, [u, v], false, command);
        }
    }

    /// The next command that has arrived by control period `tick`, in order of arrival.
    pub fn pop(&mut self, tick: u64) -> Option<Command> {
        let due = self.under_way.front()?.arrival.0;
        if due > tick { None } else { self.under_way.pop_front().map(|parcel| parcel.command) }
    }

    fn send(&mut self, tick: u64, chance: [f64; 2], overtaken: bool, command: &Command) {
        if self.under_way.len() == self.room {
            return;
        }
        let travel = self.travel(chance) / self.period_ms;
        let due = tick + (travel - ROUNDING).ceil() as u64 + u64::from(overtaken);
        let arrival = (due, overtaken, tick as f64 + travel);
        let behind = self.under_way.partition_point(|other| other.arrival <= arrival);
        self.under_way.insert(behind, DelayedCommand { arrival, command: *command });
    }

    /// Time under way [ms].
    fn travel(&self, chance: [f64; 2]) -> f64 {
        let LinkScene { delay_ms, jitter_ms, .. } = self.link;
        match self.link.jitter {
            Jitter::Uniform => delay_ms + jitter_ms * chance[0],
            Jitter::Normal => (delay_ms + jitter_ms * normal(chance)).abs(),
            Jitter::Burst if self.in_burst => delay_ms + jitter_ms,
            Jitter::Burst => delay_ms,
        }
    }
}

/// A standard normal number of two uniform ones in [0, 1), by Box and Muller.
fn normal([u, v]: [f64; 2]) -> f64 {
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// A command under way.
#[derive(Clone, Debug)]
struct DelayedCommand {
    /// Order of arrival: period from which on it may act; behind all others of that period; instant [periods].
    arrival: (u64, bool, f64),
    command: Command,
}
