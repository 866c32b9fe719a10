//! The analysis: a stream of [`Truth`] in, everything that summary, CSV and report need out.
//!
//! Steps, extrema and histograms see every record; rows are kept at 200 Hz at most and thinned out in long runs, so
//! that memory stays bounded.

mod derived;
mod energy_balance;
mod extrema;
mod gait;
mod histogram;
mod kinematic_tree;
mod peaks;
mod request_log;
#[cfg(test)]
pub mod synthetic;

pub use derived::{DerivedState, normal_forces};
pub use energy_balance::EnergyBalance;
pub use extrema::Extrema;
pub use gait::{LateralState, StepDetector};
pub use histogram::Histogram;
pub use kinematic_tree::{BodyState, FootGeometry, KinematicTree};
pub use peaks::Peaks;
pub use request_log::{RequestLog, RequestRecord};

use messages::scene::Scene;
use messages::wire::Truth;

/// A record and what it means.
#[derive(Clone)]
pub struct TrajectoryRow {
    /// As it came over the wire.
    pub truth: Truth,
    /// Derived quantities.
    pub derived: DerivedState,
    /// What came in peaks since the row before.
    pub peaks: Peaks,
}

/// Listens to a run.
pub struct RunAnalysis {
    /// The scene's robot.
    pub robot: KinematicTree,
    /// Evenly spaced rows, oldest first, if they are kept.
    pub rows: Vec<TrajectoryRow>,
    /// Time and x of the centre of mass at the same times, in any case [s, m].
    pub track: Vec<[f64; 2]>,
    /// First record.
    pub first: Option<TrajectoryRow>,
    /// Latest record.
    pub last: Option<TrajectoryRow>,
    /// Steps.
    pub gait: StepDetector,
    /// Extrema.
    pub extrema: Extrema,
    /// Where its energy goes.
    pub energy: EnergyBalance,
    /// Histograms of every record.
    pub distributions: Distributions,
    /// What was asked of it.
    pub requests: RequestLog,
    /// Records left out because their pose is not finite.
    pub dropped: u64,
    /// Integration steps in one control period.
    pub steps_per_period: u64,
    row_ns: u64,
    /// When the last row was, if there is one [ns].
    last_row_ns: Option<u64>,
    keeps_rows: bool,
    /// Peaks since the last row.
    peaks: Peaks,
    /// Where the bodies are in the record at hand.
    placed: Vec<BodyState>,
}

/// Histograms of quantities that are looked at by order of magnitude.
pub struct Distributions {
    /// Natural-map residuals, relative.
    pub natural_map: Histogram,
    /// Signorini residuals, relative.
    pub signorini: Histogram,
    /// Energy above that of free motion [J]; its zeros are the steps that lost or kept energy.
    pub energy_gain: Histogram,
    /// How many records needed 0, 1, 2, ... pivots; the last bin holds the rest.
    pub pivots: Vec<u64>,
    /// Time that the plant computed per control period [ns].
    pub plant: Histogram,
    /// Time that it waited for the command [ns].
    pub wait: Histogram,
}

/// Rows never come closer than this [ns].
const ROW_NS: u64 = 5_000_000;
/// What happens this long after a fall is of no interest [s].
const AFTERMATH: f64 = 1.0;
/// More rows than these are thinned out by half.
const MAX_ROWS: usize = 24_000;

impl RunAnalysis {
    /// Prepares to listen to a run of the scene.
    pub fn new(scene: &Scene) -> Self {
        RunAnalysis {
            robot: KinematicTree::new(scene),
            rows: Vec::new(),
            track: Vec::new(),
            first: None,
            last: None,
            gait: StepDetector::default(),
            extrema: Extrema::default(),
            energy: EnergyBalance::new(scene),
            distributions: Distributions::new(),
            requests: RequestLog::default(),
            dropped: 0,
            steps_per_period: (1.0 / (scene.rate * scene.plant.dt)).round() as u64,
            row_ns: ROW_NS,
            last_row_ns: None,
            keeps_rows: true,
            peaks: Peaks::default(),
            placed: Vec::new(),
        }
    }

    /// The same without rows, which only tables and drawings need: they are most of the memory that a run takes.
    pub fn without_rows(scene: &Scene) -> Self {
        RunAnalysis { keeps_rows: false, ..RunAnalysis::new(scene) }
    }

    /// The time of the fall [s], once it has been seen to its end: nothing is recorded any more.
    pub fn time_of_completed_fall(&self) -> Option<f64> {
        let time = self.last.as_ref().map_or(0.0, |last| last.derived.time);
        self.extrema.fall.filter(|fall| time >= fall + AFTERMATH)
    }

    /// Takes the next record. One whose pose is not finite is counted and left out.
    pub fn push(&mut self, truth: &Truth) {
        if self.time_of_completed_fall().is_some() {
            return;
        }
        self.distributions.push(truth);
        self.robot.body_states_into(truth, &mut self.placed);
        let derived = DerivedState::new(&self.robot, truth, &self.placed);
        if !is_placed(truth) || derived.com.iter().chain(&derived.com_velocity).any(|value| value.is_nan()) {
            self.dropped += 1;
            return;
        }
        self.extrema.push(&self.robot, truth, &derived);
        self.energy.push(&self.robot, truth, &self.placed, &derived);
        if self.extrema.fall.is_none() {
            self.gait.push(&derived);
        }
        if self.keeps_rows {
            self.peaks = self.peaks.and(&Peaks::of(truth));
        }
        let row = match &mut self.last {
            Some(row) => {
                row.truth = *truth; // in its place, for a record is large
                row.derived = derived;
                row.peaks = self.peaks;
                row
            }
            none => none.insert(TrajectoryRow { truth: *truth, derived, peaks: self.peaks }),
        };
        self.first.get_or_insert_with(|| row.clone());
        let (now, slot) = (truth.stamp.sim_ns, |time: u64| time / self.row_ns);
        if self.last_row_ns.is_some_and(|last| slot(last) >= slot(now)) {
            return;
        }
        self.last_row_ns = Some(now);
        self.track.push([row.derived.time, row.derived.com.x]);
        if self.keeps_rows {
            self.rows.push(row.clone());
            self.peaks = Peaks::default();
        }
        if self.track.len() > MAX_ROWS {
            self.thin_out();
        }
    }

    /// Leaves out every second row.
    fn thin_out(&mut self) {
        let (mut even, mut gone) = (false, Peaks::default());
        self.rows.retain_mut(|row| {
            even = !even;
            match even {
                true => row.peaks = row.peaks.and(&gone),
                false => gone = row.peaks,
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

/// Whether the base's pose and every joint angle are finite and the quaternion is not zero.
fn is_placed(truth: &Truth) -> bool {
    let numbers = truth.base_position.iter().chain(&truth.base_orientation).chain(&truth.angle);
    numbers.copied().all(f64::is_finite) && truth.base_orientation.iter().any(|part| *part != 0.0)
}

impl Distributions {
    fn new() -> Self {
        Distributions {
            natural_map: Histogram::new(-20, 2),
            signorini: Histogram::new(-20, 2),
            energy_gain: Histogram::new(-20, 4),
            pivots: vec![0; 65],
            plant: Histogram::new(2, 9),
            wait: Histogram::new(2, 9),
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
mod tests {
    use super::synthetic::SyntheticWalk;
    use super::*;

    #[test]
    fn rows_stay_bounded_and_evenly_spaced_however_long_the_run() {
        let mut analysis = RunAnalysis::new(&Scene::default());
        let mut truth = SyntheticWalk::new(0.0).truth(0, 0.0);
        for tick in 0..200_000_u64 {
            truth.stamp.sim_ns = tick * 1_000_000;
            analysis.push(&truth);
        }
        assert!(analysis.rows.len() <= MAX_ROWS && analysis.rows.len() > MAX_ROWS / 3, "{}", analysis.rows.len());
        let gaps = analysis.rows.windows(2).map(|w| w[1].truth.stamp.sim_ns - w[0].truth.stamp.sim_ns);
        assert!(gaps.into_iter().all(|gap| gap == analysis.row_ns));
    }

    #[test]
    fn no_peak_is_lost_between_rows_however_thin_they_are() {
        let mut analysis = RunAnalysis::new(&Scene::default());
        let mut truth = SyntheticWalk::new(0.0).truth(0, 0.0);
        for tick in 0..200_000_u64 {
            truth.stamp.sim_ns = tick * 1_000_000;
            truth.late_ns = if tick == 77_777 { 5 } else { 0 };
            truth.torque[3] = if tick == 123_456 { -9.0 } else { 1.0 };
            analysis.push(&truth);
        }
        let at =
            |is: fn(&Peaks) -> bool| analysis.rows.iter().filter(move |row| is(&row.peaks)).map(|row| row.derived.time);
        for (times, peak) in [(at(|peaks| peaks.late_ns == 5), 77.777), (at(|peaks| peaks.torque[3] == -9.0), 123.456)]
        {
            let (times, period) = (times.collect::<Vec<_>>(), analysis.row_ns as f64 * 1e-9);
            assert!(matches!(times[..], [time] if (0.0..=period).contains(&(time - peak))), "{times:?} for {peak}");
        }
    }

    #[test]
    fn odd_robots_and_broken_records_do_not_panic() {
        let mut slider = Scene::default();
        slider.bodies.retain(|body| body.name == messages::robot::TRUNK);
        let mut loose = Scene::default();
        loose.bodies.retain(|body| body.name != messages::robot::TRUNK);
        let nothing = Scene { bodies: vec![], ..Scene::default() };
        for scene in [slider, loose, nothing] {
            let mut analysis = RunAnalysis::new(&scene);
            analysis.push(&Truth::default());
            analysis.push(&SyntheticWalk::new(0.06).truth(1, 3.0));
            let mut broken = SyntheticWalk::new(0.06).truth(2, 3.001);
            broken.angle[3] = f64::NAN;
            analysis.push(&broken);
            assert!(analysis.dropped >= 2);
            assert_eq!(analysis.extrema.fall, None);
        }
    }
}
