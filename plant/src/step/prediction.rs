//! Prediction of the contacts at the end of the step, from its beginning and its middle.
//!
//! The law holds at the end of the step, with K of the end pose. That K is not known yet. It changes smoothly, so K₊ = 2K_m − K₀ to second
//! order:
//!
//! ```text
//!   K₊ᵀẋ₊ = K_mᵀẋ₊ + (K_m − K₀)ᵀẋ₋ + O(h²),    gap₊ = 2 gap_m − gap₀ − ½h K_mᵀẋ₋ + ½h K₊ᵀẋ₊ + O(h³)
//! ```
//!
//! The condition Kᵀ(ẋ₋ + ẋ₊) = 0 would be second order as well, but a velocity error would alternate in sign without end.

use super::landed::{height_errors, landed_height};
use super::landing::first_root;
use super::posed_state::PosedState;
use super::scales::greatest_size;
use super::settings::World;
use super::touches::Touches;
use crate::contact::{Memory, stops_at_any_height};
use crate::detect::{Touch, add_penetrating, is_rounding, recovery_speed, touching};
use crate::kinematics::Pose;
use messages::scene::Law;
use nalgebra::Vector3;

/// A contact that approaches faster than this many times the velocity change of a whole step lands, with an impact [-]. A slower one comes
/// to rest within the step, at the cost of an error of h².
const LANDING_RATIO: f64 = 2.0;
/// A contact that its own motion lifts faster than this lands as well, if it enters the ground before it rises again [g]: the tip of a body that
/// turns. It would not stay on the ground, and its speed at the end of the step says nothing about its impact.
const LIFTING: f64 = 10.0;
/// The contacts of a link rest when their greatest height is this part of what is rounding [-]. Heights of standing feet vary by a third of it: with 1
/// they cross the limit every second step, and a robot that stands is solved contact by contact 1.7 times as often.
const RESTING: f64 = 0.1;
/// A slip is steady if it is this many times its change within a step [-]. Friction then acts against its direction in the middle of the
/// step.
const STEADY_RATIO: f64 = 4.0;

/// A step from its beginning to its middle.
#[derive(Clone, Copy)]
pub(super) struct Prediction<'a> {
    /// Pose at the beginning.
    pub start: &'a Pose,
    /// ẋ₋.
    pub rate: &'a [f64],
    /// Pose in the middle, with the mean velocity.
    pub middle: &'a Pose,
    /// The velocity at the end of the step without contact.
    pub free: &'a [f64],
    /// Length of the step, and of the whole step of which it is a part [s].
    pub h: f64,
    pub whole: f64,
}

impl<'a> Prediction<'a> {
    /// Prediction for a step that begins at `now`. Without contact it would end with the velocity `free`. `h` is the length of the step,
    /// `whole` that of the undivided step [s].
    pub fn of(now: &'a PosedState, middle: &'a PosedState, free: &'a [f64], [h, whole]: [f64; 2]) -> Prediction<'a> {
        Prediction { start: &now.pose, rate: &middle.state.xdot, middle: &middle.pose, free, h, whole }
    }

    /// Predicts the contacts of one link.
    ///
    /// Along the ground, all contacts of a link get the velocity gain of one rigid motion: the mean of those that were active, if any were.
    /// Individual gains would differ by −½h ω²d, because the contacts turn about each other. But at the pose of A, a link cannot stretch by
    /// that, and friction would oppose it with full force.
    pub fn predict(&self, world: &World, memory: &Memory, touches: &mut [Touch]) {
        let Some(link) = touches.first().map(|touch| touch.link) else { return };
        let [before, free] = [self.rate, self.free].map(|rate| self.middle.twist(&world.model, link, rate));
        let angular_gain = before.angular - self.start.links[link].velocity.angular;
        let active = touches.iter().filter(|touch| memory.was_active(touch.id)).map(|touch| touch.id);
        let highest = greatest_size(active.map(|id| world.input.ground.gap(&world.model, self.start, id)));
        let errors = height_errors(world, self.start.links[link].velocity.angular.norm_squared(), highest);
        for touch in &mut *touches {
            touch.angular_gain = angular_gain;
            let point = &world.model.contact_points[touch.id];
            let [at_start, arm] = [self.start, self.middle].map(|pose| pose.lowest(point));
            let start = self.start.links[link].velocity.at(&at_start);
            let gap = world.input.ground.gap_at(self.start, &at_start, touch.id);
            touch.velocity_gain = before.at(&arm) - start;
            let end = free.at(&arm) + touch.velocity_gain;
            let free_gap = 2.0 * touch.gap - gap - 0.5 * self.h * before.at(&arm).z; // gap₊ without further approach
            let was_active = memory.was_active(touch.id);
            touch.approach = self.allowed_approach(world, [gap, free_gap], was_active, [highest, errors]);
            let is_fast = start.z < -LANDING_RATIO * self.whole / self.h * (end.z - start.z).abs();
            let curvature = (self.middle.links[link].velocity.at(&arm).z - start.z) / self.h;
            let lifts = end.z - start.z > LIFTING * world.model.gravity.norm() * self.h;
            let dips = start.z * start.z > 4.0 * curvature * (gap + landed_height(world));
            let lands = !was_active && start.z < 0.0 && (is_fast || lifts && dips);
            touch.lands_after = if lands { first_root(gap, start.z, curvature) } else { f64::INFINITY };
            touch.slip_direction = match memory.was_sliding(touch.id) {
                true => steady(&start, &self.middle.links[link].velocity.at(&arm), &end, world.settings.friction),
                false => Vector3::zeros(),
            };
        }
        if touches.len() > 1 {
            let any = touches.iter().any(|touch| memory.was_active(touch.id));
            let counts = |touch: &&Touch| !any || memory.was_active(touch.id);
            let at_reference = |touch: &Touch| touch.velocity_gain - angular_gain.cross(&touch.arm);
            let count = touches.iter().filter(counts).count() as f64;
            let mean = touches.iter().filter(counts).map(at_reference).sum::<Vector3<f64>>() / count;
            for touch in touches {
                let rigid = mean + angular_gain.cross(&touch.arm);
                (touch.velocity_gain.x, touch.velocity_gain.y) = (rigid.x, rigid.y);
            }
        }
    }

    /// Speed at which a point may approach the ground in this step [m/s], from its height at the beginning and that at the end without
    /// further approach. `highest` is the greatest height of the active contacts of its link. Points up to the height `errors` touch the
    /// ground with them [m].
    fn allowed_approach(
        &self,
        world: &World,
        [gap, free_gap]: [f64; 2],
        was_active: bool,
        [highest, errors]: [f64; 2],
    ) -> f64 {
        let World { model, settings, .. } = world;
        // relative to the whole step: the rest of a step after a landing may be extremely short, and the speed in it extremely large
        let recovery = |gap: f64| recovery_speed(gap, settings.h, model.gravity.norm());
        // The points of a link that touch the ground approach it in proportion to their heights, however small these are: the speeds of four
        // corners are dependent, and with others one corner would lose its load. At rest they are left alone. Where links share the load, the
        // same holds for the wheels of all links, and none is left alone.
        let rest = is_rounding(highest / RESTING, model) && !model.shares_load;
        let touches = was_active || is_rounding(gap, model) || gap.abs() <= errors;
        match touches {
            true if rest => 0.0,
            true => recovery(gap), // a gap closes in the same way as a penetration
            false if is_rounding(free_gap, model) => 0.0,
            false if free_gap > 0.0 => 2.0 * free_gap / self.h,
            false if is_rounding(gap.min(0.0), model) => 0.0,
            false => recovery(gap.min(0.0)),
        }
    }
}

/// Direction of the slip if it is steady, else zero. A slip is steady if its mean hardly differs from the slip at the beginning and
/// from the slip at the end without contact, and if the friction of a landing would change it little.
fn steady(start: &Vector3<f64>, mean: &Vector3<f64>, end: &Vector3<f64>, friction: f64) -> Vector3<f64> {
    let slip = Vector3::new(mean.x, mean.y, 0.0);
    let changes = [(mean - start).xy().norm(), (end - mean).xy().norm(), friction * end.z.abs()];
    let (speed, change) = (slip.norm(), changes.into_iter().fold(0.0, f64::max));
    if speed > STEADY_RATIO * change { slip / speed } else { Vector3::zeros() }
}

impl Touches {
    /// Lists the points that may touch before the end of the step. With `skips_landings`, points that land are omitted.
    pub fn find_predicted(
        &mut self,
        world: &World,
        prediction: &Prediction,
        memory: &Memory,
        skips_landings: bool,
    ) -> &mut Touches {
        let (law, half) = (world.settings.law, 0.5 * prediction.h);
        let reach = if stops_at_any_height(law) { Law::Cone } else { law };
        touching(&world.model, &world.input.ground, prediction.middle, reach, half, prediction.free, &mut self.list);
        self.list.chunk_by_mut(|a, b| a.link == b.link).for_each(|touches| prediction.predict(world, memory, touches));
        if skips_landings {
            self.list.retain(|touch| !touch.lands());
        }
        if stops_at_any_height(law) {
            // so only approaching points are listed
            let down =
                |touch: &Touch| prediction.middle.twist(&world.model, touch.link, prediction.free).at(&touch.arm).z;
            self.list.retain(|touch| {
                down(touch) + touch.velocity_gain.z + touch.approach < 0.0 || memory.was_active(touch.id)
            });
        }
        (self.horizon, self.min_bounce_speed) = (if skips_landings { 0.0 } else { half }, f64::INFINITY);
        self
    }

    /// Adds points that were not listed but that the velocity `after` the step drives into the ground. Returns whether there are any.
    pub fn add_penetrating(
        &mut self,
        world: &World,
        pose: &Pose,
        after: &[f64],
        prediction: Option<&Prediction>,
        memory: &Memory,
    ) -> bool {
        let more = add_penetrating(
            &world.model,
            &world.input.ground,
            pose,
            world.settings.law,
            self.horizon,
            after,
            &mut self.list,
        );
        if let Some(prediction) = prediction.filter(|_| more) {
            for touches in self.list.chunk_by_mut(|a, b| a.link == b.link) {
                prediction.predict(world, memory, touches);
            }
            // Contact forces within the step accelerated these points, so they did not land by themselves.
            self.list.iter_mut().for_each(|touch| touch.lands_after = f64::INFINITY);
        }
        more
    }
}
