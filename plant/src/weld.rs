//! Links that stand: where nothing slipped in the step before, every touching link is welded to the ground for the step.
//!
//! The contacts of a rigid link move with its six velocities: of their equations, three each, six are left, however many there are.
//! About a point c amid them the contacts at c + d_i with impulses f_i = Σ y_k e_k make the wrench w = Σ y_k g_k,
//! g_k = (e_k, d_i × e_k). With M = Σ g_k g_kᵀ = C Cᵀ and the link's velocity t at c,
//!
//! ```text
//!   w = C z,   s = Cᵀt,   w·t = z·s,   s = B z + s_free,   B = CᵀΛC,   y_k = g_k·C⁻ᵀz
//! ```
//!
//! and z follows from s = s_wanted: no motion but the closing of gaps. Of all y with their wrench these have the least norm. What
//! B does not see (two feet pressed against each other) yields by a hair, as in the full problem.
//!
//! Which directions e_k a contact pushes along, if it does, its basis says. Whether all this is so is not for this to say: what comes
//! out is judged by the residual of the full law.
//!
//! # Source
//! Λ = JH⁻¹Jᵀ: Khatib (1987), the operational-space inertia's inverse, here of every foot at once.

use crate::contact::{Problem, Spd, YIELD, dot, pushes};
use crate::delassus::ContactMap;
use crate::detect::Touch;
use crate::factor::Factor;
use crate::kinematics::Pose;
use crate::model::Model;
use crate::spatial::Spatial;
use nalgebra::{Matrix6, Vector3, Vector6};
use std::ops::Range;

/// Velocities of a rigid link.
const SIX: usize = 6;
/// A pivot this small beside its diagonal entry: these contacts hold a foot in five directions alone.
const DEPENDENT: f64 = 1e-6;
/// Refinements at most: they undo the yielding wherever B allows.
const REFINEMENTS: usize = 3;

/// A link on its contacts.
#[derive(Clone, Debug)]
struct Foot {
    touches: Range<usize>,
    /// c, from O [m].
    centre: Vector3<f64>,
    /// t_free: its velocity if nothing touched.
    free: Vector6<f64>,
    /// C, and its inverse.
    spread: Matrix6<f64>,
    inverse: Matrix6<f64>,
}

/// The reduced problem, and the full solution that it makes.
#[derive(Clone, Debug, Default)]
pub struct Weld {
    feet: Vec<Foot>,
    /// Λ, row by row.
    mobility: Vec<f64>,
    /// B, likewise.
    matrix: Vec<f64>,
    spd: Spd,
    /// s_free, s_wanted, s and z.
    free: Vec<f64>,
    wanted: Vec<f64>,
    motion: Vec<f64>,
    effort: Vec<f64>,
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
    /// Finds the feet, their free motion, and Λ. `free` is the velocity of the step without contact.
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
            let free = at_centre(&pose.twist(model, link, free)).into();
            let (spread, inverse) = (Matrix6::zeros(), Matrix6::zeros());
            self.feet.push(Foot { touches: first..first + touches.len(), centre, free, spread, inverse });
            first += touches.len();
        }
        let size = SIX * self.feet.len();
        self.mobility.clear();
        self.mobility.resize(size * size, 0.0);
        map.multiply(model, size, &mut self.mobility);
    }

    /// Impulse and velocity if every foot stays where it is and each contact pushes as its basis says; false if these cannot hold a
    /// foot.
    pub fn hold(&mut self, touches: &[Touch], problem: &Problem, map: &ContactMap, basis: &[u8]) -> bool {
        self.grip(touches, problem, map, basis)
            && {
                self.transform();
                self.resolve(problem.contacts)
            }
            && {
                self.distribute(touches, problem, map, basis);
                true
            }
    }

    /// C of every foot, s_free and s_wanted.
    fn grip(&mut self, touches: &[Touch], problem: &Problem, map: &ContactMap, basis: &[u8]) -> bool {
        self.free.clear();
        self.wanted.clear();
        for foot in &mut self.feet {
            let (mut spread, mut sink, mut count) = (Matrix6::zeros(), Vector6::zeros(), 0);
            for i in foot.touches.clone() {
                let d = touches[i].arm - foot.centre;
                for push in pushes(basis[i], problem.friction[i]) {
                    let g = wrench(&d, &map.direction(i, &push));
                    spread.syger(1.0, &g, &g, 1.0);
                    sink -= g * (push[0] * problem.approach[i]);
                    count += 1;
                }
            }
            let Some(cholesky) = (count >= SIX).then(|| spread.cholesky()).flatten() else { return false };
            foot.spread = cholesky.unpack();
            if (0..SIX).any(|k| foot.spread[(k, k)].powi(2) < DEPENDENT * spread[(k, k)]) {
                return false;
            }
            foot.inverse = Matrix6::identity();
            foot.spread.solve_lower_triangular_mut(&mut foot.inverse);
            self.free.extend(foot.spread.tr_mul(&foot.free).iter());
            self.wanted.extend((foot.inverse * sink).iter());
        }
        true
    }

    /// B = CᵀΛC.
    fn transform(&mut self) {
        let size = SIX * self.feet.len();
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        for (a, i) in self.feet.iter().zip((0..).step_by(SIX)) {
            for (b, j) in self.feet.iter().zip((0..=i).step_by(SIX)) {
                let block = Matrix6::from_fn(|r, c| self.mobility[(i + r) * size + j + c]);
                let block = a.spread.tr_mul(&(block * b.spread));
                for (r, c) in (0..SIX).flat_map(|r| (0..SIX).map(move |c| (r, c))) {
                    self.matrix[(i + r) * size + j + c] = block[(r, c)];
                    self.matrix[(j + c) * size + i + r] = block[(r, c)];
                }
            }
        }
    }

    /// z for s = s_wanted, and s; false if B is not that of a body.
    fn resolve(&mut self, contacts: usize) -> bool {
        let size = self.free.len();
        let mean = self.matrix.iter().step_by(size + 1).sum::<f64>() / (3 * contacts) as f64; // B has the trace of A
        if !self.spd.factorize(size, &self.matrix, YIELD * mean) {
            return false;
        }
        self.effort.clear();
        self.effort.resize(size, 0.0);
        self.motion.clone_from(&self.free);
        let (mut before, mut scale) = (f64::INFINITY, 0.0);
        for _ in 0..=REFINEMENTS {
            self.correction.clear();
            self.correction.extend(self.wanted.iter().zip(&self.motion).map(|(wanted, s)| wanted - s));
            let left = self.correction.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
            scale = f64::max(scale, left);
            if left <= 4.0 * f64::EPSILON * scale || left > 0.1 * before {
                break;
            }
            before = left;
            self.spd.solve(&mut self.correction);
            self.effort.iter_mut().zip(&self.correction).for_each(|(z, change)| *z += change);
            self.motion.clear();
            let rows = self.matrix.chunks_exact(size).zip(&self.free);
            self.motion.extend(rows.map(|(row, free)| free + dot(row, &self.effort)));
        }
        true
    }

    /// What that is at every contact, and how easily each moves.
    fn distribute(&mut self, touches: &[Touch], problem: &Problem, map: &ContactMap, basis: &[u8]) {
        let size = self.free.len();
        for list in [&mut self.wrench, &mut self.diagonal, &mut self.impulse, &mut self.velocity] {
            list.clear();
        }
        for (foot, at) in self.feet.iter().zip((0..).step_by(SIX)) {
            let [effort, motion] =
                [&self.effort, &self.motion].map(|list| Vector6::from_column_slice(&list[at..at + SIX]));
            self.wrench.extend((foot.spread * effort).iter());
            let [pull, motion] = [effort, motion].map(|list| foot.inverse.tr_mul(&list));
            let mobility = Matrix6::from_fn(|r, c| self.mobility[(at + r) * size + at + c]);
            for i in foot.touches.clone() {
                let d = touches[i].arm - foot.centre;
                let [pull, velocity] = [pull, motion].map(|t| t.fixed_rows::<3>(0) + t.fixed_rows::<3>(3).cross(&d));
                let impulse = pushes(basis[i], problem.friction[i]).fold([0.0; 3], |sum, push| {
                    let amount = map.direction(i, &push).dot(&pull);
                    std::array::from_fn(|row| sum[row] + push[row] * amount)
                });
                for (e, impulse) in map.axes(i).into_iter().zip(impulse) {
                    let g = wrench(&d, &e);
                    self.diagonal.push(g.dot(&(mobility * g)));
                    self.impulse.push(impulse);
                    self.velocity.push(velocity.dot(&e));
                }
            }
        }
    }
}

/// The wrench about c of a unit push along e at c + d.
fn wrench(d: &Vector3<f64>, e: &Vector3<f64>) -> Vector6<f64> {
    let round = d.cross(e);
    Vector6::new(e.x, e.y, e.z, round.x, round.y, round.z)
}
