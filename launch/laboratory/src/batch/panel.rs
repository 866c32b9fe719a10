//! A panel of a map of survival: a square for each cell, and the survival contour.

use plotters::style::RGBColor;
use records::report::plot::{INK, Mark};

/// Margins of a panel: left, between panels, above and below [cells].
const GAP: [f64; 3] = [2.2, 1.7, 1.9];
/// Height of a row of cells, and of title and legend [px].
const ROW: [f64; 2] = [17.0, 110.0];
/// Opacity of a cell.
pub const STRENGTH: f64 = 0.45;
/// A cell lies within the survival contour if at least this share of its runs survives.
pub const MOST: f64 = 0.5;
/// Most columns for which every column has its value printed below it.
const LABELLED: usize = 12;

/// The places of panels of the same size.
pub struct Layout {
    count: usize,
    across: usize,
    /// Size of a panel with its margins [cells].
    size: (f64, f64),
}

/// One panel.
pub struct Panel<'a> {
    /// Title above it.
    pub title: &'a str,
    /// Names of its axes.
    pub names: [&'a str; 2],
    /// Values along x and y.
    pub values: [&'a [String]; 2],
    /// Lower left corner.
    pub corner: (f64, f64),
    /// Colour of the cell with these indices.
    pub colour: &'a dyn Fn(usize, usize) -> RGBColor,
    /// Share of its runs that survive; NaN if none was done.
    pub up: &'a dyn Fn(usize, usize) -> f64,
}

impl Layout {
    /// The layout of panels with this number of cells along x and y, with `across` panels in a row.
    pub fn new(count: usize, across: usize, [wide, tall]: [usize; 2]) -> Layout {
        Layout { count, across, size: (wide as f64 + GAP[0], tall as f64 + GAP[1] + GAP[2]) }
    }

    /// Lower left corner of a panel.
    pub fn corner(&self, panel: usize) -> (f64, f64) {
        let (wide, tall) = self.size;
        (
            (panel % self.across) as f64 * wide + GAP[0],
            -((panel / self.across) as f64) * tall - GAP[1] - tall + GAP[1] + GAP[2],
        )
    }

    /// Width and height of all panels [cells].
    pub fn extent(&self) -> (f64, f64) {
        (self.across as f64 * self.size.0 + 0.3, self.count.div_ceil(self.across) as f64 * self.size.1)
    }

    /// Height of the figure [px].
    pub fn height(&self) -> u32 {
        (ROW[0] * self.extent().1 + ROW[1]) as u32
    }
}

impl Panel<'_> {
    /// A point of the figure [px] from a point in units of cells.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (self.corner.0 + x, self.corner.1 + y)
    }

    /// Draws cells, labels and contour.
    pub fn draw(&self, marks: &mut Vec<Mark>) {
        let (wide, tall) = (self.values[0].len(), self.values[1].len());
        for j in 0..tall {
            for i in 0..wide {
                let (x, y) = (i as f64, j as f64);
                let square = [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)].map(|(x, y)| self.at(x, y));
                marks.push(Mark::area(square.to_vec(), (self.colour)(i, j)).faint(STRENGTH));
            }
        }
        for (i, value) in self.values[0].iter().enumerate().filter(|(k, _)| wide < LABELLED || k % 2 == 0) {
            marks.push(Mark::text(self.at(i as f64 + 0.5, -1.0), value.clone()));
        }
        for (j, value) in self.values[1].iter().enumerate() {
            marks.push(Mark::text(self.at(-0.5 * GAP[0], j as f64 + 0.1), value.clone()));
        }
        marks.push(Mark::text(self.at(wide as f64 / 2.0, tall as f64 + 0.1), self.title.into()));
        marks.push(Mark::text(self.at(wide as f64 / 2.0, -1.9), self.names[0].into()));
        marks.push(Mark::text(self.at(-0.5 * GAP[0], tall as f64 + 0.1), self.names[1].into()));
        marks.extend(self.contour().into_iter().map(|edge| Mark::line(edge.to_vec(), INK)));
    }

    /// Edges between cells inside and outside the survival contour.
    fn contour(&self) -> Vec<[(f64, f64); 2]> {
        let mut edges = Vec::new();
        for j in 0..self.values[1].len() {
            for i in 0..self.values[0].len() {
                let (x, y, here) = (i as f64, j as f64, (self.up)(i, j));
                if i > 0 && changes(here, (self.up)(i - 1, j)) {
                    edges.push([self.at(x, y), self.at(x, y + 1.0)]);
                }
                if j > 0 && changes(here, (self.up)(i, j - 1)) {
                    edges.push([self.at(x, y), self.at(x + 1.0, y)]);
                }
            }
        }
        edges
    }
}

/// Whether survival changes between two cells, by the shares of their runs that survive. It does not at a cell without runs.
pub fn changes(here: f64, there: f64) -> bool {
    !here.is_nan() && !there.is_nan() && (here >= MOST) != (there >= MOST)
}

/// A mix of colours by their shares.
pub fn mixed<const N: usize>(parts: [(RGBColor, f64); N]) -> RGBColor {
    let mix =
        |channel: fn(RGBColor) -> u8| parts.iter().map(|(part, share)| f64::from(channel(*part)) * share).sum::<f64>();
    RGBColor(mix(|c| c.0) as u8, mix(|c| c.1) as u8, mix(|c| c.2) as u8)
}
