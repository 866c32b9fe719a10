//! The map: a panel for each loss, with delay as x and jitter as y. It shows the share of runs without a fall, the survival contour,
//! and the stability limit of the servo alone.

use super::cells::{Cell, Cells};
use super::grid::Grid;
use plotters::style::RGBColor;
use records::report::draw::plot;
use records::report::plot::{Axis, COM, Frame, GREEN, INK, Mark, RIGHT, ZMP};

/// Panels in a row.
const ACROSS: usize = 2;
/// Margins of a panel: left, between panels, above and below [cells].
const GAP: [f64; 3] = [2.2, 1.7, 1.9];
/// Height of a row of cells, and of title and legend [px].
const ROW: [f64; 2] = [17.0, 110.0];
/// Opacity of a cell.
const STRENGTH: f64 = 0.45;
/// A cell lies within the survival contour if at least this share of its runs ends without a fall.
const MOST: f64 = 0.5;

/// The map of survival.
pub fn survival(grid: &Grid, cells: &Cells) -> String {
    let mut marks: Vec<Mark> = legend().into();
    let (wide, tall) = (grid.delays.len() as f64 + GAP[0], grid.jitters.len() as f64 + GAP[1] + GAP[2]);
    let panels: Vec<_> = (0..grid.variations.len()).flat_map(|v| (0..grid.losses.len()).map(move |l| (v, l))).collect();
    for (i, &(variation, loss)) in panels.iter().enumerate() {
        let corner =
            ((i % ACROSS) as f64 * wide + GAP[0], -((i / ACROSS) as f64) * tall - GAP[1] - tall + GAP[1] + GAP[2]);
        let panel = MapPanel { grid, cells, variation, loss, corner };
        panel.draw(&mut marks);
    }
    let rows = panels.len().div_ceil(ACROSS) as f64;
    let frame = Frame {
        title: "How much delay, jitter and loss of commands the walk tolerates".into(),
        height: (ROW[0] * rows * tall + ROW[1]) as u32,
        x: Axis::hidden(0.0..ACROSS as f64 * wide + 0.3),
        y: Axis::hidden(-rows * tall..0.0),
    };
    plot(&frame, &marks)
}

/// Invisible marks that make the entries of the legend.
fn legend() -> [Mark; 5] {
    let speck = vec![(0.0, 0.0); 2];
    let area = |colour| Mark::area(speck.clone(), colour).faint(STRENGTH);
    [
        area(GREEN).label("walks evenly"),
        area(RIGHT).label("staggers"),
        area(ZMP).label("falls"),
        Mark::line(speck.clone(), INK).label("half of the runs stay up"),
        Mark::dashes(speck.clone(), COM).label("commands as old on average as the servo bears, by linear analysis"),
    ]
}

/// One panel.
struct MapPanel<'a> {
    grid: &'a Grid,
    cells: &'a Cells,
    variation: usize,
    loss: usize,
    /// Lower left corner.
    corner: (f64, f64),
}

impl MapPanel<'_> {
    fn cell(&self, jitter: usize, delay: usize) -> &Cell {
        self.cells.at(self.grid, self.variation, self.loss, jitter, delay)
    }

    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (self.corner.0 + x, self.corner.1 + y)
    }

    fn draw(&self, marks: &mut Vec<Mark>) {
        let (wide, tall) = (self.grid.delays.len(), self.grid.jitters.len());
        for jitter in 0..tall {
            for delay in 0..wide {
                let (x, y) = (delay as f64, jitter as f64);
                let square = [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)].map(|(x, y)| self.at(x, y));
                marks.push(Mark::area(square.to_vec(), colour(self.cell(jitter, delay))).faint(STRENGTH));
            }
        }
        for (delay, value) in self.grid.delays.iter().enumerate().filter(|(k, _)| wide < 12 || k % 2 == 0) {
            marks.push(Mark::text(self.at(delay as f64 + 0.5, -1.0), value.to_string()));
        }
        for (jitter, value) in self.grid.jitters.iter().enumerate() {
            marks.push(Mark::text(self.at(-0.6, jitter as f64 + 0.1), value.to_string()));
        }
        let loss = format!("loss {}  {}", self.grid.losses[self.loss], self.grid.variations[self.variation].name);
        marks.push(Mark::text(self.at(wide as f64 / 2.0, tall as f64 + 0.1), loss.trim().into()));
        marks.push(Mark::text(self.at(wide as f64 / 2.0, -1.9), "delay [ms]".into()));
        marks.push(Mark::text(self.at(-0.6, tall as f64 + 0.1), "jitter".into()));
        marks.extend(self.contour().into_iter().map(|edge| Mark::line(edge.to_vec(), INK)));
        marks.push(Mark::dashes(self.critical(), COM));
    }

    /// Edges between cells inside and outside the survival contour.
    fn contour(&self) -> Vec<[(f64, f64); 2]> {
        let is_up = |jitter: usize, delay: usize| self.cell(jitter, delay).up >= MOST;
        let mut edges = Vec::new();
        for jitter in 0..self.grid.jitters.len() {
            for delay in 0..self.grid.delays.len() {
                let (x, y, here) = (delay as f64, jitter as f64, is_up(jitter, delay));
                if delay > 0 && here != is_up(jitter, delay - 1) {
                    edges.push([self.at(x, y), self.at(x, y + 1.0)]);
                }
                if jitter > 0 && here != is_up(jitter - 1, delay) {
                    edges.push([self.at(x, y), self.at(x + 1.0, y)]);
                }
            }
        }
        edges
    }

    /// The line on which the mean age of the applied command equals the critical delay of the servo, through the middle of each row.
    fn critical(&self) -> Vec<(f64, f64)> {
        let critical = self.cells.critical[self.variation];
        let ages = |jitter: usize| (0..self.grid.delays.len()).map(move |delay| self.cell(jitter, delay).age);
        let place = |jitter: usize| {
            let ages: Vec<_> = ages(jitter).collect();
            let after = ages.iter().position(|age| *age >= critical)?;
            let before = after.checked_sub(1)?;
            Some(before as f64 + 0.5 + (critical - ages[before]) / (ages[after] - ages[before]))
        };
        let rows = (0..self.grid.jitters.len()).map(|jitter| (place(jitter).unwrap_or(f64::NAN), jitter as f64 + 0.5));
        rows.map(|(x, y)| self.at(x, y)).collect()
    }
}

/// A colour mixed from the shares of even walks, uneven walks and falls.
fn colour(cell: &Cell) -> RGBColor {
    let parts = [(GREEN, cell.even), (RIGHT, cell.up - cell.even), (ZMP, 1.0 - cell.up)];
    let mix =
        |channel: fn(RGBColor) -> u8| parts.iter().map(|(part, share)| f64::from(channel(*part)) * share).sum::<f64>();
    RGBColor(mix(|c| c.0) as u8, mix(|c| c.1) as u8, mix(|c| c.2) as u8)
}
