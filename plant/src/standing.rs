//! Standing feet: if no active contact moved in the last step, every link on the ground is held fixed for the step.
//!
//! Not every contact is held. An airborne foot, just lifted or about to land, has no contact impulse. A foot that stood on an edge or a
//! point stands there again. The step only checks that the airborne foot, and the other points of the tilted one, stay above the ground.
//! If they do not, the foot lands or turns. Then no link is held, and the contacts are solved one by one.
//!
//! A link that stood is held even if it would rise without contact. Friction can press it to the ground: then Coulomb's law allows both motions,
//! and the one that continues the last step is taken. If it would have to pull or slip, it is airborne.
//!
//! The contacts of a rigid link move with its six velocities. So its equations, three per contact, reduce to six. On an edge, about which
//! the link may turn, they reduce to five; on a point, to three. With the velocities t of the links about a point c amid their contacts,
//! and the wrenches w there,
//!
//! ```text
//!   t = Λ⁻¹ w + t_free = t_wanted,   Λ⁻¹ = J H⁻¹ Jᵀ = YᵀY
//! ```
//!
//! where t_wanted closes the gaps and is zero otherwise. This needs neither tangents nor a remembered basis. The soles distribute w over
//! their contacts, and check whether the impulses obey Coulomb's law; see `standing/sole.rs`.
//!
//! Two feet can press against each other along directions that Λ⁻¹ hardly resolves. There, the contacts are compliant, as in the full
//! problem. The part of w along directions that Λ⁻¹ does not resolve at all is removed, so that feet do not press against each other
//! without effect.
//!
//! # Source
//! Λ = (J H⁻¹ Jᵀ)⁻¹, the operational-space inertia: Khatib (1987); here Λ⁻¹ of all feet together.

mod certificate;
mod foot;
mod inverse_inertia;
mod sole;
mod spatial_pair;

use crate::contact::{COMPLIANCE, Report, STANDING_BOUND, STANDING_REDUCTION, WELL_SOLVED};
use crate::delassus::{Free, Response};
use crate::detect::Touch;
use crate::factor::Factor;
use crate::model::Model;
use certificate::{report, speed};
use foot::Foot;
use inverse_inertia::{BlockLdl, InverseInertia};
use nalgebra::Vector3;
use spatial_pair::{MAX_FEET, SpatialPair, padded};

/// Solutions of the linear system at most. From the second on, they undo the compliance.
const MAX_SOLUTIONS: usize = 5;
/// Active contacts that hold a link in all its directions.
const MIN_ACTIVE: usize = 3;

/// The standing feet of a step; workspace.
#[derive(Clone, Debug)]
pub struct StandingFeet {
    feet: [Foot; MAX_FEET],
    airborne: [Foot; MAX_FEET],
    /// Λ⁻¹, the inverse operational-space inertia.
    inverse_inertia: InverseInertia,
    factored: BlockLdl,
    /// Velocity change of the last solution.
    change: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
}

impl StandingFeet {
    /// Allocates for the feet of a model.
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

    /// Impulses under which no foot moves, if all feet can be held and if Coulomb's law allows it. `was_active`: whether a contact had
    /// an impulse in the last step. `friction` is μ; `disc` is the radius of the greatest disc within the law's cone [-].
    pub fn solve(
        &mut self,
        model: &Model,
        free: &Free,
        touches: &[Touch],
        [friction, disc]: [f64; 2],
        was_active: impl Fn(usize) -> bool,
    ) -> Option<(Response<'_>, Report)> {
        let StandingFeet { feet, airborne, inverse_inertia, factored, change, impulses } = self;
        let mut rises = false; // whether a link that stood would rise without contact
        let report = [true, false].into_iter().find_map(|holds_rising| {
            if !holds_rising && !rises {
                return None; // the same feet again
            }
            let is_airborne = |foot: &Foot, own: &[Touch]| {
                let is_free = foot.stays_above(&foot.free, touches);
                let stood = is_free && own.iter().any(|touch| was_active(touch.id));
                rises |= stood;
                is_free && !(stood && holds_rising)
            };
            let (feet, airborne) = select_feet(model, free, touches, &was_active, is_airborne, [feet, airborne])?;
            let speed = speed(feet, touches);
            let inverse_inertia = inverse_inertia.fill(model, feet);
            let factored = inverse_inertia.factorize(feet, if feet.len() > 1 { COMPLIANCE } else { 0.0 }, factored)?;
            solve_wrenches(inverse_inertia, factored, feet, friction, speed);
            impulses.clear();
            impulses.resize(touches.len(), Vector3::zeros());
            for foot in &mut *feet {
                foot.sole.distribute(&foot.wrench, disc, &mut impulses[foot.first..][..foot.sole.arms.len()])?;
            }
            respond(model, free.factor, feet, change);
            let clear = airborne.iter().all(|foot| foot.stays_above_after(model, touches, change))
                && feet.iter().all(|foot| foot.others_stay_above_after(model, free, touches, change));
            let report = report(feet, touches, friction, speed);
            (clear && report.natural_map <= STANDING_BOUND).then_some(report)
        })?;
        Some((Response { change, impulses }, report))
    }
}

/// Sorts the links into held feet and airborne feet, and prepares the held feet: position, free motion, wanted motion, and Y. `None` if
/// some foot can be neither.
fn select_feet<'a>(
    model: &Model,
    free: &Free,
    touches: &[Touch],
    was_active: impl Fn(usize) -> bool,
    mut is_airborne: impl FnMut(&Foot, &[Touch]) -> bool,
    [feet, airborne]: [&'a mut [Foot]; 2],
) -> Option<(&'a mut [Foot], &'a [Foot])> {
    let (mut count, mut airborne_count, mut first) = (0, 0, 0);
    for own in touches.chunk_by(|a, b| a.link == b.link) {
        let foot = feet.get_mut(count)?;
        foot.set(model, free, first, own, own.len());
        first += own.len();
        if is_airborne(foot, own) {
            std::mem::swap(foot, airborne.get_mut(airborne_count)?);
            airborne_count += 1;
            continue;
        }
        let active = own.iter().take_while(|touch| was_active(touch.id)).count();
        let elsewhere = own[active..].iter().filter(|touch| was_active(touch.id)).count();
        if active + elsewhere < own.len().min(MIN_ACTIVE) {
            if active == 0 || elsewhere > 0 {
                return None;
            }
            foot.set(model, free, foot.first, own, active);
        }
        count += 1;
    }
    for foot in &mut feet[..count] {
        foot.prepare(&touches[foot.first..])?;
        free.factor.half_solve(model, foot.link, &mut foot.rows);
    }
    Some((&mut feet[..count], &airborne[..airborne_count]))
}

/// Solves t = t_wanted for w, and computes t.
fn solve_wrenches(inverse_inertia: &InverseInertia, factored: &BlockLdl, feet: &mut [Foot], friction: f64, speed: f64) {
    feet.iter_mut().for_each(|foot| (foot.motion, foot.wrench) = (foot.free, SpatialPair::default()));
    let mut before = f64::INFINITY;
    let mut saved = [(SpatialPair::default(), SpatialPair::default()); MAX_FEET];
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
        let error = feet.iter().map(Foot::error_bound).fold(0.0, f64::max);
        if error > STANDING_REDUCTION * before {
            // no progress: the solutions only add opposing forces of the feet, by the same amount each time, so these are removed
            for (foot, (wrench, motion)) in feet.iter_mut().zip(saved) {
                for (now, saved) in foot.wrench.iter_mut().zip(wrench).chain(foot.motion.iter_mut().zip(motion)) {
                    *now = saved - (*now - saved) * pass as f64;
                }
            }
            break;
        }
        if (1.0 + friction) * error <= WELL_SOLVED * speed {
            break;
        }
        before = error;
        saved.iter_mut().zip(&*feet).for_each(|(saved, foot)| *saved = (foot.wrench, foot.motion));
    }
}

/// H⁻¹KΔf: the change of velocity that the impulses make.
fn respond(model: &Model, factor: &Factor, feet: &[Foot], change: &mut [f64]) {
    change.fill(0.0);
    for foot in feet {
        let wrench = padded(&foot.wrench);
        for (row, &dof) in foot.rows.iter().zip(model.path(foot.link)) {
            change[dof] += row.iter().zip(&wrench).map(|(y, w)| y * w).sum::<f64>();
        }
    }
    factor.second_half_solve(model, change);
}
