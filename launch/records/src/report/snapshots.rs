//! Figure 6: the robot at instants of one cycle, from the side and from the front.

use super::draw::plot;
use super::figure::{Figure, FigurePanel};
use super::plot::{Axis, Frame, GREY, LEFT, Mark, RIGHT};
use crate::analysis::{RunAnalysis, TrajectoryRow};
use messages::robot::Body;
use nalgebra::{IsometryMatrix3, Point3};
use plotters::style::RGBColor;

/// Instants that are drawn.
const FRAMES: usize = 8;

/// Frames over the last whole cycle of two steps; of a robot that does not step, over the whole run.
pub fn figure(analysis: &RunAnalysis) -> Option<Figure> {
    let (from, to) = span(analysis)?;
    let rows: Vec<&TrajectoryRow> =
        (0..=FRAMES).filter_map(|i| nearest(&analysis.rows, from + (to - from) * i as f64 / FRAMES as f64)).collect();
    let caption = if analysis.gait.steps.len() > 2 {
        "One cycle of two steps, left leg blue, right leg orange, seen from the right side (the robot walks to the \
         right) and from behind; frames are set side by side at their times (paper, Fig. 6)."
    } else {
        "Frames at equal times over the run, seen from the right side and from behind (paper, Fig. 6)."
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

/// Corners of a polygon in the plane of the drawing [m].
type Outline = Vec<(f64, f64)>;

#[derive(Clone, Copy)]
enum Projection {
    Side,
    Behind,
}

/// First and last time that is drawn [s].
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
    let placed: Vec<_> = rows.iter().map(|row| analysis.robot.body_states(&row.truth)).collect();
    let outlines: Vec<Vec<(usize, Outline)>> = (rows.iter().zip(&placed))
        .map(|(row, placed)| {
            let centre = match view {
                Projection::Side => row.derived.com.x,
                Projection::Behind => -rows[0].derived.com.y,
            };
            (analysis.robot.bodies.iter().zip(placed).enumerate())
                .map(|(i, (body, placed))| (i, outline(body, &placed.pose, view, centre)))
                .collect()
        })
        .collect();
    let points = || outlines.iter().flatten().flat_map(|(_, outline)| outline);
    let reach = points().map(|point| point.0.abs()).fold(0.05, f64::max);
    let top = points().map(|point| point.1).fold(0.1, f64::max);
    let bottom = points().map(|point| point.1).fold(0.0, f64::min);
    // The strip is 534 px wide; its height follows from the same scale on both axes.
    let pitch = 2.15 * reach;
    let width = pitch * rows.len() as f64;
    let ceiling = bottom + (top - bottom) * 1.2;
    let height = (40.0 + 534.0 / width * (ceiling - bottom + 0.06)).clamp(120.0, 420.0);
    let middle = |i: usize| (i as f64 + 0.5) * pitch;
    let mut marks = vec![Mark::line(vec![(0.0, 0.0), (width, 0.0)], GREY)];
    for (i, outlines) in outlines.iter().enumerate() {
        let shift = |points: &[(f64, f64)]| points.iter().map(|(u, v)| (u + middle(i), *v)).collect::<Vec<_>>();
        for (body, points) in outlines {
            let colour = side(&analysis.robot.bodies[*body].name);
            // From the right, the left leg is far and pale.
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
        x: Axis::hidden(0.0..width),
        y: Axis::hidden(bottom - 0.04..ceiling),
    };
    plot(&frame, &marks)
}

fn side(body: &str) -> RGBColor {
    match body {
        name if name.starts_with("left") => LEFT,
        name if name.starts_with("right") => RIGHT,
        _ => GREY,
    }
}

/// The box of a body, projected: the hull of its eight corners.
fn outline(body: &Body, pose: &IsometryMatrix3<f64>, view: Projection, centre: f64) -> Outline {
    let corners = (0..8).map(|i| {
        let place = |axis: usize| body.com[axis] + body.size[axis] * if i >> axis & 1 == 0 { -0.5 } else { 0.5 };
        let corner = pose * Point3::new(place(0), place(1), place(2));
        match view {
            Projection::Side => (corner.x - centre, corner.z),
            Projection::Behind => (-corner.y - centre, corner.z),
        }
    });
    hull(corners.collect())
}

/// Convex hull, by Andrew's monotone chain.
fn hull(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let chain = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut below = chain(&mut points.iter().copied());
    below.extend(chain(&mut points.iter().rev().copied()));
    below
}
