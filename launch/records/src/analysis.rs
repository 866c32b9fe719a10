//! Online analysis of a run: it consumes the stream of [`Truth`] records and computes what summary, CSV and report need.
//!
//! Step detection, extrema and histograms use every record. Trajectory rows are stored at 200 Hz at most. A long run
//! drops every second row repeatedly, so memory stays bounded.

mod convex_hull;
mod derived;
mod energy_balance;
mod extrema;
mod foot_geometry;
mod gait;
mod histogram;
mod kinematic_tree;
mod peaks;
mod request_log;
#[cfg(test)]
pub mod synthetic;
mod track;

pub use convex_hull::convex_hull;
pub use derived::{DerivedState, normal_forces};
pub use energy_balance::EnergyBalance;
pub use extrema::{Extrema, InitialPosture};
pub use foot_geometry::FootGeometry;
pub use gait::{LateralState, StepDetector};
pub use histogram::Histogram;
pub use kinematic_tree::{BodyState, KinematicTree, LEG_JOINTS};
pub use peaks::Peaks;
pub use request_log::{RequestLog, RequestRecord};
pub use track::{TrackPoint, speed_of_second_half};

use messages::scene::Scene;
use messages::wire::Truth;

/// A record with the quantities derived from it.
#[derive(Clone)]
pub struct TrajectoryRow {
    /// The record as received.
    pub truth: Truth,
    /// Quantities derived from it.
    pub derived: DerivedState,
    /// Peak values since the previous row.
    pub peaks: Peaks,
    /// Whether one foot supports, and has landed: see [`Extrema::has_landed`].
    pub has_landed: bool,
}

/// The analysis of one run, updated record by record.
pub struct RunAnalysis {
    /// The scene's robot.
    pub robot: KinematicTree,
    /// Evenly spaced rows, oldest first. Empty if the analysis stores no rows.
    pub rows: Vec<TrajectoryRow>,
    /// The way of the centre of mass along x at the times of the rows. Stored even without rows.
    pub track: Vec<TrackPoint>,
    /// First record.
    pub first: Option<TrajectoryRow>,
    /// Latest record.
    pub last: Option<TrajectoryRow>,
    /// Detected steps.
    pub gait: StepDetector,
    /// Extrema over all records.
    pub extrema: Extrema,
    /// Energy balance.
    pub energy: EnergyBalance,
    /// Histograms over all records.
    pub distributions: Distributions,
    /// Requests that the session answered.
    pub requests: RequestLog,
    /// Records skipped because their pose is not finite.
    pub dropped: u64,
    /// Integration steps in one control period.
    pub steps_per_period: u64,
    /// Spacing of the rows [ns].
    row_ns: u64,
    /// Simulated time of the latest row [ns].
    last_row_ns: Option<u64>,
    stores_rows: bool,
    /// Peak values since the latest row.
    peaks: Peaks,
    /// Buffer for the body states of the current record.
    states: Vec<BodyState>,
}

/// Histograms of quantities that vary over orders of magnitude.
pub struct Distributions {
    /// Natural-map residuals, relative.
    pub natural_map: Histogram,
    /// Signorini residuals, relative.
    pub signorini: Histogram,
    /// Energy above that of free motion [J]. Zero counts the periods without a gain.
    pub energy_gain: Histogram,
    /// Number of records that needed 0, 1, 2, ... pivots. The last bin counts all larger numbers.
    pub pivots: Vec<u64>,
    /// Computing time of the plant per control period [ns].
    pub plant: Histogram,
    /// Time that the plant waited for the command [ns].
    pub wait: Histogram,
}

/// Least spacing of rows [ns]: 200 Hz resolves every motion of a figure.
const ROW_NS: u64 = 5_000_000;
/// The analysis stops this long after a fall [s]: enough to show how the robot comes down.
const TIME_AFTER_FALL: f64 = 1.0;
/// Beyond this number every second row is dropped: two minutes at 200 Hz.
const MAX_ROWS: usize = 24_000;
/// Decades of the residual histograms: from far below rounding error to far above 1.
const RESIDUAL_DECADES: [i32; 2] = [-20, 2];
/// Decades of the histogram of energy gain [J], from far below rounding error to far above the robot's own energy.
const ENERGY_DECADES: [i32; 2] = [-20, 4];
/// Decades of the timing histograms [ns]: 100 ns to 1 s.
const TIMING_DECADES: [i32; 2] = [2, 9];
/// Bins of the pivot histogram: 0 to 63 pivots, and one bin for more.
const PIVOT_BINS: usize = 65;

impl RunAnalysis {
    /// An analysis of a run of the scene that stores rows.
    pub fn new(scene: &Scene) -> Self {
        let robot = KinematicTree::new(scene);
        RunAnalysis {
            rows: Vec::new(),
            track: Vec::new(),
            first: None,
            last: None,
            gait: StepDetector::default(),
            extrema: Extrema::default(),
            energy: EnergyBalance::new(scene, &robot),
            robot,
            distributions: Distributions::new(),
            requests: RequestLog::default(),
            dropped: 0,
            steps_per_period: (1.0 / (scene.rate * scene.plant.dt)).round() as u64,
            row_ns: ROW_NS,
            last_row_ns: None,
            stores_rows: true,
            peaks: Peaks::default(),
            states: Vec::new(),
        }
    }

    /// The same without rows. Only tables and figures need rows, and they take most of the memory.
    pub fn without_rows(scene: &Scene) -> Self {
        RunAnalysis { stores_rows: false, ..RunAnalysis::new(scene) }
    }

    /// Time of the fall [s], once [`TIME_AFTER_FALL`] has passed since. From then on records are ignored.
    pub fn time_of_completed_fall(&self) -> Option<f64> {
        let time = self.last.as_ref().map_or(0.0, |last| last.derived.time);
        self.extrema.fall.filter(|fall| time >= fall + TIME_AFTER_FALL)
    }

    /// Analyses the next record. A record with a non-finite pose is counted and skipped.
    pub fn push(&mut self, truth: &Truth) {
        if self.time_of_completed_fall().is_some() {
            return;
        }
        self.distributions.push(truth);
        self.robot.body_states_into(truth, &mut self.states);
        let derived = DerivedState::new(&self.robot, truth, &self.states);
        if !has_valid_pose(truth) || derived.com.iter().chain(&derived.com_velocity).any(|value| value.is_nan()) {
            self.dropped += 1;
            return;
        }
        self.extrema.push(&self.robot, truth, &derived);
        self.energy.push(&self.robot, truth, &self.states, &derived);
        if self.extrema.fall.is_none() {
            self.gait.push(&derived);
        }
        if self.stores_rows {
            self.peaks = self.peaks.max(&Peaks::new(truth));
        }
        let has_landed = self.extrema.has_landed(derived.time);
        let row = match &mut self.last {
            Some(row) => {
                row.truth = *truth; // assigned in place, because a record is large
                row.derived = derived;
                row.peaks = self.peaks;
                row.has_landed = has_landed;
                row
            }
            none => none.insert(TrajectoryRow { truth: *truth, derived, peaks: self.peaks, has_landed }),
        };
        self.first.get_or_insert_with(|| row.clone());
        let (now, slot) = (truth.stamp.sim_ns, |time: u64| time / self.row_ns);
        if self.last_row_ns.is_some_and(|last| slot(last) >= slot(now)) {
            return;
        }
        self.last_row_ns = Some(now);
        self.track.push(TrackPoint::new(&row.derived));
        if self.stores_rows {
            self.rows.push(row.clone());
            self.peaks = Peaks::default();
        }
        if self.track.len() > MAX_ROWS {
            self.thin_out();
        }
    }

    /// Drops every second row. The next row keeps the peak values of the dropped one.
    fn thin_out(&mut self) {
        let (mut even, mut dropped) = (false, Peaks::default());
        self.rows.retain_mut(|row| {
            even = !even;
            match even {
                true => row.peaks = row.peaks.max(&dropped),
                false => dropped = row.peaks,
            }
            even
        });
        let mut even = false;
        self.track.retain(|_| {
            even = !even;
            even
        });
        self.row_ns *= 2;
    }
}

/// True if the pose of the base and all joint angles are finite and the quaternion is not zero.
fn has_valid_pose(truth: &Truth) -> bool {
    let numbers = truth.base_position.iter().chain(&truth.base_orientation).chain(&truth.angle);
    numbers.copied().all(f64::is_finite) && truth.base_orientation.iter().any(|part| *part != 0.0)
}

impl Distributions {
    fn new() -> Self {
        Distributions {
            natural_map: Histogram::new(RESIDUAL_DECADES),
            signorini: Histogram::new(RESIDUAL_DECADES),
            energy_gain: Histogram::new(ENERGY_DECADES),
            pivots: vec![0; PIVOT_BINS],
            plant: Histogram::new(TIMING_DECADES),
            wait: Histogram::new(TIMING_DECADES),
        }
    }

    fn push(&mut self, truth: &Truth) {
        self.natural_map.add(truth.natural_map);
        self.signorini.add(truth.signorini);
        self.energy_gain.add(truth.energy_gain);
        let last = self.pivots.len() - 1;
        self.pivots[(truth.pivots as usize).min(last)] += 1;
        self.plant.add(truth.plant_ns as f64);
        self.wait.add(truth.wait_ns as f64);
    }
}

#[cfg(test)]
mod tests;
