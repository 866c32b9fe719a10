//! The slowest steps and ticks of the whole walk.
//!
//! The walk repeats to the bit, so what a step takes is the least of many runs of that same step: what interrupts the
//! processor never does so at the same step in all of them.

use crate::robot::Doing;
use controller::Controller;
use plant::Plant;
use std::time::Instant;

/// Runs of the walk.
const RUNS: usize = 9;

/// Steps that are told of.
const SLOWEST: usize = 5;

/// Prints median, 99.9 % and maximum of all periods, what the maximum is of the median, and the slowest steps.
pub fn print() {
    let scene = Doing::Walking.scene(&[]);
    let periods = (scene.duration * scene.rate) as usize;
    let mut least = [vec![f64::INFINITY; periods], vec![f64::INFINITY; periods]];
    let mut problems = vec![(0, 0); periods]; // contacts, pivots
    for _ in 0..RUNS {
        let mut plant = Plant::new(&scene).expect("a good scene");
        let mut controller = Controller::new(&scene).expect("a good scene");
        for period in 0..periods {
            let encoders = plant.encoders();
            let begun = Instant::now();
            let torques = controller.tick(&encoders).expect("it walks");
            let thought = Instant::now();
            plant.advance(&torques).expect("it walks");
            let spent = [thought.elapsed(), thought - begun];
            problems[period] = (plant.problem().contacts, plant.truth().pivots);
            for (least, spent) in least.iter_mut().zip(spent) {
                least[period] = least[period].min(1e6 * spent.as_secs_f64());
            }
        }
    }
    let steps = least[0].clone();
    let mut order: Vec<_> = (0..periods).collect();
    order.sort_by(|&a, &b| steps[b].total_cmp(&steps[a]));
    println!("\n{periods} periods of the walk, each the least of {RUNS} runs [µs]");
    println!("{:<18}{:>9}{:>9}{:>9}{:>9}{:>14}", "", "median", "99 %", "99.9 %", "max", "max / median");
    for (name, least) in ["plant step", "controller tick"].into_iter().zip(&mut least) {
        least.sort_by(f64::total_cmp);
        let [median, p99, p99_9, max] =
            [500, 990, 999, 1000].map(|mille| least[(periods * mille / 1000).min(periods - 1)]);
        println!("{name:<18}{median:>9.2}{p99:>9.2}{p99_9:>9.2}{max:>9.2}{:>14.1}", max / median);
    }
    for &period in &order[..SLOWEST] {
        let ((contacts, pivots), at) = (problems[period], period as f64 / scene.rate);
        println!("step at {at:.3} s: {:.2}, {contacts} contacts, {pivots} pivots", steps[period]);
    }
    let pivoting = (0..periods).filter(|&period| problems[period].1 > 0);
    let (count, time) = pivoting.fold((0, 0.0), |(count, time), period| (count + 1, time + steps[period]));
    let all: f64 = steps.iter().sum();
    println!("{count} steps of {periods} pivoted and took {:.0} % of the time", 100.0 * time / all);
}
