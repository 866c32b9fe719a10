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

/// The rows of the last [`LAST_STEPS`] steps, and of the fall that follows them. All rows if there are fewer steps.
pub fn last_cycles(analysis: &RunAnalysis) -> &[TrajectoryRow] {
    let steps = &analysis.gait.steps;
    let Some(begin) = steps.len().checked_sub(LAST_STEPS + 1).map(|i| &steps[i]) else { return &analysis.rows };
    let index = |time: f64| analysis.rows.partition_point(|row| row.derived.time < time);
    let end = match analysis.extrema.fall {
        None => index(steps[steps.len() - 1].start),
        Some(_) => analysis.rows.len(),
    };
    &analysis.rows[index(begin.start)..end]
}

#[cfg(test)]
mod tests {
    use super::last_cycles;
    use crate::analysis::RunAnalysis;
    use crate::analysis::synthetic::SyntheticWalk;
    use messages::scene::Scene;

    /// Times of the first and the last row, for a walk of 8 s that may be followed by a fall.
    fn shown(falls: bool) -> [f64; 2] {
        let (walk, mut analysis) = (SyntheticWalk::new(0.06), RunAnalysis::new(&Scene::default()));
        for seq in 0..if falls { 8500 } else { 8000 } {
            let mut truth = walk.truth(seq, seq.min(8000) as f64 * 1e-3);
            truth.stamp.sim_ns = seq * 1_000_000;
            let tilt = 2e-3 * seq.saturating_sub(8000) as f64; // backwards about the ground, at 2 rad/s
            truth.base_orientation = [(tilt / 2.0).cos(), 0.0, -(tilt / 2.0).sin(), 0.0];
            analysis.push(&truth);
        }
        assert_eq!(analysis.extrema.fall.is_some(), falls);
        let rows = last_cycles(&analysis);
        [rows[0].derived.time, rows[rows.len() - 1].derived.time]
    }

    #[test]
    fn figures_of_the_last_steps_show_the_fall_that_follows_them() {
        let ([start, end], [same_start, fallen]) = (shown(false), shown(true));
        assert!(start > 4.0 && end < 8.0 && same_start == start, "{start} to {end} s, {same_start} s");
        assert!((fallen - 8.495).abs() < 1e-9, "{fallen} s");
    }
}
