//! `biped study`: tables that the documents quote, each case a scene with some values changed.

use crate::in_process;
use crate::scenes;
use crate::summary::Summary;
use anyhow::Result;
use clap::ValueEnum;
use indicatif::{ParallelProgressIterator, ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::fmt::Write;
use std::path::Path;

/// Which table.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Study {
    /// How far the robot, its sensors and the ground may be off before it falls.
    Margins,
    /// The same walk under each contact law.
    Laws,
    /// Where the lateral orbit is attracted to, with and without the energy rule (39).
    Attraction,
    /// Long walks.
    Endurance,
}

/// One run of a table.
struct Case {
    name: String,
    scene: &'static str,
    settings: Vec<String>,
}

fn case(name: impl Into<String>, scene: &'static str, settings: &[&str]) -> Case {
    Case { name: name.into(), scene, settings: settings.iter().map(|setting| (*setting).into()).collect() }
}

/// Runs the cases of a study on all cores, prints the table and writes it to `out`, if given, as Markdown and CSV.
pub fn run(study: Study, out: Option<&Path>, quiet: bool) -> Result<()> {
    let cases = match study {
        Study::Margins => margins(),
        Study::Laws => laws(),
        Study::Attraction => attraction(),
        Study::Endurance => endurance(),
    };
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(cases.len() as u64) };
    bar.set_style(ProgressStyle::with_template("{bar:40} {pos}/{len} cases, {elapsed} of {duration}")?);
    let results: Vec<Summary> = cases.par_iter().progress_with(bar).map(simulate).collect::<Result<_>>()?;
    let table = table(study, &cases, &results);
    print!("{table}");
    if let Some(out) = out {
        std::fs::create_dir_all(out)?;
        let name = study.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned());
        std::fs::write(out.join(format!("{name}.md")), table)?;
    }
    Ok(())
}

fn simulate(case: &Case) -> Result<Summary> {
    let scene = scenes::load(case.scene, &case.settings)?;
    in_process::simulate(case.scene, &scene)
}

/// Columns that a study shows.
fn columns(study: Study) -> Vec<(&'static str, fn(&Summary) -> String)> {
    let mut columns: Vec<(&'static str, fn(&Summary) -> String)> = vec![
        ("outcome", |s| s.fall_time_s.map_or("up".into(), |t| format!("fell at {t:.1} s"))),
        ("x m", |s| format!("{:.2}", s.distance_m)),
        ("y m", |s| format!("{:.3}", s.lateral_m)),
        ("yaw °", |s| format!("{:.2}", s.yaw_deg)),
        ("m/s", |s| format!("{:.3}", s.speed_mps)),
        ("period s", |s| format!("{:.3} ± {:.3}", s.period_s, s.period_std_s)),
        ("x_2 min m", |s| format!("{:.4}", s.x2_min_m)),
        ("peak N·m", |s| format!("{:.1}", s.peak_torque_nm.into_iter().fold(0.0, f64::max))),
        ("tilt °", |s| format!("{:.2}", s.foot_tilt_max_deg)),
    ];
    if let Study::Laws = study {
        columns.extend([
            ("hop mm", (|s| format!("{:.2}", 1e3 * s.hop_max_m)) as fn(&Summary) -> String),
            ("sinks mm", |s| format!("{:.3}", 1e3 * s.penetration_max_m)),
            ("peak force N", |s| format!("{:.0}", s.peak_force_n)),
            ("Signorini", |s| format!("{:.0e}", s.signorini_max)),
            ("natural map", |s| format!("{:.0e}", s.natural_map_max)),
            ("energy gain J", |s| format!("{:.0e}", s.energy_gain_max_j)),
            ("µs/step", |s| format!("{:.2}", s.plant_median_s * 1e6 / s.steps_per_period as f64)),
        ]);
    }
    columns
}

fn table(study: Study, cases: &[Case], results: &[Summary]) -> String {
    let columns = columns(study);
    let mut rows = vec![["case"].into_iter().chain(columns.iter().map(|(name, _)| *name)).map(String::from).collect::<Vec<_>>()];
    rows.extend(cases.iter().zip(results).map(|(case, summary)| {
        [case.name.clone()].into_iter().chain(columns.iter().map(|(_, cell)| cell(summary))).collect()
    }));
    let widths: Vec<usize> =
        (0..rows[0].len()).map(|k| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0)).collect();
    let mut text = String::new();
    for (i, row) in rows.iter().enumerate() {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!(" {cell:<width$} |")).collect::<String>();
        let _ = writeln!(text, "|{cells}");
        if i == 0 {
            let rule = widths.iter().map(|width| format!("{}|", "-".repeat(width + 2))).collect::<String>();
            let _ = writeln!(text, "|{rule}");
        }
    }
    let up = results.iter().filter(|summary| !summary.fell).count();
    let _ = writeln!(text, "\n{up} of {} stay up.", results.len());
    text
}

fn margins() -> Vec<Case> {
    let mut cases = vec![case("walk as it is", "walk", &[]), case("stamp as it is, 14 s", "stamp", &["duration=14"])];
    let mut vary = |what: &str, unit: &str, key: &str, values: &[&str]| {
        cases.extend(values.iter().map(|v| case(format!("{what} {v}{unit}"), "walk", &[&format!("{key}={v}")])));
    };
    vary("dt", " s", "plant.dt", &["0.000125", "0.00025", "0.001"]);
    vary("latency", " ms", "plant.latency_ticks", &["1", "2", "3", "4"]);
    vary("stale ticks, probability", "", "plant.stale_probability", &["0.2", "0.5"]);
    vary("friction", "", "plant.friction", &["0.4", "0.3", "0.2", "0.15"]);
    vary("payload", " kg", "plant.payload_kg", &["1", "2", "3", "4"]);
    vary("encoder", " bit", "plant.encoder_bits", &["18", "16", "15", "14", "13"]);
    vary("torque limit", " N·m", "plant.torque_limit", &["25", "20", "16", "14"]);
    vary("joint damping", " N·m·s", "plant.joint_damping", &["0.2", "0.5"]);
    vary("speed", " m/s", "controller.speed", &["-0.1", "0.1", "0.3"]);
    vary("feedback of the measured CoG", " 1/s", "controller.com_feedback", &["5", "20"]);
    cases.push(case("control 250 Hz", "walk", &["rate=250"]));
    cases.push(case("control 500 Hz", "walk", &["rate=500"]));
    cases.push(case("control 2000 Hz", "walk", &["rate=2000"]));
    cases.push(case("relay", "walk", &["controller.switching=relay"]));
    cases.push(case("joint rates ≤ 4 rad/s in the QP", "walk", &["controller.rate_limit=4"]));
    cases.push(case("no drive inertia", "walk", &["plant.drive_inertia=0"]));
    cases.push(case("the paper's sagittal rule", "walk-literal", &[]));
    cases.push(case("without foot placement (control)", "walk", &["controller.foot_placement_gain=0"]));
    cases.push(case(
        "all at once: 1 ms late, 16 bit, μ .4, 1 kg off centre, 25 N·m",
        "walk",
        &[
            "plant.latency_ticks=1",
            "plant.encoder_bits=16",
            "plant.friction=0.4",
            "plant.payload_kg=1",
            "plant.payload_offset=[0.03, 0.02, 0.1]",
            "plant.torque_limit=25",
        ],
    ));
    for (scene, name) in [("walk", "walking"), ("stamp", "stamping")] {
        for (direction, impulse) in
            [("forward", [2, 0]), ("backward", [-2, 0]), ("left", [0, 2]), ("right", [0, -2])]
        {
            for eighth in 0..8 {
                let time = 8.0 + 0.6 * f64::from(eighth) / 8.0;
                cases.push(case(
                    format!("2 N·s {direction} at {eighth}/8 of a period, {name}"),
                    scene,
                    &[
                        "duration=14",
                        &format!("plant.push_impulse=[{}.0, {}.0, 0.0]", impulse[0], impulse[1]),
                        &format!("plant.push_time={time}"),
                    ],
                ));
            }
        }
    }
    cases
}

fn laws() -> Vec<Case> {
    let laws = ["EnergyQp", "Complementarity", "Aligned"];
    let each = |name: &str, scene: &'static str, more: &[&str]| {
        laws.map(|law| {
            let settings: Vec<&str> = more.to_vec();
            let law_setting = format!("plant.law={law}");
            let all: Vec<&str> = settings.into_iter().chain([law_setting.as_str()]).collect();
            case(format!("{name}, {law}"), scene, &all)
        })
    };
    [
        each("walk 14 s", "walk", &[]),
        each("walk 110 s", "walk", &["duration=110"]),
        each("walk 14 s, dt .25 ms", "walk", &["plant.dt=0.00025"]),
        each("stamp 60 s", "stamp", &[]),
        each("slide", "slide", &[]),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn attraction() -> Vec<Case> {
    let mut cases = Vec::new();
    for gain in ["4.0", "0.0"] {
        for start in ["0.030", "0.034", "0.0388", "0.041", "0.044"] {
            cases.push(case(
                format!("k_E = {gain}, released at x_2 = {start} m"),
                "stamp",
                &[
                    "duration=10",
                    &format!("controller.energy_gain={gain}"),
                    &format!("controller.release_x2={start}"),
                ],
            ));
        }
    }
    cases
}

fn endurance() -> Vec<Case> {
    vec![
        case("walk 110 s", "walk", &["duration=110"]),
        case("walk 600 s", "walk", &["duration=600"]),
        case("stamp 600 s", "stamp", &["duration=600"]),
        case("the paper's sagittal rule 110 s", "walk-literal", &["duration=110"]),
    ]
}
