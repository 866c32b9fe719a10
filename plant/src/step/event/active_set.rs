//! Active contacts between events. They are determined at the beginning of a step, after the impact of landing points, and their forces are
//! computed in every stage.

use crate::composite::Composite;
use crate::contact::{Memory, Problem, Report};
use crate::delassus::Free;
use crate::detect::{Touch, max_recovery_speed};
use crate::error::PlantError;
use crate::kinematics::Pose;
use crate::model::{ContactPoint, Model};
use crate::step::Plant;
use crate::step::contact::{Contact, Contacts};
use crate::step::event_contact::EventContact;
use crate::step::landed::Landed;
use crate::step::per_contact::JAM;
use crate::step::posed_state::PosedState;
use crate::step::scales::{greatest_size, natural_rate, typical_length};
use crate::step::settings::World;
use crate::step::step_state::StepState;
use crate::step::touches::Touches;
use messages::scene::{Law, Method};
use nalgebra::Vector3;

/// A contact is active up to this gap [`typical_length`]. An impact is located to 1e-15 m, so a landed point is far below it.
const ACTIVE_GAP: f64 = 1e-8;
/// Greatest rate at which gap and velocity of active contacts decay to zero [`natural_rate`]: 20/s for 12.5 to 25 cm. It is slow: the stages
/// of a step are off the ground by h², and a fast decay there would reduce the method's order.
const BAUMGARTE_RATE: f64 = 2.26;
/// Greatest decay in a step of dt [-]. A long step, or a scene in slow motion, has a slower decay in proportion; beyond 2.78 the decay would
/// be unstable in RK4.
const BAUMGARTE_DECAY: f64 = 0.25;
/// A faster approach to the ground is an impact [`typical_length` × `natural_rate`].
const IMPACT_SPEED: f64 = 1e-7;
/// A contact with a slower slip sticks [`typical_length` × `natural_rate`].
const STICKING_SPEED: f64 = 1e-7;
/// A sticking contact with a lower tangential acceleration continues to stick [`typical_length` × `natural_rate`²: g].
const STICKING_ACCELERATION: f64 = 1e-8;
/// A slip below this part of the slip at the beginning of the step keeps the direction that it had there [-].
const MIN_SLIP: f64 = 1e-6;
/// A greater force is that of contacts about to jam [mass of the robot × greatest acceleration of a contact point without contact].
const GREATEST_FORCE: f64 = 1e3;

impl Plant {
    /// Determines active and sticking contacts, after the impact of landing points.
    pub(super) fn update_active_set(&mut self) -> Result<(), PlantError> {
        self.find_ground();
        let Plant { world, state: StepState { now: PosedState { pose, .. }, event_contacts, .. }, .. } = self;
        let length = typical_length(world);
        let speed = length * natural_rate(world);
        let mut impacts = false;
        for (id, (point, contact)) in world.model.contact_points.iter().zip(event_contacts).enumerate() {
            let arm = pose.lowest(point);
            let at = pose.reference + arm;
            contact.tile = world.model.ground_at(&at);
            contact.gap = if point.may_touch(at.x) { world.input.ground.gap_at(pose, &arm, id) } else { f64::INFINITY };
            let was_active = contact.carries_load();
            contact.active = contact.gap <= ACTIVE_GAP * length || was_active;
            impacts |= contact.active && pose.links[point.link].velocity.at(&arm).z < -IMPACT_SPEED * speed;
        }
        if impacts {
            self.land_coincident_points();
            let Plant { world, state: StepState { now, event_contacts, memory, .. }, work, .. } = self;
            work.touches.find_active(world, &now.pose, event_contacts).mark_landing(memory);
            self.impact([0.0; 2])?;
        }
        let Plant { world, state: StepState { now: PosedState { pose, .. }, event_contacts, .. }, .. } = self;
        for (point, contact) in world.model.contact_points.iter().zip(event_contacts) {
            // an impact can open a contact that still has no gap; a drift alone cannot
            contact.rate = pose.links[point.link].velocity.at(&pose.lowest(point)).z;
            let rises = contact.rate > IMPACT_SPEED * speed;
            if contact.active && rises && (impacts || !contact.pressed) {
                (contact.active, contact.pressed, contact.gap) = (false, false, contact.gap.max(ACTIVE_GAP * length));
            }
            let slip = slip(pose, point);
            contact.speed = slip.norm();
            let held = contact.sticking && contact.held && !impacts; // an impact may start a slip, whatever the force before it was
            contact.sticking = contact.active && (contact.speed <= STICKING_SPEED * speed || held);
            contact.slip_direction = if contact.speed > 0.0 { slip / contact.speed } else { slip };
        }
        Ok(())
    }

    /// Activates the points that land with others; see [`Landed`]. With error control the time between two landings tells them apart.
    fn land_coincident_points(&mut self) {
        let Plant { world, state: StepState { now: PosedState { pose, .. }, event_contacts, .. }, .. } = self;
        let controlled = world.settings.method == Method::EventDriven;
        let resting = (0..event_contacts.len()).filter(|&id| event_contacts[id].carries_load());
        let landed =
            Landed::new(world, 0.0, if controlled { 0.0 } else { world.settings.h }).beside(world, pose, resting);
        for (point, contact) in world.model.contact_points.iter().zip(event_contacts) {
            let velocity = pose.links[point.link].velocity.at(&pose.lowest(point)).z;
            contact.active |= landed.includes(contact.gap, velocity);
        }
    }
}

impl Touches {
    /// Lists the active contacts.
    pub(in crate::step) fn find_active(
        &mut self,
        world: &World,
        pose: &Pose,
        event_contacts: &[EventContact],
    ) -> &mut Touches {
        let points = world.model.contact_points.iter().zip(event_contacts).enumerate();
        (self.horizon, self.min_bounce_speed) = (0.0, 0.0);
        self.list.clear();
        self.list.extend(points.filter(|(_, (_, contact))| contact.active).map(|(id, (point, _))| {
            let arm = pose.lowest(point);
            Touch::new(id, point.link, arm, world.input.ground.gap_at(pose, &arm, id))
        }));
        self
    }
}

impl Contacts {
    /// Forces of all active contacts, and the acceleration with them; `free` is the acceleration without. Stores what each force does in
    /// `event_contacts`.
    ///
    /// All Coulomb laws use the round cone here, because the direction of slip is known. They differ in impacts only. `None` if no forces
    /// exist, because the contacts jam.
    pub(in crate::step) fn forces(
        &mut self,
        world: &World,
        free: &Free,
        composite: &Composite,
        touches: &Touches,
        event_contacts: &mut [EventContact],
        memory: &mut Memory,
    ) -> Result<Option<&Contact>, PlantError> {
        let (touches, Contacts { per_contact, contact, solved, warm, .. }) = (&touches.list, self);
        contact.clear(free);
        if touches.is_empty() {
            return Ok(Some(contact));
        }
        let (model, natural) = (&world.model, natural_rate(world));
        let velocity = |touch: &Touch| free.pose.links[touch.link].velocity.at(&touch.arm);
        // a slip near its end has no direction; beyond it, friction keeps its direction, so that the slip speed crosses zero
        let along = |touch: &Touch| {
            let (contact, velocity) = (&event_contacts[touch.id], velocity(touch));
            let slip = Vector3::new(velocity.x, velocity.y, 0.0);
            let clear = slip.dot(&contact.slip_direction) > MIN_SLIP * contact.speed;
            if clear { slip.normalize() } else { contact.slip_direction }
        };
        let rate = (BAUMGARTE_RATE * natural).min(BAUMGARTE_DECAY / world.settings.h);
        let deepest = recovered_depth(world, rate);
        let drift = |i: usize, own: Vector3<f64>| {
            let touch = &touches[i];
            let velocity = velocity(touch);
            let bias_acceleration = composite.bias_acceleration(model, free.pose, &model.contact_points[touch.id]);
            let mut drift = own + bias_acceleration + velocity * rate;
            drift.z += (velocity.z + touch.gap.max(-deepest) * rate) * rate;
            drift
        };
        let problem = per_contact.map.drift(model, free, touches, Law::Cone, drift);
        problem.friction.fill(world.settings.friction);
        // the law gets the direction of the slip; else friction would oppose the acceleration
        let given = |touch: &Touch| if event_contacts[touch.id].sticking { Vector3::zeros() } else { along(touch) };
        problem.slip.extend(touches.iter().map(given).map(|slip| [slip.x, slip.y]));
        let rows = 1 + problem.tangents;
        let report = per_contact.solve_unchecked(world, free, touches, Law::Cone, memory);
        if report.natural_map > JAM || is_beyond_bounds(model, &per_contact.map.problem, &per_contact.solver.impulse) {
            return Ok(None);
        }
        world.check(&report, &per_contact.map.problem)?;
        let response = per_contact.respond(world, free);
        // the energy gain of forces on accelerations has no meaning
        contact.set(free, touches, &response, Report { energy_gain: 0.0, ..report });
        (*solved, *warm) = (*solved + 1, *warm + u64::from(report.warm));
        for ((id, force), acceleration) in contact.impulses.iter().zip(per_contact.solver.velocity.chunks_exact(rows)) {
            let (contact, least) =
                (&mut event_contacts[*id], STICKING_ACCELERATION * typical_length(world) * natural * natural);
            contact.pressed = force.z > 0.0;
            contact.held = acceleration[1..].iter().all(|a| a.abs() <= least);
        }
        Ok(Some(contact))
    }
}

/// Whether a force is so great that the contacts are about to jam. Before that moment it grows beyond all bounds.
fn is_beyond_bounds(model: &Model, problem: &Problem, force: &[f64]) -> bool {
    let acceleration = greatest_size(problem.drift.iter().copied());
    greatest_size(force.iter().copied()) > GREATEST_FORCE * model.mass() * acceleration
}

/// Depth from which on a point inside the ground is not pushed out faster [m]. With v̇ = −2 rate v − rate² gap, a point that stays at
/// gap = −d tends to ½ rate d, which is to be [`max_recovery_speed`]. Drift is above this depth.
fn recovered_depth(world: &World, rate: f64) -> f64 {
    let fastest = max_recovery_speed(world.settings.h, world.model.gravity.norm());
    (2.0 * fastest / rate).max(ACTIVE_GAP * typical_length(world))
}

/// Slip velocity of a contact point [m/s].
pub(super) fn slip(pose: &Pose, point: &ContactPoint) -> Vector3<f64> {
    let velocity = pose.links[point.link].velocity.at(&pose.lowest(point));
    Vector3::new(velocity.x, velocity.y, 0.0)
}
