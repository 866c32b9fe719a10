//! One foot on its contacts, and how it moves.

use super::sole::Sole;
use super::{Pair, Six, pair, six, velocity};
use crate::delassus::Free;
use crate::detect::Touch;
use crate::model::Model;

/// A link on its contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct Foot {
    pub link: usize,
    /// Its first contact.
    pub first: usize,
    pub sole: Sole,
    /// K of its six velocities, where it is held, a row for each degree of freedom of its path; once welded, Y = √D⁻¹ L⁻ᵀK.
    pub rows: Vec<Six>,
    pub free: Pair,
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
        self.free = pair(&t);
    }

    /// Whether the motion t keeps it above the ground for a step of `h`.
    pub fn stays_above(&self, t: &Pair, touches: &[Touch], h: f64) -> bool {
        let mut contacts = self.sole.arms.iter().zip(touches);
        contacts.all(|(d, touch)| velocity(t, d).z + touch.gap.max(0.0) / h > 0.0)
    }

    /// The same if it hovers, after a change of the robot's velocity.
    pub fn goes_on(&self, model: &Model, touches: &[Touch], change: &[f64], h: f64) -> bool {
        let paired = self.rows.iter().zip(model.path(self.link));
        let t =
            paired.fold(six(&self.free), |t, (row, &dof)| std::array::from_fn(|k| row[k].mul_add(change[dof], t[k])));
        self.stays_above(&pair(&t), &touches[self.first..], h)
    }

    /// Gets ready to be welded; none where [`Sole::spread_out`] has none.
    pub fn land(&mut self, touches: &[Touch], h: f64) -> Option<()> {
        self.sole.spread_out()?;
        self.wanted = self.sole.landing(touches, h);
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
