//! Figure 9: phase portrait in the lateral plane, and the energy of the lateral pendulum.

use super::draw::plot;
use super::figure::{Figure, FigurePanel, LAST_STEPS, series, time_axis};
use super::plot::{COM, Frame, GREEN, GREY, INK, Mark, PlotAxis, padded_range};
use crate::analysis::{LateralState, RunAnalysis, TrajectoryRow};
use messages::wire::{PHASES, Telemetry};

/// The orbit of (32) in the support frame, the orbit of the reference energy (40), and E_2 over time.
pub fn figure(analysis: &RunAnalysis) -> Option<Figure> {
    if analysis.gait.steps.is_empty() {
        return None;
    }
    Some(Figure {
        title: "Figure 9: phase portrait in the lateral plane",
        caption: "In the support frame a step runs from touchdown (bottom right) past the turning point to the next touchdown \
                  (top right). In a stable limit cycle the last steps follow one arc. Control law (39) keeps it on the \
                  orbit of the reference energy (40) (paper, Fig. 9).",
        panels: vec![
            FigurePanel::new("phase-portrait", portrait(analysis)),
            FigurePanel::new("energy", energy(analysis)),
        ],
    })
}

fn portrait(analysis: &RunAnalysis) -> String {
    let steps = &analysis.gait.steps;
    let (begin, last_begin) = (steps[0].start, steps[steps.len().saturating_sub(LAST_STEPS + 1)].start);
    let all = orbit(analysis.rows.iter().filter(|row| row.derived.time >= begin));
    let last = orbit(analysis.rows.iter().filter(|row| row.derived.time >= last_begin));
    let x = padded_range(all.iter().map(|point| point.0), 0.06, 0.01);
    let y = padded_range(all.iter().map(|point| point.1), 0.08, 0.05);
    let mut marks =
        vec![Mark::thin(all, GREY).faint(0.6).label("all steps"), Mark::line(last, COM).label("last 8 steps")];
    if let Some(points) = reference(analysis) {
        marks.push(Mark::dashes(points, INK).label("orbit of the reference energy"));
    }
    let frame = Frame {
        title: "Support frame, axis 2 from the support to the swing foot".into(),
        height: 380,
        x: PlotAxis::new("x_c2 [m]", x),
        y: PlotAxis::new("dx_c2/dt [m/s]", y),
    };
    plot(&frame, &marks)
}

/// Lateral states, interrupted where the support foot changes.
fn orbit<'a>(rows: impl Iterator<Item = &'a TrajectoryRow>) -> Vec<(f64, f64)> {
    let (mut points, mut previous) = (Vec::new(), None);
    for now in rows.filter_map(|row| LateralState::new(&row.derived)) {
        if previous.is_some_and(|support| support != now.support) {
            points.push((f64::NAN, f64::NAN));
        }
        previous = Some(now.support);
        points.push((now.position, now.velocity));
    }
    points
}

/// The orbit (33) with E_2 = E_2ref, up to half the distance of the feet.
fn reference(analysis: &RunAnalysis) -> Option<Vec<(f64, f64)>> {
    let energy = walking(analysis).last()?.energy_ref[1];
    let omega = omega(analysis).filter(|_| energy < 0.0)?;
    let [left, right] = analysis.rows.last()?.derived.soles?;
    let x_min = (-2.0 * energy).sqrt() / omega;
    let half = (left.centre.y - right.centre.y).abs() / 2.0;
    let reach = (half / x_min).max(1.0).acosh();
    Some(
        (-40..=40).map(|i| reach * f64::from(i) / 40.0).map(|s| (x_min * s.cosh(), x_min * omega * s.sinh())).collect(),
    )
}

/// Telemetry of the planner during the walking phase.
fn walking(analysis: &RunAnalysis) -> impl Iterator<Item = &Telemetry> {
    let all = analysis.rows.iter().map(|row| &row.truth.telemetry);
    all.filter(|telemetry| PHASES.get(telemetry.phase as usize) == Some(&"walk"))
}

/// ω_2 from the planner's states and energies by (33): the median of sqrt(v² − 2E)/x.
fn omega(analysis: &RunAnalysis) -> Option<f64> {
    let mut estimates: Vec<f64> = walking(analysis)
        .map(|telemetry| (telemetry.pendulum[3].powi(2) - 2.0 * telemetry.energy[1]).sqrt() / telemetry.pendulum[2])
        .filter(|omega| omega.is_finite() && *omega > 0.0)
        .collect();
    estimates.sort_by(f64::total_cmp);
    estimates.get(estimates.len() / 2).copied()
}

/// E_2 from three sources: the planner's estimate, the robot's centre of mass by (33), and the reference.
fn energy(analysis: &RunAnalysis) -> String {
    let omega = omega(analysis).unwrap_or(f64::NAN);
    let measured = |row: &TrajectoryRow| {
        let lateral = LateralState::new(&row.derived);
        lateral.map_or(f64::NAN, |at| 0.5 * (at.velocity.powi(2) - (omega * at.position).powi(2)))
    };
    let begin = analysis.gait.steps.first().map_or(0.0, |step| step.start);
    let robot: Vec<(f64, f64)> =
        series(&analysis.rows, measured).into_iter().filter(|point| point.0 >= begin).collect();
    // before the first command there is no telemetry
    let planned = |row: &TrajectoryRow, energy: f64| if row.truth.command.seq > 0 { energy } else { f64::NAN };
    let estimated = series(&analysis.rows, |row| planned(row, row.truth.telemetry.energy[1]));
    let reference = series(&analysis.rows, |row| planned(row, row.truth.telemetry.energy_ref[1]));
    let all = || estimated.iter().chain(&reference);
    let frame = Frame {
        title: "Energy of the lateral pendulum".into(),
        height: 380,
        x: time_axis(all().map(|point| point.0)),
        y: PlotAxis::new("E_2 [m²/s²]", padded_range(all().map(|point| point.1), 0.08, 2e-3)),
    };
    let marks = [
        Mark::thin(robot, COM).faint(0.7).label("of the robot"),
        Mark::line(estimated, GREEN).label("estimated"),
        Mark::dashes(reference, INK).label("reference (40)"),
    ];
    plot(&frame, &marks)
}
