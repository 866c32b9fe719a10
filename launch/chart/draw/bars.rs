//! Views (ii) and (iv): a bar for each cost, named and numbered where it ends.

use super::{Family, label};
use crate::chart::csv::{Row, View};
use crate::chart::models::Group;
use crate::report::plot::{Axis, Frame, LEFT, Mark, plot};
use plotters::style::RGBColor;

/// Height of a bar with the space to the next, and of what surrounds them [px].
const ROW: [f64; 2] = [17.0, 96.0];
/// Share of the axis that bars may take; the rest is for the names.
const REACH: f64 = 0.52;

/// View (ii) of a scene; none without measurements.
pub fn steps(scene: &str, title: &str, rows: &[Row]) -> Option<String> {
    let bars = rows.iter().filter(|row| row.view == View::Steps && row.scene == scene).map(|row| {
        let name = if Family::of(row) == Family::Peer { label(row) } else { row.method.clone() };
        (row.us_per_step, name, Family::of(row).colour(false))
    });
    draw(title, "CPU time per step of 1 ms [µs]", bars.collect(), |us| format!("{us:.2}"), true)
}

/// View (iv) of a group; none without measurements.
pub fn models(group: &Group, rows: &[Row]) -> Option<String> {
    let bars = rows.iter().filter(|row| row.view == View::Models && row.scene == group.name).map(|row| {
        let same = if row.error < 1e-13 { "the same".into() } else { format!("{:.0e} off", row.error) };
        (row.us_per_step, format!("{}, {same}", row.method), LEFT)
    });
    draw(group.title, "CPU time per step of 1 ms [µs]", bars.collect(), |us| format!("{us:.2}"), false)
}

type Bar = (f64, String, RGBColor);

fn draw(title: &str, what: &'static str, mut bars: Vec<Bar>, number: fn(f64) -> String, sort: bool) -> Option<String> {
    bars.retain(|bar| bar.0 > 0.0);
    if bars.is_empty() {
        return None;
    }
    if sort {
        bars.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let logs = || bars.iter().map(|bar| bar.0.log10());
    let from = (logs().fold(f64::INFINITY, f64::min) - 0.3).floor();
    let longest = (logs().fold(f64::MIN, f64::max) - from).max(0.7);
    let mut marks = Vec::new();
    for (i, (us, name, colour)) in bars.iter().enumerate() {
        let (top, bottom, end) = (-(i as f64) - 0.18, -(i as f64) - 0.82, us.log10());
        marks.push(Mark::area(vec![(from, top), (end, top), (end, bottom), (from, bottom)], *colour).faint(0.75));
        let at = (end + 0.015 * longest / REACH, -(i as f64) - 0.5);
        marks.push(Mark::note(at, format!("{}  {name}", number(*us)), *colour));
    }
    let frame = Frame {
        title: title.into(),
        height: (ROW[0] * bars.len() as f64 + ROW[1]) as u32,
        x: Axis::powers(what, from - 0.03 * longest..from + longest / REACH),
        y: Axis::hidden(-(bars.len() as f64)..0.0),
    };
    Some(plot(&frame, &marks))
}
