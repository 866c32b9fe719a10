//! The drawing of a sweep of two or more keys: a map of survival over the first two, and a panel for each combination of the others.

use super::edge::Edge;
use super::figures::{Fate, Survival};
use super::grid::Grid;
use crate::batch::axis::{Axis, combinations, settings};
use crate::batch::panel::{Layout, MOST, Panel, STRENGTH, mixed};
use crate::batch::table::Row;
use plotters::style::RGBColor;
use records::report::draw;
use records::report::plot::{Frame, GREEN, GREY, INK, Mark, PlotAxis, RIGHT, ZMP};

/// Most columns of a panel that shares its row with another one.
const NARROW: usize = 8;
/// Width of the figure, and of a character of a label [px].
const WIDTH: f64 = 560.0;
const CHARACTER: f64 = 8.0;

/// Colours of cells by what became of their runs.
const COLOURS: [(Fate, RGBColor, &str); 3] =
    [(Fate::Survives, GREEN, "survives"), (Fate::DoesNot, ZMP, "does not"), (Fate::Refused, GREY, "refused")];

/// The map of survival. Edges are the thresholds of the first key: vertical lines in the rows of their cells.
pub fn draw(grid: &Grid, survival: &Survival, rows: &[Row], edges: &[Edge]) -> String {
    let (axes, seeds) = grid.drawn();
    let [along, up] = [&axes[0], &axes[1]];
    let panels = combinations(&axes[2..]);
    let runs = |i: usize, j: usize, panel: usize| {
        let cell = (i * up.values.len() + j) * panels.len() + panel;
        &rows[cell * seeds..(cell + 1) * seeds]
    };
    let colour = |runs: &[Row]| {
        let share =
            |fate: Fate| runs.iter().filter(|row| survival.fate(&row.results) == fate).count() as f64 / seeds as f64;
        mixed(COLOURS.map(|(fate, colour, _)| (colour, share(fate))))
    };
    let has_refused = rows.iter().any(|row| survival.fate(&row.results) == Fate::Refused);
    let across = if panels.len() == 1 || along.values.len() > NARROW { 1 } else { 2 };
    let layout = Layout::new(panels.len(), across, [along.values.len(), up.values.len()]);
    let labels = spaced(&along.values, WIDTH / layout.extent().0);
    let mut marks = legend(has_refused);
    let (wide, tall) = layout.extent();
    marks.push(Mark::text((0.5 * wide, -tall), format!("to the right: {}, upward: {}", along.key, up.key)));
    for (panel, combination) in panels.iter().enumerate() {
        let drawn = Panel {
            title: &settings(&axes[2..], combination).join(" "),
            names: ["", ""],
            values: [&labels, &up.values],
            corner: layout.corner(panel),
            colour: &|i, j| colour(runs(i, j, panel)),
            up: &|i, j| survival.share(runs(i, j, panel)),
        };
        drawn.draw(&mut marks);
        for edge in edges.iter().filter(|edge| !edge.refused) {
            let run = &grid.runs[edge.run];
            if run[2..axes.len()] == combination[..] {
                let (x, y) = (place(along, run[0], edge.value), run[1] as f64);
                marks.push(Mark::dashes(vec![drawn.at(x, y), drawn.at(x, y + 1.0)], RIGHT));
            }
        }
    }
    if edges.iter().any(|edge| !edge.refused) {
        marks.push(Mark::dashes(vec![(0.0, 0.0); 2], RIGHT).label("survival changes"));
    }
    let (title, height) = (grid.title(survival), layout.height());
    draw::plot(&Frame { title, height, x: PlotAxis::hidden(0.0..wide), y: PlotAxis::hidden(-tall..0.0) }, &marks)
}

/// The place of a value between those of two columns, the first of which is `column` [cells].
fn place(axis: &Axis, column: usize, value: f64) -> f64 {
    let at = |column: usize| axis.values.get(column).and_then(|text| text.parse().ok()).unwrap_or(f64::NAN);
    let [low, high]: [f64; 2] = [at(column), at(column + 1)];
    column as f64 + 0.5 + (value - low) / (high - low)
}

/// Invisible marks that make the entries of the legend.
fn legend(has_refused: bool) -> Vec<Mark> {
    const { assert!(MOST == 0.5) }; // as the legend says
    let speck = vec![(0.0, 0.0); 2];
    let shown = COLOURS.iter().filter(|(fate, ..)| *fate != Fate::Refused || has_refused);
    let areas = shown.map(|(_, colour, words)| Mark::area(speck.clone(), *colour).faint(STRENGTH).label(words));
    areas.chain([Mark::line(speck.clone(), INK).label("half of the runs survive")]).collect()
}

/// The labels of columns of a width [px], without those that would overlap the one before.
fn spaced(labels: &[String], width: f64) -> Vec<String> {
    let longest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    let step = (CHARACTER * longest as f64 / width).ceil().max(1.0) as usize;
    let shown = |(k, label): (usize, &String)| if k % step == 0 { label.clone() } else { String::new() };
    labels.iter().enumerate().map(shown).collect()
}
