//! Joint torques.

use super::draw::plot;
use super::figure::{Figure, Panel, last_cycles, series};
use super::plot::{Axis, COM, Frame, GREEN, LEFT, Mark, RIGHT, around};
use crate::record::Recorder;
use messages::wire::JOINTS;

/// Torques of both legs over the last cycles; `None` without joints.
pub fn figure(recorder: &Recorder) -> Option<Figure> {
    let joints = recorder.robot.joints().len().min(JOINTS);
    if joints == 0 {
        return None;
    }
    let panels = if recorder.robot.feet.is_some() && joints == JOINTS {
        let names = ["ankle roll", "ankle pitch", "knee", "hip"];
        vec![
            Panel::new("torques-left", panel(recorder, "Left leg", [0, 1, 2, 3], names)),
            Panel::new("torques-right", panel(recorder, "Right leg", [7, 6, 5, 4], names)),
        ]
    } else {
        let names = [["joint 0", "joint 1", "joint 2", "joint 3"], ["joint 4", "joint 5", "joint 6", "joint 7"]];
        let mut panels = vec![Panel::new("torques", panel(recorder, "Joints", [0, 1, 2, 3], names[0]))];
        if joints > 4 {
            panels.push(Panel::new("torques-more", panel(recorder, "Further joints", [4, 5, 6, 7], names[1])));
        }
        panels
    };
    Some(Figure {
        title: "Joint torques",
        caption: "Torques of the drives over the last eight steps, or over the whole run if it has fewer; each counts as \
                  its joint's angle does, so that the two legs of a walk mirror each other.",
        panels,
    })
}

fn panel(recorder: &Recorder, title: &str, joints: [usize; 4], names: [&'static str; 4]) -> String {
    let rows = last_cycles(recorder);
    let present = recorder.robot.joints().len();
    let marks: Vec<Mark> = (joints.into_iter().zip(names).zip([GREEN, LEFT, RIGHT, COM]))
        .filter(|((joint, _), _)| *joint < present)
        .map(|((joint, name), colour)| Mark::line(series(rows, |row| row.truth.torque[joint]), colour).label(name))
        .collect();
    let all = || rows.iter().flat_map(|row| row.truth.torque);
    let frame = Frame {
        title: title.into(),
        height: 330,
        x: Axis::new("time [s]", around(rows.iter().map(|row| row.sample.time), 0.0, 1e-3)),
        y: Axis::new("torque [N·m]", around(all(), 0.06, 0.1)),
    };
    plot(&frame, &marks)
}
