//! `trajectory.csv`: one line per trajectory row and one for the end of the run, with the units in the column names.

use crate::analysis::{RunAnalysis, TrajectoryRow, normal_forces};
use messages::wire::{JOINTS, PHASES, Truth};
use shared::csv;

/// The table as text. Lines that begin with `#` are comments; the next line names the columns. A cell without a value
/// (for example the zero-moment point in flight) is empty.
pub fn table(analysis: &RunAnalysis) -> String {
    let columns = columns(analysis);
    let names = columns.iter().map(|(name, _)| name.clone()).collect();
    let stored = analysis.rows.last().map(|row| row.truth.stamp.sim_ns);
    let end = analysis.last.iter().filter(|last| Some(last.truth.stamp.sim_ns) != stored);
    let rows =
        analysis.rows.iter().chain(end).map(|row| columns.iter().map(|(_, value)| value(row)).collect::<Vec<_>>());
    String::from(
        "# World frame W: x forward, y left, z up. sole_*: centre of the sole; tilt against the ground.\n\
         # normal_*: normal force on a contact point, mean over the control period; contact points are numbered body by body.\n\
         # torque_*: mean over the control period. x1, v1, x2, v2, e2: the planner's pendulums and energy (31)-(33).\n",
    ) + &csv::text([names].into_iter().chain(rows))
}

/// Least number that is written with nine decimals. Those of a small scene are less: a grain of 1 µg weighs 1e-8 N.
const LEAST_DECIMAL: f64 = 1e-3;

type CsvColumn = (String, Box<dyn Fn(&TrajectoryRow) -> String>);
type JointValues = fn(&Truth) -> &[f64; JOINTS];

/// Names and values of the columns, in order.
fn columns(analysis: &RunAnalysis) -> Vec<CsvColumn> {
    let mut columns = pose();
    let joint_columns: [(&str, &str, JointValues); 3] = [
        ("angle", "rad", |truth| &truth.angle),
        ("rate", "radps", |truth| &truth.rate),
        ("torque", "nm", |truth| &truth.torque),
    ];
    for (name, unit, values) in joint_columns {
        for i in 0..analysis.robot.joint_names().len().min(JOINTS) {
            columns.push(number(&format!("{name}_{i}_{unit}"), move |row| values(&row.truth)[i]));
        }
    }
    columns.extend(whole_body());
    if analysis.robot.feet.is_some() {
        columns.extend(soles());
    }
    for i in 0..analysis.robot.contacts.len() {
        columns.push(number(&format!("normal_{i}_n"), move |row| normal_forces(&row.truth)[i]));
    }
    columns.extend(controller());
    columns
}

fn pose() -> Vec<CsvColumn> {
    let mut columns = vec![number("time_s", |row| row.derived.time)];
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        columns.push(number(&format!("base_{axis}_m"), move |row| row.truth.base_position[i]));
    }
    for (i, part) in ["w", "x", "y", "z"].into_iter().enumerate() {
        columns.push(number(&format!("base_quaternion_{part}"), move |row| row.truth.base_orientation[i]));
    }
    columns
}

fn whole_body() -> Vec<CsvColumn> {
    let mut columns = Vec::new();
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        columns.push(number(&format!("com_{axis}_m"), move |row| row.derived.com[i]));
    }
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        columns.push(number(&format!("com_velocity_{axis}_mps"), move |row| row.derived.com_velocity[i]));
    }
    columns.push(number("zmp_x_m", |row| row.derived.zmp.x));
    columns.push(number("zmp_y_m", |row| row.derived.zmp.y));
    columns
}

fn soles() -> Vec<CsvColumn> {
    let mut columns = Vec::new();
    for (foot, side) in ["left", "right"].into_iter().enumerate() {
        let sole = move |row: &TrajectoryRow| row.derived.soles.map(|soles| soles[foot]);
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let name = format!("sole_{side}_{axis}_m");
            columns.push(number(&name, move |row| sole(row).map_or(f64::NAN, |sole| sole.centre[i])));
        }
        let angle = |name: &str| format!("sole_{side}_{name}_rad");
        columns.push(number(&angle("yaw"), move |row| sole(row).map_or(f64::NAN, |sole| sole.yaw())));
        columns.push(number(&angle("tilt"), move |row| sole(row).map_or(f64::NAN, |sole| sole.tilt)));
    }
    columns
}

fn controller() -> Vec<CsvColumn> {
    let mut columns: Vec<CsvColumn> = vec![
        ("phase".into(), Box::new(|row| PHASES.get(row.truth.telemetry.phase as usize).unwrap_or(&"?").to_string())),
        ("support".into(), Box::new(|row| if row.truth.telemetry.support == 0 { "left" } else { "right" }.into())),
        ("steps".into(), Box::new(|row| row.truth.telemetry.steps.to_string())),
    ];
    for (i, name) in ["x1_m", "v1_mps", "x2_m", "v2_mps"].into_iter().enumerate() {
        columns.push(number(name, move |row| row.truth.telemetry.pendulum[i]));
    }
    columns.push(number("e2_m2ps2", |row| row.truth.telemetry.energy[1]));
    columns.push(number("e2_ref_m2ps2", |row| row.truth.telemetry.energy_ref[1]));
    columns
}

fn number(name: &str, value: impl Fn(&TrajectoryRow) -> f64 + 'static) -> CsvColumn {
    (name.into(), Box::new(move |row| cell(value(row))))
}

/// A number with nine decimals, or with nine digits if they would hold fewer than seven of them; empty if it is not finite.
fn cell(value: f64) -> String {
    match value {
        _ if !value.is_finite() => String::new(),
        _ if value != 0.0 && value.abs() < LEAST_DECIMAL => format!("{value:.8e}"),
        _ => format!("{value:.9}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::synthetic::SyntheticWalk;
    use messages::scene::Scene;

    #[test]
    fn the_table_has_a_line_per_row_and_all_cells() {
        let (walk, mut analysis) = (SyntheticWalk::new(0.06), RunAnalysis::new(&Scene::default()));
        for seq in 0..=2000 {
            analysis.push(&walk.truth(seq, seq as f64 * 1e-3));
        }
        let table = table(&analysis);
        let mut lines = table.lines().skip_while(|line| line.starts_with('#'));
        let header: Vec<_> = lines.next().unwrap().split(',').collect();
        // time, pose 7, joints 3 x 8, com 6, zmp 2, soles 2 x 5, normals 8, controller 9
        assert_eq!(header.len(), 1 + 7 + 24 + 6 + 2 + 10 + 8 + 9);
        let rows: Vec<Vec<_>> = lines.map(|line| line.split(',').collect()).collect();
        assert_eq!(rows.len(), 401, "2 s at 200 Hz, both ends");
        assert!(rows.iter().all(|row| row.len() == header.len()));
        let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
        assert_eq!(rows[400][column("time_s")].parse::<f64>().unwrap(), 2.0);
        let com: f64 = rows[400][column("com_y_m")].parse().unwrap();
        assert!((com - analysis.rows[400].derived.com.y).abs() < 1e-9);
        assert_eq!(rows[400][column("phase")], "walk");
    }

    #[test]
    fn a_number_keeps_its_digits_whatever_its_size() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut random = fastrand::Rng::with_seed(seed);
        for exponent in -300..10 {
            let value = (1.0 + 9.0 * random.f64()) * 10f64.powi(exponent) * if random.bool() { 1.0 } else { -1.0 };
            let read: f64 = cell(value).parse().unwrap();
            assert!((read - value).abs() <= 5.1e-7 * value.abs(), "{value:e} is written as {}", cell(value));
        }
        assert_eq!(
            [0.0, 0.5, -0.001, 9.81e-9].map(cell),
            ["0.000000000", "0.500000000", "-0.001000000", "9.81000000e-9"]
        );
        assert_eq!([f64::NAN, f64::INFINITY].map(cell), ["", ""]);
    }

    #[test]
    fn the_last_line_is_the_end_of_the_run() {
        let walk = SyntheticWalk::new(0.06);
        for times in [&[0, 4][..], &[0, 5, 10, 13], &[0, 5, 10], &[0]] {
            let (mut analysis, end) = (RunAnalysis::new(&Scene::default()), times[times.len() - 1]);
            (0..=end).for_each(|ms| analysis.push(&walk.truth(ms, ms as f64 * 1e-3)));
            let table = table(&analysis);
            let lines = table.lines().skip_while(|line| line.starts_with('#')).skip(1);
            let firsts: Vec<_> = lines.map(|line| line.split(',').next().unwrap()).collect();
            assert_eq!(firsts, times.iter().map(|ms| format!("0.{ms:03}000000")).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_robot_without_feet_or_joints_has_fewer_columns() {
        let mut scene = Scene::default();
        scene.bodies.retain(|body| body.name == messages::robot::TRUNK);
        let mut analysis = RunAnalysis::new(&scene);
        analysis.push(&SyntheticWalk::new(0.0).truth(0, 0.0));
        let table = table(&analysis);
        let widths: Vec<_> =
            table.lines().skip_while(|line| line.starts_with('#')).map(|l| l.split(',').count()).collect();
        assert_eq!(widths, [1 + 7 + 6 + 2 + 9; 2]);
    }
}
