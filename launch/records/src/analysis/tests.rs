//! Claims about the stored rows and the track.

use super::synthetic::SyntheticWalk;
use super::*;

#[test]
fn the_number_of_rows_is_bounded_and_their_spacing_even_in_a_long_run() {
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
fn thinning_out_rows_keeps_all_peak_values() {
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
    for (times, peak) in [(at(|peaks| peaks.late_ns == 5), 77.777), (at(|peaks| peaks.torque[3] == -9.0), 123.456)] {
        let (times, period) = (times.collect::<Vec<_>>(), analysis.row_ns as f64 * 1e-9);
        assert!(matches!(times[..], [time] if (0.0..=period).contains(&(time - peak))), "{times:?} for {peak}");
    }
}

#[test]
fn unusual_robots_and_invalid_records_do_not_panic() {
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
