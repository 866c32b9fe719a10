//! Figure 7: trajectory of the centre of gravity.

use super::draw::plot;
use super::figure::{Figure, FigurePanel, series, time_axis};
use super::plot::{COM, FAINT, Frame, GREEN, LEFT, Mark, PlotAxis, RIGHT, ZMP, padded_range};
use crate::analysis::{FootGeometry, RunAnalysis};

/// Top view with footprints, and the three coordinates over time.
pub fn figure(analysis: &RunAnalysis) -> Figure {
    Figure {
        title: "Figure 7: trajectory of the centre of gravity",
        caption: if analysis.robot.feet.is_some() {
            "In the top view the path of the centre of gravity alternates between the footprints of the left and the right \
             foot. Over time, x shows the speed, y the lateral oscillation and z the variation of height (paper, Fig. 7)."
        } else {
            "Path of the centre of gravity in the top view, and its coordinates over time (paper, Fig. 7)."
        },
        panels: vec![
            FigurePanel::new("cog-top-view", top_view(analysis)),
            FigurePanel::new("cog-x", over_time(analysis, 0)),
            FigurePanel::new("cog-y", over_time(analysis, 1)),
            FigurePanel::new("cog-z", over_time(analysis, 2)),
        ],
    }
}

/// Greatest number of footprints. More would overlap, so only the last ones are drawn.
const MAX_FOOTPRINTS: usize = 80;

fn top_view(analysis: &RunAnalysis) -> String {
    let (mut marks, mut named) = (Vec::new(), [false; 2]);
    let (mut along, mut across) = (Vec::new(), Vec::new());
    let steps = &analysis.gait.steps;
    for step in &steps[steps.len().saturating_sub(MAX_FOOTPRINTS)..] {
        let Some(feet) = &analysis.robot.feet else { break };
        let corners = footprint(&feet[step.support], step.sole.centre.xy().into(), step.sole.yaw());
        along.extend(corners.iter().map(|corner| corner.0));
        across.extend(corners.iter().map(|corner| corner.1));
        let colour = [LEFT, RIGHT][step.support];
        let mut print = Mark::area(corners.clone(), colour).faint(FAINT);
        if !std::mem::replace(&mut named[step.support], true) {
            print.name(["left footprint", "right footprint"][step.support]);
        }
        marks.push(print);
        marks.push(Mark::thin(corners, colour).faint(0.6));
    }
    let path: Vec<_> = analysis.rows.iter().map(|row| (row.derived.com.x, row.derived.com.y)).collect();
    along.extend(path.iter().map(|point| point.0));
    across.extend(path.iter().map(|point| point.1));
    marks.push(Mark::line(path, COM).label("centre of gravity"));
    let frame = Frame {
        title: "Top view, lateral axis stretched".into(),
        height: 330,
        x: PlotAxis::new("x, forward [m]", padded_range(along, 0.03, 0.1)),
        y: PlotAxis::new("y, left [m]", padded_range(across, 0.06, 0.1)),
    };
    plot(&frame, &marks)
}

/// Corners of a sole on the ground, as a closed polygon.
fn footprint(foot: &FootGeometry, centre: [f64; 2], yaw: f64) -> Vec<(f64, f64)> {
    let (sin, cos) = yaw.sin_cos();
    [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
        .map(|(a, b)| (a * foot.half[0], b * foot.half[1]))
        .map(|(u, v)| (centre[0] + cos * u - sin * v, centre[1] + sin * u + cos * v))
        .to_vec()
}

fn over_time(analysis: &RunAnalysis, axis: usize) -> String {
    let points = series(&analysis.rows, |row| row.derived.com[axis]);
    let title = ["Forward", "Sideways", "Height"][axis];
    let label = ["x [m]", "y [m]", "z [m]"][axis];
    let frame = Frame {
        title: title.into(),
        height: 330,
        x: time_axis(points.iter().map(|point| point.0)),
        y: PlotAxis::new(label, padded_range(points.iter().map(|point| point.1), 0.08, 0.02)),
    };
    plot(&frame, &[Mark::line(points, [COM, GREEN, ZMP][axis])])
}
