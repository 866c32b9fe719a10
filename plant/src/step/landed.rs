//! Which points have landed when another point lands: those on the ground up to errors of the steps, and those that would land hardly later.

use super::scales::natural_rate;
use super::settings::World;
use crate::kinematics::Pose;

/// Points nearer to the ground than this when another point lands have landed too [length of the model].
const LANDED: f64 = 1e-8;
/// The same for the errors of h² with which a step leaves the heights of contacts [g h²]. Two points of an edge land at once. If such an
/// error separated their landings, the body would turn several times as fast afterwards.
const LANDED_IN_STEP: f64 = 0.005;
/// Resting contacts are off the ground by errors of the steps, and show how great these are: points up to this many times their greatest distance
/// above the ground have landed as well [-]. The error of one point of an edge reappears at the opposite edge, enlarged by the ratio of their
/// lengths. However short the steps are, the errors are never exactly zero.
const ENLARGED: f64 = 4.0;
/// The greatest distance from the ground that is such an error, in terms of [`LANDED`] and [`LANDED_IN_STEP`] [-]. Deeper points began inside the
/// ground, or entered a tile. Beside gravity it counts the acceleration of points of links that turn: an edge that turns at 24 rad/s is left three
/// hundredths of a millimetre inside the ground by steps of 1 ms.
const MAX_ERROR: f64 = 20.0;
/// Points that would land within a part of a step after another one land with it: this many times (hω)², ω being the rate of a pendulum as long
/// as the model [-].
///
/// If a body turns about an edge that is parallel to the ground, both points of the opposite edge land at once. Errors of the steps separate
/// their landings, for a box of .2 m by 1e-4, 4e-4 and 2e-3 of a step of 1, 2 and 5 ms. Two impacts instead of one would lead to another motion.
/// Landings that are as close by chance hardly occur.
const COINCIDENT: f64 = 10.0;
/// The greatest such part of a step [-].
const MAX_COINCIDENT: f64 = 5e-3;

/// Which points have landed when another point lands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landed {
    /// Height of the point that lands [m].
    first: f64,
    /// Up to this height above it every point has landed [m].
    height: f64,
    /// Time within which another point would land [s].
    time: f64,
}

impl Landed {
    /// Points up to this height, and those that would land within a part of a step of `h`.
    pub fn new(world: &World, height: f64, h: f64) -> Landed {
        Landed { first: 0.0, height, time: h * (COINCIDENT * (h * natural_rate(world)).powi(2)).min(MAX_COINCIDENT) }
    }

    /// The same beside a point that lands at the height `first` [m].
    pub fn above(self, first: f64) -> Landed {
        Landed { first, ..self }
    }

    /// The same, and points as near to the ground as the errors of the resting contacts explain.
    pub fn beside(self, world: &World, pose: &Pose, resting: impl Iterator<Item = usize>) -> Landed {
        let World { model, input, .. } = world;
        let [mut highest, mut turning] = [0.0_f64; 2];
        for id in resting {
            highest = highest.max(input.ground.gap(model, pose, id).abs());
            turning = turning.max(pose.links[model.contact_points[id].link].velocity.angular.norm_squared());
        }
        Landed { height: self.height.max(height_errors(world, turning, highest)), ..self }
    }

    /// Whether a point with this gap [m] and vertical velocity [m/s] has landed.
    pub fn includes(self, gap: f64, velocity: f64) -> bool {
        gap - self.first <= self.height.max(-self.time * velocity)
    }
}

/// Height up to which a point has landed [m].
pub(super) fn landed_height(world: &World) -> f64 {
    landed_at(world, world.model.gravity.norm())
}

/// The same for points with this acceleration [m/s²].
fn landed_at(world: &World, acceleration: f64) -> f64 {
    f64::max(LANDED * world.model.length, LANDED_IN_STEP * acceleration * world.settings.h.powi(2))
}

/// Height up to which a point touches the ground as far as resting contacts tell; see [`ENLARGED`]. `highest` is their greatest height [m], and
/// `turning` the greatest square of their links' angular velocities [rad²/s²].
pub(super) fn height_errors(world: &World, turning: f64, highest: f64) -> f64 {
    let acceleration = world.model.gravity.norm() + turning * world.model.length;
    ENLARGED * highest.min(MAX_ERROR * landed_at(world, acceleration))
}
