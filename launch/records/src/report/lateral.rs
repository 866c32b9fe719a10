//! Figure 8: position and velocity in the lateral plane.

use super::draw::plot;
use super::figure::{Figure, FigurePanel, last_seconds, series, time_axis};
use super::plot::{COM, FAINT, Frame, GREEN, LEFT, Mark, PlotAxis, RIGHT, padded_range};
use crate::analysis::{RunAnalysis, TrajectoryRow};

/// Longest time that the figure shows [s]: the length of the built-in walk. Of a longer run it shows the end.
const WINDOW: f64 = 14.0;

/// Lateral position and velocity over time, with the support phases shaded.
pub fn figure(analysis: &RunAnalysis) -> Option<Figure> {
    analysis.robot.feet.as_ref()?;
    let rows = last_seconds(&analysis.rows, WINDOW);
    Some(Figure {
        title: "Figure 8: lateral position and velocity",
        caption: "The centre of gravity oscillates between the feet with the period of two steps. It turns back before it \
                  reaches the support foot. Shading shows which foot supports (paper, Fig. 8).",
        panels: vec![
            FigurePanel::new(
                "lateral-position",
                over_time(analysis, rows, "Position", "y [m]", |row| row.derived.com.y),
            ),
            FigurePanel::new(
                "lateral-velocity",
                over_time(analysis, rows, "Velocity", "dy/dt [m/s]", |row| row.derived.com_velocity.y),
            ),
        ],
    })
}

fn over_time(
    analysis: &RunAnalysis,
    rows: &[TrajectoryRow],
    title: &str,
    label: &'static str,
    value: fn(&TrajectoryRow) -> f64,
) -> String {
    let points = series(rows, value);
    let time = time_axis(points.iter().map(|point| point.0));
    let reach = padded_range(points.iter().map(|point| point.1), 0.08, 1e-3);
    let steps = &analysis.gait.steps;
    let ends = steps.iter().skip(1).map(|step| step.start).chain([time.range.end]);
    let mut marks: Vec<Mark> = (steps.iter().zip(ends))
        .filter(|(_, end)| *end > time.range.start)
        .map(|(step, end)| {
            let (from, to) = (step.start.max(time.range.start), end);
            let corners = vec![(from, reach.start), (to, reach.start), (to, reach.end), (from, reach.end)];
            Mark::area(corners, [LEFT, RIGHT][step.support]).faint(FAINT)
        })
        .collect();
    for (mark, step) in marks.iter_mut().rev().zip(steps.iter().rev()).take(2) {
        mark.name(["left foot supports", "right foot supports"][step.support]);
    }
    marks.push(Mark::line(points, if label.starts_with('y') { COM } else { GREEN }));
    let frame = Frame { title: title.into(), height: 330, x: time, y: PlotAxis::new(label, reach) };
    plot(&frame, &marks)
}
