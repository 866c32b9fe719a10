//! The last resort: a regularised problem, and the impulse with the least residual of all.

use super::super::lemke::{Care, QUICK};
use super::super::residual;
use super::{SOLVED, Solver, yardstick};
use messages::scene::Law;

/// Rounds: regularisation rho, and what counts as zero. First the problem itself with other tolerances.
const ROUNDS: [(f64, f64); 12] = [
    (0.0, 1e-12),
    (0.0, 1e-7),
    (1e-8, 1e-9),
    (1e-8, 1e-12),
    (1e-6, 1e-9),
    (1e-6, 1e-12),
    (1e-4, 1e-9),
    (1e-8, 1e-9),
    (1e-6, 1e-9),
    (1e-4, 1e-9),
    (1e-8, 1e-9),
    (1e-8, 1e-9),
];

impl Solver {
    /// Remembers the impulse if its residual is the least so far.
    pub(super) fn note(&mut self, error: f64) {
        if error < self.least {
            self.least = error;
            self.best.clone_from(&self.f);
        }
    }

    /// Goes back to the impulse with the least residual so far.
    pub(super) fn take_best(&mut self) {
        self.f.clone_from(&self.best);
        self.scaled.velocity(&self.f, &mut self.v);
        self.scaled.harden(&self.f, &mut self.v);
    }

    /// Proximal rounds: f' solves the problem with A + rho I and b - rho f, which is nowhere singular and has the same
    /// fixed point. Each basis is first tried on the true problem. Ends with the impulse whose residual is the least of
    /// all; returns the pivots.
    pub(super) fn fall_back(&mut self, law: Law) -> u32 {
        let mut pivots = 0;
        self.f.clear();
        self.f.resize(self.scaled.drift.len(), 0.0);
        for (rho, zero) in ROUNDS {
            self.proximal.regularise(&self.scaled, rho, &self.f);
            match law {
                Law::EnergyQp | Law::EnergyQpGap => {
                    self.basis.fill(0);
                    self.energy_qp.begin(&self.proximal, &self.basis);
                    let found = self.energy_qp.pivot(&self.proximal, &[], &mut pivots);
                    self.energy_qp.write(&self.proximal, &mut self.f, &mut self.basis);
                    found
                }
                _ => self.facets.pivot(&self.proximal, Care { zero, ..QUICK }, &mut self.basis, &mut pivots),
            };
            for exact in [true, false] {
                let problem = if exact { &self.scaled } else { &self.proximal };
                if self.block.solve(problem, law, &self.basis, &mut self.f, &mut self.v) {
                    self.scaled.velocity(&self.f, &mut self.v);
                    self.note(residual::natural_map(&self.scaled, &self.f, &self.v, yardstick(law)));
                }
                if self.least <= SOLVED {
                    self.take_best();
                    return pivots;
                }
            }
        }
        self.take_best();
        pivots
    }
}
