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

use super::super::super::pivoted::Pivoted;
use super::super::scaled::Scaled;
use super::EnergyQp;
use super::border::{Border, Outlook};
use super::edges::{Panel, WIDTH, add};
use super::responses::Responses;
use super::slides::{Slide, slip};

/// Pieces of a path at most: of one that is longer another beginning is shorter.
const PIECES: usize = 16;
/// What is left of a pivot if it belongs to a direction in which many shifts are right; the entries are about 1.
const NOTHING: f64 = 1e-14;
/// The same where one of these is as good as another.
const LITTLE: f64 = 1e-7;

/// What is added to each v_N, and the path to what it should be.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Shift {
    pub now: Vec<f64>,
    /// Whether of many shifts that are right the evenest is looked for.
    pub even: bool,
    /// What the slip asks for at the beginning of the path, and by how much that is more than there is.
    asked: Vec<f64>,
    off: Vec<f64>,
    /// Edges of each contact that push.
    pushing: Vec<usize>,
    slides: Vec<Slide>,
    responses: Responses,
    /// 1 − dslip/dshift, column by column.
    square: Vec<f64>,
    factor: Pivoted,
    /// How the shifts of the slides change while τ falls by 1, and with them \[y; w\].
    change: Vec<f64>,
    course: Vec<Panel>,
    outlook: Outlook,
    /// A change that is as right, and what changes with it; impulses of the state and of both.
    turn: Vec<f64>,
    turned: Vec<Panel>,
    impulses: [Vec<f64>; 3],
}

impl Shift {
    /// None, of another problem.
    pub fn begin(&mut self, scaled: &Scaled) {
        self.now.clear();
        self.now.resize(scaled.contacts, 0.0);
        self.responses.begin(scaled.contacts, scaled.facets());
    }

    /// Makes room for as many slides as there are contacts.
    pub fn rehearse(&mut self, scaled: &Scaled) {
        let Shift { slides, square, factor, change, course, turn, turned, impulses, .. } = self;
        let contacts = scaled.contacts;
        slides.reserve(contacts);
        square.resize(contacts * contacts, 1.0);
        factor.factorize(contacts, square, NOTHING);
        [change, turn].into_iter().for_each(|list| list.reserve(contacts));
        turned.reserve(course.len());
        impulses.iter_mut().for_each(|list| list.reserve(scaled.drift.len()));
    }

    /// From the optimum with the present shift to that of Coulomb's law. Adds the edges that join to `count`. False if the path does not
    /// lead there; then there is another shift to begin with.
    pub fn settle(&mut self, program: &mut EnergyQp, scaled: &Scaled, count: &mut u32) -> bool {
        self.responses.check(program.exchanges);
        self.set_out(program, NOTHING * program.scale(scaled));
        let (mut tau, mut crossed) = (1.0, Border::End);
        for _ in 0..PIECES {
            self.find_slides(program, crossed != Border::End);
            if !self.head(program, scaled, tau) {
                break;
            }
            let Some((along, border)) = self.go(program, tau, crossed) else { break };
            tau -= along;
            if tau > 1.0 {
                break;
            }
            let joins = match border {
                Border::End => {
                    self.arrive(program);
                    return true;
                }
                Border::Leaves(r) => self.let_out(program, r),
                Border::Joins(r) => Some(r),
                Border::Lands(contact) => Some(self.land(program, contact, tau)),
            };
            crossed = border;
            if let Some(r) = joins {
                *count += 1;
                if !self.let_in(program, scaled, r) {
                    break;
                }
                crossed = Border::Joins(r);
            }
        }
        std::mem::swap(&mut self.now, &mut self.asked);
        false
    }

    /// What pushes, and how far its slip is from the shift. What does not push is shifted by its slip whatever that is: its w stands
    /// without. If it was shifted by more, that may have hidden that it sinks.
    fn set_out(&mut self, program: &mut EnergyQp, none: f64) {
        let (each, contacts) = (program.edges.each, self.now.len());
        self.pushing.clear();
        self.pushing.resize(contacts, 0);
        program.basic.iter().for_each(|r| self.pushing[r / each] += 1);
        self.asked.clear();
        self.off.clear();
        for (contact, (shift, pushing)) in self.now.iter().zip(&self.pushing).enumerate() {
            let w = program.velocity_of(contact);
            let (asked, _) = slip(w);
            self.asked.push(asked);
            if *pushing > 0 {
                self.off.push(if asked.max(*shift) > none { asked - shift } else { 0.0 });
            } else {
                self.off.push(f64::min(asked - shift, 0.0));
                w.iter_mut().for_each(|w| *w -= shift);
            }
        }
    }

    /// Contacts that push and are shifted, or may slide. What neither slips nor is shifted does not begin to before something else
    /// changes.
    fn find_slides(&mut self, program: &EnergyQp, crossed: bool) {
        let Shift { now, off, pushing, slides, .. } = self;
        slides.clear();
        slides.extend(
            (0..now.len())
                .filter(|&i| pushing[i] > 0)
                .map(|contact| Slide::of(program, contact))
                .filter(|slide| crossed && !slide.sticks() || now[slide.contact] != 0.0 || off[slide.contact] != 0.0),
        );
    }

    /// Where the path goes: (1 − dslip/dshift) change = off, and what changes with that. False if that is no number.
    fn head(&mut self, program: &EnergyQp, scaled: &Scaled, tau: f64) -> bool {
        let Shift { off, slides, responses, square, factor, change, course, .. } = self;
        course.clear();
        course.resize(program.state.len(), [0.0; WIDTH]);
        if slides.is_empty() {
            return true;
        }
        square.clear();
        for (k, slide) in slides.iter().enumerate() {
            responses.find(slide.contact, &program.directions);
            let velocity = responses.velocity(slide.contact);
            square.extend(slides.iter().map(|slide| -slide.speed(velocity)));
            square[k * slides.len() + k] += 1.0;
        }
        if !factor.factorize(slides.len(), square, if self.even { LITTLE } else { NOTHING }) {
            return false;
        }
        change.clear();
        change.extend(slides.iter().map(|slide| off[slide.contact]));
        factor.solve(change);
        responses.add(parts(change, slides), course);
        for k in 0..self.slides.len() {
            if self.factor.is_dependent(k) {
                self.even_out(program, scaled, k, tau);
            }
        }
        true
    }

    /// Many shifts are right: where the path ends, the impulses are to have the least norm, as if contacts yielded.
    fn even_out(&mut self, program: &EnergyQp, scaled: &Scaled, k: usize, tau: f64) {
        let Shift { slides, responses, square, factor, change, course, turn, turned, impulses, .. } = self;
        turn.clear();
        turn.extend_from_slice(&square[k * slides.len()..][..slides.len()]);
        factor.solve(turn);
        turn.iter_mut().for_each(|change| *change = -*change);
        turn[k] = 1.0;
        turned.clear();
        turned.resize(course.len(), [0.0; WIDTH]);
        responses.add(parts(turn, slides), turned);
        for (impulse, amounts) in impulses.iter_mut().zip([&program.state, &*course, &*turned]) {
            program.edges.impulse(scaled, &program.basic, amounts.as_flattened(), impulse);
        }
        let [now, along, turned_by] = &*impulses;
        let (mut uneven, mut square) = (0.0, 0.0);
        for ((now, along), turned) in now.iter().zip(along).zip(turned_by) {
            uneven += (now + tau * along) * turned;
            square += turned * turned;
        }
        let share = -uneven / (tau * square);
        if share.is_finite() {
            add(course, share, turned);
            change.iter_mut().zip(turn).for_each(|(change, turn)| *change += share * *turn);
        }
    }

    /// Goes to the end of the piece, forwards or, where only that leads across the border behind, backwards: by how much τ falls, and
    /// what is there. None where no end is in sight.
    fn go(&mut self, program: &mut EnergyQp, tau: f64, crossed: Border) -> Option<(f64, Border)> {
        let Shift { off, pushing, course, outlook, .. } = self;
        let each = program.edges.each;
        outlook.look(program, course, tau, pushing, off);
        let ahead = outlook.ahead(crossed, pushing, each);
        let (way, edge) = outlook.nearest(course, ahead, if ahead > 0.0 { tau } else { f64::INFINITY });
        let border = match edge {
            None => Border::End,
            Some(r) if program.pushes(r) => Border::Leaves(r),
            Some(r) if pushing[r / each] > 0 => Border::Joins(r),
            Some(r) => Border::Lands(r / each),
        };
        let along = ahead * way;
        self.advance(program, along);
        along.is_finite().then_some((along, border))
    }

    /// Goes along the course by so much of τ.
    fn advance(&mut self, program: &mut EnergyQp, along: f64) {
        add(&mut program.state, along, &self.course);
        parts(&self.change, &self.slides).for_each(|(change, contact)| self.now[contact] += along * change);
    }

    /// Edge r begins to push; false if it depends on those that do.
    fn let_in(&mut self, program: &mut EnergyQp, scaled: &Scaled, r: usize) -> bool {
        let joined = program.join(scaled, r);
        if joined {
            self.pushing[r / program.edges.each] += 1;
            self.responses.join(&program.directions);
        }
        joined
    }

    /// Edge r ceases to push. The one that begins to instead, if the contact sticks with three: friction along the pair of r turns.
    fn let_out(&mut self, program: &mut EnergyQp, r: usize) -> Option<usize> {
        let contact = r / program.edges.each;
        program.let_out(r);
        self.responses.leave(r, &program.directions);
        self.pushing[contact] -= 1;
        if self.pushing[contact] == 0 {
            let now = self.now[contact];
            program.velocity_of(contact).iter_mut().for_each(|w| *w -= now);
        }
        let turns = program.edges.each == 4 && !program.pushes(r ^ 1) && program.pushes(r ^ 2) && program.pushes(r ^ 3);
        turns.then_some(r ^ 1)
    }

    /// The edge with which a contact begins to push, which is shifted from now on.
    fn land(&mut self, program: &mut EnergyQp, contact: usize, tau: f64) -> usize {
        let w = program.velocity_of(contact);
        let (asked, edge) = slip(w);
        let now = asked - tau * self.off[contact];
        w.iter_mut().for_each(|w| *w += now);
        self.now[contact] = now;
        contact * program.edges.each + edge
    }

    /// What the path has led to.
    fn arrive(&mut self, program: &mut EnergyQp) {
        for contact in 0..self.now.len() {
            if self.pushing[contact] == 0 {
                self.now[contact] = slip(program.velocity_of(contact)).0;
            }
            self.now[contact] = self.now[contact].max(0.0);
        }
    }
}

/// What of a change is that of which contact.
fn parts(change: &[f64], slides: &[Slide]) -> impl Iterator<Item = (f64, usize)> + Clone {
    change.iter().copied().zip(slides.iter().map(|slide| slide.contact))
}
