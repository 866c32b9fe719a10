//! Coulomb's law from the energy program: the normal rows of sliding contacts are shifted by μ |v_F|.
//!
//! The optimum of the program has v_N >= μ |v_F|. Without sliding, that is Coulomb's law. With a shift that equals μ times the slip
//! speed, the optimum obeys Coulomb's law everywhere (De Saxcé; Acary & Cadoux). While the set of basic edges stays the same, the slip is
//! an affine function of the shift. Newton's method then finds the shift in one step, unless an edge enters or leaves on the way. In that
//! case the method continues with the new set of edges. So it follows a piecewise linear path on which slip − shift = τ times its initial
//! value, from τ = 1 to τ = 0.
//!
//! If a piece can only be passed backwards, the method passes it backwards. If the path returns to its beginning, the method gives up, and
//! the program restarts with the shift that equals μ times the slip there. Under one foot, many shifts may solve the problem. The path
//! then leads to the shift with impulses of least norm, or in every second restart to one near it.
//!
//! # Source
//! Acary, Cadoux, Lemaréchal & Malick, *A formulation of the linear discrete Coulomb friction problem via convex optimization* (2011);
//! Katzenelson, *An algorithm for solving nonlinear resistor networks* (1965).

use super::super::super::lu::Lu;
use super::super::super::tolerance::{DEPENDENT_PIVOT, NEARLY_DEPENDENT_PIVOT, ZERO_AMOUNT};
use super::super::scaled_problem::ScaledProblem;
use super::EnergyQp;
use super::edges::{Panel, WIDTH, add};
use super::ratio_test::{Breakpoint, RatioTest};
use super::shift_responses::ShiftResponses;
use super::sliding::{SlidingContact, slip};

/// Pieces of a path at most: a restart is cheaper than a longer path.
const MAX_PIECES: usize = 16;

/// The shift of each v_N, and the path to its solution.
#[derive(Clone, Debug, Default)]
pub struct ShiftPath {
    pub value: Vec<f64>,
    /// Whether to choose the shift with impulses of least norm, if many shifts solve the problem.
    pub min_norm: bool,
    /// μ times the slip speed at the beginning of the path, and its excess over the shift.
    target: Vec<f64>,
    defect: Vec<f64>,
    /// Number of basic edges of each contact.
    basic_count: Vec<usize>,
    sliding: Vec<SlidingContact>,
    responses: ShiftResponses,
    /// 1 − dslip/dshift, column by column.
    square: Vec<f64>,
    factor: Lu,
    /// Change of the shifts of sliding contacts while τ falls by 1, and the resulting change of \[y; w\].
    change: Vec<f64>,
    direction: Vec<Panel>,
    ratio_test: RatioTest,
    /// A change in the null space of the equations, with its change of \[y; w\]; impulses of the state and of both changes.
    null_change: Vec<f64>,
    null_direction: Vec<Panel>,
    impulses: [Vec<f64>; 3],
}

impl ShiftPath {
    /// Resets to zero shift, for another problem.
    pub fn reset(&mut self, scaled: &ScaledProblem) {
        self.value.clear();
        self.value.resize(scaled.contacts, 0.0);
        self.responses.reset(scaled.contacts, scaled.facets());
    }

    /// Allocates for the case that all contacts slide.
    pub fn reserve_for(&mut self, scaled: &ScaledProblem) {
        let ShiftPath { sliding, square, factor, change, direction, null_change, null_direction, impulses, .. } = self;
        let contacts = scaled.contacts;
        sliding.reserve(contacts);
        square.resize(contacts * contacts, 1.0);
        factor.factorize(contacts, square, DEPENDENT_PIVOT);
        [change, null_change].into_iter().for_each(|list| list.reserve(contacts));
        null_direction.reserve(direction.len());
        impulses.iter_mut().for_each(|list| list.reserve(scaled.drift.len()));
    }

    /// Follows the path from the optimum with the present shift to that of Coulomb's law. Adds the entering edges to `count`. False if the
    /// path does not lead there; the shift is then that of a restart.
    pub fn follow_path(&mut self, program: &mut EnergyQp, scaled: &ScaledProblem, count: &mut u32) -> bool {
        self.responses.invalidate_if_changed(program.exchanges);
        self.begin_path(program, ZERO_AMOUNT * program.scale(scaled));
        let (mut tau, mut crossed) = (1.0, Breakpoint::End);
        for _ in 0..MAX_PIECES {
            self.find_sliding(program, crossed != Breakpoint::End);
            if !self.find_direction(program, scaled, tau) {
                break;
            }
            let Some((along, breakpoint)) = self.go_to_breakpoint(program, tau, crossed) else { break };
            tau -= along;
            if tau > 1.0 {
                break;
            }
            let joins = match breakpoint {
                Breakpoint::End => {
                    self.finish(program);
                    return true;
                }
                Breakpoint::EdgeLeaves(r) => self.leave(program, r),
                Breakpoint::EdgeEnters(r) => Some(r),
                Breakpoint::ContactCloses(contact) => Some(self.close_contact(program, contact, tau)),
            };
            crossed = breakpoint;
            if let Some(r) = joins {
                *count += 1;
                if !self.enter(program, scaled, r) {
                    break;
                }
                crossed = Breakpoint::EdgeEnters(r);
            }
        }
        std::mem::swap(&mut self.value, &mut self.target);
        false
    }

    /// Computes the defect, slip − shift, of each contact at the beginning of the path. An open contact is shifted by its own slip, so its
    /// w is stored without shift. A greater shift before may have hidden that it penetrates.
    fn begin_path(&mut self, program: &mut EnergyQp, none: f64) {
        let (each, contacts) = (program.edges.each, self.value.len());
        self.basic_count.clear();
        self.basic_count.resize(contacts, 0);
        program.basic.iter().for_each(|r| self.basic_count[r / each] += 1);
        self.target.clear();
        self.defect.clear();
        for (contact, (shift, basic_count)) in self.value.iter().zip(&self.basic_count).enumerate() {
            let w = program.velocity_of(contact);
            let (target, _) = slip(w);
            self.target.push(target);
            if *basic_count > 0 {
                self.defect.push(if target.max(*shift) > none { target - shift } else { 0.0 });
            } else {
                self.defect.push(f64::min(target - shift, 0.0));
                w.iter_mut().for_each(|w| *w -= shift);
            }
        }
    }

    /// Lists the active contacts that are shifted or may slide. A contact with neither slip nor shift does not start to slide before the
    /// next breakpoint.
    fn find_sliding(&mut self, program: &EnergyQp, crossed: bool) {
        let ShiftPath { value, defect, basic_count, sliding, .. } = self;
        sliding.clear();
        sliding.extend(
            (0..value.len())
                .filter(|&i| basic_count[i] > 0)
                .map(|contact| SlidingContact::of(program, contact))
                .filter(|contact_slip| {
                    crossed && !contact_slip.sticks()
                        || value[contact_slip.contact] != 0.0
                        || defect[contact_slip.contact] != 0.0
                }),
        );
    }

    /// Direction of the path: (1 − dslip/dshift) change = defect, and the resulting change of \[y; w\]. False if it is not finite.
    fn find_direction(&mut self, program: &EnergyQp, scaled: &ScaledProblem, tau: f64) -> bool {
        let ShiftPath { defect, sliding, responses, square, factor, change, direction, .. } = self;
        direction.clear();
        direction.resize(program.state.len(), [0.0; WIDTH]);
        if sliding.is_empty() {
            return true;
        }
        square.clear();
        for (k, contact_slip) in sliding.iter().enumerate() {
            responses.compute(contact_slip.contact, &program.directions);
            let velocity = responses.velocity(contact_slip.contact);
            square.extend(sliding.iter().map(|contact_slip| -contact_slip.speed(velocity)));
            square[k * sliding.len() + k] += 1.0;
        }
        if !factor.factorize(
            sliding.len(),
            square,
            if self.min_norm { NEARLY_DEPENDENT_PIVOT } else { DEPENDENT_PIVOT },
        ) {
            return false;
        }
        change.clear();
        change.extend(sliding.iter().map(|contact_slip| defect[contact_slip.contact]));
        factor.solve(change);
        responses.add(parts(change, sliding), direction);
        for k in 0..self.sliding.len() {
            if self.factor.is_dependent(k) {
                self.minimise_norm(program, scaled, k, tau);
            }
        }
        true
    }

    /// If many shifts solve the problem, turns the direction so that the impulses at its end have the least norm, as compliant contacts
    /// would have.
    fn minimise_norm(&mut self, program: &EnergyQp, scaled: &ScaledProblem, k: usize, tau: f64) {
        let ShiftPath {
            sliding,
            responses,
            square,
            factor,
            change,
            direction,
            null_change,
            null_direction,
            impulses,
            ..
        } = self;
        null_change.clear();
        null_change.extend_from_slice(&square[k * sliding.len()..][..sliding.len()]);
        factor.solve(null_change);
        null_change.iter_mut().for_each(|change| *change = -*change);
        null_change[k] = 1.0;
        null_direction.clear();
        null_direction.resize(direction.len(), [0.0; WIDTH]);
        responses.add(parts(null_change, sliding), null_direction);
        for (impulse, amounts) in impulses.iter_mut().zip([&program.state, &*direction, &*null_direction]) {
            program.edges.impulse(scaled, &program.basic, amounts.as_flattened(), impulse);
        }
        let [now, along, null_impulse] = &*impulses;
        let (mut along_null, mut square) = (0.0, 0.0);
        for ((now, along), null_direction) in now.iter().zip(along).zip(null_impulse) {
            along_null += (now + tau * along) * null_direction;
            square += null_direction * null_direction;
        }
        let share = -along_null / (tau * square);
        if share.is_finite() {
            add(direction, share, null_direction);
            change.iter_mut().zip(null_change).for_each(|(change, null_change)| *change += share * *null_change);
        }
    }

    /// Goes to the next breakpoint, backwards if only the backward direction leads away from the last one.
    /// Returns the decrease of τ, and the breakpoint; `None` if there is no breakpoint.
    fn go_to_breakpoint(&mut self, program: &mut EnergyQp, tau: f64, crossed: Breakpoint) -> Option<(f64, Breakpoint)> {
        let ShiftPath { defect, basic_count, direction, ratio_test, .. } = self;
        let each = program.edges.each;
        ratio_test.set(program, direction, tau, basic_count, defect);
        let sign = ratio_test.direction_sign(crossed, basic_count, each);
        let (solver, edge) = ratio_test.first_breakpoint(direction, sign, if sign > 0.0 { tau } else { f64::INFINITY });
        let breakpoint = match edge {
            None => Breakpoint::End,
            Some(r) if program.is_basic(r) => Breakpoint::EdgeLeaves(r),
            Some(r) if basic_count[r / each] > 0 => Breakpoint::EdgeEnters(r),
            Some(r) => Breakpoint::ContactCloses(r / each),
        };
        let along = sign * solver;
        self.advance(program, along);
        along.is_finite().then_some((along, breakpoint))
    }

    /// Moves along the direction by a change of τ.
    fn advance(&mut self, program: &mut EnergyQp, along: f64) {
        add(&mut program.state, along, &self.direction);
        parts(&self.change, &self.sliding).for_each(|(change, contact)| self.value[contact] += along * change);
    }

    /// Makes edge r basic; false if it depends on the basic edges.
    fn enter(&mut self, program: &mut EnergyQp, scaled: &ScaledProblem, r: usize) -> bool {
        let joined = program.make_basic(scaled, r);
        if joined {
            self.basic_count[r / program.edges.each] += 1;
            self.responses.edge_entered(&program.directions);
        }
        joined
    }

    /// Makes edge r nonbasic. If the contact sticks with three edges, returns the edge opposite to r, which enters instead: friction along
    /// that tangent reverses.
    fn leave(&mut self, program: &mut EnergyQp, r: usize) -> Option<usize> {
        let contact = r / program.edges.each;
        program.leave(r);
        self.responses.edge_left(r, &program.directions);
        self.basic_count[contact] -= 1;
        if self.basic_count[contact] == 0 {
            let now = self.value[contact];
            program.velocity_of(contact).iter_mut().for_each(|w| *w -= now);
        }
        let turns =
            program.edges.each == 4 && !program.is_basic(r ^ 1) && program.is_basic(r ^ 2) && program.is_basic(r ^ 3);
        turns.then_some(r ^ 1)
    }

    /// Makes an open contact active and gives it a shift; returns its entering edge.
    fn close_contact(&mut self, program: &mut EnergyQp, contact: usize, tau: f64) -> usize {
        let w = program.velocity_of(contact);
        let (target, edge) = slip(w);
        let now = target - tau * self.defect[contact];
        w.iter_mut().for_each(|w| *w += now);
        self.value[contact] = now;
        contact * program.edges.each + edge
    }

    /// Sets the shifts at the end of the path.
    fn finish(&mut self, program: &mut EnergyQp) {
        for contact in 0..self.value.len() {
            if self.basic_count[contact] == 0 {
                self.value[contact] = slip(program.velocity_of(contact)).0;
            }
            self.value[contact] = self.value[contact].max(0.0);
        }
    }
}

/// The change of each sliding contact, with the contact.
fn parts(change: &[f64], sliding: &[SlidingContact]) -> impl Iterator<Item = (f64, usize)> + Clone {
    change.iter().copied().zip(sliding.iter().map(|contact_slip| contact_slip.contact))
}
