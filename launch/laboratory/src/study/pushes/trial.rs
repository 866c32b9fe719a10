//! One run with pushes at given times.

use super::DURATION;
use messages::scene::Scene;
use records::record::Recorder;
use records::summary::yaw;
use sessions::run::in_process_with;
use shared::exit::{Exit, Failure, check_interrupt};
use std::sync::atomic::AtomicBool;

/// A push of the base.
#[derive(Clone, Copy)]
pub struct Push {
    /// When it begins [s].
    pub time: f64,
    /// In W [N·s].
    pub impulse: [f64; 3],
}

/// What became of a run.
pub struct Trial {
    /// All that was recorded, but for rows.
    pub recorder: Recorder,
    /// When the robot fell [s].
    pub fall: Option<f64>,
    /// Greatest angle of the trunk about the vertical [deg].
    pub yaw: f64,
}

/// Runs a scene with pushes, in the order of their times, to its end or its fall.
///
/// # Errors
/// Ctrl-C, or a scene that is bad. What fails otherwise is a fall.
pub fn disturbed(scene: &Scene, pushes: &[Push], stop: &AtomicBool) -> Result<Trial, Failure> {
    let base = scene.bodies.iter().position(|body| body.joint.is_none()).unwrap_or(0);
    let mut recorder = Recorder::without_rows(scene);
    let (mut next, mut turned, mut time) = (0, 0.0_f64, 0.0);
    let end = in_process_with(scene, |truth, simulation| {
        check_interrupt(stop)?;
        recorder.push(truth);
        time = truth.stamp.sim_ns as f64 * 1e-9;
        turned = turned.max(yaw(truth.base_orientation).to_degrees().abs());
        while let Some(push) = pushes.get(next).filter(|push| push.time <= time) {
            simulation.push(base, push.impulse, DURATION);
            next += 1;
        }
        if recorder.extremes.fall.is_some() { Err(Failure::new(Exit::Fell, "it fell")) } else { Ok(()) }
    });
    let fall = match end {
        Err(failure) if failure.exit == Exit::Interrupted || time == 0.0 => return Err(failure),
        Err(_) => recorder.extremes.fall.or(Some(time)),
        Ok(()) => None,
    };
    Ok(Trial { recorder, fall, yaw: turned })
}
