//! Figure 7: trajectory of the centre of gravity.

use super::draw::plot;
use super::figure::{Figure, FigurePanel, series};
use super::plot::{Axis, COM, Frame, GREEN, LEFT, Mark, RIGHT, ZMP, around};
use crate::analysis::{FootGeometry, RunAnalysis};

/// Top view with footprints, and the three coordinates over time.
pub fn figure(analysis: &RunAnalysis) -> Figure {
    Figure {
        title: "Figure 7: trajectory of the centre of gravity",
        caption: if analysis.robot.feet.is_some() {
            "From above, the centre of gravity weaves between the footprints of the left and the right foot; over time \
             x shows the speed, y the swing from foot to foot, z how level the motion is (paper, Fig. 7)."
        } else {
            "The path of the centre of gravity from above, and its coordinates over time (paper, Fig. 7)."
        },
        panels: vec![
            FigurePanel::new("cog-top-view", top_view(analysis)),
            FigurePanel::new("cog-x", over_time(analysis, 0)),
            FigurePanel::new("cog-y", over_time(analysis, 1)),
            FigurePanel::new("cog-z", over_time(analysis, 2)),
        ],
    }
}

/// Footprints beyond this many would hide each other: only the last are drawn.
const FOOTPRINTS: usize = 80;

fn top_view(analysis: &RunAnalysis) -> String {
    let (mut marks, mut named) = (Vec::new(), [false; 2]);
    let (mut along, mut across) = (Vec::new(), Vec::new());
    let steps = &analysis.gait.steps;
    for step in &steps[steps.len().saturating_sub(FOOTPRINTS)..] {
        let Some(feet) = &analysis.robot.feet else { break };
        let corners = footprint(&feet[step.support], step.sole.centre.xy().into(), step.sole.yaw());
        along.extend(corners.iter().map(|corner| corner.0));
        across.extend(corners.iter().map(|corner| corner.1));
        let colour = [LEFT, RIGHT][step.support];
        let mut print = Mark::area(corners.clone(), colour).faint(0.13);
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
        title: "From above, sideways stretched".into(),
        height: 330,
        x: Axis::new("x, forward [m]", around(along, 0.03, 0.1)),
        y: Axis::new("y, left [m]", around(across, 0.06, 0.1)),
    };
    plot(&frame, &marks)
}

/// Corners of a sole on the ground, closed.
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
        x: Axis::new("time [s]", around(points.iter().map(|point| point.0), 0.0, 1e-3)),
        y: Axis::new(label, around(points.iter().map(|point| point.1), 0.08, 0.02)),
    };
    plot(&frame, &[Mark::line(points, [COM, GREEN, ZMP][axis])])
}
