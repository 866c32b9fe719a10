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

mod certificate;
mod foot;
mod inverse_inertia;
mod sole;

use crate::contact::{COMPLIANCE, Report, STANDING_BOUND, STANDING_REDUCTION, WELL_SOLVED};
use crate::delassus::{Free, Response};
use crate::detect::Touch;
use crate::factor::Factor;
use crate::model::Model;
use certificate::{report, speed};
use foot::Foot;
use inverse_inertia::{BlockLdl, InverseInertia};
use nalgebra::Vector3;

/// More links are not welded: their contacts are solved one by one.
const MAX_FEET: usize = 4;
/// Solutions at most: from the second on they undo the yielding, wherever Λ allows.
const MAX_SOLUTIONS: usize = 5;
/// Contacts that hold a link in all its directions.
const MIN_ACTIVE: usize = 3;

/// Velocity (v at c, angular) or wrench (force, moment about c) in W.
type SpatialPair = [Vector3<f64>; 2];
/// The same in a row, filled up so that it is worked on four at a time.
type PaddedRow = [f64; 8];

/// Room for the welded links of a step.
#[derive(Clone, Debug)]
pub struct StandingFeet {
    feet: [Foot; MAX_FEET],
    airborne: [Foot; MAX_FEET],
    /// Λ.
    inverse_inertia: InverseInertia,
    factored: BlockLdl,
    /// The last solution.
    change: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
}

impl StandingFeet {
    /// Room for the feet of a model.
    pub fn new(model: &Model) -> StandingFeet {
        let feet = || std::array::from_fn(|_| Foot::new(model));
        StandingFeet {
            feet: feet(),
            airborne: feet(),
            inverse_inertia: InverseInertia::default(),
            factored: BlockLdl::default(),
            change: vec![0.0; model.dofs()],
            impulses: Vec::with_capacity(model.contact_points.len()),
        }
    }

    /// Impulses under which no foot moves, if all can be welded, by which contacts pushed in the step before, and Coulomb's law allows it.
    /// `friction` is μ, and the radius of the disc within the cone of the law, however that is turned [-].
    pub fn solve(
        &mut self,
        model: &Model,
        free: &Free,
        touches: &[Touch],
        [friction, disc]: [f64; 2],
        pushed: impl Fn(usize) -> bool,
    ) -> Option<(Response<'_>, Report)> {
        let StandingFeet { feet, airborne, inverse_inertia, factored, change, impulses } = self;
        let (feet, airborne) = select_feet(model, free, touches, pushed, feet, airborne)?;
        let speed = speed(feet, touches);
        let inverse_inertia = inverse_inertia.fill(model, feet);
        let factored = inverse_inertia.factorize(feet, if feet.len() > 1 { COMPLIANCE } else { 0.0 }, factored)?;
        solve_wrenches(inverse_inertia, factored, feet, friction, speed);
        impulses.clear();
        impulses.resize(touches.len(), Vector3::zeros());
        for foot in &mut *feet {
            foot.sole.distribute(&foot.wrench, disc, &mut impulses[foot.first..][..foot.sole.arms.len()])?;
        }
        let change = respond(model, free.factor, feet, change);
        let clear = airborne.iter().all(|foot| foot.stays_above_after(model, touches, change));
        let report = report(feet, touches, friction, speed);
        (clear && report.natural_map <= STANDING_BOUND).then_some((Response { change, impulses }, report))
    }
}

/// The feet that are welded, if all can be: where they are, their free motion and what is wanted of it, and Y. And those that hover.
fn select_feet<'a>(
    model: &Model,
    free: &Free,
    touches: &[Touch],
    pushed: impl Fn(usize) -> bool,
    feet: &'a mut [Foot],
    airborne: &'a mut [Foot],
) -> Option<(&'a mut [Foot], &'a [Foot])> {
    let (mut count, mut airborne_count, mut first) = (0, 0, 0);
    for own in touches.chunk_by(|a, b| a.link == b.link) {
        let foot = feet.get_mut(count)?;
        foot.set(model, free, first, own);
        first += own.len();
        if foot.stays_above(&foot.free, touches) {
            std::mem::swap(foot, airborne.get_mut(airborne_count)?);
            airborne_count += 1;
            continue;
        }
        if own.iter().filter(|touch| pushed(touch.id)).count() < own.len().min(MIN_ACTIVE) {
            return None;
        }
        count += 1;
    }
    for foot in &mut feet[..count] {
        foot.prepare(&touches[foot.first..])?;
        free.factor.half_solve(model, foot.link, &mut foot.rows);
    }
    Some((&mut feet[..count], &airborne[..airborne_count]))
}

/// w for t = t_wanted, and t.
fn solve_wrenches(inverse_inertia: &InverseInertia, factored: &BlockLdl, feet: &mut [Foot], friction: f64, speed: f64) {
    feet.iter_mut().for_each(|foot| (foot.motion, foot.wrench) = (foot.free, SpatialPair::default()));
    let mut before = f64::INFINITY;
    let mut kept = [(SpatialPair::default(), SpatialPair::default()); MAX_FEET];
    for pass in 0..MAX_SOLUTIONS {
        let mut change = [SpatialPair::default(); MAX_FEET];
        change.iter_mut().zip(&*feet).for_each(|(change, foot)| *change = foot.velocity_error());
        factored.solve(feet.len(), &mut change);
        for (foot, change) in feet.iter_mut().zip(&change) {
            foot.wrench.iter_mut().zip(change).for_each(|(wrench, change)| *wrench += change);
        }
        for i in 0..feet.len() {
            feet[i].motion = inverse_inertia.times(i, feet);
        }
        let left = feet.iter().map(Foot::error_bound).fold(0.0, f64::max);
        if left > STANDING_REDUCTION * before {
            // it pushes the feet against each other and changes nothing, nor did the solutions before, each by as much
            for (foot, (wrench, motion)) in feet.iter_mut().zip(kept) {
                for (now, kept) in foot.wrench.iter_mut().zip(wrench).chain(foot.motion.iter_mut().zip(motion)) {
                    *now = kept - (*now - kept) * pass as f64;
                }
            }
            break;
        }
        if (1.0 + friction) * left <= WELL_SOLVED * speed {
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
        let wrench = padded(&foot.wrench);
        for (row, &dof) in foot.rows.iter().zip(model.path(foot.link)) {
            change[dof] += row.iter().zip(&wrench).map(|(y, w)| y * w).sum::<f64>();
        }
    }
    factor.second_half_solve(model, change);
    change
}

fn padded([linear, angular]: &SpatialPair) -> PaddedRow {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z, 0.0, 0.0]
}

fn unpadded(six: &PaddedRow) -> SpatialPair {
    [Vector3::new(six[0], six[1], six[2]), Vector3::new(six[3], six[4], six[5])]
}

/// Velocity of a point at d from c.
fn point_velocity([linear, angular]: &SpatialPair, d: &Vector3<f64>) -> Vector3<f64> {
    linear + angular.cross(d)
}
