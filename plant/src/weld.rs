//! Links that stand: where nothing slipped in the step before, every touching link is welded to the ground for the step.
//!
//! The contacts of a rigid link move with its six velocities: of their equations, three each, six are left, however many there are.
//! About a point c amid them the contacts at c + d_i with impulses f_i = Σ y_k e_k make the wrench w = Σ y_k g_k,
//! g_k = (e_k, d_i × e_k). With M = Σ g_k g_kᵀ and the links' velocities t at their c,
//!
//! ```text
//!   t = Λ w + t_free,   y_k = g_k·M⁻¹w
//! ```
//!
//! and w follows from t = t_wanted: no motion but the closing of gaps. Of all y with their wrench these have the least norm. What
//! Λ does not see (two feet pressed against each other) yields by a hair, as in the full problem: there each y by itself, which is
//! M⁻¹w here.
//!
//! Which directions e_k a contact pushes along, if it does, its basis says. Whether all this is so is not for this to say: what comes
//! out is judged by the residual of the full law.
//!
//! # Source
//! Λ = JH⁻¹Jᵀ: Khatib (1987), the operational-space inertia's inverse, here of every foot at once.

use crate::contact::{Growing, Problem, YIELD, dot, pushes};
use crate::delassus::ContactMap;
use crate::detect::Touch;
use crate::factor::Factor;
use crate::kinematics::Pose;
use crate::model::Model;
use crate::spatial::Spatial;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Velocities of a rigid link.
const SIX: usize = 6;
/// A determinant this small beside the cube of the trace: these contacts hold a foot in five directions alone.
const DEPENDENT: f64 = 1e-9;
/// Refinements at most: they undo the yielding wherever B allows.
const REFINEMENTS: usize = 3;

/// A link on its contacts.
#[derive(Clone, Debug)]
struct Foot {
    touches: Range<usize>,
    /// c, from O [m].
    centre: Vector3<f64>,
    /// M⁻¹.
    share: Blocks,
}

/// A symmetric matrix over wrenches or velocities: force on force, force on moment, moment on moment.
#[derive(Clone, Copy, Debug, Default)]
struct Blocks {
    straight: Matrix3<f64>,
    mixed: Matrix3<f64>,
    round: Matrix3<f64>,
}

/// The reduced problem, and the full solution that it makes.
#[derive(Clone, Debug, Default)]
pub struct Weld {
    feet: Vec<Foot>,
    /// Λ, row by row.
    mobility: Vec<f64>,
    /// The same with what yields.
    matrix: Vec<f64>,
    factor: Growing,
    /// Of every foot t_free, t_wanted and t [m/s, rad/s].
    free: Vec<f64>,
    wanted: Vec<f64>,
    motion: Vec<f64>,
    correction: Vec<f64>,
    /// w of every foot [N·s, N·m·s].
    pub wrench: Vec<f64>,
    /// The rows of the full problem: A_kk [1/kg] …
    pub diagonal: Vec<f64>,
    /// … impulse [N·s] …
    pub impulse: Vec<f64>,
    /// … and velocity [m/s].
    pub velocity: Vec<f64>,
}

impl Weld {
    /// Finds the feet, their free motion, Λ, and A_kk. `free` is the velocity of the step without contact.
    pub fn reduce(
        &mut self,
        model: &Model,
        pose: &Pose,
        factor: &Factor,
        touches: &[Touch],
        free: &[f64],
        map: &mut ContactMap,
    ) {
        self.feet.clear();
        self.free.clear();
        map.clear();
        let mut first = 0;
        for touches in touches.chunk_by(|a, b| a.link == b.link) {
            let link = touches[0].link;
            let centre = touches.iter().map(|touch| touch.arm).sum::<Vector3<f64>>() / touches.len() as f64;
            let at_centre = |motion: &Spatial| {
                let (straight, round) = (motion.at(&centre), motion.angular);
                [straight.x, straight.y, straight.z, round.x, round.y, round.z]
            };
            map.add(model, pose, factor, link, SIX, |motion, k| k[..SIX].copy_from_slice(&at_centre(motion)));
            self.free.extend(at_centre(&pose.twist(model, link, free)));
            let touches = first..first + touches.len();
            first = touches.end;
            self.feet.push(Foot { touches, centre, share: Blocks::default() });
        }
        let size = SIX * self.feet.len();
        self.mobility.clear();
        self.mobility.resize(size * size, 0.0);
        map.multiply(model, size, &mut self.mobility);
        self.diagonal.clear();
        for (foot, at) in self.feet.iter().zip((0..).step_by(SIX)) {
            let mobility = Blocks::of(size, &self.mobility, at);
            for i in foot.touches.clone() {
                let of_point = mobility.at(&(touches[i].arm - foot.centre));
                self.diagonal.extend(map.axes(i).map(|e| e.dot(&(of_point * e))));
            }
        }
    }

    /// Impulse and velocity if every foot stays where it is and each contact pushes as its basis says; false if these cannot hold a
    /// foot.
    pub fn hold(&mut self, touches: &[Touch], problem: &Problem, map: &ContactMap, basis: &[u8]) -> bool {
        let held = self.grip(touches, problem, map, basis) && self.resolve();
        if held {
            self.distribute(touches, problem, map, basis);
        }
        held
    }

    /// M⁻¹ and t_wanted of every foot.
    fn grip(&mut self, touches: &[Touch], problem: &Problem, map: &ContactMap, basis: &[u8]) -> bool {
        self.wanted.clear();
        for foot in &mut self.feet {
            let (mut spread, mut force, mut moment) = (Blocks::default(), Vector3::zeros(), Vector3::zeros());
            for i in foot.touches.clone() {
                let (mut along, mut sink) = (Matrix3::zeros(), Vector3::zeros());
                for push in pushes(basis[i], problem.friction[i]) {
                    let e = map.direction(i, &push);
                    along += e * e.transpose();
                    sink -= e * (push[0] * problem.approach[i]);
                }
                let d = touches[i].arm - foot.centre;
                let turn = d.cross_matrix();
                let turned = turn * along;
                spread.straight += along;
                spread.mixed -= along * turn;
                spread.round -= turned * turn;
                force += sink;
                moment += d.cross(&sink);
            }
            let Some(share) = spread.inverse() else { return false };
            foot.share = share;
            let (straight, round) = share.times(&force, &moment);
            self.wanted.extend(straight.iter().chain(&round));
        }
        true
    }

    /// w for t = t_wanted, and t; false if Λ is not that of a body.
    fn resolve(&mut self) -> bool {
        let size = SIX * self.feet.len();
        let give = YIELD * self.diagonal.iter().sum::<f64>() / self.diagonal.len() as f64;
        self.matrix.clone_from(&self.mobility);
        for (foot, at) in self.feet.iter().zip((0..).step_by(SIX)) {
            foot.share.add(give, size, &mut self.matrix, at);
        }
        if !self.factor.factorize(size, &self.matrix) {
            return false;
        }
        let (mut before, mut scale) = (f64::INFINITY, 0.0);
        self.wrench.clear();
        self.wrench.resize(size, 0.0);
        for _ in 0..=REFINEMENTS {
            self.motion.clear();
            let rows = self.mobility.chunks_exact(size).zip(&self.free);
            self.motion.extend(rows.map(|(row, free)| free + dot(row, &self.wrench)));
            self.correction.clear();
            self.correction.extend(self.wanted.iter().zip(&self.motion).map(|(wanted, t)| wanted - t));
            let left = self.correction.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
            scale = f64::max(scale, left);
            if left <= 4.0 * f64::EPSILON * scale || left > 0.1 * before {
                break;
            }
            before = left;
            self.factor.solve(&mut self.correction);
            self.wrench.iter_mut().zip(&self.correction).for_each(|(w, change)| *w += change);
        }
        true
    }

    /// What that is at every contact.
    fn distribute(&mut self, touches: &[Touch], problem: &Problem, map: &ContactMap, basis: &[u8]) {
        self.impulse.clear();
        self.velocity.clear();
        for (foot, at) in self.feet.iter().zip((0..).step_by(SIX)) {
            let pair = |list: &[f64]| [at, at + 3].map(|k| Vector3::new(list[k], list[k + 1], list[k + 2]));
            let ([force, moment], [straight, round]) = (pair(&self.wrench), pair(&self.motion));
            let pull = foot.share.times(&force, &moment);
            for i in foot.touches.clone() {
                let d = touches[i].arm - foot.centre;
                let (pull, velocity) = (pull.0 + pull.1.cross(&d), straight + round.cross(&d));
                let impulse = pushes(basis[i], problem.friction[i]).fold([0.0; 3], |sum, push| {
                    let amount = map.direction(i, &push).dot(&pull);
                    std::array::from_fn(|row| sum[row] + push[row] * amount)
                });
                self.impulse.extend(impulse);
                self.velocity.extend(map.axes(i).map(|e| velocity.dot(&e)));
            }
        }
    }
}

impl Blocks {
    /// Those at a place on the diagonal of a matrix.
    fn of(size: usize, matrix: &[f64], at: usize) -> Blocks {
        let block = |row: usize, column: usize| Matrix3::from_fn(|r, c| matrix[(row + r) * size + column + c]);
        Blocks { straight: block(at, at), mixed: block(at, at + 3), round: block(at + 3, at + 3) }
    }

    /// Adds so much of them there.
    fn add(&self, factor: f64, size: usize, matrix: &mut [f64], at: usize) {
        let blocks = [(at, at, self.straight), (at + 3, at, self.mixed.transpose()), (at + 3, at + 3, self.round)];
        for (row, column, block) in blocks {
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                matrix[(row + r) * size + column + c] += factor * block[(r, c)]; // no more than the lower half is read
            }
        }
    }

    /// Of a push and a velocity at d: (1, d×)ᵀ M (1, d×).
    fn at(&self, d: &Vector3<f64>) -> Matrix3<f64> {
        let turn = d.cross_matrix();
        let mixed = self.mixed * turn;
        self.straight + mixed + mixed.transpose() + turn.tr_mul(&(self.round * turn))
    }

    /// Product with (force, moment).
    fn times(&self, straight: &Vector3<f64>, round: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (self.straight * straight + self.mixed * round, self.mixed.tr_mul(straight) + self.round * round)
    }

    /// Inverse, by that of what the moments leave; none if that is singular.
    fn inverse(&self) -> Option<Blocks> {
        let straight = regular_inverse(&self.straight, self.straight.trace())?;
        let across = straight * self.mixed;
        let round = regular_inverse(&(self.round - self.mixed.tr_mul(&across)), self.round.trace())?;
        let mixed = -across * round;
        Some(Blocks { straight: straight - mixed * across.transpose(), mixed, round })
    }
}

/// Inverse of a symmetric matrix, unless its determinant is no more than rounding beside such a trace.
fn regular_inverse(matrix: &Matrix3<f64>, trace: f64) -> Option<Matrix3<f64>> {
    matrix.try_inverse().filter(|_| matrix.determinant() > DEPENDENT * trace.powi(3))
}
