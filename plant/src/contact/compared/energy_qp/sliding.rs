//! Sliding contacts and their slip speed: half the difference of w of two opposite edges.

use super::EnergyQp;
use super::edges::of_contact;

/// An active contact, with the direction in which it slides.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlidingContact {
    pub contact: usize,
    /// First edge of the tangent along which it slides, and half the sign of the slip; zero if it sticks.
    pair: usize,
    side: f64,
}

impl SlidingContact {
    /// μ times the slip speed, for velocities w.
    pub fn speed(&self, w: &[f64]) -> f64 {
        self.side * (w[self.pair + 1] - w[self.pair])
    }

    /// The sliding direction of an active contact. If one edge of a tangent is basic and the other is not, that edge opposes the slip.
    pub fn of(program: &EnergyQp, contact: usize) -> SlidingContact {
        let each = program.edges.each;
        let pairs = (1 << each) / 3; // a bit for the first edge of each tangent
        let pushes = program.basic_edges_of(contact);
        let (first, second) = (pushes & pairs, pushes >> 1 & pairs);
        let (held, braking) = (first & second, first ^ second);
        if held != 0 && held | braking == pairs {
            return SlidingContact { contact, pair: contact * each, side: 0.0 };
        }
        let edge = match braking.checked_ilog2() {
            Some(pair) => pair as usize + usize::from(first >> pair & 1 == 0),
            None => slip(of_contact(program.velocity(), contact, each)).1,
        };
        SlidingContact { contact, pair: contact * each + edge / 2 * 2, side: if edge % 2 == 0 { 0.5 } else { -0.5 } }
    }

    /// Whether it sticks.
    pub fn sticks(&self) -> bool {
        self.side == 0.0
    }
}

/// Slip of a contact from w of its edges: μ times the speed, and the edge that opposes it.
pub(super) fn slip(w: &[f64]) -> (f64, usize) {
    let mut most = (0.0, 0);
    for (pair, w) in w.chunks_exact(2).enumerate() {
        let speed = 0.5 * (w[1] - w[0]);
        if speed.abs() > most.0 {
            most = (speed.abs(), 2 * pair + usize::from(speed < 0.0));
        }
    }
    most
}
