//! The laws that the default is compared with, and how each of them is solved. Nothing of the default law is in here.
//!
//! | law | solved by |
//! |---|---|
//! | `EnergyQp`, `EnergyQpGap` | the energy program along the edges of its cones ([`energy_qp`]) |
//! | `Complementarity`, `Aligned` | the same, shifted along a path; Lemke in 32 digits ([`pivoting`]) |
//! | `Facets`, `ConeQp`, `FixedPoint`, `Lagged`, `Sweep` | semismooth Newton and what is behind it ([`cones`]) |
//! | `SpringDamper` | a formula ([`spring_damper`]) |

mod basis;
mod cone_qp;
mod cones;
mod diamond;
mod dictionary;
mod energy_qp;
mod facets;
mod fixed_point;
mod lemke;
mod newton;
mod pivoting;
mod polygon;
mod rule;
mod scaled;
mod spring_damper;
mod status;
mod sweep;
mod twofold;

use super::{Memory, Problem, Report, has_basis};
use cones::Cones;
use messages::scene::Law;
use pivoting::Pivoting;

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Compared {
    pivoting: Pivoting,
    cones: Cones,
}

impl Compared {
    /// Solves; writes the impulse [N·s]. Of the report's residuals it has the law's own.
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        match has_basis(law) {
            true => self.pivoting.solve(problem, law, memory, impulse),
            false => self.cones.solve(problem, law, memory, impulse),
        }
    }

    /// The residual of a given impulse in the law's own problem.
    pub fn own_residual(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> f64 {
        match has_basis(law) {
            true => self.pivoting.own_residual(problem, law, impulse),
            false => self.cones.own_residual(problem, law, impulse),
        }
    }

    /// Makes room for so many contacts, so that no step of a law with a basis allocates.
    pub fn rehearse(&mut self, contacts: usize, tangents: usize, law: Law) {
        if has_basis(law) && contacts > 0 {
            self.pivoting.rehearse(contacts, tangents, law);
        }
    }
}
