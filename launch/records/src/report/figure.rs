//! Figures and their panels, and the rows that they draw.

use crate::analysis::{RunAnalysis, TrajectoryRow};

/// A figure: panels under one heading.
pub struct Figure {
    /// Heading.
    pub title: &'static str,
    /// One sentence that says what to see.
    pub caption: &'static str,
    /// Drawings.
    pub panels: Vec<FigurePanel>,
}

/// One drawing.
pub struct FigurePanel {
    /// Name of its file, without extension.
    pub name: &'static str,
    /// The drawing, on white.
    pub svg: String,
}

impl FigurePanel {
    /// A drawing under a name.
    pub fn new(name: &'static str, svg: String) -> Self {
        FigurePanel { name, svg }
    }
}

/// A quantity over time.
pub fn series(rows: &[TrajectoryRow], value: impl Fn(&TrajectoryRow) -> f64) -> Vec<(f64, f64)> {
    rows.iter().map(|row| (row.derived.time, value(row))).collect()
}

/// The rows of the last seconds.
pub fn last_seconds(rows: &[TrajectoryRow], seconds: f64) -> &[TrajectoryRow] {
    let end = rows.last().map_or(0.0, |row| row.derived.time);
    &rows[rows.partition_point(|row| row.derived.time < end - seconds)..]
}

/// The rows of the last eight steps; all if there are fewer.
pub fn last_cycles(analysis: &RunAnalysis) -> &[TrajectoryRow] {
    let steps = &analysis.gait.steps;
    let Some(begin) = steps.len().checked_sub(9).map(|i| &steps[i]) else { return &analysis.rows };
    let end = steps.last().map_or(0.0, |step| step.start);
    let index = |time: f64| analysis.rows.partition_point(|row| row.derived.time < time);
    &analysis.rows[index(begin.start)..index(end)]
}
