//! The stages of a step at contact: what touches, the problem (14), its impulse (15)-(22), the velocity after it.

use super::settings::{Settings, World};
use crate::contact::{Memory, Report, Solver, tangents};
use crate::delassus::{ContactMap, Free, Response};
use crate::detect::{Touch, overlooked, touching};
use crate::error::PlantError;
use crate::kinematics::Pose;
use crate::model::Model;
use crate::truth::Record;
use crate::weld::Weld;
use messages::scene::Law;
use nalgebra::Vector3;

/// The points that may touch within a time.
pub(super) struct Touches {
    pub list: Vec<Touch>,
    /// The time [s].
    pub horizon: f64,
}

impl Touches {
    pub fn new(model: &Model) -> Touches {
        Touches { list: Vec::with_capacity(model.corners.len()), horizon: 0.0 }
    }

    /// The points that may touch within a step of `h` that ends, if nothing touches, with the velocity `free`.
    pub fn find(&mut self, world: &World, pose: &Pose, free: &[f64], h: f64) -> &mut Touches {
        touching(&world.model, pose, world.settings.law, h, free, &mut self.list);
        self.horizon = h;
        self
    }
}

/// What contact makes of the free motion.
pub(super) struct Contact<'a> {
    /// ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf); between events the acceleration. (12)
    pub rate: &'a [f64],
    /// H⁻¹KΔf.
    pub change: &'a [f64],
    pub touches: &'a [Touch],
    /// Δf on each of them, in W [N·s]; between events the force [N].
    pub impulses: &'a [Vector3<f64>],
    pub report: Report,
}

impl Record {
    /// Takes impulses, or forces that act for a time.
    pub(super) fn take(&mut self, contact: &Contact, time: f64) {
        if !contact.touches.is_empty() {
            self.note(&contact.report);
        }
        for (touch, impulse) in contact.touches.iter().zip(contact.impulses) {
            self.push(touch.id, (impulse * time).into());
        }
    }
}

/// The solvers of contact and their solution.
pub(super) struct Contacts {
    pub each: Each,
    weld: Weld,
    pub outcome: Outcome,
    /// Problems solved so far …
    pub solved: u64,
    /// … and those whose remembered basis was right.
    pub warm: u64,
}

impl Contacts {
    pub fn new(model: &Model, law: Law) -> Contacts {
        let zeros = || vec![0.0; model.dofs()];
        let impulses = Vec::with_capacity(model.corners.len());
        Contacts {
            each: Each::new(model, law),
            weld: Weld::new(model),
            outcome: Outcome { rate: zeros(), change: zeros(), impulses },
            solved: 0,
            warm: 0,
        }
    }

    /// Δf by the contact law, and the velocity after it: ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf). (12)
    ///
    /// Where nothing that pushed moved in the step before, feet that stand are tried first: see [`crate::weld`]. What the impulses drive
    /// into the ground though it was not listed joins, and the problem is solved again.
    ///
    /// # Errors
    /// If a problem was not solved as well as the scene asks, or the energy rises.
    pub fn solve<'a>(
        &'a mut self,
        world: &World,
        free: &Free,
        touches: &'a mut Touches,
        h: f64,
        memory: &mut Memory,
    ) -> Result<Contact<'a>, PlantError> {
        let Contacts { each, weld, outcome, .. } = self;
        let Touches { list, horizon } = touches;
        let mut report = Report::default();
        outcome.begin(free);
        while !list.is_empty() {
            let response;
            (response, report) = match stand(world, free, list, h, memory, weld) {
                Some(held) => {
                    each.leave(list.len());
                    held
                }
                None => {
                    each.pose(world, free, list, h); // (14)
                    each.solve(world, free, list, memory)? // (15)-(22)
                }
            };
            world.check_energy(&report)?;
            outcome.set(free, &response); // (12)
            self.solved += 1;
            self.warm += u64::from(report.warm);
            if !overlooked(&world.model, free.pose, world.settings.law, *horizon, &outcome.rate, list) {
                break;
            }
        }
        Ok(outcome.contact(list, report))
    }
}

/// The velocity or acceleration with contact, and what made it.
pub(super) struct Outcome {
    rate: Vec<f64>,
    change: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
}

impl Outcome {
    /// As if nothing touched.
    pub fn begin(&mut self, free: &Free) {
        self.rate.copy_from_slice(free.rate);
        self.change.fill(0.0);
        self.impulses.clear();
    }

    /// With these impulses.
    pub fn set(&mut self, free: &Free, response: &Response) {
        self.change.copy_from_slice(response.change);
        self.rate.iter_mut().zip(free.rate).zip(&self.change).for_each(|((rate, free), change)| *rate = free + change);
        self.impulses.clear();
        self.impulses.extend_from_slice(response.impulses);
    }

    pub fn contact<'a>(&'a self, touches: &'a [Touch], report: Report) -> Contact<'a> {
        let Outcome { rate, change, impulses } = self;
        Contact { rate, change, touches, impulses, report }
    }
}

/// Every contact by itself: its problem, and its solver.
pub(super) struct Each {
    pub map: ContactMap,
    pub solver: Solver,
}

impl Each {
    fn new(model: &Model, law: Law) -> Each {
        let mut solver = Solver::default();
        solver.rehearse(model.corners.len(), tangents(law).min(model.directions), law);
        Each { map: ContactMap::new(model), solver }
    }

    /// Of so many contacts there is no problem, for they are solved otherwise.
    fn leave(&mut self, contacts: usize) {
        self.map.problem.reset_rows(0, 0);
        (self.map.problem.contacts, self.map.problem.tangents) = (contacts, 2);
    }

    /// The problem (14) of the touching points, A apart.
    fn pose(&mut self, world: &World, free: &Free, touches: &[Touch], h: f64) {
        let Settings { law, friction, restitution, spring, .. } = world.settings;
        let problem = self.map.drift(&world.model, free, touches, law, |_, drift| drift);
        let before = |touch: &Touch| free.pose.links[touch.link].velocity.at(&touch.arm);
        problem.friction.fill(friction);
        for (approach, touch) in problem.approach.iter_mut().zip(touches) {
            *approach = touch.gap.max(0.0) / h;
        }
        if law == Law::SpringDamper {
            problem.spring = spring;
            problem.gap.iter_mut().zip(touches).for_each(|(gap, touch)| *gap = touch.gap);
            for (rows, touch) in problem.before.chunks_exact_mut(3).zip(touches) {
                let v = before(touch);
                rows.copy_from_slice(&[v.z, v.x, v.y]);
            }
        }
        if restitution > 0.0 {
            // Newton's law of impact: what would land and was falling at v_N leaves at -e v_N or more. What two steps of free fall made
            // as fast stays down, or the last of its bounces would never come
            let slow = if h.is_finite() { 2.0 * world.model.gravity.norm() * h } else { 0.0 };
            let normals = problem.drift.iter().step_by(1 + problem.tangents);
            for ((approach, free), touch) in problem.approach.iter_mut().zip(normals).zip(touches) {
                let before = before(touch).z;
                if before < -slow && free + *approach < 0.0 {
                    *approach = restitution * before;
                }
            }
        }
    }

    /// The solution of the problem (14), (15)-(22).
    pub fn solve(
        &mut self,
        world: &World,
        free: &Free,
        touches: &[Touch],
        memory: &mut Memory,
    ) -> Result<(Response<'_>, Report), PlantError> {
        let Each { map, solver } = self;
        let problem = map.assemble(&world.model, free, touches);
        let report = solver.solve(problem, world.settings.law, memory);
        world.check(&report, problem)?;
        Ok((map.respond(&world.model, free.factor, &solver.impulse), report))
    }
}

/// The solution in which every link that pushes stays where it is, if it did in the step before and that obeys the law.
fn stand<'a>(
    world: &World,
    free: &Free,
    touches: &[Touch],
    h: f64,
    memory: &mut Memory,
    weld: &'a mut Weld,
) -> Option<(Response<'a>, Report)> {
    let Settings { law, restitution, welds, friction, .. } = world.settings;
    let disc = disc(law)?;
    if !(welds && restitution == 0.0 && world.model.floats() && memory.rests()) {
        return None;
    }
    let (response, report) =
        weld.hold(&world.model, free, touches, [friction, disc * friction], h, |id| memory.pushed(id))?;
    memory.stand(touches.iter().zip(response.impulses).map(|(touch, impulse)| (touch.id, *impulse)));
    Some((response, report))
}

/// Radius of the disc within the cone of a law, however its tangents are turned, as a part of μ; none if feet that stand do not obey it.
fn disc(law: Law) -> Option<f64> {
    match law {
        Law::Cone => Some(1.0),
        Law::Aligned => Some(std::f64::consts::FRAC_1_SQRT_2),
        _ => None,
    }
}
