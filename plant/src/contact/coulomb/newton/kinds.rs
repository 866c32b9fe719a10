//! What each contact does: as impulse and velocity say, or as a start says.

use super::super::super::project::length;
use super::super::super::round::{Round, part};
use super::super::super::tolerance::COMPLIANCE;
use super::super::{Iterate, Kind, Start};
use super::Newton;

/// What a contact does, and the weights of its equations.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    pub kind: Kind,
    /// Direction of friction, e.
    pub along: [f64; 2],
    /// σρ and 1 − σ.
    pub slip: f64,
    pub friction: f64,
}

impl Newton {
    /// The kinds that impulse and velocity speak for.
    pub(super) fn classify(&mut self, round: &Round, Iterate { f, v, .. }: &Iterate) {
        for group in &mut self.groups {
            let mut sticking = 0;
            for i in group.first..group.end {
                let own = &mut self.contacts[i];
                if group.sticks && own.kind == Kind::Patch {
                    continue;
                }
                let (f, v, mu) = (part(f, i), part(v, i), round.friction[i]);
                let rho = 1.0 / (round.inverse_mass[i] + COMPLIANCE);
                let x = [f[0] - rho * v[0], f[1] - rho * v[1], f[2] - rho * v[2]];
                let (bound, length) = (mu * x[0], length(x[1], x[2]));
                *own = if x[0] <= 0.0 {
                    Contact::default()
                } else if round.given[i] != [0.0; 2] {
                    Contact::given(round.given[i])
                } else if group.sticks {
                    Contact { kind: Kind::Patch, ..Contact::default() }
                } else if length <= bound {
                    sticking += 1;
                    Contact { kind: Kind::Sticks, ..Contact::default() }
                } else {
                    let share = bound / length;
                    let along = [x[1] / length, x[2] / length];
                    Contact { kind: Kind::Slides, along, slip: rho * share, friction: 1.0 - share }
                };
            }
            if sticking > 1 && group.may {
                group.sticks = true;
                let pushing = self.contacts[group.first..group.end].iter_mut().filter(|own| own.kind != Kind::Open);
                pushing.for_each(|own| *own = Contact { kind: Kind::Patch, ..Contact::default() });
            }
        }
    }

    /// The kinds of a start, and the directions in which it slid.
    pub(super) fn recall(&mut self, round: &Round, start: &Start, Iterate { f, .. }: &Iterate) {
        for group in &mut self.groups {
            group.sticks = group.may && start.kinds[group.first..group.end].contains(&Kind::Patch);
            for i in group.first..group.end {
                let (kind, slip) = (start.kinds[i], start.slips[i]);
                let speed = length(slip[0], slip[1]);
                self.contacts[i] = match kind {
                    Kind::Open => Contact::default(),
                    _ if round.given[i] != [0.0; 2] => Contact::given(round.given[i]),
                    _ if group.sticks => Contact { kind: Kind::Patch, ..Contact::default() },
                    Kind::Slides if speed > 0.0 => {
                        let along = [-slip[0] / speed, -slip[1] / speed];
                        let rho = 1.0 / round.inverse_mass[i];
                        let slides = rho * speed / (length(f[3 * i + 1], f[3 * i + 2]) + rho * speed);
                        Contact { kind, along, slip: rho * (1.0 - slides), friction: slides }
                    }
                    _ => Contact { kind: Kind::Sticks, ..Contact::default() },
                };
            }
        }
    }
}

impl Contact {
    /// A contact that slides against a given direction of friction.
    fn given(slip: [f64; 2]) -> Contact {
        Contact { kind: Kind::Slides, along: slip.map(|slip| -slip), slip: 0.0, friction: 1.0 }
    }
}
