//! The contact problem of a step, (12)-(14): K, A = KᵀH⁻¹K and b = Kᵀ(ẋ₋ + H⁻¹Δf_b).
//!
//! The contacts of one link are moved by the same degrees of freedom, those of the link's path, so their columns of K stand side
//! by side and go through the factor L of H together: Y = √D⁻¹L⁻ᵀK, A = YᵀY, and after the solution
//! H⁻¹KΔf = L⁻¹√D⁻¹(YΔf).

use crate::contact::{Problem, has_basis, tangents};
use crate::detect::Touch;
use crate::factor::Factor;
use crate::kinematics::Pose;
use crate::model::Model;
use crate::spatial::Spatial;
use messages::scene::Law;
use nalgebra::Vector3;
use std::ops::Range;

/// Columns that are worked on at once: those of a foot of four corners, three registers full.
const PANEL: usize = 12;
/// Rows of their products that are.
const ROWS: usize = 4;

/// The motion without contact, and what turns forces into motion.
#[derive(Clone, Copy, Debug)]
pub struct Free<'a> {
    /// Where the robot is.
    pub pose: &'a Pose,
    /// L and D of H there.
    pub factor: &'a Factor,
    /// The velocity that the step would end with if nothing touched, ẋ₋ + H⁻¹Δf_b; between events the acceleration.
    pub rate: &'a [f64],
}

/// Impulses, and what they do.
#[derive(Clone, Copy, Debug)]
pub struct Response<'a> {
    /// H⁻¹KΔf.
    pub change: &'a [f64],
    /// Impulse on each contact, in W [N·s].
    pub impulses: &'a [Vector3<f64>],
}

/// The problem of the touching contacts, and Y = √D⁻¹L⁻ᵀK, link by link.
#[derive(Clone, Debug)]
pub struct ContactMap {
    /// (14).
    pub problem: Problem,
    groups: Vec<LinkColumns>,
    /// Y of each group, [`PANEL`] columns at a time; what fills up the last is zero.
    blocks: Vec<[f64; PANEL]>,
    /// Force and moment about O of a unit impulse along each column of a link, [`PANEL`] columns at a time.
    wrenches: Vec<[[f64; PANEL]; 6]>,
    /// Unit tangents of each contact.
    tangents: Vec<[Vector3<f64>; 2]>,
    /// The last response.
    change: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
}

/// The contacts of one link.
#[derive(Clone, Debug)]
struct LinkColumns {
    link: usize,
    /// Their rows in the problem, which are their columns in K.
    columns: Range<usize>,
    /// First of their blocks.
    start: usize,
    /// Blocks of a column: one for each degree of freedom that moves them, or an empty one.
    height: usize,
}

impl ContactMap {
    /// Room for a model.
    pub fn new(model: &Model) -> Self {
        let points = model.contact_points.len();
        ContactMap {
            problem: Problem::default(),
            groups: Vec::with_capacity(points),
            blocks: Vec::with_capacity(points * model.dofs()),
            wrenches: Vec::with_capacity(points),
            tangents: Vec::with_capacity(points),
            change: vec![0.0; model.dofs()],
            impulses: Vec::with_capacity(points),
        }
    }

    /// What the problem of the touching contacts has beside A: who they are and b = Kᵀfree. What it makes of contact i is replaced by
    /// `replaced(i, Kᵀfree)`.
    ///
    /// The first tangent of a contact is its direction of free slip, so that friction can oppose it exactly. The paper
    /// takes the velocity before the step; a contact at rest has none, and would creep down any slope.
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

    /// The same problem with A.
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
                    // its power per unit rate: by virtual work, K's entries
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

    /// What the impulses of a solution do, as rows of the problem.
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
    /// Its Y, [`PANEL`] columns at a time: the first of them, and their blocks, base first.
    fn columns<'a>(&self, blocks: &'a [[f64; PANEL]]) -> impl Iterator<Item = (usize, &'a [[f64; PANEL]])> + use<'a> {
        let count = self.columns.len().div_ceil(PANEL);
        let blocks = blocks[self.start..].chunks_exact(self.height).take(count);
        self.columns.clone().step_by(PANEL).zip(blocks)
    }
}

/// A = YᵀY: two links meet in the degrees of freedom that they share.
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

/// Σ y_a y_bᵀ, of some columns of y_a.
#[inline(never)] // or its sums are not worked on in whole registers
fn tile(y_a: &[[f64; PANEL]], first: usize, y_b: &[[f64; PANEL]]) -> [[f64; PANEL]; ROWS] {
    let mut tile = [[0.0; PANEL]; ROWS];
    for (y_a, y_b) in y_a.iter().zip(y_b) {
        for (row, y) in tile.iter_mut().zip(&y_a[first..first + ROWS]) {
            *row = std::array::from_fn(|c| y.mul_add(y_b[c], row[c]));
        }
    }
    tile
}

/// Writes a tile to where it belongs in the product, whatever of it does; and its mirror image to where that belongs.
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

/// Along the free slip and across it; along the axes of W for a law whose tangents do not follow the slip.
fn tangents_of(drift: &Vector3<f64>, law: Law) -> [Vector3<f64>; 2] {
    let slip = drift.xy().norm();
    let along = match slip > 0.0 && has_basis(law) {
        true => Vector3::new(drift.x / slip, drift.y / slip, 0.0),
        false => Vector3::x(),
    };
    [along, Vector3::new(-along.y, along.x, 0.0)]
}
