//! The return map of a walker, from just after one step to just after the next, with its fixed point and multipliers.

use crate::support::{advance, load, pose};
use nalgebra::{Complex, DMatrix, DVector};
use plant::Plant;
use plant::kinematics::{self, Pose};
use plant::state::State;

/// Number of states after a step, from which the state just after the step is extrapolated.
const SAMPLES: usize = 4;

/// The state just after the next step, the time that passed [s], and the new stance foot.
pub struct Step {
    pub state: State,
    pub time: f64,
    pub foot: usize,
}

/// Simulates from a state with the foot `stance` on the ground until a foot ahead of it carries load.
///
/// The simulation has states only at multiples of dt. The time of the step itself is found by extrapolation: the smooth motion after the step
/// is extrapolated back, through positions and velocities of four states, to the time at which the rear foot is on the ground.
pub fn walk_on(plant: &mut Plant, stance: usize, h: f64) -> Step {
    let feet = plant.model().contact_points.len();
    let mut steps = 0;
    let foot = loop {
        advance(plant);
        steps += 1;
        assert!(f64::from(steps) * h < 20.0, "no step");
        let (pose, corners) = (pose(plant), &plant.model().contact_points);
        let ahead = |foot: usize| pose.lowest(&corners[foot]).x > pose.lowest(&corners[stance]).x + 0.05;
        if let Some(foot) = (0..feet).find(|&foot| load(plant, foot).z > 0.0 && ahead(foot)) {
            break foot;
        }
    };
    let mut samples = vec![plant.state().clone()];
    for _ in 1..SAMPLES {
        advance(plant);
        samples.push(plant.state().clone());
    }
    let (corner, mut pose) = (plant.model().contact_points[stance].clone(), Pose::new(plant.model()));
    let mut height = |back: f64| {
        kinematics::pose(plant.model(), &extrapolated(&samples, -back, h), &mut pose);
        pose.reference.z + pose.lowest(&corner).z
    };
    // the rear foot rises after the step, so backward in time it descends
    let (mut late, mut early) = (0.0, h);
    for _ in 0..60 {
        let middle = 0.5 * (late + early);
        if height(middle) > 0.0 { late = middle } else { early = middle }
    }
    Step { state: extrapolated(&samples, -late, h), time: f64::from(steps) * h - late, foot }
}

/// Value and slope at `time` of the Hermite polynomial through values and slopes at 0, h, 2h, …, by divided differences.
pub fn extrapolated(samples: &[State], time: f64, h: f64) -> State {
    let mut state = samples[0].clone();
    let nodes: Vec<f64> = (0..2 * samples.len()).map(|k| (k / 2) as f64 * h).collect();
    for i in 0..state.x.len() {
        let mut table: Vec<f64> = (0..nodes.len()).map(|k| samples[k / 2].x[i]).collect();
        for order in 1..nodes.len() {
            for k in (order..nodes.len()).rev() {
                table[k] = match (order, k % 2) {
                    (1, 1) => samples[k / 2].xdot[i],
                    _ => (table[k] - table[k - 1]) / (nodes[k] - nodes[k - order]),
                };
            }
        }
        let (mut value, mut slope) = (0.0, 0.0);
        for (coefficient, node) in table.iter().zip(&nodes).rev() {
            slope = value + slope * (time - node);
            value = coefficient + value * (time - node);
        }
        (state.x[i], state.xdot[i]) = (value, slope);
    }
    state
}

/// The return map of a walker: from the coordinates just after a step to those after the next one, and the time between.
pub type Map<'a> = dyn Fn(&DVector<f64>) -> (DVector<f64>, f64) + 'a;

/// Jacobian by central differences.
fn jacobian(map: &Map, at: &DVector<f64>, by: f64) -> DMatrix<f64> {
    let columns: Vec<_> = (0..at.len())
        .map(|k| {
            let mut shift = DVector::zeros(at.len());
            shift[k] = by;
            (map(&(at + &shift)).0 - map(&(at - &shift)).0) / (2.0 * by)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

/// Fixed point by Newton's method from a guess, its multipliers in descending order, and the period.
pub fn limit_cycle(map: &Map, guess: DVector<f64>) -> (DVector<f64>, Vec<Complex<f64>>, f64) {
    let mut at = guess;
    for _ in 0..6 {
        let (next, _) = map(&at);
        let system = jacobian(map, &at, 2e-5) - DMatrix::identity(at.len(), at.len());
        let change = system.lu().solve(&(next - &at)).expect("multipliers other than one");
        at -= &change;
        if change.norm() < 1e-13 {
            break;
        }
    }
    let mut multipliers: Vec<_> = jacobian(map, &at, 2e-5).complex_eigenvalues().iter().copied().collect();
    multipliers.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    let period = map(&at).1;
    (at, multipliers, period)
}
