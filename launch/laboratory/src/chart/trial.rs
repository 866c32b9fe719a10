//! A scene is run twice: once recorded, for its accuracy, and once without a record, for its cost.

use messages::scene::Scene;
use messages::wire::Torques;
use nalgebra::Vector3;
use nix::time::{ClockId, clock_gettime};
use plant::kinematics::{self, Pose, Totals};
use plant::{Plant, PlantError};
use shared::exit::{Failure, check_interrupt};
use shared::interrupt::{RESULTS_LOST, UnderWay};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Instant;

/// A sample of the robot's state after a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct StateSample {
    /// Simulated time [s].
    pub time: f64,
    /// Sums over the whole robot.
    pub totals: Totals,
    /// Height of the lowest contact point [m].
    pub low: f64,
    /// Height of the highest contact point [m].
    pub high: f64,
    /// x of the lowest contact point relative to the base's origin [m].
    pub ahead: f64,
    /// Horizontal speed of that point [m/s].
    pub slip: f64,
    /// Angle about y between the base's axis z and that of W [rad].
    pub tilt: f64,
    /// Angle about z between the base's axis x and that of W [rad].
    pub yaw: f64,
    /// Rate about y of the base [rad/s].
    pub spin: f64,
    /// Normal impulse of the ground since the start [N·s].
    pub load: f64,
}

/// The record of a run.
#[derive(Clone, Debug, Default)]
pub struct RunLog {
    /// The start and every step after it.
    pub samples: Vec<StateSample>,
    /// Contact points in the middle and at the end of the run [m].
    pub halves: [Vec<Vector3<f64>>; 2],
    /// Worst residual |f_N v_N| of a step.
    pub signorini: f64,
    /// Worst natural map of a step.
    pub natural_map: f64,
    /// Greatest energy that the contacts of a step gave [J].
    pub energy_gain: f64,
    /// Steps that needed the solver's fallback.
    pub fallbacks: u64,
    /// Hash of every state.
    pub hash: u64,
}

/// How a run ended.
#[derive(Clone, Debug)]
pub enum RunEnd {
    /// It reached its end.
    Done(RunLog),
    /// The method cannot simulate the scene, or Ctrl-C.
    Refused,
    /// It broke off.
    Broken(PlantError),
}

/// Runs a scene with the `torques` of each control period, and without torques after the last of them; keeps a record.
pub fn watch(scene: &Scene, torques: &[Torques]) -> RunEnd {
    watch_until(scene, torques, &AtomicBool::new(false))
}

/// As [`watch`], until Ctrl-C, for runs that may take long.
pub fn watch_until(scene: &Scene, torques: &[Torques], stop: &AtomicBool) -> RunEnd {
    let Ok(mut plant) = Plant::new(scene) else { return RunEnd::Refused };
    let mut pose = Pose::new(plant.model());
    let mut log = RunLog::default();
    log.samples.reserve(periods(scene) + 1);
    log.record(&plant, &mut pose, 0.0);
    let _under_way = UnderWay::begin(RESULTS_LOST);
    for period in 0..periods(scene) {
        if stop.load(Relaxed) {
            return RunEnd::Refused;
        }
        if let Err(error) = plant.advance(torques.get(period).unwrap_or(&Torques::default())) {
            return RunEnd::Broken(error);
        }
        log.record(&plant, &mut pose, 1.0 / scene.rate);
        if period + 1 == periods(scene) / 2 {
            log.halves[0] = points(&plant, &pose);
        }
    }
    log.halves[1] = points(&plant, &pose);
    RunEnd::Done(log)
}

/// CPU time of the same run without a record [s], and the hash of its states. A short run is repeated, and the least time counts.
///
/// # Errors
/// If the run breaks off. Ctrl-C.
pub fn time(scene: &Scene, torques: &[Torques], stop: &AtomicBool) -> Result<(f64, u64), Failure> {
    let (mut least, mut spent, mut hash) = (f64::INFINITY, 0.0, 0);
    let mut runs = 0;
    let _under_way = UnderWay::begin(RESULTS_LOST);
    while runs == 0 || (runs < 3 && spent < 0.1) || (runs < 25 && spent < 0.02) {
        let mut plant = Plant::new(scene)?;
        let start = cpu_seconds();
        for period in 0..periods(scene) {
            check_interrupt(stop)?;
            plant.advance(torques.get(period).unwrap_or(&Torques::default()))?;
        }
        let taken = cpu_seconds() - start;
        (least, spent, runs) = (least.min(taken), spent + taken, runs + 1);
        hash = plant.truth().hash;
    }
    Ok((least, hash))
}

/// Time of every step of the same run [s], and the hash of its states. The run has one step per control period. A short run is
/// repeated three times, and the fastest counts.
///
/// Times are wall times, because reading the thread's CPU clock takes too long. Interruptions affect few steps, beyond the 99th
/// percentile.
///
/// # Errors
/// If the run breaks off. Ctrl-C.
pub fn times(scene: &Scene, torques: &[Torques], stop: &AtomicBool) -> Result<(Vec<f64>, u64), Failure> {
    let asking = median(&mut (0..999).map(|_| Instant::now().elapsed().as_secs_f64()).collect::<Vec<_>>());
    let _under_way = UnderWay::begin(RESULTS_LOST);
    let run = || {
        let mut plant = Plant::new(scene)?;
        let steps = (0..periods(scene)).map(|period| {
            check_interrupt(stop)?;
            let start = Instant::now();
            plant.advance(torques.get(period).unwrap_or(&Torques::default()))?;
            Ok((start.elapsed().as_secs_f64() - asking).max(0.0))
        });
        let steps = steps.collect::<Result<Vec<_>, Failure>>()?;
        Ok::<_, Failure>((steps, plant.truth().hash))
    };
    let whole = |run: &(Vec<f64>, u64)| run.0.iter().sum::<f64>();
    let mut shortest = run()?;
    for _ in 1..if whole(&shortest) < 0.1 { 3 } else { 1 } {
        let other = run()?;
        if whole(&other) < whole(&shortest) {
            shortest = other;
        }
    }
    Ok(shortest)
}

/// The median.
pub fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// The quantile of a share of the values.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get(((share * values.len() as f64) as usize).min(last)).copied().unwrap_or(f64::NAN)
}

/// Number of control periods of a scene, to index torques.
fn periods(scene: &Scene) -> usize {
    scene.periods() as usize
}

/// CPU time of this thread [s].
fn cpu_seconds() -> f64 {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID)
        .map_or(f64::NAN, |time| time.tv_sec() as f64 + 1e-9 * time.tv_nsec() as f64)
}

/// The contact points [m].
fn points(plant: &Plant, pose: &Pose) -> Vec<Vector3<f64>> {
    plant.model().contact_points.iter().map(|corner| pose.reference + pose.lowest(corner)).collect()
}

impl RunLog {
    /// Where the centre of mass ended [m].
    pub fn end(&self) -> Option<Vector3<f64>> {
        self.samples.last().map(|sample| sample.totals.com)
    }

    fn record(&mut self, plant: &Plant, pose: &mut Pose, period: f64) {
        let (model, truth) = (plant.model(), plant.truth());
        kinematics::pose(model, plant.state(), pose);
        let base = &pose.links[model.base_link];
        let (ahead, axis) = (base.rotation.column(0), base.rotation.column(2));
        let mut sample = StateSample {
            time: plant.time_ns() as f64 * 1e-9,
            totals: kinematics::totals(model, plant.state(), pose),
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            tilt: axis.x.atan2(axis.z),
            yaw: ahead.y.atan2(ahead.x),
            spin: base.velocity.angular.y,
            load: self.samples.last().map_or(0.0, |last| last.load),
            ..StateSample::default()
        };
        for corner in &model.contact_points {
            let arm = pose.lowest(corner);
            let point = pose.reference + arm;
            if point.z < sample.low {
                let velocity = pose.links[corner.link].velocity.at(&arm);
                (sample.low, sample.ahead) = (point.z, point.x - truth.base_position[0]);
                sample.slip = velocity.x.hypot(velocity.y);
            }
            sample.high = sample.high.max(point.z);
        }
        sample.load += truth.contact_force.iter().skip(2).step_by(3).sum::<f64>() * period;
        self.signorini = self.signorini.max(truth.signorini);
        self.natural_map = self.natural_map.max(truth.natural_map);
        self.energy_gain = self.energy_gain.max(truth.energy_gain);
        (self.fallbacks, self.hash) = (truth.fallbacks, truth.hash);
        self.samples.push(sample);
    }
}
