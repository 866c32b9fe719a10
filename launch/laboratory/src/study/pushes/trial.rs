//! Runs with pushes at given times.

use messages::scene::Scene;
use messages::wire::Truth;
use records::analysis::RunAnalysis;
use records::summary::yaw;
use sessions::run::InProcess;
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
    finish(scene, InProcess::new(scene)?, RunAnalysis::without_rows(scene), pushes, stop)
}

/// A walk up to the instant of a push. Pushes of different strength continue from here.
pub struct UndisturbedWalk<'a> {
    scene: &'a Scene,
    run: InProcess,
    /// The record at time zero.
    first: Truth,
    /// Time of the push [s].
    time: f64,
}

impl UndisturbedWalk<'_> {
    /// Walks until this time [s]. `None` if the run fails before.
    ///
    /// # Errors
    /// Ctrl-C, or a bad scene.
    pub fn until<'a>(scene: &'a Scene, time: f64, stop: &AtomicBool) -> Result<Option<UndisturbedWalk<'a>>, Failure> {
        let mut run = InProcess::new(scene)?;
        let (first, mut reached) = (run.truth(), 0.0);
        let end = run.finish(|truth, _| {
            check_interrupt(stop)?;
            reached = truth.stamp.time();
            if reached >= time { Err(Failure::new(Exit::Ok, "the time of the push")) } else { Ok(()) }
        });
        match end {
            Err(failure) if failure.exit == Exit::Interrupted || reached == 0.0 => Err(failure),
            _ => Ok((reached >= time).then_some(UndisturbedWalk { scene, run, first, time })),
        }
    }

    /// Continues with a push of this impulse [N·s], to the end or to the fall.
    ///
    /// # Errors
    /// As [`disturbed`].
    pub fn pushed(&self, impulse: [f64; 3], stop: &AtomicBool) -> Result<PushTrial, Failure> {
        let mut recorder = RunAnalysis::without_rows(self.scene);
        recorder.push(&self.first); // a fall is judged by the initial posture
        let push = TimedPush { time: self.time, impulse };
        finish(self.scene, self.run.branch(self.scene)?, recorder, &[push], stop)
    }
}

/// Finishes a run with pushes.
fn finish(
    scene: &Scene,
    mut run: InProcess,
    mut recorder: RunAnalysis,
    pushes: &[TimedPush],
    stop: &AtomicBool,
) -> Result<PushTrial, Failure> {
    let base = scene.base_body();
    let (mut next, mut turned, mut time) = (0, 0.0_f64, 0.0);
    let end = run.finish(|truth, simulation| {
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
