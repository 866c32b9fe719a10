//! The laws that the default law is compared with, and their solvers. The default law uses nothing of this module.
//!
//! | law | solver |
//! |---|---|
//! | `EnergyQp`, `EnergyQpGap` | the energy program along the edges of its cones ([`energy_qp`]) |
//! | `Complementarity`, `Aligned` | the energy program with a shift that is followed along a path; Lemke's method with 32 digits ([`basis_solver`]) |
//! | `Facets`, `ConeQp`, `FixedPoint`, `Lagged`, `Sweep` | semismooth Newton, with fallbacks ([`cone_solver`]) |
//! | `SpringDamper` | a formula ([`spring_damper`]) |

mod basis_solver;
mod basis_system;
mod condition;
mod cone_qp;
mod cone_solver;
mod dictionary;
mod double_double;
mod energy_qp;
mod facets;
mod fixed_point;
mod gauss_seidel;
mod lemke;
mod polygon;
mod scaled_problem;
mod semismooth_newton;
mod spring_damper;
mod square_cone;
mod status;
mod vector;

use super::law::has_basis;
use super::memory::Memory;
use super::problem::Problem;
use super::report::Report;
use basis_solver::BasisSolver;
use cone_solver::ConeSolver;
use messages::scene::Law;

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Compared {
    basis_solver: BasisSolver,
    cone_solver: ConeSolver,
}

impl Compared {
    /// Solves the problem and writes the impulse [N·s]. The report has the law's own residual only.
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        match has_basis(law) {
            true => self.basis_solver.solve(problem, law, memory, impulse),
            false => self.cone_solver.solve(problem, law, memory, impulse),
        }
    }

    /// The residual of a given impulse in the conditions of the law itself.
    pub fn own_residual(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> f64 {
        match has_basis(law) {
            true => self.basis_solver.own_residual(problem, law, impulse),
            false => self.cone_solver.own_residual(problem, law, impulse),
        }
    }

    /// Allocates for this many contacts, so that no step of a law with a basis allocates.
    pub fn reserve_for(&mut self, contacts: usize, tangents: usize, law: Law) {
        if has_basis(law) && contacts > 0 {
            self.basis_solver.reserve_for(contacts, tangents, law);
        }
    }
}
