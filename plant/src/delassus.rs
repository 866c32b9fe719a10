//! The contact problem of a step, (12)-(14): K, the Delassus matrix A = KᵀH⁻¹K, and b = Kᵀ(ẋ₋ + H⁻¹Δf_b).
//!
//! The same degrees of freedom, those of the link's path, move all contacts of a link. So their columns of K are stored side by side and
//! pass the factor L of H together: Y = √D⁻¹L⁻ᵀK and A = YᵀY. After the solution, H⁻¹KΔf = L⁻¹√D⁻¹(YΔf).

use crate::contact::{Problem, has_basis, tangents};
use crate::detect::Touch;
use crate::factor::Factor;
use crate::kinematics::Pose;
use crate::model::Model;
use crate::spatial::Spatial;
use messages::scene::Law;
use nalgebra::Vector3;
use std::ops::Range;

/// Columns per block: those of a foot with four contacts, in three vector registers.
const PANEL: usize = 12;
/// Rows per tile of the product.
const ROWS: usize = 4;

/// The motion without contact, and the factor of H that maps forces to motion.
#[derive(Clone, Copy, Debug)]
pub struct Free<'a> {
    /// Pose of the robot.
    pub pose: &'a Pose,
    /// Factors of H at that pose.
    pub factor: &'a Factor,
    /// Velocity at the end of the step without contact, ẋ₋ + H⁻¹Δf_b; between events the acceleration.
    pub rate: &'a [f64],
}

/// Contact impulses and the velocity change that they cause.
#[derive(Clone, Copy, Debug)]
pub struct Response<'a> {
    /// H⁻¹KΔf.
    pub change: &'a [f64],
    /// Impulse on each contact, in W [N·s].
    pub impulses: &'a [Vector3<f64>],
}

/// The contact problem, and Y = √D⁻¹L⁻ᵀK, link by link.
#[derive(Clone, Debug)]
pub struct ContactMap {
    /// The problem (14).
    pub problem: Problem,
    groups: Vec<LinkColumns>,
    /// Y of each link, [`PANEL`] columns per block; the last is padded with zeros.
    blocks: Vec<[f64; PANEL]>,
    /// Force and moment about O of a unit impulse along each column of a link, [`PANEL`] columns at a time.
    wrenches: Vec<[[f64; PANEL]; 6]>,
    /// Unit tangents of each contact.
    tangents: Vec<[Vector3<f64>; 2]>,
    /// The last response.
    change: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
}

/// The contacts of one link, as columns of K.
#[derive(Clone, Debug)]
struct LinkColumns {
    link: usize,
    /// Rows of these contacts in the problem, which are their columns in K.
    columns: Range<usize>,
    /// Index of the first block.
    start: usize,
    /// Blocks per column: one for each degree of freedom that moves them, at least one.
    height: usize,
}

impl ContactMap {
    /// Allocates for a model.
    pub fn new(model: &Model) -> Self {
        let points = model.contact_points.len();
        let mut problem = Problem::default();
        problem.reset(points, model.directions);
        problem.link.reserve(points);
        problem.slip.reserve(points);
        ContactMap {
            problem,
            groups: Vec::with_capacity(points),
            blocks: Vec::with_capacity(points * model.dofs()),
            wrenches: Vec::with_capacity(points),
            tangents: Vec::with_capacity(points),
            change: vec![0.0; model.dofs()],
            impulses: Vec::with_capacity(points),
        }
    }

    /// Sets up the problem of the touching contacts without A: identities and b = Kᵀfree. `replaced(i, Kᵀfree)` gives the drift of contact
    /// i.
    ///
    /// The first tangent of a contact is the direction of its free slip, so that friction opposes it exactly. The paper takes the direction
    /// of the velocity before the step. A contact at rest has none, so it would creep down any slope.
    pub fn drift(
        &mut self,
        model: &Model,
        free: &Free,
        touches: &[Touch],
        law: Law,
        replaced: impl Fn(usize, Vector3<f64>) -> Vector3<f64>,
    ) -> &mut Problem {
        let problem = &mut self.problem;
        let tangents = tangents(law).min(model.directions);
        let rows = 1 + tangents;
        problem.reset_rows(touches.len(), tangents);
        self.tangents.clear();
        for touches in touches.chunk_by(|a, b| a.link == b.link) {
            let twist = free.pose.twist(model, touches[0].link, free.rate);
            let first = self.tangents.len();
            for (i, touch) in touches.iter().enumerate() {
                problem.id[first + i] = touch.id;
                problem.link.push(touch.link);
                let drift = replaced(first + i, twist.at(&touch.arm));
                let [along, across] = tangents_of(&drift, law);
                let at = self.tangents.len() * rows;
                self.tangents.push([along, across]);
                let drift = [drift.z, drift.dot(&along), drift.dot(&across)];
                problem.drift[at..at + rows].copy_from_slice(&drift[..rows]);
            }
        }
        problem
    }

    /// The whole problem (14) of contact points with the same friction coefficient [-], at the velocity without contact.
    pub fn set_up(&mut self, model: &Model, free: &Free, touches: &[Touch], law: Law, friction: f64) -> &Problem {
        let problem = self.drift(model, free, touches, law, |_, drift| drift);
        problem.friction.fill(friction);
        problem.approach.iter_mut().zip(touches).for_each(|(approach, touch)| *approach = touch.approach);
        self.assemble(model, free, touches)
    }

    /// Adds A to the problem.
    pub fn assemble(&mut self, model: &Model, free: &Free, touches: &[Touch]) -> &Problem {
        let ContactMap { problem, groups, blocks, wrenches, tangents, .. } = self;
        let rows = 1 + problem.tangents;
        groups.clear();
        blocks.clear();
        let mut first = 0;
        for touches in touches.chunk_by(|a, b| a.link == b.link) {
            let (link, tangents) = (touches[0].link, &tangents[first..first + touches.len()]);
            let columns = first * rows..(first + touches.len()) * rows;
            first += touches.len();
            let (path, start, width) = (model.path(link), blocks.len(), columns.len().div_ceil(PANEL));
            let height = path.len().max(1);
            blocks.resize(start + height * width, [0.0; PANEL]);
            wrenches.clear();
            wrenches.resize(width, [[0.0; PANEL]; 6]);
            for (i, (touch, [along, across])) in touches.iter().zip(tangents).enumerate() {
                for (column, n) in (i * rows..).zip([Vector3::z(), *along, *across].iter().take(rows)) {
                    let (wrench, m) = (&mut wrenches[column / PANEL], touch.arm.cross(n));
                    wrench.iter_mut().zip(n.iter().chain(&m)).for_each(|(part, x)| part[column % PANEL] = *x);
                }
            }
            let y = &mut blocks[start..];
            for (depth, &dof) in path.iter().enumerate() {
                let Spatial { linear, angular } = free.pose.links[dof + 1].column;
                let [a, b, c, d, e, f] = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
                for (y, [w0, w1, w2, w3, w4, w5]) in y[depth..].iter_mut().step_by(height).zip(&*wrenches) {
                    // power per unit rate; by virtual work these are the entries of K
                    *y = std::array::from_fn(|k| {
                        let force = c.mul_add(w2[k], b.mul_add(w1[k], a * w0[k]));
                        f.mul_add(w5[k], e.mul_add(w4[k], d * w3[k])) + force
                    });
                }
            }
            free.factor.half_solve(model, link, y);
            groups.push(LinkColumns { link, columns, start, height });
        }
        let size = problem.rows();
        problem.delassus.resize(size * size, 0.0);
        multiply(model, groups, blocks, size, &mut problem.delassus);
        problem
    }

    /// Velocity change and impulses in W of a solution.
    pub fn respond(&mut self, model: &Model, factor: &Factor, impulse: &[f64]) -> Response<'_> {
        let ContactMap { problem, groups, blocks, tangents, change, impulses, .. } = self;
        change.fill(0.0);
        for group in &*groups {
            for (column, blocks) in group.columns(blocks) {
                let impulse = &impulse[column..group.columns.end];
                for (y, &dof) in blocks.iter().zip(model.path(group.link)) {
                    change[dof] += y.iter().zip(impulse).map(|(y, f)| y * f).sum::<f64>();
                }
            }
        }
        factor.second_half_solve(model, change);
        impulses.clear();
        impulses.extend(impulse.chunks_exact(1 + problem.tangents).zip(&*tangents).map(|(parts, tangents)| {
            parts[1..].iter().zip(tangents).fold(Vector3::z() * parts[0], |sum, (f, t)| sum + t * *f)
        }));
        Response { change, impulses }
    }
}

impl LinkColumns {
    /// Blocks of Y with the index of their first column. In each block, the base comes first.
    fn columns<'a>(&self, blocks: &'a [[f64; PANEL]]) -> impl Iterator<Item = (usize, &'a [[f64; PANEL]])> + use<'a> {
        let count = self.columns.len().div_ceil(PANEL);
        let blocks = blocks[self.start..].chunks_exact(self.height).take(count);
        self.columns.clone().step_by(PANEL).zip(blocks)
    }
}

/// A = YᵀY. The columns of two links share the blocks of their common degrees of freedom.
fn multiply(model: &Model, groups: &[LinkColumns], blocks: &[[f64; PANEL]], size: usize, product: &mut [f64]) {
    for (i, a) in groups.iter().enumerate() {
        for b in &groups[..=i] {
            let shared = model.shared(a.link, b.link);
            for (row, y_a) in a.columns(blocks) {
                for (column, y_b) in b.columns(blocks).take_while(|(column, _)| *column <= row) {
                    for first in (0..a.columns.end - row).step_by(ROWS).take(PANEL / ROWS) {
                        let tile = tile(&y_a[..shared], first, &y_b[..shared]);
                        let place = (row + first..a.columns.end, column..b.columns.end);
                        write(&tile, place, column < row, size, product);
                    }
                }
            }
        }
    }
}

/// Σ y_a y_bᵀ for some columns of y_a.
#[inline(never)] // inlined, it would not use whole vector registers
fn tile(y_a: &[[f64; PANEL]], first: usize, y_b: &[[f64; PANEL]]) -> [[f64; PANEL]; ROWS] {
    let mut tile = [[0.0; PANEL]; ROWS];
    for (y_a, y_b) in y_a.iter().zip(y_b) {
        for (row, y) in tile.iter_mut().zip(&y_a[first..first + ROWS]) {
            *row = std::array::from_fn(|c| y.mul_add(y_b[c], row[c]));
        }
    }
    tile
}

/// Writes the part of a tile that lies inside the product, and its transpose if `mirrored`.
fn write(
    tile: &[[f64; PANEL]; ROWS],
    (rows, columns): (Range<usize>, Range<usize>),
    mirrored: bool,
    size: usize,
    product: &mut [f64],
) {
    for (r, tile) in rows.zip(tile) {
        let line = &mut product[r * size..][columns.clone()];
        match line.first_chunk_mut() {
            Some(line) => *line = *tile,
            None => line.copy_from_slice(&tile[..line.len()]),
        }
        if mirrored {
            columns.clone().zip(tile).for_each(|(c, entry)| product[c * size + r] = *entry);
        }
    }
}

/// Tangents along and across the free slip; along the axes of W for laws whose tangents do not follow the slip.
fn tangents_of(drift: &Vector3<f64>, law: Law) -> [Vector3<f64>; 2] {
    let slip = drift.xy().norm();
    let along = match slip > 0.0 && has_basis(law) {
        true => Vector3::new(drift.x / slip, drift.y / slip, 0.0),
        false => Vector3::x(),
    };
    [along, Vector3::new(-along.y, along.x, 0.0)]
}
