//! `biped chart --growth`: how the cost of a step grows with contacts, links and step length, compared with MuJoCo on the same
//! robots, and the throughput of several processors.

mod drawing;
mod peers;
mod points;
mod scenes;

use super::args::ChartArgs;
use super::core::Core;
use super::csv::OURS;
use super::trial::time;
use super::watch::{ChartProgress, Job};
use crate::study::tables::table;
use messages::load::load;
use points::{Point, exponent, keep_least, of};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use scenes::GrowthCurve;
use sessions::run::in_process;
use shared::csv;
use shared::exit::{Exit, Failure};
use shared::list::SCENES;
use shared::output::{print_text, write_atomically, write_failure};
use std::time::Instant;

/// Number of measurements. The least time counts, because the machine may be slow for seconds.
const ROUNDS: usize = 4;

/// Measures, prints, and writes a table and a drawing of each curve into the folder.
///
/// # Errors
/// Ctrl-C, a table of other engines, engines that cannot be measured, or a folder that cannot be written.
pub fn run(args: &ChartArgs, watch: &ChartProgress) -> Result<(), Failure> {
    let failed = |error| write_failure(&args.out, &error);
    if let Some(Some(table)) = &args.peers {
        let other = format!("--growth measures peers itself: --peers without {}", table.display());
        return Err(Failure::new(Exit::Usage, other));
    }
    let mut points = Vec::new();
    let held = Core::hold();
    let rounds = if args.quick { 1 } else { ROUNDS };
    for curve in (0..rounds).flat_map(|_| &GrowthCurve::ALL) {
        let scenes = curve.scenes(args.quick)?;
        watch.expect(scenes.len());
        for (x, scene) in &scenes {
            watch.step(Job::Timing)?;
            if let Ok((seconds, _)) = time(scene, &[], watch.stop) {
                let us = 1e6 * seconds / scene.periods() as f64;
                keep_least(&mut points, Point { curve: curve.name, engine: OURS, x: *x, us });
            }
        }
        if args.peers.is_some() {
            let theirs = peers::points(curve, &scenes, watch)?;
            theirs.into_iter().for_each(|point| keep_least(&mut points, point));
        }
    }
    drop(held);
    let sweeps = sweeps(if args.quick { 0.5 } else { 4.0 }, watch)?;
    watch.finish();
    for curve in GrowthCurve::ALL {
        write_atomically(&args.out.join(format!("growth-{}.svg", curve.name)), &drawing::draw(&curve, &points))
            .map_err(failed)?;
    }
    let header = ["curve", "engine", "x", "us_per_step"].map(String::from);
    let row =
        |point: &Point| [point.curve.into(), point.engine.into(), point.x.to_string(), format!("{:.3}", point.us)];
    let table = csv::text([header].into_iter().chain(points.iter().map(row)));
    write_atomically(&args.out.join("growth.csv"), &table).map_err(failed)?;
    print_text(format!("{}\n{}\n{}", times(&points), exponents(&points), processors(&sweeps)));
    Ok(())
}

/// Names of the drawings.
pub fn drawings() -> Vec<String> {
    GrowthCurve::ALL.iter().map(|curve| format!("growth-{}", curve.name)).collect()
}

fn times(points: &[Point]) -> String {
    let mut rows = vec![["what grows", "to", "ours µs", "MuJoCo µs", "its / ours"].map(String::from).to_vec()];
    for curve in GrowthCurve::ALL {
        let theirs = of(points, &curve, peers::NAME);
        for own in of(points, &curve, OURS) {
            let other = theirs.iter().find(|other| other.x == own.x).map(|other| other.us);
            let cell = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2}"));
            let ratio = other.map(|other| other / own.us);
            let numbers = [own.x.to_string(), cell(Some(own.us)), cell(other), cell(ratio)];
            rows.push([curve.name.to_string()].into_iter().chain(numbers).collect());
        }
    }
    table(&rows)
}

fn exponents(points: &[Point]) -> String {
    let mut rows = vec![["exponent", "from", "ours", "MuJoCo"].map(String::from).to_vec()];
    for curve in GrowthCurve::ALL {
        let of = |engine| exponent(&of(points, &curve, engine), curve.from).map_or("-".into(), |p| format!("{p:.2}"));
        rows.push(vec![curve.name.into(), curve.from.to_string(), of(OURS), of(peers::NAME)]);
    }
    table(&rows)
}

/// Simulated time per wall time of parallel walks, on one processor and on more; the best of three measurements.
fn sweeps(seconds: f64, watch: &ChartProgress) -> Result<Vec<(usize, f64)>, Failure> {
    let scene = load("walk", &[format!("duration={seconds}")], SCENES)?;
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut sweeps: Vec<_> = (1..=all).map(|threads| (threads, 0.0)).collect();
    watch.expect(3 * all);
    for (threads, most) in (0..3).flat_map(|_| 0..all).map(|k| (k + 1, k)).collect::<Vec<_>>() {
        watch.step(Job::Timing)?;
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| Failure::new(Exit::Fault, format!("no threads: {error}")))?;
        let walks = 4 * threads;
        let begun = Instant::now();
        pool.install(|| (0..walks).into_par_iter().try_for_each(|_| in_process(&scene, |_| Ok(()))))?;
        let rate = walks as f64 * seconds / begun.elapsed().as_secs_f64();
        sweeps[most].1 = f64::max(sweeps[most].1, rate);
    }
    Ok(sweeps)
}

fn processors(sweeps: &[(usize, f64)]) -> String {
    let mut rows = vec![["processors", "walks at once, simulated s per s", "of one"].map(String::from).to_vec()];
    let one = sweeps.first().map_or(f64::NAN, |sweep| sweep.1);
    rows.extend(sweeps.iter().map(|(n, rate)| vec![n.to_string(), format!("{rate:.0}"), format!("{:.2}", rate / one)]));
    table(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_of_every_curve_can_be_simulated_and_grows_as_it_says() {
        for curve in GrowthCurve::ALL {
            for (x, scene) in curve.scenes(true).expect("good scenes") {
                let mut plant = plant::Plant::new(&scene).expect("a good scene");
                for _ in 0..50 {
                    plant.advance(&Default::default()).expect("a step");
                }
                match curve.name {
                    "contacts" => assert_eq!(plant.problem().contacts as f64, x),
                    "links" => assert_eq!(plant.model().dofs() as f64, x),
                    _ => assert_eq!(scene.plant.dt, 1e-3 * x),
                }
            }
        }
    }

    /// 24 equations constrain ten degrees of freedom: redundant equations must be distinguished from rounding.
    #[test]
    fn a_table_that_does_not_tip_is_standing_and_stands_as_corner_by_corner() {
        for (points, scene) in GrowthCurve::ALL[0].scenes(false).expect("good scenes") {
            let plant = || plant::Plant::new(&scene).expect("a good scene");
            let (mut ours, mut theirs, mut worst, mut standing) =
                (plant(), plant().without_standing_feet(), 0.0_f64, 0);
            for _ in 0..300 {
                for plant in [&mut ours, &mut theirs] {
                    plant.advance(&Default::default()).expect("a step");
                }
                let [a, b] = [ours.state(), theirs.state()];
                let pairs = a.x.iter().zip(&b.x).chain(a.xdot.iter().zip(&b.xdot));
                worst = pairs.fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
                standing += usize::from(points > 0.0 && ours.problem().delassus.is_empty());
                assert!(points == 0.0 || !theirs.problem().delassus.is_empty());
            }
            println!(
                "{points} corners: states differ by {worst:.1e}, {standing} of 300 steps solved as a standing table"
            );
            assert!(worst < 1e-9, "{points} corners: {worst}");
            // Of three corners and of five corners, one carries no load. The other four of the five hold the table in some steps. On a
            // single corner the table tips, and it counts as standing while that corner stands still.
            let held = match points {
                0.0 | 3.0 => 0..=0,
                5.0 => 1..=150,
                1.0 => 1..=60,
                _ => 291..=300,
            };
            assert!(held.contains(&standing), "{points} corners: {standing} standing steps");
        }
    }
}
