//! Figure 6: snapshots of the robot during one cycle, from the side and from behind.

use super::draw::plot;
use super::figure::{Figure, FigurePanel};
use super::plot::{Frame, GREY, LEFT, Mark, PlotAxis, RIGHT};
use crate::analysis::{RunAnalysis, TrajectoryRow, convex_hull};
use messages::robot::Body;
use nalgebra::{IsometryMatrix3, Point3};
use plotters::style::RGBColor;

/// Number of intervals between snapshots.
const INTERVALS: usize = 8;
/// Width of the plotting area in a figure without axes [px].
const STRIP_WIDTH: f64 = 534.0;
/// Height of the title [px].
const TITLE_HEIGHT: f64 = 40.0;
/// Distance of neighbouring snapshots, relative to the half width of a snapshot [-]: they do not overlap.
const PITCH: f64 = 2.15;

/// Snapshots over the last whole cycle of two steps. For a robot that does not step: over the whole run.
pub fn figure(analysis: &RunAnalysis) -> Option<Figure> {
    let (from, to) = span(analysis)?;
    let rows: Vec<&TrajectoryRow> = (0..=INTERVALS)
        .filter_map(|i| nearest(&analysis.rows, from + (to - from) * i as f64 / INTERVALS as f64))
        .collect();
    let caption = if analysis.gait.steps.len() > 2 {
        "One cycle of two steps from the right side (the robot walks to the right) and from behind. Left leg blue, right \
         leg orange. The frames are placed side by side in the order of time (paper, Fig. 6)."
    } else {
        "Frames at equal intervals over the run, from the right side and from behind (paper, Fig. 6)."
    };
    Some(Figure {
        title: "Figure 6: frames of the robot",
        caption,
        panels: vec![
            FigurePanel::new("frames-side", strip(analysis, &rows, "Side view", Projection::Side)),
            FigurePanel::new("frames-behind", strip(analysis, &rows, "View from behind", Projection::Behind)),
        ],
    })
}

/// Corners of a polygon in the plane of the figure [m].
type Outline = Vec<(f64, f64)>;

#[derive(Clone, Copy)]
enum Projection {
    Side,
    Behind,
}

/// First and last time of the snapshots [s].
fn span(analysis: &RunAnalysis) -> Option<(f64, f64)> {
    let steps = &analysis.gait.steps;
    match steps.len() {
        3.. => Some((steps[steps.len() - 3].start, steps[steps.len() - 1].start)),
        _ => Some((analysis.rows.first()?.derived.time, analysis.rows.last()?.derived.time)),
    }
}

fn nearest(rows: &[TrajectoryRow], time: f64) -> Option<&TrajectoryRow> {
    let after = rows.partition_point(|row| row.derived.time < time);
    rows.get(after).or(rows.last())
}

fn strip(analysis: &RunAnalysis, rows: &[&TrajectoryRow], title: &str, view: Projection) -> String {
    let states: Vec<_> = rows.iter().map(|row| analysis.robot.body_states(&row.truth)).collect();
    let outlines: Vec<Vec<(usize, Outline)>> = (rows.iter().zip(&states))
        .map(|(row, states)| {
            let centre = match view {
                Projection::Side => row.derived.com.x,
                Projection::Behind => -rows[0].derived.com.y,
            };
            (analysis.robot.bodies.iter().zip(states).enumerate())
                .map(|(i, (body, state))| (i, outline(body, &state.pose, view, centre)))
                .collect()
        })
        .collect();
    let points = || outlines.iter().flatten().flat_map(|(_, outline)| outline);
    let reach = points().map(|point| point.0.abs()).fold(0.05, f64::max);
    let top = points().map(|point| point.1).fold(0.1, f64::max);
    let bottom = points().map(|point| point.1).fold(0.0, f64::min);
    // Both axes have the same scale, which determines the height.
    let pitch = PITCH * reach;
    let width = pitch * rows.len() as f64;
    let ceiling = bottom + (top - bottom) * 1.2;
    let height = (TITLE_HEIGHT + STRIP_WIDTH / width * (ceiling - bottom + 0.06)).clamp(120.0, 420.0);
    let middle = |i: usize| (i as f64 + 0.5) * pitch;
    let mut marks = vec![Mark::line(vec![(0.0, 0.0), (width, 0.0)], GREY)];
    for (i, outlines) in outlines.iter().enumerate() {
        let shift = |points: &[(f64, f64)]| points.iter().map(|(u, v)| (u + middle(i), *v)).collect::<Vec<_>>();
        for (body, points) in outlines {
            let colour = colour_of(&analysis.robot.bodies[*body].name);
            // In the side view the left leg is behind the right leg and paler.
            let opacity = if matches!(view, Projection::Side) && colour == RIGHT { 0.6 } else { 0.25 };
            let mut edge = shift(points);
            marks.push(Mark::area(edge.clone(), colour).faint(opacity));
            edge.extend(edge.first().copied());
            marks.push(Mark::thin(edge, colour));
        }
        marks.push(Mark::text((middle(i), top + 0.03 * ceiling), format!("{:.2} s", rows[i].derived.time)));
    }
    let frame = Frame {
        title: title.into(),
        height: height as u32,
        x: PlotAxis::hidden(0.0..width),
        y: PlotAxis::hidden(bottom - 0.04..ceiling),
    };
    plot(&frame, &marks)
}

fn colour_of(body: &str) -> RGBColor {
    match body {
        name if name.starts_with("left") => LEFT,
        name if name.starts_with("right") => RIGHT,
        _ => GREY,
    }
}

/// The projection of a body's box: the convex hull of its eight corners.
fn outline(body: &Body, pose: &IsometryMatrix3<f64>, view: Projection, centre: f64) -> Outline {
    let corners = (0..8).map(|i| {
        let coordinate = |axis: usize| body.com[axis] + body.size[axis] * if i >> axis & 1 == 0 { -0.5 } else { 0.5 };
        let corner = pose * Point3::new(coordinate(0), coordinate(1), coordinate(2));
        match view {
            Projection::Side => (corner.x - centre, corner.z),
            Projection::Behind => (-corner.y - centre, corner.z),
        }
    });
    convex_hull(corners.collect())
}
