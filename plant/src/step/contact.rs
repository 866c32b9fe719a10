//! The stages of a step at contact: what touches, its impulse (14)-(22), the velocity after it.

use super::each::Each;
use super::settings::{Settings, World};
use crate::contact::{Memory, Report};
use crate::delassus::{Free, Response};
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

/// The ways to the impulses, and the outcome.
pub(super) struct Contacts {
    pub each: Each,
    weld: Weld,
    pub outcome: Outcome,
}

impl Contacts {
    pub fn new(model: &Model, law: Law) -> Contacts {
        Contacts { each: Each::new(model, law), weld: Weld::new(model), outcome: Outcome::new(model) }
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
        let (Contacts { each, weld, outcome }, Touches { list, horizon }) = (self, touches);
        outcome.begin(free);
        while !list.is_empty() {
            let (response, report) = match stand(world, free, list, h, memory, weld) {
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
            outcome.set(free, &response, report); // (12)
            if !overlooked(&world.model, free.pose, world.settings.law, *horizon, &outcome.rate, list) {
                break;
            }
        }
        Ok(outcome.contact(list))
    }
}

/// The last [`Contact`], and how many there were.
pub(super) struct Outcome {
    rate: Vec<f64>,
    change: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
    report: Report,
    /// Problems solved so far …
    pub solved: u64,
    /// … and those whose remembered basis was right.
    pub warm: u64,
}

impl Outcome {
    fn new(model: &Model) -> Outcome {
        let (rate, change) = (vec![0.0; model.dofs()], vec![0.0; model.dofs()]);
        let impulses = Vec::with_capacity(model.corners.len());
        Outcome { rate, change, impulses, report: Report::default(), solved: 0, warm: 0 }
    }

    /// As if nothing touched.
    pub fn begin(&mut self, free: &Free) {
        self.rate.copy_from_slice(free.rate);
        self.change.fill(0.0);
        self.impulses.clear();
        self.report = Report::default();
    }

    /// With these impulses.
    pub fn set(&mut self, free: &Free, response: &Response, report: Report) {
        for ((rate, free), change) in self.rate.iter_mut().zip(free.rate).zip(response.change) {
            *rate = free + change;
        }
        self.change.copy_from_slice(response.change);
        self.impulses.clear();
        self.impulses.extend_from_slice(response.impulses);
        self.report = report;
        self.solved += 1;
        self.warm += u64::from(report.warm);
    }

    /// What came of these contacts.
    pub fn contact<'a>(&'a self, touches: &'a [Touch]) -> Contact<'a> {
        let Outcome { rate, change, impulses, report, .. } = self;
        Contact { rate, change, touches, impulses, report: *report }
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
