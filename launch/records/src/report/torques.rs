//! Joint torques.

use super::draw::plot;
use super::figure::{Figure, FigurePanel, last_cycles, series, time_axis};
use super::plot::{COM, Frame, GREEN, LEFT, Mark, PlotAxis, RIGHT, padded_range};
use crate::analysis::{LEG_JOINTS, RunAnalysis};
use messages::wire::JOINTS;

/// Torques of both legs over the last cycles. `None` without joints.
pub fn figure(analysis: &RunAnalysis) -> Option<Figure> {
    let joints = analysis.robot.joint_names().len().min(JOINTS);
    if joints == 0 {
        return None;
    }
    let panels = if analysis.robot.feet.is_some() && joints == JOINTS {
        vec![
            FigurePanel::new("torques-left", panel(analysis, "Left leg", [0, 1, 2, 3], LEG_JOINTS)),
            FigurePanel::new("torques-right", panel(analysis, "Right leg", [7, 6, 5, 4], LEG_JOINTS)),
        ]
    } else {
        let names = [["joint 0", "joint 1", "joint 2", "joint 3"], ["joint 4", "joint 5", "joint 6", "joint 7"]];
        let mut panels = vec![FigurePanel::new("torques", panel(analysis, "Joints", [0, 1, 2, 3], names[0]))];
        if joints > 4 {
            panels.push(FigurePanel::new("torques-more", panel(analysis, "Further joints", [4, 5, 6, 7], names[1])));
        }
        panels
    };
    Some(Figure {
        title: "Joint torques",
        caption: "Torques of the drives over the last eight steps and the fall after them, or over the whole run if it has fewer. A torque has the \
                  sign convention of its joint angle, so the two legs mirror each other during a walk.",
        panels,
    })
}

fn panel(analysis: &RunAnalysis, title: &str, joints: [usize; 4], names: [&'static str; 4]) -> String {
    let rows = last_cycles(analysis);
    let present = analysis.robot.joint_names().len();
    let marks: Vec<Mark> = (joints.into_iter().zip(names).zip([GREEN, LEFT, RIGHT, COM]))
        .filter(|((joint, _), _)| *joint < present)
        .map(|((joint, name), colour)| Mark::line(series(rows, |row| row.truth.torque[joint]), colour).label(name))
        .collect();
    let all = || rows.iter().flat_map(|row| row.truth.torque);
    let frame = Frame {
        title: title.into(),
        height: 330,
        x: time_axis(rows.iter().map(|row| row.derived.time)),
        y: PlotAxis::new("torque [N·m]", padded_range(all(), 0.06, 0.1)),
    };
    plot(&frame, &marks)
}
