//! Vertical load on the feet, and the zero-moment point under the support foot.

use super::draw::plot;
use super::figure::{Figure, FigurePanel, last_cycles, series, time_axis};
use super::plot::{Frame, GREY, LEFT, Mark, PlotAxis, RIGHT, ZMP};
use crate::analysis::{RunAnalysis, TrajectoryRow};

/// Percentile of the load that the axis is scaled by [-]: above it are the peaks at touchdown.
const LOAD_PERCENTILE: usize = 98;

/// Loads over the last cycles, and the zero-moment point in the frame of the sole.
pub fn figure(analysis: &RunAnalysis) -> Figure {
    let mut panels = vec![FigurePanel::new("loads", loads(analysis))];
    if analysis.robot.feet.is_some() {
        panels.push(FigurePanel::new("zmp", zmp(analysis)));
    }
    let (title, caption) = if analysis.robot.feet.is_some() {
        (
            "Load on the feet and zero-moment point",
            "The weight moves from foot to foot at each change of support. Dots show the zero-moment point in single \
             support, without its first 40 ms, in which a foot may still rest on one edge: the farther it is from the edge of the \
             sole, the larger the margin against tipping.",
        )
    } else {
        ("Load", "Sum of the normal forces on all contact points, as means over each control period.")
    };
    Figure { title, caption, panels }
}

fn loads(analysis: &RunAnalysis) -> String {
    let rows = last_cycles(analysis);
    let foot = |i: usize| series(rows, |row| row.derived.soles.map_or(f64::NAN, |soles| soles[i].load));
    let marks = if analysis.robot.feet.is_some() {
        vec![Mark::line(foot(0), LEFT).label("left foot"), Mark::line(foot(1), RIGHT).label("right foot")]
    } else {
        vec![Mark::line(series(rows, |row| row.derived.load), LEFT).label("all contact points")]
    };
    // An axis up to the peak at touchdown would make the rest illegible, so it ends at twice a high percentile.
    let mut values: Vec<f64> = rows.iter().map(|row| row.derived.load).collect();
    values.sort_by(f64::total_cmp);
    let high = values.get(values.len() * LOAD_PERCENTILE / 100).copied().unwrap_or(1.0);
    let top = (2.0 * high).min(values.last().copied().unwrap_or(1.0) * 1.08).max(1.0);
    let frame = Frame {
        title: "Vertical load".into(),
        height: 330,
        x: time_axis(rows.iter().map(|row| row.derived.time)),
        y: PlotAxis::new("force [N]", 0.0..top),
    };
    plot(&frame, &marks)
}

fn zmp(analysis: &RunAnalysis) -> String {
    let mut marks = Vec::new();
    let mut reach = [0.1, 0.05];
    if let Some([foot, _]) = &analysis.robot.feet {
        reach = foot.half;
        let corners = foot.outline.iter().map(|corner| (corner.x, corner.y));
        marks.push(Mark::area(corners.clone().collect(), GREY).faint(0.12).label("sole"));
        marks.push(Mark::thin(corners.cycle().take(foot.outline.len() + 1).collect(), GREY));
    }
    for (i, (label, colour)) in [("left foot", LEFT), ("right foot", RIGHT)].into_iter().enumerate() {
        let walks = |row: &&TrajectoryRow| analysis.extrema.fall.is_none_or(|fall| row.derived.time < fall);
        let points = last_cycles(analysis).iter().filter(walks).filter_map(|row| in_sole(row, i)).collect();
        marks.push(Mark::dots(points, 1.6, colour).faint(0.7).label(label));
    }
    let origin = vec![(0.0, 0.0)];
    marks.push(Mark::dots(origin, 3.0, ZMP).label("sole's centre"));
    let frame = Frame {
        title: "Zero-moment point in single support".into(),
        height: 330,
        x: PlotAxis::new("forward of the sole's centre [m]", -1.2 * reach[0]..1.2 * reach[0]),
        y: PlotAxis::new("left of it [m]", -1.2 * reach[1]..1.2 * reach[1]),
    };
    plot(&frame, &marks)
}

/// The zero-moment point in the frame of the sole, if this foot supports alone and has landed.
fn in_sole(row: &TrajectoryRow, foot: usize) -> Option<(f64, f64)> {
    let (_, sole) = row.derived.single_support().filter(|(support, _)| row.has_landed && *support == foot)?;
    let offset = sole.offset_to(row.derived.zmp);
    Some((offset.x, offset.y))
}
