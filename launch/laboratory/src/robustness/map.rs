//! The map: a panel for each loss, with delay as x and jitter as y. It shows the share of runs without a fall, the survival contour,
//! and the stability limit of the servo alone.

use super::cells::{Cell, Cells};
use super::grid::LinkGrid;
use crate::batch::panel::{Layout, Panel, STRENGTH, mixed};
use plotters::style::RGBColor;
use records::report::draw::plot;
use records::report::plot::{COM, Frame, GREEN, INK, Mark, PlotAxis, RIGHT, ZMP};

/// Panels in a row.
const ACROSS: usize = 2;

/// The map of survival.
pub fn survival(grid: &LinkGrid, cells: &Cells) -> String {
    let mut marks: Vec<Mark> = legend().into();
    let values = [&grid.delays, &grid.jitters].map(|axis| axis.iter().map(f64::to_string).collect::<Vec<_>>());
    let panels: Vec<_> = (0..grid.variations.len()).flat_map(|v| (0..grid.losses.len()).map(move |l| (v, l))).collect();
    let layout = Layout::new(panels.len(), ACROSS, [grid.delays.len(), grid.jitters.len()]);
    for (i, &(variation, loss)) in panels.iter().enumerate() {
        let title = format!("loss {}  {}", grid.losses[loss], grid.variations[variation].name);
        let cell = |delay: usize, jitter: usize| cells.at(grid, variation, loss, jitter, delay);
        let panel = Panel {
            title: title.trim(),
            names: ["delay [ms]", "jitter [ms]"],
            values: [&values[0], &values[1]],
            corner: layout.corner(i),
            colour: &|delay, jitter| colour(cell(delay, jitter)),
            up: &|delay, jitter| cell(delay, jitter).up,
        };
        panel.draw(&mut marks);
        let line = critical(grid, cell, cells.critical[variation]).into_iter().map(|(x, y)| panel.at(x, y));
        marks.push(Mark::dashes(line.collect(), COM));
    }
    let (wide, tall) = layout.extent();
    let frame = Frame {
        title: "How much delay, jitter and loss of commands the walk tolerates".into(),
        height: layout.height(),
        x: PlotAxis::hidden(0.0..wide),
        y: PlotAxis::hidden(-tall..0.0),
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
        Mark::dashes(speck.clone(), COM).label("mean age of commands at which the servo alone is unstable"),
    ]
}

/// The line on which the mean age of the applied command equals the critical delay of the servo, through the middle of each row.
fn critical<'a>(grid: &LinkGrid, cell: impl Fn(usize, usize) -> &'a Cell, critical: f64) -> Vec<(f64, f64)> {
    let place = |jitter: usize| {
        let ages: Vec<_> = (0..grid.delays.len()).map(|delay| cell(delay, jitter).age).collect();
        let after = ages.iter().position(|age| *age >= critical)?;
        let before = after.checked_sub(1)?;
        Some(before as f64 + 0.5 + (critical - ages[before]) / (ages[after] - ages[before]))
    };
    (0..grid.jitters.len()).map(|jitter| (place(jitter).unwrap_or(f64::NAN), jitter as f64 + 0.5)).collect()
}

/// A colour mixed from the shares of even walks, uneven walks and falls.
fn colour(cell: &Cell) -> RGBColor {
    mixed([(GREEN, cell.even), (RIGHT, cell.up - cell.even), (ZMP, 1.0 - cell.up)])
}
