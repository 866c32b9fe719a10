//! The slowest steps and ticks of the walk and of variants of it.
//!
//! A walk repeats bit for bit, so the time of a step is its least time in many runs: interruptions never hit the same step in all runs.

use crate::robot::Activity;
use controller::Controller;
use messages::scene::Scene;
use plant::Plant;
use std::time::Instant;

/// Number of runs of the walk.
const RUNS: usize = 9;

/// Number of runs of each variant.
const RUNS_OF_OTHERS: usize = 3;

/// Variants of the walk. Each has different contact problems.
const OTHERS: [&str; 12] = [
    "plant.friction=0.49",
    "plant.friction=0.5",
    "plant.friction=0.52",
    "plant.friction=0.55",
    "plant.friction=0.6",
    "plant.friction=0.65",
    "plant.friction=0.75",
    "controller.speed=0.16",
    "controller.speed=0.17",
    "controller.speed=0.18",
    "controller.speed=0.19",
    "controller.speed=0.195",
];

/// Number of slow steps that are printed.
const SLOWEST: usize = 5;

/// For each control period: least time of the step and of the tick \[µs\], number of contacts, number of pivots.
struct WalkTimes {
    least: [Vec<f64>; 2],
    problems: Vec<(usize, u64)>,
}

/// Prints median, 99.9th percentile, maximum and ratio of maximum to median of all periods, and the slowest steps.
pub fn print() {
    let scene = Activity::Walking.scene(&[]);
    let WalkTimes { least, problems } = walk(&scene, RUNS);
    let periods = problems.len();
    println!("\n{periods} periods of the walk, each the least of {RUNS} runs [µs]");
    println!("{:<18}{:>9}{:>9}{:>9}{:>9}{:>14}", "", "median", "99 %", "99.9 %", "max", "max / median");
    let aligned = walk(&Activity::Walking.scene(&["plant.law=Aligned".to_string()]), RUNS).least;
    for (name, least) in [("plant step", &least[0]), ("the same, Aligned", &aligned[0]), ("controller tick", &least[1])]
    {
        let [median, p99, p99_9, max] = quantiles(least);
        println!("{name:<18}{median:>9.2}{p99:>9.2}{p99_9:>9.2}{max:>9.2}{:>14.1}", max / median);
    }
    let steps = &least[0];
    let mut order: Vec<_> = (0..periods).collect();
    order.sort_by(|&a, &b| steps[b].total_cmp(&steps[a]));
    for &period in &order[..SLOWEST] {
        let ((contacts, pivots), at) = (problems[period], period as f64 / scene.rate);
        println!("step at {at:.3} s: {:.2}, {contacts} contacts, {pivots} pivots", steps[period]);
    }
    let pivoting = (0..periods).filter(|&period| problems[period].1 > 0);
    let (count, time) = pivoting.fold((0, 0.0), |(count, time), period| (count + 1, time + steps[period]));
    let all: f64 = steps.iter().sum();
    println!("{count} steps of {periods} pivoted and took {:.0} % of the time", 100.0 * time / all);
    print_others();
}

/// Prints the ratio of the slowest step to the median for each variant.
fn print_others() {
    let ratios = OTHERS.map(|setting| {
        let scene = Activity::Walking.scene(&[setting.to_string()]);
        let [median, _, p99_9, max] = quantiles(&walk(&scene, RUNS_OF_OTHERS).least[0]);
        [p99_9, max].map(|time| time / median)
    });
    println!("of the median in {} other walks, least, middle and most:", OTHERS.len());
    for (name, k) in ["99.9 %", "max"].into_iter().zip(0..) {
        let mut ratios = ratios.map(|ratio| ratio[k]);
        ratios.sort_by(f64::total_cmp);
        let middle = ratios.len() / 2;
        println!("{name:<18}{:>9.1}{:>9.1}{:>9.1}", ratios[0], ratios[middle], ratios[ratios.len() - 1]);
    }
}

/// Repeats the walk a number of times.
fn walk(scene: &Scene, runs: usize) -> WalkTimes {
    let periods = (scene.duration * scene.rate) as usize;
    let mut least = [vec![f64::INFINITY; periods], vec![f64::INFINITY; periods]];
    let mut problems = vec![(0, 0); periods];
    for _ in 0..runs {
        let mut plant = Plant::new(scene).expect("a good scene");
        let mut controller = Controller::new(scene).expect("a good scene");
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
    WalkTimes { least, problems }
}

/// Median, 99th and 99.9th percentile, and maximum.
pub fn quantiles(times: &[f64]) -> [f64; 4] {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    [500, 990, 999, 1000].map(|mille| times[(times.len() * mille / 1000).min(times.len() - 1)])
}
