//! The drawing of a sweep of one key: a figure of every run over the values of the key, and where survival changes.

use super::edge::Edge;
use super::figures::{Fate, Survival};
use super::grid::Grid;
use crate::batch::panel;
use crate::batch::table::Row;
use records::report::draw::plot;
use records::report::plot::{Frame, GREEN, GREY, INK, Mark, PlotAxis, RIGHT, ZMP, padded_range};
use std::ops::Range;

/// Height of the figure [px].
const HEIGHT: u32 = 330;
/// Radius of a dot [px].
const DOT: f64 = 3.0;
/// Least range of an axis [its unit].
const FLAT: f64 = 1e-3;
/// Height of the dots of runs in which the figure was not measured, above the lower end, relative to the axis.
const FLOOR: f64 = 0.1;
/// Values whose greatest is this many times the least are drawn by their logarithms.
const LOGARITHMIC: f64 = 100.0;

/// The scale of the key.
enum Scale {
    Linear,
    Logarithmic,
    /// Values that are no numbers, by their index.
    Words,
}

/// The curve.
pub fn draw(grid: &Grid, survival: &Survival, rows: &[Row], edges: &[Edge]) -> String {
    let (axes, seeds) = grid.drawn();
    let axis = &axes[0];
    let (scale, places) = places(&axis.values);
    let cells: Vec<(f64, &[Row])> = places.iter().copied().zip(rows.chunks(seeds)).collect();
    let measured = |row: &Row| Some(survival.value(&row.results)).filter(|value| value.is_finite());
    let values = rows.iter().filter_map(measured).chain(survival.limit());
    let y = padded_range(values, 0.08, FLAT);
    let floor = y.start + FLOOR * (y.end - y.start);
    let dots = |fate: Fate, known: bool| {
        let has = |row: &&Row| survival.fate(&row.results) == fate && measured(row).is_some() == known;
        let dot = |x: f64, row: &Row| (x, measured(row).unwrap_or(floor));
        cells.iter().flat_map(|(x, rows)| rows.iter().filter(has).map(|row| dot(*x, row))).collect::<Vec<_>>()
    };
    let mean = cells.iter().map(|(x, rows)| {
        let values: Vec<f64> = rows.iter().filter_map(measured).collect();
        (*x, values.iter().sum::<f64>() / values.len() as f64)
    });
    let mut marks = vec![Mark::thin(mean.collect(), GREY).label(if seeds > 1 { "mean" } else { "all runs" })];
    if let Some(limit) = survival.limit() {
        let ends = [places.iter().copied().fold(f64::NAN, f64::min), places.iter().copied().fold(f64::NAN, f64::max)];
        marks.push(Mark::dashes(ends.map(|x| (x, limit)).into(), RIGHT).label("limit"));
    }
    let mut changes = changes(&cells, survival);
    if !edges.is_empty() {
        changes = edges.iter().filter(|edge| !edge.refused).map(|edge| scale.place(edge.value)).collect();
    }
    let line = |(k, x): (usize, &f64)| {
        let line = Mark::dashes(vec![(*x, y.start), (*x, y.end)], INK);
        if k == 0 { line.label("survival changes") } else { line }
    };
    marks.extend(changes.iter().enumerate().map(line));
    for (fate, known, colour, words) in [
        (Fate::Survives, true, GREEN, "survives"),
        (Fate::DoesNot, true, ZMP, "does not"),
        (Fate::DoesNot, false, ZMP, "not measured"),
        (Fate::Refused, false, GREY, "refused"),
    ] {
        let points = dots(fate, known);
        if !points.is_empty() {
            let mark = if known { Mark::dots(points, DOT, colour) } else { Mark::rings(points, DOT, colour) };
            marks.push(mark.label(words));
        }
    }
    let margin = if let Scale::Words = scale { 0.2 } else { 0.04 };
    let x = padded_range(places.iter().copied(), margin, FLAT);
    if let Scale::Words = scale {
        let word = |(x, value): (&f64, &String)| Mark::text((*x, y.start), value.clone());
        marks.extend(places.iter().zip(&axis.values).map(word));
        let top = y.end - 0.5 * FLOOR * (y.end - y.start);
        marks.push(Mark::note((x.start, top), format!("to the right: {}", axis.key), INK));
    }
    let x = scale.axis(&axis.key, x);
    plot(&Frame { title: grid.title(survival), height: HEIGHT, x, y: PlotAxis::new(survival.name(), y) }, &marks)
}

/// The middles between neighbouring values of which half of the runs survive on one side only.
fn changes(cells: &[(f64, &[Row])], survival: &Survival) -> Vec<f64> {
    let changed = cells.windows(2).filter(|pair| panel::changes(survival.share(pair[0].1), survival.share(pair[1].1)));
    changed.map(|pair| 0.5 * (pair[0].0 + pair[1].0)).collect()
}

/// The scale of values, and their places on it.
fn places(values: &[String]) -> (Scale, Vec<f64>) {
    let numbers: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
    let Some(numbers) = numbers else { return (Scale::Words, (0..values.len()).map(|k| k as f64).collect()) };
    let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let scale = if least > 0.0 && greatest >= LOGARITHMIC * least { Scale::Logarithmic } else { Scale::Linear };
    let places = numbers.iter().map(|number| scale.place(*number)).collect();
    (scale, places)
}

impl Scale {
    fn place(&self, value: f64) -> f64 {
        if let Scale::Logarithmic = self { value.log10() } else { value }
    }

    fn axis(&self, name: &str, range: Range<f64>) -> PlotAxis {
        match self {
            Scale::Linear => PlotAxis::new(name, range),
            Scale::Logarithmic => PlotAxis::powers(name, range),
            Scale::Words => PlotAxis::hidden(range),
        }
    }
}
