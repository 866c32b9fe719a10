//! One foot on its contacts, and how it moves.

use super::sole::Sole;
use super::{Pair, Six, pair, six, velocity};
use crate::delassus::Free;
use crate::detect::Touch;
use crate::model::Model;
use nalgebra::Vector3;

/// A link on its contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct Foot {
    pub link: usize,
    /// Its first contact.
    pub first: usize,
    pub sole: Sole,
    /// K of its six velocities, where it is held, a row for each degree of freedom of its path; once welded, Y = √D⁻¹ L⁻ᵀK.
    pub rows: Vec<Six>,
    /// Its velocity at the end of the step if nothing touched.
    pub free: Pair,
    /// What of it K gains on the way there.
    swept: Pair,
    wanted: Pair,
    /// t.
    pub motion: Pair,
    /// w.
    pub wrench: Pair,
}

impl Foot {
    /// Room for the contacts of any link of a model.
    pub fn new(model: &Model) -> Foot {
        Foot { sole: Sole::new(model.corners.len()), rows: Vec::with_capacity(model.dofs()), ..Foot::default() }
    }

    /// Becomes the foot on these contacts, the first of all being `first`; finds its free motion, but for turning where they do not hold
    /// it.
    pub fn set(&mut self, model: &Model, free: &Free, first: usize, touches: &[Touch]) {
        (self.link, self.first) = (touches[0].link, first);
        self.sole.place(touches);
        let mut t = Six::default();
        self.rows.clear();
        for &dof in model.path(self.link) {
            let column = &free.pose.links[dof + 1].column;
            let row = six(&[column.at(&self.sole.centre), column.angular - self.sole.loose * column.angular]);
            t = std::array::from_fn(|k| row[k].mul_add(free.rate[dof], t[k]));
            self.rows.push(row);
        }
        let [straight, round] = pair(&t);
        let swept = touches.iter().map(|touch| touch.swept).sum::<Vector3<f64>>() / touches.len() as f64;
        let turned = touches[0].turned - self.sole.loose * touches[0].turned;
        self.swept = [swept, turned];
        self.free = [straight + swept, round + turned];
    }

    /// Velocity of its contacts at the end of the step when it moves by t.
    pub fn velocities<'a>(
        &'a self,
        t: &'a Pair,
        touches: &'a [Touch],
    ) -> impl Iterator<Item = (Vector3<f64>, &'a Touch)> {
        let contacts = self.sole.arms.iter().zip(&touches[self.first..]);
        contacts.map(|(d, touch)| (velocity(t, d) + (touch.swept - velocity(&self.swept, d)), touch))
    }

    /// Whether the motion t keeps it above the ground for the step.
    pub fn stays_above(&self, t: &Pair, touches: &[Touch]) -> bool {
        self.velocities(t, touches).all(|(v, touch)| v.z + touch.approach > 0.0)
    }

    /// The same if it hovers, after a change of the robot's velocity.
    pub fn goes_on(&self, model: &Model, touches: &[Touch], change: &[f64]) -> bool {
        let paired = self.rows.iter().zip(model.path(self.link));
        let t =
            paired.fold(six(&self.free), |t, (row, &dof)| std::array::from_fn(|k| row[k].mul_add(change[dof], t[k])));
        self.stays_above(&pair(&t), touches)
    }

    /// Gets ready to be welded; none where [`Sole::spread_out`] has none.
    pub fn land(&mut self, touches: &[Touch]) -> Option<()> {
        self.sole.spread_out()?;
        let swept = self.swept;
        self.wanted = self.sole.landing(touches, |d, touch| touch.approach + (touch.swept - velocity(&swept, d)).z);
        Some(())
    }

    /// What is wanted of its motion and lacks.
    pub fn lacks(&self) -> Pair {
        [self.wanted[0] - self.motion[0], self.wanted[1] - self.motion[1]]
    }

    /// No less than any contact moves otherwise than it should [m/s].
    pub fn left(&self) -> f64 {
        let [straight, round] = self.lacks();
        straight.norm() + round.norm() * self.sole.reach
    }
}
