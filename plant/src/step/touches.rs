//! The points that may touch the ground within a time.

use super::landed::Landed;
use super::posed_state::PosedState;
use super::settings::World;
use crate::contact::{Memory, stops_at_any_height};
use crate::detect::{Touch, allowed_approach, touching};
use crate::kinematics::Pose;
use crate::model::Model;
use crate::state::State;

/// A contact bounces only if it approaches faster than free fall makes it in this many steps [-]. Otherwise a ball would bounce without end.
const BOUNCE_STEPS: f64 = 2.0;

/// The points that may touch within a time.
pub(super) struct Touches {
    pub list: Vec<Touch>,
    /// That time [s].
    pub horizon: f64,
    /// Contacts that approach more slowly than this do not bounce [m/s].
    pub min_bounce_speed: f64,
    /// Scratch: the state after that time without contact.
    end: PosedState,
}

impl Touches {
    pub fn new(model: &Model) -> Touches {
        let list = Vec::with_capacity(model.contact_points.len());
        Touches { list, horizon: 0.0, min_bounce_speed: 0.0, end: PosedState::new(model, State::zero(model)) }
    }

    /// Lists the points that may touch within `h`, in which the velocity without contact would become `free`. Points that only pass over the
    /// ground are not stopped.
    pub fn find(&mut self, world: &World, now: &PosedState, free: &[f64], h: f64, memory: &Memory) -> &mut Touches {
        self.list_near(world, &now.pose, free, h);
        self.let_pass(world, now, free, memory);
        self
    }

    /// Lists the points that may touch within `h`, in which the velocity without contact would become `free`.
    ///
    /// Slow contacts, whose speed two steps of free fall could have caused, do not bounce.
    fn list_near(&mut self, world: &World, pose: &Pose, free: &[f64], h: f64) {
        touching(&world.model, &world.input.ground, pose, world.settings.law, h, free, &mut self.list);
        (self.horizon, self.min_bounce_speed) = (h, BOUNCE_STEPS * world.model.gravity.norm() * h);
    }

    /// The law takes the path of a point as straight. If a point that is above the ground comes below it only by that, its path being curved
    /// upward, then its gap at the end of the motion without contact counts instead: gap₊ + h Kᵀ(ẋ₊ − ẋ_free) ≥ 0. Points
    /// that rested on the ground are left out: `ImplicitMidpoint` would let them pass in every second iteration, and not converge.
    fn let_pass(&mut self, world: &World, now: &PosedState, free: &[f64], memory: &Memory) {
        let Touches { list, horizon: h, end, .. } = self;
        if stops_at_any_height(world.settings.law) {
            return;
        }
        let down = |touch: &Touch| now.pose.twist(&world.model, touch.link, free).at(&touch.arm).z;
        let lands =
            |touch: &Touch| touch.gap > 0.0 && !memory.was_active(touch.id) && touch.gap + *h * down(touch) < 0.0;
        let mut landing = list.iter_mut().filter(|touch| lands(touch)).peekable();
        if landing.peek().is_none() {
            return;
        }
        end.state.x.copy_from_slice(&now.state.x);
        end.state.xdot.copy_from_slice(free);
        if end.integrate_position(world, *h).is_err() {
            return; // the step itself reports it
        }
        for touch in landing {
            let gap = world.input.ground.gap(&world.model, &end.pose, touch.id);
            if gap >= 0.0 {
                touch.approach = allowed_approach(gap, *h, &world.model) - down(touch);
            }
        }
    }

    /// Lists the points inside the ground, which have to leave it within `h`, at the end of a step of `h` that ignored the ground. A point that was at
    /// rest has fallen by ½gh², which is not a penetration.
    pub fn find_penetrating(&mut self, world: &World, pose: &Pose, free: &[f64], h: f64) -> &mut Touches {
        self.list_near(world, pose, free, 0.0);
        let gravity = world.model.gravity.norm();
        let depth = |gap: f64| (gap + 0.5 * gravity * h * h).min(0.0);
        self.list.iter_mut().for_each(|touch| touch.approach = allowed_approach(depth(touch.gap), h, &world.model));
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
        let landed = landed.beside(world, pose, active);
        self.list.clear();
        for (id, point) in contact_points.iter().enumerate() {
            let arm = pose.lowest(point);
            let gap = world.input.ground.gap_at(pose, &arm, id);
            let has_landed = landed.includes(gap, pose.links[point.link].velocity.at(&arm).z);
            if (has_landed || memory.was_active(id)) && point.may_touch(pose.reference.x + arm.x) {
                self.list.push(Touch::new(id, point.link, arm, gap));
            }
        }
        // lowest first, as in a step, so that no result depends on the numbering of contacts
        self.list.sort_by(|a, b| a.link.cmp(&b.link).then(a.gap.total_cmp(&b.gap)));
        (self.horizon, self.min_bounce_speed) = (0.0, 0.0);
        self.mark_landing(memory);
        self
    }

    /// Points that were not active in the step before land now.
    pub fn mark_landing(&mut self, memory: &Memory) {
        for touch in self.list.iter_mut().filter(|touch| !memory.was_active(touch.id)) {
            touch.lands_after = 0.0;
        }
    }
}
