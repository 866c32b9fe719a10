//! Mode of each contact: from the present impulse and velocity, or from a guess.

use super::super::super::mode::ContactMode;
use super::super::super::projection::norm;
use super::super::super::round_cones::{RoundCones, contact_rows};
use super::super::super::tolerance::{COMPLIANCE, WELL_SOLVED};
use super::super::iterate::{Guess, Iterate, Weight};
use super::PatchNewton;
use super::equations::ModeWeights;

impl PatchNewton {
    /// Sets the modes from impulse and velocity.
    pub(super) fn classify(&mut self, cones: &RoundCones, weight: Weight, Iterate { f, v, .. }: &Iterate) {
        let balance = match weight {
            Weight::Mass => 1.0,
            Weight::Masses(factor) => factor,
            Weight::Balanced => {
                let greatest = |x: &[f64]| x.iter().fold(0.0, |greatest: f64, x| greatest.max(x.abs()));
                let ratio = greatest(f) / greatest(v);
                if ratio > 1.0 { ratio.min(1.0 / WELL_SOLVED) } else { 1.0 }
            }
        };
        for group in &mut self.groups {
            let mut sticking = 0;
            for i in group.first..group.end {
                let own = &mut self.contacts[i];
                if group.sticks && own.mode == ContactMode::Patch {
                    continue;
                }
                let (f, v, mu) = (contact_rows(f, i), contact_rows(v, i), cones.friction[i]);
                let rho = balance / (cones.inverse_mass[i] + COMPLIANCE);
                let x = [f[0] - rho * v[0], f[1] - rho * v[1], f[2] - rho * v[2]];
                let (bound, length) = (mu * x[0], norm(x[1], x[2]));
                *own = if x[0] <= 0.0 {
                    ModeWeights::default()
                } else if cones.slip_direction[i] != [0.0; 2] {
                    ModeWeights::sliding_along(cones.slip_direction[i])
                } else if group.sticks {
                    ModeWeights { mode: ContactMode::Patch, ..ModeWeights::default() }
                } else if length <= bound {
                    sticking += 1;
                    ModeWeights { mode: ContactMode::Sticking, ..ModeWeights::default() }
                } else {
                    let share = bound / length;
                    let along = [x[1] / length, x[2] / length];
                    ModeWeights {
                        mode: ContactMode::Sliding,
                        along,
                        slip_weight: rho * share,
                        friction_weight: 1.0 - share,
                    }
                };
            }
            if sticking > 1 && group.may_stick {
                group.sticks = true;
                let active =
                    self.contacts[group.first..group.end].iter_mut().filter(|own| own.mode != ContactMode::Open);
                active.for_each(|own| *own = ModeWeights { mode: ContactMode::Patch, ..ModeWeights::default() });
            }
        }
    }

    /// Sets the modes and friction directions from a guess.
    pub(super) fn apply_guess(&mut self, cones: &RoundCones, guess: &Guess, Iterate { f, .. }: &Iterate) {
        for group in &mut self.groups {
            group.sticks = group.may_stick && guess.modes[group.first..group.end].contains(&ContactMode::Patch);
            for i in group.first..group.end {
                let (mode, slip) = (guess.modes[i], guess.slips[i]);
                let speed = norm(slip[0], slip[1]);
                self.contacts[i] = match mode {
                    ContactMode::Open => ModeWeights::default(),
                    _ if cones.slip_direction[i] != [0.0; 2] => ModeWeights::sliding_along(cones.slip_direction[i]),
                    _ if group.sticks => ModeWeights { mode: ContactMode::Patch, ..ModeWeights::default() },
                    ContactMode::Sliding if speed > 0.0 => {
                        let along = [-slip[0] / speed, -slip[1] / speed];
                        let rho = 1.0 / cones.inverse_mass[i];
                        let slides = rho * speed / (norm(f[3 * i + 1], f[3 * i + 2]) + rho * speed);
                        ModeWeights { mode, along, slip_weight: rho * (1.0 - slides), friction_weight: slides }
                    }
                    _ => ModeWeights { mode: ContactMode::Sticking, ..ModeWeights::default() },
                };
            }
        }
    }
}

impl ModeWeights {
    /// A contact that slides in a given direction.
    pub(super) fn sliding_along(slip: [f64; 2]) -> ModeWeights {
        ModeWeights {
            mode: ContactMode::Sliding,
            along: slip.map(|slip| -slip),
            slip_weight: 0.0,
            friction_weight: 1.0,
        }
    }
}
