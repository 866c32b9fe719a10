//! Links that stand: where nothing that pushed moved in the step before, every link that comes down to the ground is welded to it for
//! the step. One that does not, a foot just lifted or about to land, hovers: it is only seen to that it goes on to. One that stood on
//! less than a face in the step before, and has more of it down, lands or turns: then none is welded.
//!
//! The contacts of a rigid link move with its six velocities: of their equations, three each, six are left, however many there are;
//! on an edge five, for it may turn about that, and on a point three.
//! With the velocities t of the links about a point c amid their contacts, and the wrenches w there,
//!
//! ```text
//!   t = Λ w + t_free = t_wanted,   Λ = YᵀY
//! ```
//!
//! where t_wanted closes what gaps there are and moves nothing else. Neither tangents nor a remembered basis are needed: the soles
//! say what w is at each contact, and whether all that obeys Coulomb's law; see `weld/sole.rs`.
//!
//! What Λ of two feet hardly sees (that they press against each other) yields by a hair, each contact by as much as in the full problem;
//! and what it does not see at all is taken back, so that feet do not press against each other for what no press can change.
//!
//! # Source
//! Λ = JH⁻¹Jᵀ: Khatib (1987), the operational-space inertia's inverse, here of every foot at once.

mod blocks;
mod certificate;
mod foot;
mod sole;

use crate::contact::{COMPLIANCE, Report, SOLVED};
use crate::delassus::{Free, Response};
use crate::detect::Touch;
use crate::factor::Factor;
use crate::model::Model;
use blocks::{Blocks, Factored};
use certificate::{report, speed};
use foot::Foot;
use nalgebra::Vector3;

/// More links are not welded: their contacts are solved one by one.
const FEET: usize = 4;
/// Solutions at most: from the second on they undo the yielding, wherever Λ allows.
const REFINEMENTS: usize = 5;
/// What a solution after the first must leave at most of the velocity before.
const SHRINKS: f64 = 0.5;
/// A bound on the residual up to this will do: the residual is less, and this below the 1e-10 that a step promises.
const HELD: f64 = 2.0 * SOLVED;
/// Contacts that hold a link in all its directions.
const FACE: usize = 3;
/// A residual this small is not refined further.
const ENOUGH: f64 = 0.5 * SOLVED;

/// Velocity (v at c, angular) or wrench (force, moment about c) in W.
type Pair = [Vector3<f64>; 2];
/// The same in a row, filled up so that it is worked on four at a time.
type Six = [f64; 8];

/// Room for the welded links of a step.
#[derive(Clone, Debug)]
pub struct Weld {
    feet: [Foot; FEET],
    hovering: [Foot; FEET],
    /// Λ.
    mobility: Blocks,
    factored: Factored,
    /// The last solution.
    change: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
}

impl Weld {
    /// Room for the feet of a model.
    pub fn new(model: &Model) -> Weld {
        let feet = || std::array::from_fn(|_| Foot::new(model));
        Weld {
            feet: feet(),
            hovering: feet(),
            mobility: Blocks::default(),
            factored: Factored::default(),
            change: vec![0.0; model.dofs()],
            impulses: Vec::with_capacity(model.corners.len()),
        }
    }

    /// Impulses under which no foot moves, if all can be welded, by which contacts pushed in the step before, and Coulomb's law allows it.
    /// `friction` is μ, and the radius of the disc within the cone of the law, however that is turned [-].
    pub fn hold(
        &mut self,
        model: &Model,
        free: &Free,
        touches: &[Touch],
        [friction, disc]: [f64; 2],
        pushed: impl Fn(usize) -> bool,
    ) -> Option<(Response<'_>, Report)> {
        let Weld { feet, hovering, mobility, factored, change, impulses } = self;
        let (feet, hovering) = stand(model, free, touches, pushed, feet, hovering)?;
        let speed = speed(feet, touches);
        let mobility = mobility.fill(model, feet);
        let factored = mobility.factorize(feet, if feet.len() > 1 { COMPLIANCE } else { 0.0 }, factored)?;
        resolve(mobility, factored, feet, friction, speed);
        impulses.clear();
        impulses.resize(touches.len(), Vector3::zeros());
        for foot in &mut *feet {
            foot.sole.spread(&foot.wrench, disc, &mut impulses[foot.first..][..foot.sole.arms.len()])?;
        }
        let change = respond(model, free.factor, feet, change);
        let hover = hovering.iter().all(|foot| foot.goes_on(model, touches, change));
        let report = report(feet, touches, friction, speed);
        (hover && report.natural_map <= HELD).then_some((Response { change, impulses }, report))
    }
}

/// The feet that are welded, if all can be: where they are, their free motion and what is wanted of it, and Y. And those that hover.
fn stand<'a>(
    model: &Model,
    free: &Free,
    touches: &[Touch],
    pushed: impl Fn(usize) -> bool,
    feet: &'a mut [Foot],
    hovering: &'a mut [Foot],
) -> Option<(&'a mut [Foot], &'a [Foot])> {
    let (mut count, mut hovers, mut first) = (0, 0, 0);
    for own in touches.chunk_by(|a, b| a.link == b.link) {
        let foot = feet.get_mut(count)?;
        foot.set(model, free, first, own);
        first += own.len();
        if foot.stays_above(&foot.free, touches) {
            std::mem::swap(foot, hovering.get_mut(hovers)?);
            hovers += 1;
            continue;
        }
        if own.iter().filter(|touch| pushed(touch.id)).count() < own.len().min(FACE) {
            return None;
        }
        count += 1;
    }
    for foot in &mut feet[..count] {
        foot.land(&touches[foot.first..])?;
        free.factor.half_solve(model, foot.link, &mut foot.rows);
    }
    Some((&mut feet[..count], &hovering[..hovers]))
}

/// w for t = t_wanted, and t.
fn resolve(mobility: &Blocks, factored: &Factored, feet: &mut [Foot], friction: f64, speed: f64) {
    feet.iter_mut().for_each(|foot| (foot.motion, foot.wrench) = (foot.free, Pair::default()));
    let mut before = f64::INFINITY;
    let mut kept = [(Pair::default(), Pair::default()); FEET];
    for pass in 0..REFINEMENTS {
        let mut change = [Pair::default(); FEET];
        change.iter_mut().zip(&*feet).for_each(|(change, foot)| *change = foot.lacks());
        factored.solve(feet.len(), &mut change);
        for (foot, change) in feet.iter_mut().zip(&change) {
            foot.wrench.iter_mut().zip(change).for_each(|(wrench, change)| *wrench += change);
        }
        for i in 0..feet.len() {
            feet[i].motion = mobility.times(i, feet);
        }
        let left = feet.iter().map(Foot::left).fold(0.0, f64::max);
        if left > SHRINKS * before {
            // it pushes the feet against each other and changes nothing, nor did the solutions before, each by as much
            for (foot, (wrench, motion)) in feet.iter_mut().zip(kept) {
                for (now, kept) in foot.wrench.iter_mut().zip(wrench).chain(foot.motion.iter_mut().zip(motion)) {
                    *now = kept - (*now - kept) * pass as f64;
                }
            }
            break;
        }
        if (1.0 + friction) * left <= ENOUGH * speed {
            break;
        }
        before = left;
        kept.iter_mut().zip(&*feet).for_each(|(kept, foot)| *kept = (foot.wrench, foot.motion));
    }
}

/// H⁻¹KΔf: the change of velocity that the impulses make.
fn respond<'a>(model: &Model, factor: &Factor, feet: &[Foot], change: &'a mut [f64]) -> &'a [f64] {
    change.fill(0.0);
    for foot in feet {
        let wrench = six(&foot.wrench);
        for (row, &dof) in foot.rows.iter().zip(model.path(foot.link)) {
            change[dof] += row.iter().zip(&wrench).map(|(y, w)| y * w).sum::<f64>();
        }
    }
    factor.second_half_solve(model, change);
    change
}

fn six([straight, round]: &Pair) -> Six {
    [straight.x, straight.y, straight.z, round.x, round.y, round.z, 0.0, 0.0]
}

fn pair(six: &Six) -> Pair {
    [Vector3::new(six[0], six[1], six[2]), Vector3::new(six[3], six[4], six[5])]
}

/// Velocity of a point at d from c.
fn velocity([straight, round]: &Pair, d: &Vector3<f64>) -> Vector3<f64> {
    straight + round.cross(d)
}
