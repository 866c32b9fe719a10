//! What bears between events: found at the beginning of a step, after the impact of what comes down, and its forces in every stage.

use crate::composite::Composite;
use crate::contact::{Memory, Report};
use crate::delassus::Free;
use crate::detect::Touch;
use crate::error::PlantError;
use crate::kinematics::Pose;
use crate::model::Corner;
use crate::step::Plant;
use crate::step::contact::{Contact, Contacts, Touches};
use crate::step::now::Now;
use crate::step::settings::World;
use messages::scene::Law;
use nalgebra::Vector3;

/// A corner bears up to this gap [length of the model]; an impact is located to 1e-15 m, so what has landed is far below it.
const BEARS: f64 = 1e-8;
/// Rate at which gap and velocity of what bears are drawn back to zero [1/s]. Slow: the stages of a step are off the ground
/// by h², and what pulls them there costs the method its order.
const SETTLES: f64 = 20.0;
/// What approaches the ground faster than this hits it [lengths/s].
const HITS: f64 = 1e-6;
/// What moves slower than this along the ground sticks [lengths/s].
const STICKS: f64 = 1e-6;
/// What is accelerated less than this sticks on [lengths/s²].
const HELD: f64 = 1e-6;
/// A slip slower than this, beside that at the step's beginning, keeps its direction of then.
const NEARLY_STOPPED: f64 = 1e-6;

/// What a corner does: as it was when a step began, and as its last force says.
///
/// Gap and slip of a contact that bears or sticks drift by the method's error. So it goes on doing so for as long as its
/// force does, however far it has drifted.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::step) struct Bearing {
    /// It carries, or would if pressed.
    pub(super) bears: bool,
    /// Bearing, it does not move along the ground.
    pub(super) sticks: bool,
    /// Height above the ground; infinite where there is none [m].
    pub(super) gap: f64,
    /// Direction of slip …
    pub(super) along: Vector3<f64>,
    /// … and its speed [m/s].
    pub(super) speed: f64,
    /// The last force presses.
    pressed: bool,
    /// The last force leaves no acceleration along the ground.
    held: bool,
}

impl Plant {
    /// What bears and what sticks now, after the impact of whatever comes down.
    pub(super) fn land(&mut self) -> Result<(), PlantError> {
        let Plant { world, now: Now { pose, .. }, bearings, .. } = self;
        let (length, mut hits) = (world.model.length, false);
        for (corner, bearing) in world.model.corners.iter().zip(bearings) {
            let arm = pose.lowest(corner);
            let at = pose.reference + arm;
            bearing.gap = if corner.has_ground(at.x) { at.z } else { f64::INFINITY };
            let bore = bearing.bears && bearing.pressed && bearing.gap.is_finite();
            bearing.bears = bearing.gap <= BEARS * length || bore;
            hits |= bearing.bears && pose.links[corner.link].velocity.at(&arm).z < -HITS * length;
        }
        if hits {
            self.work.touches.bearing(&self.world, &self.now.pose, &self.bearings);
            self.impact()?;
        }
        let Plant { world, now: Now { pose, .. }, bearings, .. } = self;
        for (corner, bearing) in world.model.corners.iter().zip(bearings) {
            // what the impact throws off does not bear, though it has no gap yet; what drifts off does
            let rises = pose.links[corner.link].velocity.at(&pose.lowest(corner)).z > HITS * length;
            if bearing.bears && rises && (hits || !bearing.pressed) {
                (bearing.bears, bearing.gap) = (false, bearing.gap.max(BEARS * length));
            }
            let slip = slip(pose, corner);
            bearing.speed = slip.norm();
            bearing.sticks = bearing.bears && (bearing.speed <= STICKS * length || bearing.sticks && bearing.held);
            bearing.along = if bearing.speed > 0.0 { slip / bearing.speed } else { slip };
        }
        Ok(())
    }
}

impl Touches {
    /// Lists what bears.
    pub(in crate::step) fn bearing(&mut self, world: &World, pose: &Pose, bearings: &[Bearing]) -> &mut Touches {
        let corners = world.model.corners.iter().zip(bearings).enumerate();
        (self.horizon, self.slow) = (0.0, 0.0);
        self.list.clear();
        self.list.extend(corners.filter(|(_, (_, bearing))| bearing.bears).map(|(id, (corner, _))| {
            let arm = pose.lowest(corner);
            Touch::new(id, corner.link, arm, pose.reference.z + arm.z)
        }));
        self
    }
}

impl Contacts {
    /// The forces of all that bears, and the acceleration with them; `free` is that without. What bears is told what its force does.
    ///
    /// They are those of the round cone under every law of Coulomb's: a slip's direction is known here, so that the laws differ in impacts.
    pub(in crate::step) fn forces(
        &mut self,
        world: &World,
        free: &Free,
        composite: &Composite,
        touches: &Touches,
        bearings: &mut [Bearing],
        memory: &mut Memory,
    ) -> Result<&Contact, PlantError> {
        let (touches, Contacts { each, contact, solved, warm, .. }) = (&touches.list, self);
        contact.clear(free);
        if touches.is_empty() {
            return Ok(contact);
        }
        let (model, length) = (&world.model, world.model.length);
        let velocity = |touch: &Touch| free.pose.links[touch.link].velocity.at(&touch.arm);
        // near its end a slip has no direction, and beyond it goes on being braked: the end is a zero of its speed
        let along = |touch: &Touch| {
            let (bearing, velocity) = (&bearings[touch.id], velocity(touch));
            let slip = Vector3::new(velocity.x, velocity.y, 0.0);
            let clear = slip.dot(&bearing.along) > NEARLY_STOPPED * bearing.speed;
            if clear { slip.normalize() } else { bearing.along }
        };
        let pull = |i: usize, own: Vector3<f64>| {
            let touch = &touches[i];
            let velocity = velocity(touch);
            let swept = composite.swept(model, free.pose, &model.corners[touch.id]);
            let mut pull = own + swept + velocity * SETTLES;
            pull.z += (velocity.z + touch.gap * SETTLES) * SETTLES;
            pull
        };
        let problem = each.map.drift(model, free, touches, Law::Cone, pull);
        problem.friction.fill(world.settings.friction);
        // the law is told the direction of a slip, for it would turn friction against any acceleration
        let given = |touch: &Touch| if bearings[touch.id].sticks { Vector3::zeros() } else { along(touch) };
        problem.slip.extend(touches.iter().map(given).map(|slip| [slip.x, slip.y]));
        let rows = 1 + problem.tangents;
        let report = each.solve(world, free, touches, Law::Cone, memory)?;
        let response = each.respond(world, free);
        // what its forces do to accelerations is no energy
        contact.set(free, touches, &response, Report { energy_gain: 0.0, ..report });
        (*solved, *warm) = (*solved + 1, *warm + u64::from(report.warm));
        for ((id, force), acceleration) in contact.impulses.iter().zip(each.solver.velocity.chunks_exact(rows)) {
            let bearing = &mut bearings[*id];
            bearing.pressed = force.z > 0.0;
            bearing.held = acceleration[1..].iter().all(|a| a.abs() <= HELD * length);
        }
        Ok(contact)
    }
}

/// Velocity of a corner along the ground [m/s].
pub(super) fn slip(pose: &Pose, corner: &Corner) -> Vector3<f64> {
    let velocity = pose.links[corner.link].velocity.at(&pose.lowest(corner));
    Vector3::new(velocity.x, velocity.y, 0.0)
}
