//! The points that may touch the ground within a time.

use super::landed::Landed;
use super::settings::World;
use crate::contact::Memory;
use crate::detect::{Touch, allowed_approach, touching};
use crate::kinematics::Pose;
use crate::model::Model;

/// A contact bounces only if it approaches faster than free fall makes it in this many steps [-]. Otherwise a ball would bounce without end.
const BOUNCE_STEPS: f64 = 2.0;

/// The points that may touch within a time.
pub(super) struct Touches {
    pub list: Vec<Touch>,
    /// That time [s].
    pub horizon: f64,
    /// Contacts that approach more slowly than this do not bounce [m/s].
    pub min_bounce_speed: f64,
}

impl Touches {
    pub fn new(model: &Model) -> Touches {
        Touches { list: Vec::with_capacity(model.contact_points.len()), horizon: 0.0, min_bounce_speed: 0.0 }
    }

    /// Lists the points that may touch within a step of `h` whose velocity without contact would be `free`.
    ///
    /// Slow contacts, whose speed two steps of free fall could have caused, do not bounce.
    pub fn find(&mut self, world: &World, pose: &Pose, free: &[f64], h: f64) -> &mut Touches {
        touching(&world.model, &world.input.ground, pose, world.settings.law, h, free, &mut self.list);
        (self.horizon, self.min_bounce_speed) = (h, BOUNCE_STEPS * world.model.gravity.norm() * h);
        self
    }

    /// Lists the points inside the ground, which have to leave it within `h`.
    pub fn find_penetrating(&mut self, world: &World, pose: &Pose, free: &[f64], h: f64) -> &mut Touches {
        self.find(world, pose, free, 0.0);
        let gravity = world.model.gravity.norm();
        self.list.iter_mut().for_each(|touch| touch.approach = allowed_approach(touch.gap, h, &world.model));
        self.min_bounce_speed = BOUNCE_STEPS * gravity * h;
        self
    }

    /// Lets points that should recover from a penetration stay inside the ground. False if there are none.
    pub fn leave_inside(&mut self) -> bool {
        let recovers = self.list.iter().any(|touch| touch.approach < 0.0);
        self.list.iter_mut().for_each(|touch| touch.approach = touch.approach.max(0.0));
        recovers
    }

    /// Lists the points that have landed, and those that were active in the step before. An impact takes no time, so no other point can come
    /// nearer.
    pub fn find_on_ground(&mut self, world: &World, pose: &Pose, landed: Landed, memory: &Memory) -> &mut Touches {
        let Model { contact_points, .. } = &world.model;
        let active = (0..contact_points.len()).filter(|&id| memory.was_active(id));
        let landed = landed.beside(world, active.map(|id| world.input.ground.gap(&world.model, pose, id)));
        self.list.clear();
        for (id, point) in contact_points.iter().enumerate() {
            let arm = pose.lowest(point);
            let gap = world.input.ground.gap_at(pose, &arm, id);
            let has_landed = landed.includes(gap, pose.links[point.link].velocity.at(&arm).z);
            if (has_landed || memory.was_active(id)) && point.may_touch(pose.reference.x + arm.x) {
                let lands_after = if memory.was_active(id) { f64::INFINITY } else { 0.0 };
                self.list.push(Touch { lands_after, ..Touch::new(id, point.link, arm, gap) });
            }
        }
        // lowest first, as in a step, so that no result depends on the numbering of contacts
        self.list.sort_by(|a, b| a.link.cmp(&b.link).then(a.gap.total_cmp(&b.gap)));
        (self.horizon, self.min_bounce_speed) = (0.0, 0.0);
        self
    }
}
