//! One foot on its contacts, and its motion.

use super::sole::Sole;
use super::spatial_pair::{PaddedRow, SpatialPair, padded, point_velocity, unpadded};
use crate::delassus::Free;
use crate::detect::Touch;
use crate::model::Model;
use nalgebra::Vector3;

/// A link on its contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct Foot {
    pub link: usize,
    /// First contact, and number of contacts of the link. Those of the sole come first, the others do not hold it.
    pub first: usize,
    contacts: usize,
    pub sole: Sole,
    /// J of its six velocities without free axes, one row for each degree of freedom of its path. Once prepared: Y = √D⁻¹ L⁻ᵀJᵀ.
    pub rows: Vec<PaddedRow>,
    /// Velocity at the end of the step without contact.
    pub free: SpatialPair,
    /// Change of that velocity from the change of J within the step.
    velocity_gain: SpatialPair,
    wanted: SpatialPair,
    /// t.
    pub motion: SpatialPair,
    /// w.
    pub wrench: SpatialPair,
}

impl Foot {
    /// Allocates for the contacts of any link of a model.
    pub fn new(model: &Model) -> Foot {
        Foot { sole: Sole::new(model.contact_points.len()), rows: Vec::with_capacity(model.dofs()), ..Foot::default() }
    }

    /// Sets the foot on the first `held` of the contacts of its link; `first` is the index of the first of them. Computes its free motion,
    /// except rotation about its free axes.
    pub fn set(&mut self, model: &Model, free: &Free, first: usize, link: &[Touch], held: usize) {
        let touches = &link[..held];
        (self.link, self.first, self.contacts) = (touches[0].link, first, link.len());
        self.sole.set(touches);
        let mut t = PaddedRow::default();
        self.rows.clear();
        for &dof in model.path(self.link) {
            let column = &free.pose.links[dof + 1].column;
            let row = padded(&[column.at(&self.sole.centre), column.angular - self.sole.free_axes * column.angular]);
            t = std::array::from_fn(|k| row[k].mul_add(free.rate[dof], t[k]));
            self.rows.push(row);
        }
        let [linear, angular] = unpadded(&t);
        let velocity_gain =
            touches.iter().map(|touch| touch.velocity_gain).sum::<Vector3<f64>>() / touches.len() as f64;
        let angular_gain = touches[0].angular_gain - self.sole.free_axes * touches[0].angular_gain;
        self.velocity_gain = [velocity_gain, angular_gain];
        self.free = [linear + velocity_gain, angular + angular_gain];
    }

    /// Velocities of its contacts at the end of the step, if it moves with t.
    pub fn velocities<'a>(
        &'a self,
        t: &'a SpatialPair,
        touches: &'a [Touch],
    ) -> impl Iterator<Item = (Vector3<f64>, &'a Touch)> {
        let contacts = self.sole.arms.iter().zip(&touches[self.first..]);
        contacts.map(|(d, touch)| {
            (point_velocity(t, d) + (touch.velocity_gain - point_velocity(&self.velocity_gain, d)), touch)
        })
    }

    /// Whether it stays above the ground during the step, if it moves with t.
    pub fn stays_above(&self, t: &SpatialPair, touches: &[Touch]) -> bool {
        self.velocities(t, touches).all(|(v, touch)| v.z + touch.approach > 0.0)
    }

    /// The same for an airborne foot, after a change of the robot's velocity.
    pub fn stays_above_after(&self, model: &Model, touches: &[Touch], change: &[f64]) -> bool {
        let paired = self.rows.iter().zip(model.path(self.link));
        let t = paired
            .fold(padded(&self.free), |t, (row, &dof)| std::array::from_fn(|k| row[k].mul_add(change[dof], t[k])));
        self.stays_above(&unpadded(&t), touches)
    }

    /// Whether the contacts that do not hold it stay above the ground, after a change of the robot's velocity.
    pub fn others_stay_above_after(&self, model: &Model, free: &Free, touches: &[Touch], change: &[f64]) -> bool {
        touches[self.first..][..self.contacts].iter().skip(self.sole.arms.len()).all(|touch| {
            let rise = |dof: usize| free.pose.links[dof + 1].column.at(&touch.arm).z * (free.rate[dof] + change[dof]);
            let v = model.path(self.link).iter().map(|&dof| rise(dof)).sum::<f64>();
            v + touch.velocity_gain.z + touch.approach > 0.0
        })
    }

    /// Prepares the foot to be held; `None` if [`Sole::prepare`] fails.
    pub fn prepare(&mut self, touches: &[Touch]) -> Option<()> {
        self.sole.prepare()?;
        let velocity_gain = self.velocity_gain;
        self.wanted = self.sole.closing_velocity(touches, |d, touch| {
            touch.approach + (touch.velocity_gain - point_velocity(&velocity_gain, d)).z
        });
        Some(())
    }

    /// Difference between its wanted motion and its motion.
    pub fn velocity_error(&self) -> SpatialPair {
        [self.wanted[0] - self.motion[0], self.wanted[1] - self.motion[1]]
    }

    /// Upper bound on the velocity error of the foot's contacts [m/s].
    pub fn error_bound(&self) -> f64 {
        let [linear, angular] = self.velocity_error();
        linear.norm() + angular.norm() * self.sole.reach
    }
}
