//! The second-order default method compared with the paper's method: the least time of each step in many runs, alternating between the methods.

use crate::robot::{Activity, Recording};
use crate::tail::quantiles;
use messages::scene::Method;
use plant::Plant;
use std::ops::Range;
use std::time::Instant;

/// Runs with each method.
const RUNS: usize = 9;
/// The walk between start and stop, and the whole walk. Landings are one step in a hundred between start and stop, so the 99th percentile is that of
/// the landings there. Over the whole walk it is that of the start, where the feet press against each other.
const STRIDE: Range<usize> = 2000..13_000;
const WHOLE: Range<usize> = 0..14_000;
/// The compared methods.
const METHODS: [Method; 2] = [Method::SemiImplicitEuler, Method::MidpointContact];

/// Prints median and 99th percentile of a step, for the whole step and for its part after the command arrives, with ratios to the paper's method.
pub fn print() {
    println!("\nsteps of 1 ms, each the least of {RUNS} runs [µs]");
    println!("{:<15}{:<20}{:>9}{:>9}{:>9}{:>9}", "", "", "median", "99 %", "awaited", "99 %");
    for (name, activity, window, most) in [
        ("flying", Activity::Flying, Activity::Flying.window(), "median 2"),
        ("standing", Activity::Standing, Activity::Standing.window(), "median 1.25"),
        ("start to stop", Activity::Walking, STRIDE, "median 1.3, 99 % 1.5"),
        ("whole walk", Activity::Walking, WHOLE, "median 1.3, 99 % 1.5"),
    ] {
        let recordings = METHODS.map(|method| {
            let settings = [format!("plant.method={method:?}"), "plant.dt=0.001".into(), "rate=1000".into()];
            Recording::over(activity, &settings, window.clone())
        });
        let mut least =
            recordings.each_ref().map(|recording| [(); 2].map(|()| vec![f64::INFINITY; recording.window.end]));
        for run in 0..2 * RUNS {
            for (recording, least) in recordings.iter().zip(&mut least) {
                time(recording, run % 2, &mut least[run % 2]);
            }
        }
        let [paper, ours] = [0, 1].map(|k| {
            let from = recordings[k].window.start;
            let [[median, p99, ..], [awaited, slow, ..]] = [0, 1].map(|ready| quantiles(&least[k][ready][from..]));
            println!("{name:<15}{:<20}{median:>9.2}{p99:>9.2}{awaited:>9.2}{slow:>9.2}", format!("{:?}", METHODS[k]));
            [median, p99, awaited, slow]
        });
        let ratio = [0, 1, 2, 3].map(|k| format!("{:>9.2}", ours[k] / paper[k])).concat();
        println!("{:<15}{:<20}{ratio}   asked: {most}", "", "ratio");
    }
}

/// Times every control period once. `ready` excludes the work that can be done before the command arrives.
fn time(recording: &Recording, ready: usize, least: &mut [f64]) {
    let mut plant = Plant::new(&recording.scene).expect("a good scene");
    for (torques, least) in recording.torques.iter().zip(least) {
        if ready == 1 {
            plant.prepare();
        }
        let begun = Instant::now();
        plant.advance(torques).expect("it did before");
        *least = least.min(1e6 * begun.elapsed().as_secs_f64());
    }
}
