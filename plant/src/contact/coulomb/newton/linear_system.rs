//! The linear system of a Newton step: its unknowns, its matrix, and its solution.

use super::super::super::mode::ContactMode;
use super::super::super::round_cones::RoundCones;
use super::super::iterate::Iterate;
use super::PatchNewton;
use super::dependence::Selection;
use super::equations::{Equations, Unknown};

impl PatchNewton {
    /// Solves the equations once and writes f = G y. False if a number is not finite.
    pub(super) fn solve(&mut self, cones: &RoundCones, selection: Selection, f: &mut [f64]) -> bool {
        self.list_unknowns(cones, selection);
        if self.unknowns.is_empty() {
            f.fill(0.0);
            return true;
        }
        self.assemble(cones, selection, f.len());
        let PatchNewton { groups, contacts, patch, unknowns, matrix, factor, right, .. } = self;
        if !factor.factorize(unknowns.len(), matrix, 0.0) {
            return false;
        }
        factor.solve(right);
        f.fill(0.0);
        Equations { cones, groups, contacts, patch }.add(unknowns, right, f);
        f.iter().all(|f| f.is_finite())
    }

    /// Lists the unknowns of all contacts by their modes, and computes the bases of patches and, where the selection needs them, of normals.
    pub(super) fn list_unknowns(&mut self, cones: &RoundCones, selection: Selection) {
        let PatchNewton { groups, contacts, patch, unknowns, .. } = self;
        unknowns.clear();
        for (g, group) in groups.iter_mut().enumerate() {
            if group.sticks {
                patch.find_basis(cones, group, 3, |i| contacts[i].mode == ContactMode::Patch);
                unknowns.extend((0..group.rank).map(|column| Unknown::Patch { group: g, column }));
            } else if selection == Selection::OfLinks {
                patch.find_basis(cones, group, 1, |i| contacts[i].mode != ContactMode::Open);
            }
            for (contact, own) in (group.first..).zip(&contacts[group.first..group.end]) {
                match own.mode {
                    ContactMode::Open | ContactMode::Patch => {}
                    ContactMode::Sticking => unknowns.extend([0, 1, 2].map(|row| Unknown::Sticking { contact, row })),
                    ContactMode::Sliding => {
                        unknowns.push(Unknown::ConeEdge(contact));
                        if cones.slip_direction[contact] == [0.0; 2] {
                            unknowns.push(Unknown::Transverse(contact)); // else friction has a given direction
                        }
                    }
                }
            }
        }
    }

    /// Assembles the matrix R (A + ε) G + D, column by column, and the right side R (ε f₀ − b). `rows` is the number of contact rows.
    fn assemble(&mut self, cones: &RoundCones, selection: Selection, rows: usize) {
        let PatchNewton {
            groups,
            contacts,
            patch,
            unknowns,
            response,
            matrix,
            right,
            dependence,
            compliance,
            prox_centre,
            ..
        } = self;
        let equations = Equations { cones, groups, contacts, patch };
        let n = unknowns.len();
        matrix.clear();
        right.clear();
        for (place, unknown) in unknowns.iter().enumerate() {
            response.clear();
            response.resize(rows, 0.0);
            equations.scatter(*unknown, |row, weight| {
                let a = &cones.delassus[row * rows..][..rows];
                response.iter_mut().zip(a).for_each(|(sum, a)| *sum = a.mul_add(weight, *sum));
                response[row] += *compliance * weight;
            });
            equations.gather(unknowns, response, matrix);
            if let Unknown::Transverse(i) = *unknown {
                matrix[place * n + place] += contacts[i].friction_weight;
            }
        }
        match selection {
            Selection::Any => {}
            Selection::OfLinks => equations.use_min_norm_pressure(unknowns, matrix),
            Selection::OfRobot => {
                dependence.find(&equations, unknowns);
                dependence.add_least_norm(&equations, matrix, n);
            }
        }
        response.clear();
        response.extend(cones.drift.iter().zip(&*prox_centre).map(|(b, prox_centre)| *compliance * prox_centre - b));
        equations.gather(unknowns, response, right);
    }

    /// Undoes the compliance with the present factors. Keeps the result if its residual is less.
    pub(super) fn refine(&mut self, cones: &RoundCones, iterate: &mut Iterate) {
        let Iterate { f, v, error, .. } = iterate;
        let PatchNewton { groups, contacts, patch, unknowns, factor, right, undistributed, saved, change, .. } = self;
        if unknowns.is_empty() {
            return;
        }
        saved.clone_from(f);
        let equations = Equations { cones, groups, contacts, patch };
        change.clear();
        equations.gather(unknowns, v, change);
        for ((change, unknown), y) in change.iter_mut().zip(&*unknowns).zip(&*right) {
            *change = match *unknown {
                Unknown::Transverse(i) => -*change - contacts[i].friction_weight * y,
                _ => -*change,
            };
        }
        factor.solve(change);
        f.clone_from(undistributed);
        equations.add(unknowns, change, f);
        self.distribute(cones, f);
        cones.velocity(f, v);
        let refined = cones.residual(f, v);
        if !self.failed && refined < *error {
            *error = refined;
        } else {
            f.clone_from(&self.saved);
            cones.velocity(f, v);
        }
    }
}
