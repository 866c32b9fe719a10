//! Contact stages of a step: touching points, contact impulse (14)-(22), and the velocity after it.

use super::per_contact::PerContact;
use super::prediction::Prediction;
use super::settings::{Settings, World};
use super::touches::Touches;
use crate::contact::{Memory, Report, disc};
use crate::delassus::{Free, Response};
use crate::detect::Touch;
use crate::error::PlantError;
use crate::model::Model;
use crate::standing::StandingFeet;
use crate::truth::Record;
use messages::scene::{Law, Method};
use nalgebra::Vector3;

/// Result of the contact stages.
pub(super) struct Contact {
    /// ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf); between events the acceleration. (12)
    pub rate: Vec<f64>,
    /// H⁻¹KΔf.
    pub change: Vec<f64>,
    /// Contact points with their impulses Δf, in W [N·s]; between events, with their forces [N].
    pub impulses: Vec<(usize, Vector3<f64>)>,
    pub report: Report,
}

impl Contact {
    fn new(model: &Model) -> Contact {
        let (rate, change) = (vec![0.0; model.dofs()], vec![0.0; model.dofs()]);
        Contact { rate, change, impulses: Vec::with_capacity(model.contact_points.len()), report: Report::default() }
    }

    /// Resets to the motion without contact.
    pub fn clear(&mut self, free: &Free) {
        self.rate.copy_from_slice(free.rate);
        self.change.fill(0.0);
        self.impulses.clear();
    }

    /// Sets the motion with contact impulses.
    pub fn set(&mut self, free: &Free, touches: &[Touch], response: &Response, report: Report) {
        for ((rate, free), change) in self.rate.iter_mut().zip(free.rate).zip(response.change) {
            *rate = free + change;
        }
        self.change.copy_from_slice(response.change);
        self.impulses.clear();
        self.impulses.extend(touches.iter().zip(response.impulses).map(|(touch, impulse)| (touch.id, *impulse)));
        self.report = report;
    }
}

impl Record {
    /// Records impulses, or forces that act for a time.
    pub(super) fn take(&mut self, contact: &Contact, time: f64) {
        if !contact.impulses.is_empty() {
            self.note(&contact.report);
        }
        for (id, impulse) in &contact.impulses {
            self.push(*id, (impulse * time).into());
        }
    }
}

/// The solvers of the contact stages: all feet standing, or contact by contact.
pub(super) struct Contacts {
    pub per_contact: PerContact,
    standing_feet: StandingFeet,
    pub contact: Contact,
    /// Problems solved so far.
    pub solved: u64,
    /// Those of which the memory was nearly the solution, as in [`Report::warm`].
    pub warm: u64,
}

impl Contacts {
    pub fn new(model: &Model, law: Law, method: Method) -> Contacts {
        Contacts {
            per_contact: PerContact::new(model, law, method),
            standing_feet: StandingFeet::new(model),
            contact: Contact::new(model),
            solved: 0,
            warm: 0,
        }
    }

    /// Δf by the contact law, and the velocity after it: ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf). (12)
    ///
    /// If no active contact moved in the step before, it first tries the case that all feet stand: see [`crate::standing`]. If the impulses
    /// drive further points into the ground, these are added, and the problem is solved again. Where friction holds a point inside the ground,
    /// Coulomb's law has no solution in which it leaves, so it stays.
    ///
    /// # Errors
    /// If a problem misses the scene's tolerance, or if contact raises the energy.
    pub fn solve(
        &mut self,
        world: &World,
        free: &Free,
        touches: &mut Touches,
        prediction: Option<&Prediction>,
        memory: &mut Memory,
    ) -> Result<&Contact, PlantError> {
        let Contacts { per_contact, standing_feet, contact, solved, warm, .. } = self;
        contact.clear(free);
        memory.set_jams(memory.jams() && touches.leave_inside()); // what jams does not recover as long as nothing moves
        while !touches.list.is_empty() {
            let (response, mut report) = match stand(world, free, &touches.list, memory, standing_feet) {
                Some(held) => {
                    per_contact.skip(touches.list.len());
                    held
                }
                None => {
                    if is_impact(&touches.list) && world.settings.law == Law::Cone {
                        memory.expect_impact(touches.list.iter().filter(|touch| touch.lands()).map(|touch| touch.id));
                    }
                    let report = per_contact.solve_possible(world, free, touches, memory)?; // (14)-(22)
                    (per_contact.respond(world, free), report)
                }
            };
            report.energy_gain -= recovery_work(&touches.list, response.impulses);
            world.check_energy(&report)?;
            contact.set(free, &touches.list, &response, report); // (12)
            (*solved, *warm) = (*solved + 1, *warm + u64::from(report.warm));
            if !touches.add_penetrating(world, free.pose, &contact.rate, prediction, memory) {
                break;
            }
        }
        Ok(contact)
    }
}

/// The solution in which all feet stand, if they stood in the step before and if it obeys the law.
fn stand<'a>(
    world: &World,
    free: &Free,
    touches: &[Touch],
    memory: &mut Memory,
    feet: &'a mut StandingFeet,
) -> Option<(Response<'a>, Report)> {
    let Settings { law, restitution, standing_feet, friction, .. } = world.settings;
    let disc = friction * disc(law)?;
    let may_stand = standing_feet && restitution == 0.0 && world.model.has_floating_base() && memory.is_static();
    if !(may_stand && world.are_level(touches)) {
        return None;
    }
    let (response, report) = feet.solve(&world.model, free, touches, [friction, disc], |id| memory.was_active(id))?;
    memory.record_standing(touches.iter().zip(response.impulses).map(|(touch, impulse)| (touch.id, *impulse)));
    Some((response, report))
}

/// Whether points land now.
fn is_impact(touches: &[Touch]) -> bool {
    touches.iter().any(|touch| touch.lands_after == 0.0)
}

/// Work of the impulses that move points out of the ground [J]. Their penetration is a numerical error, so this work does not count against
/// the law.
fn recovery_work(touches: &[Touch], impulses: &[Vector3<f64>]) -> f64 {
    touches.iter().zip(impulses).map(|(touch, impulse)| impulse.z * (-touch.approach).max(0.0)).sum()
}
