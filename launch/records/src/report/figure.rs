//! Figures and their panels, and the rows that they draw.

use crate::record::{Recorder, Row};

/// A figure: panels under one heading.
pub struct Figure {
    /// Heading.
    pub title: &'static str,
    /// One sentence that says what to see.
    pub caption: &'static str,
    /// Drawings.
    pub panels: Vec<Panel>,
}

/// One drawing.
pub struct Panel {
    /// Name of its file, without extension.
    pub name: &'static str,
    /// The drawing, on white.
    pub svg: String,
}

impl Panel {
    /// A drawing under a name.
    pub fn new(name: &'static str, svg: String) -> Self {
        Panel { name, svg }
    }
}

/// A quantity over time.
pub fn series(rows: &[Row], value: impl Fn(&Row) -> f64) -> Vec<(f64, f64)> {
    rows.iter().map(|row| (row.sample.time, value(row))).collect()
}

/// The rows of the last seconds.
pub fn last_seconds(rows: &[Row], seconds: f64) -> &[Row] {
    let end = rows.last().map_or(0.0, |row| row.sample.time);
    &rows[rows.partition_point(|row| row.sample.time < end - seconds)..]
}

/// The rows of the last eight steps; all if there are fewer.
pub fn last_cycles(recorder: &Recorder) -> &[Row] {
    let steps = &recorder.gait.steps;
    let Some(begin) = steps.len().checked_sub(9).map(|i| &steps[i]) else { return &recorder.rows };
    let end = steps.last().map_or(0.0, |step| step.start);
    let index = |time: f64| recorder.rows.partition_point(|row| row.sample.time < time);
    &recorder.rows[index(begin.start)..index(end)]
}
