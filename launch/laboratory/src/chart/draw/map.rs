//! View (iii): the map of failures, a letter for each cause.

use super::style::{CurveFamily, label};
use crate::chart::csv::{Measurement, View};
use crate::chart::failures::{Cause, REFUSED, SOUND};
use plotters::style::RGBColor;
use records::report::draw::plot;
use records::report::plot::{COM, Frame, GREEN, GREY, Mark, PlotAxis, RIGHT, ZMP};
use strum::VariantArray;

/// Width of the names, in columns of the map.
const NAMES: f64 = 3.6;
/// Height of a row, and height of the drawing without its rows [px].
const ROW: [f64; 2] = [22.0, 72.0];

/// The map with these scenes as columns; `None` without measurements.
pub fn failures(columns: &[&str], rows: &[Measurement]) -> Option<String> {
    let judged: Vec<_> = rows.iter().filter(|row| row.view == View::Failures && row.dt > 0.0).collect();
    let mut methods: Vec<&Measurement> = Vec::new();
    for row in &judged {
        if methods.iter().all(|known| known.method != row.method) {
            methods.push(row);
        }
    }
    methods.sort_by_key(|row| std::cmp::Reverse(CurveFamily::of(row)));
    let mut marks = Vec::new();
    for (j, scene) in columns.iter().enumerate() {
        let step = if j % 2 == 0 { 0.1 } else { 0.75 };
        marks.push(Mark::text((j as f64 + 0.5, step), (*scene).into()));
    }
    for (i, of) in methods.iter().enumerate() {
        let y = -(i as f64);
        marks.push(Mark::note((-NAMES, y - 0.5), label(of), CurveFamily::of(of).colour(false)));
        for (j, scene) in columns.iter().enumerate() {
            let found: Vec<_> = judged.iter().filter(|row| row.method == of.method && row.scene == **scene).collect();
            let Some(first) = found.first() else { continue };
            let (colour, strength) = colour(&first.metric);
            let (left, right, top, bottom) = (j as f64 + 0.04, j as f64 + 0.96, y - 0.06, y - 0.94);
            let cell = vec![(left, top), (right, top), (right, bottom), (left, bottom)];
            marks.push(Mark::area(cell, colour).faint(strength));
            let causes = found.iter().filter(|row| row.metric != SOUND && row.metric != REFUSED);
            let letters: String = causes.filter_map(|row| row.metric.chars().next()).take(3).collect();
            marks.push(Mark::text((j as f64 + 0.5, y - 0.8), letters));
        }
    }
    let frame = Frame {
        title: "Where methods fail at 1 ms".into(),
        height: (ROW[0] * (methods.len() as f64 + 1.5) + ROW[1]) as u32,
        x: PlotAxis::hidden(-NAMES..columns.len() as f64),
        y: PlotAxis::hidden(-(methods.len() as f64)..1.5),
    };
    (!methods.is_empty()).then(|| plot(&frame, &marks))
}

/// Colour and opacity of a cell.
fn colour(metric: &str) -> (RGBColor, f64) {
    match Cause::VARIANTS.iter().copied().find(|cause| cause.name() == metric) {
        Some(Cause::BlowUp | Cause::NoSolution | Cause::Zeno) => (ZMP, 0.6),
        Some(Cause::Hop | Cause::Tunnelling) => (RIGHT, 0.5),
        Some(Cause::Creep | Cause::Drift) => (RIGHT, 0.25),
        Some(Cause::Order) => (COM, 0.3),
        None if metric == SOUND => (GREEN, 0.2),
        None => (GREY, 0.12),
    }
}
