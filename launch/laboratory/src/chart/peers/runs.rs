//! Runs of other simulators, as traces of poses. Their errors are computed in the same way as the errors of our own runs.

use super::resolved;
use crate::chart::cases::{self, Combination, ComparisonScene, LAW, METHOD, Question};
use crate::chart::csv::{Measurement, View};
use crate::chart::metrics::{self, Metric};
use crate::chart::trial::{RunLog, StateSample};
use messages::scene::Scene;
use nalgebra::{Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use shared::exit::{Exit, Failure};
use std::path::Path;

/// The file of all runs, a line of JSON for each.
const RUNS: &str = "runs.jsonl";
/// With a greater error, a run counts as blown up.
const BLOWN_UP: f64 = 1e6;

/// A line of the file of runs.
#[derive(Deserialize)]
struct PeerRun {
    view: String,
    scene: String,
    engine: String,
    method: String,
    /// Step [s].
    dt: f64,
    us_per_step: f64,
    /// Steps between two rows of the trace, if there is one.
    #[serde(default)]
    stride: usize,
    /// File of the trace, 64-bit floats: by row the poses `x y z qw qx qy qz` of the bodies that may touch the ground, in flight the
    /// kinetic energy.
    trace: Option<String>,
}

/// The rows of every run in a folder.
///
/// # Errors
/// A file that cannot be read, or holds no such runs.
pub fn measure(folder: &Path) -> Result<Vec<Measurement>, Failure> {
    let file = folder.join(RUNS);
    let fault = |reason: String| Failure::new(Exit::Usage, format!("--peers: {}: {reason}", file.display()));
    if !file.exists() {
        let words = format!("--peers: the folder {} has no {RUNS}", folder.display());
        return Err(Failure::new(Exit::Usage, words));
    }
    let text = messages::file::text(&file).map_err(|error| fault(error.to_string()))?;
    let mut rows = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let bad = |reason: String| fault(format!("line {}: {reason}", number + 1));
        let run: PeerRun = serde_json::from_str(line).map_err(|error| bad(error.to_string()))?;
        let view = View::named(&run.view).ok_or_else(|| bad(format!("there is no view `{}`", run.view)))?;
        let row = |metric: &str, error: f64| Measurement {
            view,
            scene: run.scene.clone(),
            engine: run.engine.clone(),
            method: run.method.clone(),
            dt: run.dt,
            metric: metric.into(),
            error,
            cost: 1e-6 * run.us_per_step / run.dt,
            us_per_step: run.us_per_step,
        };
        let Some(trace) = &run.trace else {
            rows.push(row("", f64::NAN));
            continue;
        };
        let [case] = cases::chosen(std::slice::from_ref(&run.scene))?[..] else { continue };
        let errors = errors(case, &folder.join(trace), run.dt * run.stride as f64).map_err(bad)?;
        rows.extend(errors.into_iter().map(|(metric, error)| row(metric, error)));
    }
    Ok(rows)
}

/// The errors of a run; infinite where it blew up.
fn errors(case: ComparisonScene, file: &Path, period: f64) -> Result<Vec<Metric>, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let (values, rest) = bytes.as_chunks::<8>();
    let trace: Vec<f64> = values.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let refused = |failure: Failure| failure.message;
    let resolved = resolved::scene(case.name).map_err(refused)?;
    let width = width(case.question, &resolved);
    if trace.len() < 2 * width || !trace.len().is_multiple_of(width) || !rest.is_empty() {
        return Err(format!("{} is no trace of rows of {width} numbers", file.display()));
    }
    if trace.iter().any(|value| !value.is_finite()) {
        return Ok(case.question.metrics().iter().map(|&metric| (metric, f64::INFINITY)).collect());
    }
    let scene = cases::scene(case.name, Combination { law: LAW, method: METHOD }, 1e-3, &[]).map_err(refused)?;
    let errors =
        metrics::errors(case.question, &scene, &log(case.question, &resolved, trace.chunks_exact(width), period));
    let finite = |error: f64| if error < BLOWN_UP { error } else { f64::INFINITY };
    Ok(errors.into_iter().map(|(metric, error)| (metric, finite(error))).collect())
}

/// Numbers in a row of a trace.
fn width(question: Question, scene: &Scene) -> usize {
    match question {
        Question::Flight => 1,
        _ => 7 * scene.bodies.iter().filter(|body| body.contact_spheres().next().is_some()).count(),
    }
}

/// Converts a trace to the record format of our own runs. Only the parts that errors need are filled in.
fn log<'a>(question: Question, scene: &Scene, rows: impl ExactSizeIterator<Item = &'a [f64]>, period: f64) -> RunLog {
    let (mut log, last) = (RunLog::default(), rows.len() - 1);
    for (i, row) in rows.enumerate() {
        let mut sample = StateSample { time: i as f64 * period, ..StateSample::default() };
        if question == Question::Flight {
            sample.totals.kinetic = row[0];
        } else {
            let points = record_poses(scene, row, &mut sample);
            if i == last / 2 {
                log.halves[0] = points;
            } else if i == last {
                log.halves[1] = points;
            }
        }
        log.samples.push(sample);
    }
    log
}

/// Enters the poses of the bodies that may touch the ground; returns their contact points, of a ball its lowest point [m].
fn record_poses(scene: &Scene, row: &[f64], sample: &mut StateSample) -> Vec<Vector3<f64>> {
    let touching = || scene.bodies.iter().filter(|body| body.contact_spheres().next().is_some());
    let poses = row.chunks_exact(7).map(|pose| {
        let turn = UnitQuaternion::new_normalize(Quaternion::new(pose[3], pose[4], pose[5], pose[6]));
        Translation3::new(pose[0], pose[1], pose[2]) * turn
    });
    let mut points = Vec::new();
    (sample.low, sample.high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (first, (body, pose)) in touching().zip(poses).enumerate() {
        if first == 0 {
            let (ahead, axis) = (pose * Vector3::x(), pose * Vector3::z());
            sample.totals.com = pose.translation.vector; // of a single body, whose origin it is
            (sample.tilt, sample.yaw) = (axis.x.atan2(axis.z), ahead.y.atan2(ahead.x));
        }
        for ball in body.contact_spheres() {
            let point = (pose * Point3::from(ball.at)).coords - Vector3::z() * ball.radius;
            if point.z < sample.low {
                (sample.low, sample.ahead) = (point.z, point.x - sample.totals.com.x);
            }
            sample.high = sample.high.max(point.z);
            points.push(point);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::cases::CASES;
    use crate::chart::trial::{RunEnd, watch};
    use messages::robot::Body;
    use plant::Plant;
    use plant::kinematics::{self, Pose};

    /// Poses of the bodies that may touch the ground, that of the base at its centre of mass, or the kinetic energy.
    fn row(plant: &Plant, scene: &Scene, question: Question) -> Vec<f64> {
        let (model, mut pose) = (plant.model(), Pose::new(plant.model()));
        kinematics::pose(model, plant.state(), &mut pose);
        if question == Question::Flight {
            return vec![kinematics::totals(model, plant.state(), &pose).kinetic];
        }
        let bodies =
            scene.bodies.iter().zip(&model.body_link).filter(|(body, _)| body.contact_spheres().next().is_some());
        let pose = |(body, &link): (&Body, &usize)| {
            let origin = if body.joint.is_none() { model.links[link].com } else { Vector3::zeros() };
            [pose.point(link, &origin).as_slice(), &pose.orientation(link)[..]].concat()
        };
        bodies.flat_map(pose).collect()
    }

    /// A run of this simulator has the same errors as a record and as a trace.
    #[test]
    fn a_trace_is_judged_as_our_own_run_is() {
        let file = std::env::temp_dir().join(format!("biped-trace-{}", std::process::id()));
        let write = |values: &[f64]| {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            std::fs::write(&file, bytes).expect("a file");
        };
        for case in CASES {
            let scene = cases::scene(case.name, Combination { law: LAW, method: METHOD }, 1e-3, &[]).expect("a scene");
            let RunEnd::Done(log) = watch(&scene, &[]) else { panic!("{} breaks off", case.name) };
            let mut plant = Plant::new(&scene).expect("a plant");
            let mut trace = row(&plant, &scene, case.question);
            for _ in 1..log.samples.len() {
                plant.advance(&messages::wire::Torques::default()).expect("a step");
                trace.extend(row(&plant, &scene, case.question));
            }
            write(&trace);
            let found = errors(case, &file, 1e-3).expect("errors");
            for ((metric, found), (_, own)) in found.into_iter().zip(metrics::errors(case.question, &scene, &log)) {
                assert!((found - own).abs() < 1e-9 + 1e-6 * own, "{} {metric}: {found:e}, recorded {own:e}", case.name);
            }
            write(&vec![f64::NAN; trace.len()]);
            let blown_up = errors(case, &file, 1e-3).expect("errors");
            assert!(blown_up.iter().all(|metric| metric.1 == f64::INFINITY), "{}", case.name);
            write(&trace[1..=1]);
            assert!(errors(case, &file, 1e-3).expect_err("one number").contains("no trace"), "{}", case.name);
        }
        std::fs::remove_file(&file).expect("our own file");
    }
}
