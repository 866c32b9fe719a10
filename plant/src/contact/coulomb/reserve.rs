//! Allocation for every stage before the first step, so that no step allocates.

use super::super::memory::{LastContact, Memory};
use super::super::mode::ContactMode;
use super::super::problem::Problem;
use super::Coulomb;

impl Coulomb {
    /// For this many contacts, and for problems of less friction and of fewer contacts.
    pub fn reserve_for(&mut self, contacts: usize, tangents: usize) {
        self.reserve_first_stages(contacts, tangents);
        self.selected.reserve(contacts);
        self.part.get_or_insert_default().reserve_first_stages(contacts, tangents);
        if contacts > 0 {
            self.energy_minima(); // for these two another stage comes first in the problems above
            self.iterate.f.fill(0.0);
            self.least_squares.run(&self.cones, 1.0, &mut self.iterate);
        }
    }

    /// Runs Newton's method with this many contacts: each on its own link and all on one, sticking, slipping in a given direction, and slipping.
    /// Then runs interior points on the last of these problems, whose slip is not given: there a contact has most unknowns. The buffers then have
    /// their greatest size.
    fn reserve_first_stages(&mut self, contacts: usize, tangents: usize) {
        if contacts == 0 {
            return;
        }
        let mut problem = Problem::default();
        problem.reset(contacts, tangents);
        let (next, stride) = (problem.rows() + 1, 1 + tangents);
        problem.delassus.iter_mut().step_by(next).for_each(|a| *a = 1.0);
        problem.friction.fill(0.5);
        problem.drift.chunks_exact_mut(stride).for_each(|b| b[..2].copy_from_slice(&[-1.0, 0.3]));
        for link in [|i: usize| i, |_| 0] {
            problem.link = (0..contacts).map(link).collect();
            for mode in [ContactMode::Sticking, ContactMode::Patch, ContactMode::Sliding] {
                let mut memory = Memory::of(contacts);
                for id in 0..contacts {
                    *memory.contact_mut(id) = LastContact { mode, impulse: [1.0, 0.1, 0.0], ..LastContact::default() };
                }
                for slip in [Some([1.0, 0.0]), None] {
                    problem.slip = slip.map_or(vec![], |slip| vec![slip; contacts]);
                    self.solve(&problem, &mut memory.clone(), &mut Vec::new());
                }
            }
        }
        self.interior_points();
        self.newton.solution.copy(&self.best); // else taken only if normal impulses are redundant, which these are not
    }
}
