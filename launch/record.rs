//! The recorder: a stream of [`Truth`] in, everything that summary, CSV and report need out.
//!
//! Steps, extremes and histograms see every record; rows are kept at 200 Hz at most and thinned out in long runs, so
//! that memory stays bounded.

mod extremes;
#[cfg(test)]
pub mod fake;
mod gait;
mod histogram;
mod robot;
mod sample;
mod worst;

pub use extremes::Extremes;
pub use gait::{Gait, Lateral};
pub use histogram::Histogram;
pub use robot::{Foot, Robot};
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
    /// Evenly spaced rows, oldest first.
    pub rows: Vec<Row>,
    /// First record.
    pub first: Option<Row>,
    /// Latest record.
    pub last: Option<Row>,
    /// Steps.
    pub gait: Gait,
    /// Extremes.
    pub extremes: Extremes,
    /// Histograms of every record.
    pub spread: Spread,
    /// Records left out because their pose is not finite.
    pub dropped: u64,
    /// Integration steps in one control period.
    pub steps_per_period: u64,
    row_ns: u64,
    /// Peaks since the last row.
    worst: Worst,
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
            first: None,
            last: None,
            gait: Gait::default(),
            extremes: Extremes::default(),
            spread: Spread::new(),
            dropped: 0,
            steps_per_period: (1.0 / (scene.rate * scene.plant.dt)).round() as u64,
            row_ns: ROW_NS,
            worst: Worst::default(),
        }
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
        let placed = self.robot.place(truth);
        let sample = Sample::new(&self.robot, truth, &placed);
        if !is_placed(truth) || sample.com.iter().chain(&sample.com_velocity).any(|value| value.is_nan()) {
            self.dropped += 1;
            return;
        }
        self.extremes.push(&self.robot, truth, &sample);
        if self.extremes.fall.is_none() {
            self.gait.push(&sample);
        }
        self.worst = self.worst.and(&Worst::of(truth));
        self.keep(Row { truth: *truth, sample, worst: self.worst });
    }

    fn keep(&mut self, row: Row) {
        let slot = |row: &Row| row.truth.stamp.sim_ns / self.row_ns;
        if self.rows.last().is_none_or(|last| slot(last) < slot(&row)) {
            self.rows.push(row.clone());
            self.worst = Worst::default();
        }
        if self.rows.len() > MAX_ROWS {
            let (mut even, mut gone) = (false, Worst::default());
            self.rows.retain_mut(|row| {
                even = !even;
                match even {
                    true => row.worst = row.worst.and(&gone),
                    false => gone = row.worst,
                }
                even
            });
            self.row_ns *= 2;
        }
        self.first.get_or_insert_with(|| row.clone());
        self.last = Some(row);
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
    use super::fake::{FakeWalk, RELEASE, STEP};
    use super::*;

    /// Records a made-up walk from standing until `end`, at 1 kHz.
    fn walk(step_length: f64, end: f64) -> Recorder {
        let (fake, mut recorder) = (FakeWalk::new(step_length), Recorder::new(&Scene::default()));
        for seq in 0..=(end * 1e3) as u64 {
            recorder.push(&fake.truth(seq, seq as f64 * 1e-3));
        }
        recorder
    }

    #[test]
    fn a_limit_cycle_is_measured_as_it_is() {
        let recorder = walk(0.06, 8.0);
        let (period, deviation) = recorder.gait.period(20);
        assert!((period - 2.0 * STEP).abs() < 1e-6 && deviation < 1e-6, "{period} +- {deviation}");
        assert!((recorder.gait.x2_min(20) - FakeWalk::x2_min()).abs() < 1e-9, "{}", recorder.gait.x2_min(20));
        assert_eq!(recorder.gait.steps.len(), ((8.0 - RELEASE + STEP / 2.0) / STEP) as usize);
        let supports: Vec<_> = recorder.gait.steps.iter().map(|step| step.support).collect();
        assert!(supports.windows(2).all(|pair| pair[0] != pair[1]) && supports[0] == 1, "{supports:?}");
        assert!((recorder.gait.speed() - 0.2).abs() < 1e-6, "{}", recorder.gait.speed());
        assert_eq!(recorder.extremes.fall, None);
    }

    #[test]
    fn standing_is_not_stepping() {
        assert!(walk(0.06, 0.5).gait.steps.is_empty());
        let mut recorder = Recorder::new(&Scene::default());
        let mut truth = FakeWalk::new(0.0).truth(0, 0.0);
        for seq in 0..1000 {
            // Rounding errors cross the midline at every sample.
            truth.base_position[1] = if seq % 2 == 0 { 1e-6 } else { -1e-6 };
            truth.stamp.sim_ns = seq * 1_000_000;
            recorder.push(&truth);
        }
        assert!(recorder.gait.steps.is_empty());
    }

    #[test]
    fn a_fall_is_seen_when_it_happens_and_ends_the_counting_of_steps() {
        let (fake, mut recorder) = (FakeWalk::new(0.06), Recorder::new(&Scene::default()));
        for seq in 0..6000 {
            let time = seq as f64 * 1e-3;
            let mut truth = fake.truth(seq, time);
            // Tips over backwards about the ground from 4 s on, at 1 rad/s.
            let tilt = (time - 4.0).max(0.0);
            truth.base_orientation = [(tilt / 2.0).cos(), 0.0, -(tilt / 2.0).sin(), 0.0];
            recorder.push(&truth);
        }
        let fall = recorder.extremes.fall.expect("45 degrees is a fall");
        assert!((fall - 4.0 - 45f64.to_radians()).abs() < 2e-3, "{fall}");
        assert!(recorder.gait.steps.iter().all(|step| step.start < fall));
        assert_eq!(recorder.is_over(), Some(fall));
        let last = recorder.last.expect("a last record").sample.time;
        assert!((last - fall - AFTERMATH).abs() < 2e-3, "the record ends at {last} s");
    }

    #[test]
    fn rates_and_poses_belong_together() {
        let (fake, robot) = (FakeWalk::new(0.06), Robot::new(&Scene::default()));
        for time in [1.0, 1.7, 3.21, 5.05] {
            let com = |time| robot.com(&robot.place(&fake.truth(0, time)));
            let slope = (com(time + 1e-5).0 - com(time - 1e-5).0) / 2e-5;
            let error = (slope - com(time).1).norm();
            assert!(error < 1e-6, "CoM velocity off by {error} m/s at {time} s");
        }
    }

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

    #[test]
    fn a_residual_that_is_not_a_number_is_not_hidden() {
        let mut recorder = Recorder::new(&Scene::default());
        let fake = FakeWalk::new(0.0);
        for seq in 0..3 {
            let truth = fake.truth(seq, seq as f64 * 1e-3);
            recorder.push(&Truth { signorini: if seq == 1 { f64::NAN } else { 1e-16 }, ..truth });
        }
        assert!(recorder.extremes.signorini.is_nan() && recorder.extremes.natural_map > 0.0);
    }

    #[test]
    fn tilt_of_the_loaded_foot_and_margin_of_the_zero_moment_point_are_exact() {
        let (fake, scene) = (FakeWalk::new(0.06), Scene::default());
        // In single support on the right foot, the zero-moment point up to 0.3 of the half width off the centre.
        let mut recorder = Recorder::new(&scene);
        (4000..6000).for_each(|seq| recorder.push(&fake.truth(seq, seq as f64 * 1e-3)));
        assert!((recorder.extremes.zmp_margin - 0.05 * 0.7).abs() < 1e-5, "{}", recorder.extremes.zmp_margin);
        assert!((recorder.rows[0].sample.load - 14.0 * 9.81).abs() < 1e-9);
        assert!(recorder.extremes.foot_tilt < 1e-12);
        let mut tilted = fake.truth(6000, 6.0);
        let (loaded, free) = if tilted.telemetry.support == 0 { (0, 7) } else { (7, 0) };
        tilted.angle[free] += 0.2;
        recorder.push(&tilted);
        assert!(recorder.extremes.foot_tilt < 1e-12, "a foot in the air may tilt");
        tilted.angle[loaded] += 0.01;
        recorder.push(&tilted);
        assert!((recorder.extremes.foot_tilt - 0.01).abs() < 1e-12, "{}", recorder.extremes.foot_tilt);
    }

    #[test]
    fn a_payload_moves_the_centre_of_mass() {
        let mut scene = Scene::default();
        let truth = Truth { base_orientation: [1.0, 0.0, 0.0, 0.0], ..Truth::default() };
        let com = |scene: &Scene| {
            let robot = Robot::new(scene);
            robot.com(&robot.place(&truth)).0
        };
        let before = com(&scene);
        (scene.plant.payload_kg, scene.plant.payload_offset) = (2.0, [0.1, 0.0, 0.3]);
        let expected = (before * 14.0 + nalgebra::Vector3::new(0.2, 0.0, 0.6)) / 16.0;
        assert!((com(&scene) - expected).norm() < 1e-14);
        // The upright robot of Table 1, from the trunk's centre .65 m above the soles.
        assert!((before.z + 0.65 - 0.3196).abs() < 5e-5, "{before}");
    }

    #[test]
    fn quantiles_of_a_histogram_are_within_its_bins() {
        let mut histogram = Histogram::new(0, 6);
        (1..=1000).for_each(|i| histogram.add(f64::from(i)));
        for (share, exact) in [(0.5, 500.0), (0.99, 990.0), (1.0, 1000.0)] {
            assert!((histogram.quantile(share) / exact).ln().abs() < 0.04, "{}", histogram.quantile(share));
        }
        histogram.add(f64::NAN);
        histogram.add(0.0);
        assert_eq!((histogram.zeros, histogram.total()), (2, 1002));
        assert_eq!(histogram.bars(4).iter().map(|bar| bar.1).sum::<u64>(), 1000);
    }
}
