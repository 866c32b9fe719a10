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
/// Greatest share of the axis that bars take; the rest is for the names.
const REACH: f64 = 0.52;
/// Width of a character of a name, as a share of the axis.
const CHARACTER: f64 = 0.0125;

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

impl Bar {
    /// The end of the bar and of its line, as a power of ten.
    fn end(&self) -> f64 {
        self.us.max(self.reach).log10()
    }

    /// The text behind the bar.
    fn label(&self) -> String {
        let percentile = if self.reach.is_finite() { format!(" | {:.2}", self.reach) } else { String::new() };
        format!("{:.2}{percentile} µs: {}", self.us, self.name)
    }
}

fn draw(title: &str, what: &'static str, mut bars: Vec<Bar>, sort: bool) -> Option<String> {
    bars.retain(|bar| bar.us > 0.0);
    if bars.is_empty() {
        return None;
    }
    if sort {
        bars.sort_by(|a, b| a.us.total_cmp(&b.us));
    }
    let from = (bars.iter().map(|bar| bar.us.log10()).fold(f64::INFINITY, f64::min) - 0.3).floor();
    let longest = (bars.iter().map(Bar::end).fold(f64::MIN, f64::max) - from).max(0.7);
    // every bar with its label fits into the axis
    let room = |bar: &Bar| (1.0 - CHARACTER * bar.label().chars().count() as f64) * longest / (bar.end() - from);
    let share = bars.iter().map(room).fold(REACH, f64::min);
    let mut marks = Vec::new();
    for (i, bar) in bars.iter().enumerate() {
        let (top, middle, bottom, end) = (-(i as f64) - 0.18, -(i as f64) - 0.5, -(i as f64) - 0.82, bar.us.log10());
        marks.push(Mark::area(vec![(from, top), (end, top), (end, bottom), (from, bottom)], bar.colour).faint(0.75));
        if bar.reach.is_finite() {
            marks.push(Mark::thin(vec![(end, middle), (bar.end(), middle)], bar.colour));
        }
        marks.push(Mark::note((bar.end() + 0.015 * longest / share, middle), bar.label(), bar.colour));
    }
    let frame = Frame {
        title: title.into(),
        height: (ROW[0] * bars.len() as f64 + ROW[1]) as u32,
        x: PlotAxis::powers(what, from - 0.03 * longest..from + longest / share),
        y: PlotAxis::hidden(-(bars.len() as f64)..0.0),
    };
    Some(plot(&frame, &marks))
}
