//! Links that stand: where nothing moved in the step before, every touching link is welded to the ground for the step.
//!
//! The contacts of a rigid link move with its six velocities: of their equations, three each, six are left, however many there are.
//! With the velocities t of the links about a point c amid their contacts, and the wrenches w there,
//!
//! ```text
//!   t = Λ w + t_free = t_wanted,   Λ = YᵀY
//! ```
//!
//! where t_wanted closes what gaps there are and moves nothing else. Neither tangents nor a remembered basis are needed: the soles
//! say what w is at each contact, and whether all that obeys Coulomb's law; see `weld/sole.rs`.
//!
//! What Λ of two feet does not see (that they press against each other) yields by a hair, as in the full problem.
//!
//! # Source
//! Λ = JH⁻¹Jᵀ: Khatib (1987), the operational-space inertia's inverse, here of every foot at once.

mod blocks;
mod sole;

use crate::contact::{Report, SOLVED, YIELD};
use crate::detect::Touch;
use crate::factor::Factor;
use crate::kinematics::Pose;
use crate::model::Model;
use blocks::{Blocks, Factored};
use nalgebra::Vector3;
use sole::Sole;

/// More links are not welded: their contacts are solved one by one.
const FEET: usize = 4;
/// Solutions at most: from the second on they undo the yielding, wherever Λ allows.
const REFINEMENTS: usize = 5;
/// A velocity this small beside the free one is left.
const ENOUGH: f64 = 1e-13;

/// Velocity (v at c, angular) or wrench (force, moment about c) in W, filled up so that it is worked on four at a time.
type Six = [f64; 8];

/// A link on its contacts.
#[derive(Clone, Debug, Default)]
struct Foot {
    link: usize,
    sole: Sole,
    /// Y = √D⁻¹ L⁻ᵀK of its six velocities, a row for each degree of freedom of its path.
    rows: Vec<Six>,
    free: Six,
    wanted: Six,
    /// t.
    motion: Six,
    /// w.
    wrench: Six,
}

/// The welded links of a step; workspace and last solution.
#[derive(Clone, Debug, Default)]
pub struct Weld {
    feet: [Foot; FEET],
    count: usize,
    /// Λ.
    mobility: Blocks,
    factored: Factored,
    /// Impulse on each contact, in W [N·s].
    pub impulse: Vec<Vector3<f64>>,
}

impl Weld {
    /// Finds the feet, if all can be welded: where they are, their free motion and what is wanted of it, and Y.
    pub fn stand(
        &mut self,
        model: &Model,
        pose: &Pose,
        factor: &Factor,
        touches: &[Touch],
        free: &[f64],
        h: f64,
    ) -> Option<()> {
        self.count = 0;
        for touches in touches.chunk_by(|a, b| a.link == b.link) {
            let foot = self.feet.get_mut(self.count)?;
            self.count += 1;
            foot.link = touches[0].link;
            foot.sole.set(touches)?;
            foot.wanted = foot.sole.landing(touches, h);
            foot.free = Six::default();
            foot.rows.clear();
            for &dof in model.path(foot.link) {
                let column = &pose.links[dof + 1].column;
                let row = six(&column.at(&foot.sole.centre), &column.angular);
                foot.free = std::array::from_fn(|k| row[k].mul_add(free[dof], foot.free[k]));
                foot.rows.push(row);
            }
            factor.half_solve(model, foot.link, &mut foot.rows);
        }
        Some(())
    }

    /// Impulses under which they do not move, if Coulomb's law allows them.
    pub fn hold(&mut self, model: &Model, touches: &[Touch], friction: f64, h: f64) -> Option<Report> {
        self.resolve(model)?;
        self.impulse.clear();
        for foot in &mut self.feet[..self.count] {
            foot.sole.spread(&foot.wrench, &foot.free, friction, &mut self.impulse)?;
        }
        Some(self.report(model, touches, friction, h)).filter(|report| report.natural_map <= SOLVED)
    }

    /// w for t = t_wanted, and t; none if Λ is not that of a body.
    fn resolve(&mut self, model: &Model) -> Option<()> {
        let Weld { feet, count, mobility, factored, .. } = self;
        let feet = &mut feet[..*count];
        for (i, a) in feet.iter().enumerate() {
            for (j, b) in feet[..=i].iter().enumerate() {
                let shared = if i == j { a.rows.len() } else { model.shared(a.link, b.link) };
                mobility.put(i, j, &a.rows[..shared], &b.rows[..shared]);
            }
        }
        mobility.factorize(feet.len(), if feet.len() > 1 { YIELD } else { 0.0 }, factored)?;
        feet.iter_mut().for_each(|foot| foot.motion = foot.free);
        let mut wrench = [Six::default(); FEET];
        let mut scale = 0.0;
        for _ in 0..REFINEMENTS {
            let mut change = [Six::default(); FEET];
            let mut left = 0.0_f64;
            for (change, foot) in change.iter_mut().zip(&*feet) {
                *change = std::array::from_fn(|k| foot.wanted[k] - foot.motion[k]);
                left = change.iter().fold(left, |most, t| most.max(t.abs()));
            }
            scale = f64::max(scale, left);
            if left <= ENOUGH * scale {
                break;
            }
            factored.solve(feet.len(), &mut change);
            for (wrench, change) in wrench.iter_mut().zip(&change).take(*count) {
                *wrench = std::array::from_fn(|k| wrench[k] + change[k]);
            }
            for (i, foot) in feet.iter_mut().enumerate() {
                foot.motion = mobility.times(i, &wrench[..*count], &foot.free);
            }
        }
        feet.iter_mut().zip(wrench).for_each(|(foot, wrench)| foot.wrench = wrench);
        Some(())
    }

    /// How well the impulses obey the law.
    ///
    /// They are within their cones, so that the natural map is no more than the velocity that is left. It is measured with a bound:
    /// a contact moves no less easily than the whole robot's mass does, A_kk >= 1/m.
    fn report(&self, model: &Model, touches: &[Touch], friction: f64, h: f64) -> Report {
        let (mut slip, mut work, mut gain) = (0.0_f64, 0.0_f64, 0.0);
        let mut contacts = touches.iter().zip(&self.impulse);
        for foot in &self.feet[..self.count] {
            for (touch, impulse) in contacts.by_ref().take(foot.sole.len()) {
                let v = foot.velocity(&touch.arm) + Vector3::z() * (touch.gap.max(0.0) / h);
                slip = slip.max(v.z.abs() + (1.0 + friction) * v.xy().norm());
                work = work.max((impulse.z * v.z).abs());
            }
            let both = foot.motion.iter().zip(&foot.free).zip(&foot.wrench);
            gain += 0.5 * both.map(|((t, free), w)| w * (t + free)).sum::<f64>();
        }
        let (mass, push) = (model.mass(), self.impulse.iter().fold(0.0_f64, |push, impulse| push.max(impulse.z)));
        let natural_map = mass * slip / push;
        let signorini = mass * work / (push * push);
        Report { natural_map, own: natural_map, signorini, energy_gain: gain, warm: true, ..Report::default() }
    }

    /// H⁻¹KΔf: the change of velocity that the impulses make.
    pub fn respond(&self, model: &Model, factor: &Factor, change: &mut [f64]) {
        change.fill(0.0);
        for foot in &self.feet[..self.count] {
            for (row, &dof) in foot.rows.iter().zip(model.path(foot.link)) {
                change[dof] += row.iter().zip(&foot.wrench).map(|(y, w)| y * w).sum::<f64>();
            }
        }
        factor.second_half_solve(model, change);
    }
}

impl Foot {
    /// Velocity of a point of it, given from O [m/s].
    fn velocity(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        let [straight, round] = halves(&self.motion);
        straight + round.cross(&(arm - self.sole.centre))
    }
}

fn six(straight: &Vector3<f64>, round: &Vector3<f64>) -> Six {
    [straight.x, straight.y, straight.z, round.x, round.y, round.z, 0.0, 0.0]
}

fn halves(six: &Six) -> [Vector3<f64>; 2] {
    [Vector3::new(six[0], six[1], six[2]), Vector3::new(six[3], six[4], six[5])]
}
