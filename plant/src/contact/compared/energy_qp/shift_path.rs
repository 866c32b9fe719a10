//! Coulomb's law at the optimum of the energy program: its normal rows are shifted by mu |v_F| of what slides.
//!
//! The optimum has v_N >= mu |v_F|. Where nothing slides that is Coulomb's law, and with a shift that is what its slip asks for it is
//! Coulomb's law everywhere (De Saxcé; Acary & Cadoux). While the same edges push, the slip is an affine function of the shift. So
//! Newton's method has the answer at once, unless on the way an edge ceases to push or begins to. There it goes on with what pushes
//! then, and so on: along a path from piece to piece on which slip − shift = τ times what it was at the beginning, to τ = 0.
//!
//! A piece where the path can only go backwards is gone through backwards. Where it leads back to the beginning it is given up, and
//! the program begins again from what the slip asked for there. Under one foot many pressures may be right, and then the path leads to
//! the evenest of them; every other time to one that is near.
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

/// Pieces of a path at most: of one that is longer another beginning is shorter.
const MAX_PIECES: usize = 16;

/// What is added to each v_N, and the path to what it should be.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct ShiftPath {
    pub value: Vec<f64>,
    /// Whether of many shifts that are right the evenest is looked for.
    pub min_norm: bool,
    /// What the slip asks for at the beginning of the path, and by how much that is more than there is.
    target: Vec<f64>,
    defect: Vec<f64>,
    /// Edges of each contact that push.
    pushing: Vec<usize>,
    sliding: Vec<SlidingContact>,
    responses: ShiftResponses,
    /// 1 − dslip/dshift, column by column.
    square: Vec<f64>,
    factor: Lu,
    /// How the shifts of the slides change while τ falls by 1, and with them \[y; w\].
    change: Vec<f64>,
    direction: Vec<Panel>,
    ratio_test: RatioTest,
    /// A change that is as right, and what changes with it; impulses of the state and of both.
    null_change: Vec<f64>,
    null_direction: Vec<Panel>,
    impulses: [Vec<f64>; 3],
}

impl ShiftPath {
    /// None, of another problem.
    pub fn reset(&mut self, scaled: &ScaledProblem) {
        self.value.clear();
        self.value.resize(scaled.contacts, 0.0);
        self.responses.reset(scaled.contacts, scaled.facets());
    }

    /// Makes room for as many slides as there are contacts.
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

    /// From the optimum with the present shift to that of Coulomb's law. Adds the edges that join to `count`. False if the path does not
    /// lead there; then there is another shift to begin with.
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

    /// What pushes, and how far its slip is from the shift. What does not push is shifted by its slip whatever that is: its w stands
    /// without. If it was shifted by more, that may have hidden that it sinks.
    fn begin_path(&mut self, program: &mut EnergyQp, none: f64) {
        let (each, contacts) = (program.edges.each, self.value.len());
        self.pushing.clear();
        self.pushing.resize(contacts, 0);
        program.basic.iter().for_each(|r| self.pushing[r / each] += 1);
        self.target.clear();
        self.defect.clear();
        for (contact, (shift, pushing)) in self.value.iter().zip(&self.pushing).enumerate() {
            let w = program.velocity_of(contact);
            let (target, _) = slip(w);
            self.target.push(target);
            if *pushing > 0 {
                self.defect.push(if target.max(*shift) > none { target - shift } else { 0.0 });
            } else {
                self.defect.push(f64::min(target - shift, 0.0));
                w.iter_mut().for_each(|w| *w -= shift);
            }
        }
    }

    /// Contacts that push and are shifted, or may slide. What neither slips nor is shifted does not begin to before something else
    /// changes.
    fn find_sliding(&mut self, program: &EnergyQp, crossed: bool) {
        let ShiftPath { value, defect, pushing, sliding, .. } = self;
        sliding.clear();
        sliding.extend(
            (0..value.len()).filter(|&i| pushing[i] > 0).map(|contact| SlidingContact::of(program, contact)).filter(
                |contact_slip| {
                    crossed && !contact_slip.sticks()
                        || value[contact_slip.contact] != 0.0
                        || defect[contact_slip.contact] != 0.0
                },
            ),
        );
    }

    /// Where the path goes: (1 − dslip/dshift) change = off, and what changes with that. False if that is no number.
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

    /// Many shifts are right: where the path ends, the impulses are to have the least norm, as if contacts yielded.
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

    /// Goes to the end of the piece, forwards or, where only that leads across the border behind, backwards: by how much τ falls, and
    /// what is there. None where no end is in sight.
    fn go_to_breakpoint(&mut self, program: &mut EnergyQp, tau: f64, crossed: Breakpoint) -> Option<(f64, Breakpoint)> {
        let ShiftPath { defect, pushing, direction, ratio_test, .. } = self;
        let each = program.edges.each;
        ratio_test.set(program, direction, tau, pushing, defect);
        let sign = ratio_test.direction_sign(crossed, pushing, each);
        let (solver, edge) = ratio_test.first_breakpoint(direction, sign, if sign > 0.0 { tau } else { f64::INFINITY });
        let breakpoint = match edge {
            None => Breakpoint::End,
            Some(r) if program.is_basic(r) => Breakpoint::EdgeLeaves(r),
            Some(r) if pushing[r / each] > 0 => Breakpoint::EdgeEnters(r),
            Some(r) => Breakpoint::ContactCloses(r / each),
        };
        let along = sign * solver;
        self.advance(program, along);
        along.is_finite().then_some((along, breakpoint))
    }

    /// Goes along the course by so much of τ.
    fn advance(&mut self, program: &mut EnergyQp, along: f64) {
        add(&mut program.state, along, &self.direction);
        parts(&self.change, &self.sliding).for_each(|(change, contact)| self.value[contact] += along * change);
    }

    /// Edge r begins to push; false if it depends on those that do.
    fn enter(&mut self, program: &mut EnergyQp, scaled: &ScaledProblem, r: usize) -> bool {
        let joined = program.make_basic(scaled, r);
        if joined {
            self.pushing[r / program.edges.each] += 1;
            self.responses.edge_entered(&program.directions);
        }
        joined
    }

    /// Edge r ceases to push. The one that begins to instead, if the contact sticks with three: friction along the pair of r turns.
    fn leave(&mut self, program: &mut EnergyQp, r: usize) -> Option<usize> {
        let contact = r / program.edges.each;
        program.leave(r);
        self.responses.edge_left(r, &program.directions);
        self.pushing[contact] -= 1;
        if self.pushing[contact] == 0 {
            let now = self.value[contact];
            program.velocity_of(contact).iter_mut().for_each(|w| *w -= now);
        }
        let turns =
            program.edges.each == 4 && !program.is_basic(r ^ 1) && program.is_basic(r ^ 2) && program.is_basic(r ^ 3);
        turns.then_some(r ^ 1)
    }

    /// The edge with which a contact begins to push, which is shifted from now on.
    fn close_contact(&mut self, program: &mut EnergyQp, contact: usize, tau: f64) -> usize {
        let w = program.velocity_of(contact);
        let (target, edge) = slip(w);
        let now = target - tau * self.defect[contact];
        w.iter_mut().for_each(|w| *w += now);
        self.value[contact] = now;
        contact * program.edges.each + edge
    }

    /// What the path has led to.
    fn finish(&mut self, program: &mut EnergyQp) {
        for contact in 0..self.value.len() {
            if self.pushing[contact] == 0 {
                self.value[contact] = slip(program.velocity_of(contact)).0;
            }
            self.value[contact] = self.value[contact].max(0.0);
        }
    }
}

/// What of a change is that of which contact.
fn parts(change: &[f64], sliding: &[SlidingContact]) -> impl Iterator<Item = (f64, usize)> + Clone {
    change.iter().copied().zip(sliding.iter().map(|contact_slip| contact_slip.contact))
}
