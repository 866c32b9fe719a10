//! Views (ii) and (iv): a bar for each cost, with name and number at its end.

use super::style::{CurveFamily, label};
use crate::chart::csv::{Measurement, View};
use crate::chart::models::Group;
use crate::chart::steps::{MEDIAN, P99};
use plotters::style::RGBColor;
use records::report::draw::plot;
use records::report::plot::{Frame, LEFT, Mark, PlotAxis};

/// Height of a bar with the space around it, and height of the drawing without its bars [px].
const ROW: [f64; 2] = [17.0, 96.0];
/// Share of the axis that bars may take; the rest is for the names.
const REACH: f64 = 0.52;

/// View (ii) of a scene; `None` without measurements.
pub fn steps(scene: &str, title: &str, rows: &[Measurement]) -> Option<String> {
    let of_scene = || rows.iter().filter(|row| row.view == View::Steps && row.scene == scene);
    let bars = of_scene().filter(|row| row.metric != P99).map(|row| {
        let worst = of_scene().find(|other| other.metric == P99 && other.method == row.method && row.metric == MEDIAN);
        let reach = worst.map_or(f64::NAN, |row| row.us_per_step);
        Bar { us: row.us_per_step, reach, name: label(row), colour: CurveFamily::of(row).colour(false) }
    });
    draw(title, "time per step of 1 ms [µs]", bars.collect(), true)
}

/// View (iv) of a group; `None` without measurements.
pub fn models(group: &Group, rows: &[Measurement]) -> Option<String> {
    let bars = rows.iter().filter(|row| row.view == View::Models && row.scene == group.name).map(|row| {
        let same = if row.error < 1e-13 { "the same".into() } else { format!("{:.0e} off", row.error) };
        Bar { us: row.us_per_step, reach: f64::NAN, name: format!("{}, {same}", row.method), colour: LEFT }
    });
    draw(group.title, "CPU time per step of 1 ms [µs]", bars.collect(), false)
}

/// A cost with its 99th percentile (a thin line; NaN for none), its name and its colour.
struct Bar {
    us: f64,
    reach: f64,
    name: String,
    colour: RGBColor,
}

fn draw(title: &str, what: &'static str, mut bars: Vec<Bar>, sort: bool) -> Option<String> {
    bars.retain(|bar| bar.us > 0.0);
    if bars.is_empty() {
        return None;
    }
    if sort {
        bars.sort_by(|a, b| a.us.total_cmp(&b.us));
    }
    let logs = || bars.iter().map(|bar| bar.us.max(bar.reach).log10());
    let from = (bars.iter().map(|bar| bar.us.log10()).fold(f64::INFINITY, f64::min) - 0.3).floor();
    let longest = (logs().fold(f64::MIN, f64::max) - from).max(0.7);
    let mut marks = Vec::new();
    for (i, Bar { us, reach, name, colour }) in bars.iter().enumerate() {
        let (top, middle, bottom, end) = (-(i as f64) - 0.18, -(i as f64) - 0.5, -(i as f64) - 0.82, us.log10());
        marks.push(Mark::area(vec![(from, top), (end, top), (end, bottom), (from, bottom)], *colour).faint(0.75));
        let far = end.max(reach.log10());
        let mut numbers = format!("{us:.2}");
        if reach.is_finite() {
            marks.push(Mark::thin(vec![(end, middle), (far, middle)], *colour));
            numbers += &format!(" | {reach:.2}");
        }
        let at = (far + 0.015 * longest / REACH, middle);
        marks.push(Mark::note(at, format!("{numbers}  {name}"), *colour));
    }
    let frame = Frame {
        title: title.into(),
        height: (ROW[0] * bars.len() as f64 + ROW[1]) as u32,
        x: PlotAxis::powers(what, from - 0.03 * longest..from + longest / REACH),
        y: PlotAxis::hidden(-(bars.len() as f64)..0.0),
    };
    Some(plot(&frame, &marks))
}
