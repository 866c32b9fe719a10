//! One run with pushes at given times.

use messages::scene::Scene;
use records::analysis::RunAnalysis;
use records::summary::yaw;
use sessions::run::in_process_with;
use shared::exit::{Exit, Failure, check_interrupt};
use std::sync::atomic::AtomicBool;

/// The first push may come when the gait is steady [s].
pub const BEGIN: f64 = 4.5;
/// Duration of a push [s].
pub const DURATION: f64 = 0.05;

/// A push of the base.
#[derive(Clone, Copy)]
pub struct TimedPush {
    /// Start [s].
    pub time: f64,
    /// Impulse in W [N·s].
    pub impulse: [f64; 3],
}

/// The result of a run.
pub struct PushTrial {
    /// The record, without rows.
    pub recorder: RunAnalysis,
    /// Time of the fall [s].
    pub fall: Option<f64>,
    /// Greatest angle of the trunk about the vertical [deg].
    pub yaw: f64,
}

/// Runs a scene with pushes, which are sorted by time, to its end or to the fall.
///
/// # Errors
/// Ctrl-C, or a bad scene. Any other failure counts as a fall.
pub fn disturbed(scene: &Scene, pushes: &[TimedPush], stop: &AtomicBool) -> Result<PushTrial, Failure> {
    let base = scene.bodies.iter().position(|body| body.joint.is_none()).unwrap_or(0);
    let mut recorder = RunAnalysis::without_rows(scene);
    let (mut next, mut turned, mut time) = (0, 0.0_f64, 0.0);
    let end = in_process_with(scene, |truth, simulation| {
        check_interrupt(stop)?;
        recorder.push(truth);
        time = truth.stamp.time();
        turned = turned.max(yaw(truth.base_orientation).to_degrees().abs());
        while let Some(push) = pushes.get(next).filter(|push| push.time <= time) {
            simulation.push(base, push.impulse, DURATION);
            next += 1;
        }
        if recorder.extrema.fall.is_some() { Err(Failure::new(Exit::Fell, "it fell")) } else { Ok(()) }
    });
    let fall = match end {
        Err(failure) if failure.exit == Exit::Interrupted || time == 0.0 => return Err(failure),
        Err(_) => recorder.extrema.fall.or(Some(time)),
        Ok(()) => None,
    };
    Ok(PushTrial { recorder, fall, yaw: turned })
}
