//! Figures, their panels, and the selection of rows for them.

use super::plot::{PlotAxis, padded_range};
use crate::analysis::{RunAnalysis, TrajectoryRow};

/// A figure: panels with a common title and caption.
pub struct Figure {
    /// Title.
    pub title: &'static str,
    /// Explanation.
    pub caption: &'static str,
    /// Panels.
    pub panels: Vec<FigurePanel>,
}

/// One diagram of a figure.
pub struct FigurePanel {
    /// File name without extension.
    pub name: &'static str,
    /// SVG with a white background.
    pub svg: String,
}

impl FigurePanel {
    /// A panel with a file name.
    pub fn new(name: &'static str, svg: String) -> Self {
        FigurePanel { name, svg }
    }
}

/// A quantity over time, from the rows.
pub fn series(rows: &[TrajectoryRow], value: impl Fn(&TrajectoryRow) -> f64) -> Vec<(f64, f64)> {
    rows.iter().map(|row| (row.derived.time, value(row))).collect()
}

/// Least width of a time axis [s]: of a run with one record.
const MIN_TIME_RANGE: f64 = 1e-3;

/// The axis of these times, without margins.
pub fn time_axis(times: impl IntoIterator<Item = f64>) -> PlotAxis {
    PlotAxis::new("time [s]", padded_range(times, 0.0, MIN_TIME_RANGE))
}

/// The rows of the last `seconds`.
pub fn last_seconds(rows: &[TrajectoryRow], seconds: f64) -> &[TrajectoryRow] {
    let end = rows.last().map_or(0.0, |row| row.derived.time);
    &rows[rows.partition_point(|row| row.derived.time < end - seconds)..]
}

/// Number of steps in figures that show the last cycles.
pub const LAST_STEPS: usize = 8;

/// The rows of the last [`LAST_STEPS`] steps. All rows if there are fewer steps.
pub fn last_cycles(analysis: &RunAnalysis) -> &[TrajectoryRow] {
    let steps = &analysis.gait.steps;
    let Some(begin) = steps.len().checked_sub(LAST_STEPS + 1).map(|i| &steps[i]) else { return &analysis.rows };
    let end = steps.last().map_or(0.0, |step| step.start);
    let index = |time: f64| analysis.rows.partition_point(|row| row.derived.time < time);
    &analysis.rows[index(begin.start)..index(end)]
}
