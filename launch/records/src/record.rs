//! The recorder: a stream of [`Truth`] in, everything that summary, CSV and report need out.
//!
//! Steps, extremes and histograms see every record; rows are kept at 200 Hz at most and thinned out in long runs, so
//! that memory stays bounded.

mod energy;
mod extremes;
#[cfg(test)]
pub mod fake;
mod gait;
mod histogram;
mod requests;
mod robot;
mod sample;
mod worst;

pub use energy::Energy;
pub use extremes::Extremes;
pub use gait::{Gait, Lateral};
pub use histogram::Histogram;
pub use requests::{Answered, Requests};
pub use robot::{Foot, Placed, Robot};
pub use sample::{Sample, normal_forces};
pub use worst::Worst;

use messages::scene::Scene;
use messages::wire::Truth;

/// A record and what it means.
#[derive(Clone)]
pub struct Row {
    /// As it came over the wire.
    pub truth: Truth,
    /// Derived quantities.
    pub sample: Sample,
    /// What came in peaks since the row before.
    pub worst: Worst,
}

/// Listens to a run.
pub struct Recorder {
    /// The scene's robot.
    pub robot: Robot,
    /// Evenly spaced rows, oldest first, if they are kept.
    pub rows: Vec<Row>,
    /// Time and x of the centre of mass at the same times, in any case [s, m].
    pub track: Vec<[f64; 2]>,
    /// First record.
    pub first: Option<Row>,
    /// Latest record.
    pub last: Option<Row>,
    /// Steps.
    pub gait: Gait,
    /// Extremes.
    pub extremes: Extremes,
    /// Where its energy goes.
    pub energy: Energy,
    /// Histograms of every record.
    pub spread: Spread,
    /// What was asked of it.
    pub requests: Requests,
    /// Records left out because their pose is not finite.
    pub dropped: u64,
    /// Integration steps in one control period.
    pub steps_per_period: u64,
    row_ns: u64,
    /// When the last row was, if there is one [ns].
    last_row_ns: Option<u64>,
    keeps_rows: bool,
    /// Peaks since the last row.
    worst: Worst,
    /// Where the bodies are in the record at hand.
    placed: Vec<Placed>,
}

/// Histograms of quantities that are looked at by order of magnitude.
pub struct Spread {
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

impl Recorder {
    /// Prepares to listen to a run of the scene.
    pub fn new(scene: &Scene) -> Self {
        Recorder {
            robot: Robot::new(scene),
            rows: Vec::new(),
            track: Vec::new(),
            first: None,
            last: None,
            gait: Gait::default(),
            extremes: Extremes::default(),
            energy: Energy::new(scene),
            spread: Spread::new(),
            requests: Requests::default(),
            dropped: 0,
            steps_per_period: (1.0 / (scene.rate * scene.plant.dt)).round() as u64,
            row_ns: ROW_NS,
            last_row_ns: None,
            keeps_rows: true,
            worst: Worst::default(),
            placed: Vec::new(),
        }
    }

    /// The same without rows, which only tables and drawings need: they are most of the memory that a run takes.
    pub fn without_rows(scene: &Scene) -> Self {
        Recorder { keeps_rows: false, ..Recorder::new(scene) }
    }

    /// The time of the fall [s], once it has been seen to its end: nothing is recorded any more.
    pub fn is_over(&self) -> Option<f64> {
        let time = self.last.as_ref().map_or(0.0, |last| last.sample.time);
        self.extremes.fall.filter(|fall| time >= fall + AFTERMATH)
    }

    /// Takes the next record. One whose pose is not finite is counted and left out.
    pub fn push(&mut self, truth: &Truth) {
        if self.is_over().is_some() {
            return;
        }
        self.spread.push(truth);
        self.robot.place_in(truth, &mut self.placed);
        let sample = Sample::new(&self.robot, truth, &self.placed);
        if !is_placed(truth) || sample.com.iter().chain(&sample.com_velocity).any(|value| value.is_nan()) {
            self.dropped += 1;
            return;
        }
        self.extremes.push(&self.robot, truth, &sample);
        self.energy.push(&self.robot, truth, &self.placed, &sample);
        if self.extremes.fall.is_none() {
            self.gait.push(&sample);
        }
        if self.keeps_rows {
            self.worst = self.worst.and(&Worst::of(truth));
        }
        let row = match &mut self.last {
            Some(row) => {
                row.truth = *truth; // in its place, for a record is large
                row.sample = sample;
                row.worst = self.worst;
                row
            }
            none => none.insert(Row { truth: *truth, sample, worst: self.worst }),
        };
        self.first.get_or_insert_with(|| row.clone());
        let (now, slot) = (truth.stamp.sim_ns, |time: u64| time / self.row_ns);
        if self.last_row_ns.is_some_and(|last| slot(last) >= slot(now)) {
            return;
        }
        self.last_row_ns = Some(now);
        self.track.push([row.sample.time, row.sample.com.x]);
        if self.keeps_rows {
            self.rows.push(row.clone());
            self.worst = Worst::default();
        }
        if self.track.len() > MAX_ROWS {
            self.thin_out();
        }
    }

    /// Leaves out every second row.
    fn thin_out(&mut self) {
        let (mut even, mut gone) = (false, Worst::default());
        self.rows.retain_mut(|row| {
            even = !even;
            match even {
                true => row.worst = row.worst.and(&gone),
                false => gone = row.worst,
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

impl Spread {
    fn new() -> Self {
        Spread {
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
    use super::fake::FakeWalk;
    use super::*;

    #[test]
    fn rows_stay_bounded_and_evenly_spaced_however_long_the_run() {
        let mut recorder = Recorder::new(&Scene::default());
        let mut truth = FakeWalk::new(0.0).truth(0, 0.0);
        for tick in 0..200_000_u64 {
            truth.stamp.sim_ns = tick * 1_000_000;
            recorder.push(&truth);
        }
        assert!(recorder.rows.len() <= MAX_ROWS && recorder.rows.len() > MAX_ROWS / 3, "{}", recorder.rows.len());
        let gaps = recorder.rows.windows(2).map(|w| w[1].truth.stamp.sim_ns - w[0].truth.stamp.sim_ns);
        assert!(gaps.into_iter().all(|gap| gap == recorder.row_ns));
    }

    #[test]
    fn no_peak_is_lost_between_rows_however_thin_they_are() {
        let mut recorder = Recorder::new(&Scene::default());
        let mut truth = FakeWalk::new(0.0).truth(0, 0.0);
        for tick in 0..200_000_u64 {
            truth.stamp.sim_ns = tick * 1_000_000;
            truth.late_ns = if tick == 77_777 { 5 } else { 0 };
            truth.torque[3] = if tick == 123_456 { -9.0 } else { 1.0 };
            recorder.push(&truth);
        }
        let at =
            |is: fn(&Worst) -> bool| recorder.rows.iter().filter(move |row| is(&row.worst)).map(|row| row.sample.time);
        for (times, peak) in [(at(|worst| worst.late_ns == 5), 77.777), (at(|worst| worst.torque[3] == -9.0), 123.456)]
        {
            let (times, period) = (times.collect::<Vec<_>>(), recorder.row_ns as f64 * 1e-9);
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
            let mut recorder = Recorder::new(&scene);
            recorder.push(&Truth::default());
            recorder.push(&FakeWalk::new(0.06).truth(1, 3.0));
            let mut broken = FakeWalk::new(0.06).truth(2, 3.001);
            broken.angle[3] = f64::NAN;
            recorder.push(&broken);
            assert!(recorder.dropped >= 2);
            assert_eq!(recorder.extremes.fall, None);
        }
    }
}
