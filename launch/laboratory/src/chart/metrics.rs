//! Errors of a run: first the metrics that answer the scene's question, then metrics that every run has.

use super::cases::{HOP, PENETRATION, Question};
use super::exact::{Ball, Puck, Wheel, gravity, landing, rocking_ratio, sliding};
use super::trial::{RunLog, StateSample};
use messages::scene::Scene;
use nalgebra::Vector3;

/// Weight of a velocity error relative to a position error, tau of the mean error [s].
const TAU: f64 = 0.1;
/// Steps of the wheel over which its speed is averaged.
const ROUNDS: usize = 5;

/// A quantity and its value.
pub type Metric = (&'static str, f64);

/// Every metric of a run, those that answer the scene's question first.
pub fn metrics(question: Question, scene: &Scene, log: &RunLog) -> Vec<Metric> {
    let mut list = errors(question, scene, log);
    match question {
        Question::Flight => return [list, vec![("angular momentum", momentum_drift(&log.samples))]].concat(),
        Question::Wheel => list.push(("ratio", spin_ratio(scene, &log.samples))),
        _ => {}
    }
    if question.has_formula() {
        list.push(("mean_m", mean_error(scene, &log.samples)));
        list.push(("impulse", impulse_error(scene, &log.samples)));
    }
    if question != Question::Drop {
        list.push((HOP, hop(question, &log.samples)));
        list.push((PENETRATION, (-least(&log.samples).1).max(0.0)));
    }
    list.push((SIGNORINI, log.signorini));
    list.push(("natural map", log.natural_map));
    list.push(("energy_gain_j", log.energy_gain));
    list
}

/// Residual of (19).
pub const SIGNORINI: &str = "signorini";

/// The metrics that answer the scene's question. The runs of every engine are judged by them.
pub fn errors(question: Question, scene: &Scene, log: &RunLog) -> Vec<Metric> {
    question.metrics().iter().copied().zip(values(question, scene, log)).collect()
}

/// Values of [`Question::metrics`]; the second value is 0 where there is only one metric.
fn values(question: Question, scene: &Scene, log: &RunLog) -> [f64; 2] {
    let samples = &log.samples;
    match question {
        Question::Flight => {
            let energies = || samples.iter().map(|sample| sample.totals.kinetic);
            let first = energies().next().unwrap_or(f64::NAN);
            [energies().fold(0.0, |worst: f64, energy| worst.max((energy / first - 1.0).abs())), 0.0]
        }
        Question::Slide | Question::Descend => {
            let wanted = across(&sliding(scene, scene.duration)[0]);
            let (moved, direction) = (across(&com_displacement(samples)), wanted.normalize());
            [(moved.dot(&direction) / wanted.norm() - 1.0).abs(), moved.cross(&direction).norm() / wanted.norm()]
        }
        Question::Stick | Question::Stand => [creep(&log.halves) / (0.5 * scene.duration), 0.0],
        Question::Drop => {
            let (deepest, least) = least(samples);
            [(-least).max(0.0), samples[deepest..].iter().fold(0.0, |hop: f64, sample| hop.max(sample.low))]
        }
        Question::Rock => [rocking_error(scene, samples), 0.0],
        Question::Wheel => [(wheel_speed(samples) / Wheel::of(scene).speed() - 1.0).abs(), 0.0],
        Question::Turn => {
            let end = Puck::of(scene).at(scene.duration);
            let yaw = samples.last().map_or(f64::NAN, |sample| sample.yaw);
            let off = across(&com_displacement(samples)) - end.displacement;
            [(yaw / end.yaw - 1.0).abs(), off.norm() / end.displacement.norm()]
        }
        Question::Roll => {
            let (ball, [first, last]) = (Ball::of(scene), [samples.first(), samples.last()]);
            let angle = ball.at(scene.duration);
            let [start, end] = [first, last].map(|sample| sample.map_or(f64::NAN, |sample| sample.tilt));
            let displacement = ball.displacement(angle);
            [
                ((end - angle) / start).abs(),
                ((com_displacement(samples).x - displacement) / (ball.radius * start)).abs(),
            ]
        }
    }
}

/// Greatest displacement of a contact point in the second half of the run [m].
fn creep([middle, end]: &[Vec<Vector3<f64>>; 2]) -> f64 {
    middle.iter().zip(end).fold(0.0, |worst: f64, (middle, end)| worst.max((end - middle).norm()))
}

fn com_displacement(samples: &[StateSample]) -> Vector3<f64> {
    match samples {
        [first, .., last] => last.totals.com - first.totals.com,
        _ => Vector3::zeros(),
    }
}

fn across(vector: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, 0.0)
}

/// Index of the sample with the lowest contact point, and the height of that point [m].
fn least(samples: &[StateSample]) -> (usize, f64) {
    let deeper = |least: (usize, f64), (i, sample): (usize, &StateSample)| {
        if sample.low < least.1 { (i, sample.low) } else { least }
    };
    samples.iter().enumerate().fold((0, f64::INFINITY), deeper)
}

/// Greatest relative change of the angular momentum [-].
fn momentum_drift(samples: &[StateSample]) -> f64 {
    let first = samples.first().map_or(Vector3::zeros(), |sample| sample.totals.angular);
    samples.iter().fold(0.0, |worst: f64, sample| worst.max((sample.totals.angular - first).norm())) / first.norm()
}

/// (1/T)∫ ‖(x - x*, tau (v - v*))‖ dt of the centre of mass [m].
fn mean_error(scene: &Scene, samples: &[StateSample]) -> f64 {
    let start = samples.first().map_or(Vector3::zeros(), |sample| sample.totals.com);
    let error = |sample: &StateSample| {
        let [travel, velocity] = sliding(scene, sample.time);
        (sample.totals.com - start - travel).norm().hypot(TAU * (sample.totals.com_velocity - velocity).norm())
    };
    samples.iter().map(error).sum::<f64>() / samples.len() as f64
}

/// sup |∫f_N - ∫f_N*| / (m g T), from the landing on. The exact impulse ∫f_N* is that of the weight since the start of the run.
fn impulse_error(scene: &Scene, samples: &[StateSample]) -> f64 {
    let ([_, into], fall) = (gravity(scene), landing(scene));
    let weight = samples.first().map_or(f64::NAN, |sample| sample.totals.mass) * into;
    let due = |time: f64| if time > fall { weight * time } else { 0.0 };
    let after = |sample: &&StateSample| fall == 0.0 || (sample.time - fall).abs() > 0.05;
    let worst = samples.iter().filter(after).map(|sample| (sample.load - due(sample.time)).abs()).fold(0.0, f64::max);
    worst / (weight * scene.duration)
}

/// Greatest height above the ground [m]: of any point of a flat body, of the lowest point of other bodies.
fn hop(question: Question, samples: &[StateSample]) -> f64 {
    let height = |sample: &StateSample| if question.is_flat() { sample.high } else { sample.low };
    samples.iter().fold(0.0, |hop: f64, sample| hop.max(height(sample)))
}

/// Relative error of the angle to which a rocking block rises on its other edge; Housner's ratio gives the exact angle.
fn rocking_error(scene: &Scene, samples: &[StateSample]) -> f64 {
    let [width, _, height] = scene.bodies[0].size;
    let (tipping, ratio) = (width.atan2(height), rocking_ratio(width, height));
    let start = samples.first().map_or(f64::NAN, |sample| sample.tilt);
    let potential = (tipping - start.abs()).cos() - tipping.cos();
    let wanted = tipping - (tipping.cos() + ratio * ratio * potential).acos();
    let side = -start.signum();
    let Some(impact) = samples.iter().position(|sample| side * sample.tilt > 0.0) else { return 1.0 };
    let parts = || samples[impact..].windows(3);
    let apex = parts().find(|part| side * part[1].tilt >= side * part[2].tilt);
    let apex = apex.map_or(0.0, |part| peak([part[0].tilt, part[1].tilt, part[2].tilt].map(|tilt| side * tilt)));
    (apex / wanted - 1.0).abs()
}

/// Maximum of the parabola through three equidistant values, of which the middle one is the greatest.
fn peak([a, b, c]: [f64; 3]) -> f64 {
    let bend = a - 2.0 * b + c;
    if bend < 0.0 { b - (a - c).powi(2) / (8.0 * bend) } else { b }
}

/// Times and places at which the hub is above a tip. The motion is smooth there, so linear interpolation is accurate.
fn upright(samples: &[StateSample]) -> Vec<[f64; 2]> {
    let passes = samples.windows(2).filter(|pair| pair[0].ahead > 0.0 && pair[1].ahead <= 0.0);
    let pass = |pair: &[StateSample]| {
        let part = pair[0].ahead / (pair[0].ahead - pair[1].ahead);
        let between = |of: fn(&StateSample) -> f64| of(&pair[0]) + part * (of(&pair[1]) - of(&pair[0]));
        [between(|sample| sample.time), between(|sample| sample.totals.com.x)]
    };
    passes.map(pass).collect()
}

/// Mean speed over the last [`ROUNDS`] steps of the wheel [m/s].
fn wheel_speed(samples: &[StateSample]) -> f64 {
    let passes = upright(samples);
    let from = passes.len().saturating_sub(ROUNDS + 1);
    match &passes[from..] {
        [first, .., last] => (last[1] - first[1]) / (last[0] - first[0]),
        _ => 0.0,
    }
}

/// Relative error of the ratio of angular velocities at the last impact, both extrapolated to the middle of the step with the impact.
fn spin_ratio(scene: &Scene, samples: &[StateSample]) -> f64 {
    let wanted = Wheel::of(scene).ratio();
    let mut impacts = samples.windows(4).filter(|part| part[2].spin < 0.9 * part[1].spin);
    let ratio = |part: &[StateSample]| {
        let before = 1.5 * part[1].spin - 0.5 * part[0].spin;
        let after = 1.5 * part[2].spin - 0.5 * part[3].spin;
        (after / before / wanted - 1.0).abs()
    };
    impacts.next_back().map_or(1.0, ratio)
}
