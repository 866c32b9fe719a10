//! View (iii), thresholds: the step, friction, stiffness or mass ratio from which on a method fails, found by bisection and compared
//! with the exact value.

use super::cases::{Combination, LAW, METHOD, scene, word};
use super::csv::{Measurement, OURS, View};
use super::failures::{EXACT, MEASURED};
use super::trial::{RunEnd, RunLog, StateSample, watch};
use super::watch::{ChartProgress, Job};
use messages::load::parse;
use messages::scene::{Law, Method, Scene};
use plant::contact::{Memory, Problem, Solver};
use shared::exit::Failure;

/// One threshold.
struct Threshold {
    /// Scene.
    scene: &'static str,
    /// Law and integrator.
    method: String,
    /// Quantity.
    quantity: &'static str,
    exact: f64,
    measured: f64,
}

type ThresholdResult = Result<Vec<Threshold>, Failure>;

/// Displacement of the cube on 26° in half a second below which it sticks [m]. A cube that slips there moves by millimetres.
const STICKS_WITHIN: f64 = 1e-9;
/// Slip below which the edge of the rocking block sticks [m/s]. A sticking edge has the velocity ω²lh = 2e-5 m/s at the end of a step of
/// 20 µs, because the block turns about it within the step.
const STICKING_EDGE: f64 = 1e-4;
/// Initial depth of the ball beyond its equilibrium, relative to that depth [-]. It starts an oscillation that an unstable step amplifies.
const NUDGE: f64 = 1e-6;
/// Steps of a run with the ball, and at each end of it the part in which the amplitude is measured.
const BALL_STEPS: (usize, usize) = (4000, 100);
/// The ball has settled if its late amplitude is below twice the early one, and below this part of its depth [-].
const SETTLED: f64 = 0.01;

/// A ball on one point, pressed into its spring by its weight and nudged; ω²h² decides whether it comes to rest.
const SPRING: &str = r#"
[plant]
base = "planar"
law = "SpringDamper"
friction = 0.0

[[bodies]]
name = "ball"
mass = 1.0
size = [0.1, 0.1, 0.1]
contacts = [[0.0, 0.0, 0.0]]
"#;

/// A rod on its tip, inclined with tan θ = 2, sliding with its foot ahead.
const ROD: &str = r#"
[plant]
base = "planar"

[initial]
clearance = 0.0
velocity = [1.0, 0.0, 0.0]

[[bodies]]
name = "rod"
mass = 1.0
size = [2.0, 0.01, 0.01]
inertia = [0.3333333333333333, 0.3333333333333333, 0.3333333333333333]
contacts = [[FOOT, 0.0, -0.8944271909999159]]
"#;

/// Each threshold as two rows, measured and exact.
///
/// # Errors
/// Ctrl-C, or a bad scene (excluded by a test).
pub fn measure(progress: &ChartProgress) -> Result<Vec<Measurement>, Failure> {
    let jobs: [fn() -> ThresholdResult; 4] = [springs, sticking, painleve, masses];
    progress.expect(jobs.len());
    let mut rows = Vec::new();
    for job in jobs {
        progress.step(Job::Bisecting)?;
        for threshold in job()? {
            for (kind, value) in [(MEASURED, threshold.measured), (EXACT, threshold.exact)] {
                rows.push(Measurement {
                    view: View::Failures,
                    scene: threshold.scene.into(),
                    engine: OURS.into(),
                    method: threshold.method.clone(),
                    dt: f64::NAN,
                    metric: format!("{}{kind}", threshold.quantity),
                    error: value,
                    cost: f64::NAN,
                    us_per_step: f64::NAN,
                });
            }
        }
    }
    Ok(rows)
}

/// The limit of a property that holds at `low` and not at `high`, by bisection to a relative accuracy of 1e-7.
fn bisect(mut low: f64, mut high: f64, mut holds: impl FnMut(f64) -> Result<bool, Failure>) -> Result<f64, Failure> {
    while high / low > 1.0 + 1e-7 {
        let middle = (low * high).sqrt();
        if holds(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(low)
}

/// h* and k* of springs and dampers: ω h < 2 (√(1 + ζ²) - ζ) under semi-implicit Euler.
fn springs() -> ThresholdResult {
    let limit = |ratio: f64| 2.0 * ((1.0 + ratio * ratio).sqrt() - ratio);
    let method = format!("{}/{}", word(&Law::SpringDamper), word(&Method::SemiImplicitEuler));
    let mut found = Vec::new();
    for (ratio, place) in [(0.0, "spring, ζ 0"), (0.1, "spring, ζ 0.1"), (1.0, "spring, ζ 1")] {
        let stiffness = 1e4;
        let measured = bisect(1e-4, 1e-1, |h| settles(stiffness, ratio, h))?;
        let exact = limit(ratio) / f64::sqrt(stiffness);
        found.push(Threshold { scene: place, method: method.clone(), quantity: "h* [s]", exact, measured });
    }
    let measured = bisect(1e4, 1e8, |stiffness| settles(stiffness, 0.5, 1e-3))?;
    let exact = (limit(0.5) / 1e-3).powi(2);
    found.push(Threshold { scene: "spring, ζ 0.5, 1 ms", method, quantity: "k* [N/m]", exact, measured });
    Ok(found)
}

/// Whether a nudge of a millionth of the depth does not grow in 4000 steps.
fn settles(stiffness: f64, ratio: f64, h: f64) -> Result<bool, Failure> {
    let mut scene = parse(SPRING, "spring")?;
    let depth = scene.plant.gravity / stiffness;
    scene.initial.position[2] = -depth * (1.0 + NUDGE);
    (scene.plant.contact_stiffness, scene.plant.contact_damping_ratio) = (stiffness, ratio);
    let (steps, part) = BALL_STEPS;
    (scene.plant.method, scene.plant.dt, scene.rate) = (Method::SemiImplicitEuler, h, 1.0 / h);
    scene.duration = steps as f64 * h;
    let RunEnd::Done(log) = watch(&scene, &[]) else { return Ok(false) };
    let amplitude =
        |part: &[StateSample]| part.iter().fold(0.0, |most: f64, sample| most.max((sample.low + depth).abs()));
    let (early, late) = (amplitude(&log.samples[..part]), amplitude(&log.samples[steps - part..]));
    Ok(late < 2.0 * early && late < SETTLED * depth)
}

/// μ* of the block that rests at 26°, and of the one that rocks without slipping.
fn sticking() -> ThresholdResult {
    let combination = Combination { law: LAW, method: METHOD };
    let run = |name: &str, h: f64, friction: f64, duration: f64| -> Result<Option<(Scene, RunLog)>, Failure> {
        let settings = [format!("plant.friction={friction}"), format!("duration={duration:?}")];
        let scene = scene(name, combination, h, &settings)?;
        Ok(match watch(&scene, &[]) {
            RunEnd::Done(log) => Some((scene, log)),
            _ => None,
        })
    };
    let slips = |friction: f64| -> Result<bool, Failure> {
        let displacement = |(_, log): (Scene, RunLog)| match log.samples.as_slice() {
            [first, .., last] => (last.totals.com - first.totals.com).norm(),
            _ => 0.0,
        };
        Ok(run("stick", 1e-3, friction, 0.5)?.is_none_or(|run| displacement(run) > STICKS_WITHIN))
    };
    let rocks = |friction: f64| -> Result<bool, Failure> {
        let slip = |(_, log): (Scene, RunLog)| log.samples.iter().fold(0.0, |slip: f64, sample| slip.max(sample.slip));
        Ok(run("rock", 2e-5, friction, 0.4)?.is_none_or(|run| slip(run) > STICKING_EDGE))
    };
    let threshold =
        |scene, exact, measured| Threshold { scene, method: combination.name(), quantity: "μ* [-]", exact, measured };
    Ok(vec![
        threshold("stick", 26f64.to_radians().tan(), bisect(0.3, 0.7, slips)?),
        threshold("rock", 12.0 / 65.0, bisect(0.05, 0.6, rocks)?),
    ])
}

/// μ* above which a sliding rod jams, (t² + 4)/(3t) with t = tan θ = 2.
fn painleve() -> ThresholdResult {
    let mut found = Vec::new();
    for law in [Law::Aligned, LAW] {
        let jams = |friction: f64| -> Result<bool, Failure> {
            let mut scene = parse(&ROD.replace("FOOT", "0.4472135954999579"), "rod")?;
            (scene.plant.law, scene.plant.method, scene.plant.friction) = (law, Method::SemiImplicitEuler, friction);
            (scene.plant.dt, scene.rate, scene.duration) = (1e-6, 1e6, 1e-6);
            let RunEnd::Done(log) = watch(&scene, &[]) else { return Ok(true) };
            Ok(log.samples.last().is_some_and(|sample| sample.load > 0.1))
        };
        let measured = bisect(0.5, 3.0, |friction| Ok(!jams(friction)?))?;
        let method = Combination { law, method: Method::SemiImplicitEuler }.name();
        found.push(Threshold { scene: "Painlevé's rod", method, quantity: "μ* [-]", exact: 4.0 / 3.0, measured });
    }
    Ok(found)
}

/// r* of iterative sweeps: a heavy mass on a light one, mass ratio r, is solved to 1 % if (r/(1 + r))ⁿ < 0.01.
fn masses() -> ThresholdResult {
    let mut found = Vec::new();
    for sweeps in [4_u16, 8, 50] {
        let measured = bisect(1e-2, 1e9, |ratio| Ok(stacked(Law::Sweep(sweeps), ratio) < 0.01))?;
        let exact = 1.0 / (0.01_f64.powf(-1.0 / f64::from(sweeps)) - 1.0);
        let method = word(&Law::Sweep(sweeps));
        found.push(Threshold { scene: "heavy on light", method, quantity: "r* [-]", exact, measured });
    }
    Ok(found)
}

/// Relative error of the ground's impulse below two stacked masses, the upper one `ratio` times the lower one.
fn stacked(law: Law, ratio: f64) -> f64 {
    let mut problem = Problem::default();
    problem.reset(2, plant::contact::tangents(law));
    let (rows, stride) = (problem.rows(), 1 + problem.tangents);
    for row in 0..rows {
        problem.delassus[row * rows + row] = 1.0;
    }
    problem.delassus[stride] = -1.0;
    problem.delassus[stride * rows] = -1.0;
    problem.delassus[stride * rows + stride] = 1.0 + 1.0 / ratio;
    problem.drift[0] = -1.0;
    let mut solver = Solver::default();
    solver.solve(&problem, law, &mut Memory::default());
    (solver.impulse[0] / (1.0 + ratio) - 1.0).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bisection_finds_an_end() {
        let end = bisect(1.0, 100.0, |value| Ok(value < 7.0)).expect("no error");
        assert!((end / 7.0 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_stack_is_solved_at_every_mass_ratio() {
        for ratio in [1.0, 1e3, 1e6] {
            assert!(stacked(LAW, ratio) < 1e-6, "{ratio}: {}", stacked(LAW, ratio));
        }
    }
}
