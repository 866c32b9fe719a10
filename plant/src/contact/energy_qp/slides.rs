//! Which contacts slide, and what their speed of slip is: half the difference of the w of two edges.

use super::EnergyQp;
use super::edges::of_contact;

/// A contact that pushes and slides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slide {
    pub contact: usize,
    /// First of the pair of edges along which it slides, and half its sign; zero where it sticks.
    pair: usize,
    side: f64,
}

impl Slide {
    /// mu times the speed, of velocities w.
    pub fn speed(&self, w: &[f64]) -> f64 {
        self.side * (w[self.pair + 1] - w[self.pair])
    }

    /// Of a contact that pushes. Of one that brakes with one edge of a pair we know which way.
    pub fn of(program: &EnergyQp, contact: usize) -> Slide {
        let each = program.edges.each;
        let edges = contact * each..(contact + 1) * each;
        let (mut braking, mut held) = (None, 0);
        for pair in edges.clone().step_by(2) {
            match (program.pushes(pair), program.pushes(pair + 1)) {
                (true, false) => braking = Some((pair, 0.5)),
                (false, true) => braking = Some((pair, -0.5)),
                (true, true) => held += 1,
                (false, false) => {}
            }
        }
        let (pair, side) = match braking {
            _ if held > 0 && (braking.is_some() || 2 * held == each) => (edges.start, 0.0),
            Some(braking) => braking,
            None => {
                let (_, edge) = slip(of_contact(program.velocity(), contact, each));
                (edges.start + edge / 2 * 2, if edge % 2 == 0 { 0.5 } else { -0.5 })
            }
        };
        Slide { contact, pair, side }
    }

    /// Whether it does not slide.
    pub fn sticks(&self) -> bool {
        self.side == 0.0
    }
}

/// How a contact slips, by the w of its edges: mu times the speed, and which edge brakes it.
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
