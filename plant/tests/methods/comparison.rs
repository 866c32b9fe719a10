//! The scenes of the comparison of engines: accuracy of the best method, in steps of 5 ms and more.

use crate::support::{built_in, corners, gap, ground_distance, plant, run_steps, totals};
use messages::scene::Method;

#[test]
fn blocks_stick_and_slide_on_slopes_to_rounding() {
    let (s, c) = 20f64.to_radians().sin_cos();
    for dt in [0.02, 0.005] {
        let mut sliding = plant(built_in("incline"), Method::EventDriven, dt);
        let start = totals(&sliding).com;
        run_steps(&mut sliding, (2.0 / dt).round() as usize);
        let error = (ground_distance(&start, &totals(&sliding).com) / (0.5 * 9.81 * (s - 0.3 * c) * 4.0) - 1.0).abs();
        println!("incline at {dt}: {error:e}");
        assert!(error < 1e-12, "{error:e}");
    }
}

#[test]
fn a_standing_biped_does_not_creep() {
    for name in ["stand0", "stand10"] {
        let mut standing = plant(built_in(name), Method::EventDriven, 0.005);
        let start = corners(&standing);
        run_steps(&mut standing, 2000);
        let moved = corners(&standing).iter().zip(&start).map(|(a, b)| ground_distance(a, b)).fold(0.0, f64::max);
        println!("{name}: {:e} m/s, gap {:e} m, {:?}", moved / 10.0, gap(&standing), standing.counts());
        assert!(moved / 10.0 < 1e-12 && gap(&standing).abs() < 1e-12, "{name}: {moved:e}");
    }
}

/// Housner: a rocking block keeps (1 - 1.5 sin² a)² of its energy above that of lying flat.
#[test]
fn a_rocking_block_loses_energy_as_housner_predicts() {
    for (method, dt, limit) in
        [(Method::EventDriven, 0.02, 1e-10), (Method::EventDriven, 0.005, 1e-10), (Method::Rk4Impact, 0.002, 1e-4)]
    {
        let mut block = plant(built_in("rock"), method, dt);
        let above = |energy: f64| energy - 9.81 * 0.2;
        let start = above(totals(&block).potential);
        run_steps(&mut block, (0.4 / dt).round() as usize); // between its first and second impact
        let now = totals(&block);
        let ratio = (above(now.kinetic + now.potential) / start).sqrt();
        println!("{method:?} {dt}: ratio {ratio}");
        assert!((ratio / 0.911_764_705_882_352_9 - 1.0).abs() < limit, "{method:?} {dt}: {ratio}");
    }
}

/// At its steady speed, each impact dissipates the energy that the slope adds from spoke to spoke.
#[test]
fn a_rimless_wheel_keeps_its_steady_speed() {
    for (method, dt, limit) in [(Method::EventDriven, 0.02, 1e-9), (Method::Rk4Impact, 0.005, 1e-4)] {
        let mut wheel = plant(built_in("wheel"), method, dt);
        let energy = |plant: &biped_plant::Plant| totals(plant).kinetic + totals(plant).potential;
        let (start, kinetic) = (energy(&wheel), totals(&wheel).kinetic);
        let drop = 10.0 * 9.81 * 8f64.to_radians().sin() * 2.0 * 0.3 * 22.5f64.to_radians().sin();
        let mut worst = 0.0_f64;
        for _ in 0..(4.0 / dt).round() as usize {
            run_steps(&mut wheel, 1);
            let expected = start - wheel.counts().events as f64 * drop;
            worst = worst.max((energy(&wheel) - expected).abs() / kinetic);
        }
        println!("{method:?} {dt}: energy off by {worst:e} of the kinetic, {:?}", wheel.counts());
        assert!(wheel.counts().events >= 12 && worst < limit, "{method:?} {dt}: {worst:e}");
    }
}
