//! Passive walkers on the general engine: scenes 7, 8 and 9. Feet are contact points, what happens at a step is the contact law,
//! and limit cycle and multipliers are those of the map from just after one step to just after the next.

use crate::support::{advance, assert_near, load, pose, scene};
use messages::scene::Scene;
use nalgebra::{Complex, DMatrix, DVector};
use plant::Plant;
use plant::kinematics::{self, Pose};
use plant::state::State;
use std::f64::consts::PI;

/// States after a step that the one just after it is extrapolated from.
const SAMPLES: usize = 4;

/// The state just after the next step, with the time that passed [s] and the foot that now stands.
struct Step {
    state: State,
    time: f64,
    foot: usize,
}

/// Walks on from a state with the foot `stance` on the ground until a foot ahead of it carries.
///
/// The engine stops at multiples of dt. The moment of the step is where the motion after it, which is smooth, has the foot
/// behind on the ground: it is extrapolated back by the polynomial through positions and velocities of four states.
fn walk_on(plant: &mut Plant, stance: usize, h: f64) -> Step {
    let feet = plant.model().corners.len();
    let mut steps = 0;
    let foot = loop {
        advance(plant);
        steps += 1;
        assert!(f64::from(steps) * h < 20.0, "no step");
        let (pose, corners) = (pose(plant), &plant.model().corners);
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
    let (corner, mut pose) = (plant.model().corners[stance].clone(), Pose::new(plant.model()));
    let mut height = |back: f64| {
        kinematics::pose(plant.model(), &extrapolated(&samples, -back, h), &mut pose);
        pose.reference.z + pose.lowest(&corner).z
    };
    // it leaves the ground at once and rises, so going back it comes down
    let (mut late, mut early) = (0.0, h);
    for _ in 0..60 {
        let middle = 0.5 * (late + early);
        if height(middle) > 0.0 { late = middle } else { early = middle }
    }
    Step { state: extrapolated(&samples, -late, h), time: f64::from(steps) * h - late, foot }
}

/// Value and slope at `time` of the polynomial that has given values and slopes at 0, h, 2h, … (Hermite, by divided differences).
fn extrapolated(samples: &[State], time: f64, h: f64) -> State {
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

/// A walker as a map: numbers that say how it moves just after a step, to those after the next, with the time between.
type Map<'a> = dyn Fn(&DVector<f64>) -> (DVector<f64>, f64) + 'a;

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

/// Fixed point by Newton's method from a guess, its multipliers from the largest, and the period.
fn limit_cycle(map: &Map, guess: DVector<f64>) -> (DVector<f64>, Vec<Complex<f64>>, f64) {
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

/// A scene with a method and a step, one to a control period.
fn by(name: &str, method: &str, h: f64) -> Scene {
    let settings = [
        format!("plant.method={method}"),
        format!("plant.dt={h}"),
        format!("rate={}", 1.0 / h),
        "plant.tolerance_step=1e-12".into(),
    ];
    scene(name, &settings.each_ref().map(String::as_str))
}

/// Legs of a two-legged walker just after a step: angle of the standing leg and the rates of both, from the normal of the
/// ground, forward. The other leg's angle is opposite.
fn legs(scene: &Scene, at: &DVector<f64>) -> (DVector<f64>, f64) {
    let (angle, rate, other) = (at[0], at[1], at[2]);
    let mut scene = scene.clone();
    let (sin, cos) = angle.sin_cos();
    scene.initial.position = [sin, 0.0, cos];
    scene.initial.orientation_deg = [0.0, angle.to_degrees(), 0.0];
    scene.initial.velocity = [rate * cos, 0.0, -rate * sin];
    scene.initial.angular_velocity = [0.0, rate, 0.0];
    scene.initial.joints = vec![-2.0 * angle];
    scene.initial.joint_rates = vec![other - rate];
    let mut plant = Plant::new(&scene).expect("a walker");
    let step = walk_on(&mut plant, 0, scene.plant.dt);
    assert_eq!(step.foot, 1);
    // left is the base
    let (x, v) = (&step.state.x, &step.state.xdot);
    (DVector::from_vec(vec![x[2] + x[3], v[2] + v[3], v[2]]), step.time)
}

/// A wheel without a rim, on two spokes, turning about the front one.
fn wheel(scene: &Scene, at: &DVector<f64>) -> (DVector<f64>, f64) {
    let mut scene = scene.clone();
    let (sin, cos) = (PI / 8.0).sin_cos();
    scene.initial.position = [0.0, 0.0, cos];
    scene.initial.velocity = [at[0] * cos, 0.0, at[0] * sin];
    scene.initial.angular_velocity = [0.0, at[0], 0.0];
    let mut plant = Plant::new(&scene).expect("a wheel");
    let front = {
        let (pose, corners) = (pose(&plant), &plant.model().corners);
        (0..8).find(|&i| pose.lowest(&corners[i]).x > 0.1 && pose.lowest(&corners[i]).z < -0.9).expect("a front spoke")
    };
    let step = walk_on(&mut plant, front, scene.plant.dt);
    (DVector::from_vec(vec![step.state.xdot[2]]), step.time)
}

/// The limit cycle of a wheel of gyration radius² `gyration` and spokes of 1 m on a slope of 0.08 rad, in closed form.
fn wheel_by_hand(gyration: f64) -> [f64; 3] {
    let half = PI / 8.0;
    let ratio = (gyration + (2.0 * half).cos()) / (1.0 + gyration);
    let before = (4.0 * 9.81 / (1.0 + gyration) * half.sin() * 0.08_f64.sin() / (1.0 - ratio * ratio)).sqrt();
    [ratio * before, before, ratio * ratio]
}

#[test]
fn a_wheel_without_a_rim_has_the_limit_cycle_of_its_closed_form() {
    let scene = by("rimless-wheel", "EventDriven", 5e-3);
    let [after, before, multiplier] = wheel_by_hand(0.0);
    assert_near("w after", after, 1.095_462_839_648, 1e-12);
    assert_near("w before", before, 1.549_218_404_905, 1e-12);
    let cycle = |gyration: f64| {
        let mut scene = scene.clone();
        scene.bodies[0].inertia = Some([gyration; 3]);
        let (at, multipliers, period) = limit_cycle(&|at| wheel(&scene, at), DVector::from_vec(vec![1.1]));
        let [exact, _, exact_multiplier] = wheel_by_hand(gyration);
        println!(
            "gyration {gyration}: w {:e} off, multiplier {:e} off",
            at[0] - exact,
            multipliers[0].re - exact_multiplier
        );
        assert_near("w after", at[0], exact, 1e-9);
        assert_near("multiplier", multipliers[0].re, exact_multiplier, 1e-4);
        [at[0], multipliers[0].re, period]
    };
    let (one, two) = (cycle(1e-5), cycle(2e-5));
    let limit = [0, 1, 2].map(|k| 2.0 * one[k] - two[k]);
    println!("as the wheel's own inertia vanishes: {limit:?}");
    assert_near("w after", limit[0], after, 1e-9);
    assert_near("multiplier", limit[1], multiplier, 1e-4);
    // seen through where the spoke behind leaves the ground, which is known to 1e-9 m
    assert_near("period", limit[2], 1.034_549_811_423, 4e-9);
    assert_near("speed", 2.0 * (PI / 8.0).sin() / limit[2], 0.739_806_683, 4e-9);
}

#[test]
fn the_compass_gait_has_its_known_limit_cycle() {
    let scene = by("compass-gait", "EventDriven", 5e-3);
    let slope = 0.0525;
    let guess = DVector::from_vec(vec![-0.27, 1.09, 0.37]);
    let (at, multipliers, period) = limit_cycle(&|at| legs(&scene, at), guess);
    println!("{at} {multipliers:?} {period}");
    // the angles of the literature are from the vertical
    assert_near("standing leg", at[0] + slope, -0.218_774_617_980, 1e-6);
    assert_near("swinging leg", -at[0] + slope, 0.323_774_617_980, 1e-6);
    assert_near("its rate", at[1], 1.092_866_810_580, 1e-6);
    assert_near("the other's", at[2], 0.376_134_593_531, 1e-6);
    assert_near("period", period, 0.734_460_621_337, 1e-6);
    let exact = [Complex::new(-0.202_216_100_1, 0.543_414_971_4), Complex::new(-0.202_216_100_1, -0.543_414_971_4)];
    for (multiplier, exact) in multipliers.iter().zip([exact[0], exact[1], Complex::new(0.131_386_707_2, 0.0)]) {
        assert_near("multiplier", (multiplier - exact).norm(), 0.0, 1e-4);
    }
}

/// Twenty steps on, tile by tile, each as long as the legs are apart.
#[test]
fn the_compass_gait_keeps_walking() {
    let mut scene = scene("compass-gait", &[]);
    (scene.plant.dt, scene.rate) = (0.734_460_621_337 / 700.0, 700.0 / 0.734_460_621_337);
    let mut plant = Plant::new(&scene).expect("a walker");
    let start = plant.state().x[0];
    for _ in 0..20 * 700 {
        advance(&mut plant);
    }
    let way = plant.state().x[0] - start;
    println!("{way} m in 20 steps");
    assert_near("way", way, 20.0 * 2.0 * 0.271_274_617_980_f64.sin(), 1e-6);
}

/// Its feet weigh `foot` each in a body of 1 kg.
fn with_feet(scene: &Scene, foot: f64) -> Scene {
    let mut scene = scene.clone();
    let [left, right] = &mut scene.bodies[..] else { unreachable!("two legs") };
    left.mass = 1.0 + foot;
    left.com = [0.0, 0.0, -foot / (1.0 + foot)];
    left.inertia = Some([foot / (1.0 + foot), foot / (1.0 + foot), 1e-9]);
    right.mass = foot;
    right.inertia = Some([1e-9 * foot; 3]);
    scene
}

/// The limit of no mass in the feet, from three small ones.
#[test]
fn the_simplest_walker_has_its_known_limit_cycle() {
    let scene = by("simplest-walker", "EventDriven", 2e-2);
    let cycle = |foot: f64| {
        let scene = with_feet(&scene, foot);
        let guess = DVector::from_vec(vec![-0.2003, 0.19983, 0.184]);
        let (at, multipliers, period) = limit_cycle(&|at| legs(&scene, at), guess);
        println!("feet of {foot}: {:.9} {:.9} {:?} {period:.9}", at[0], at[1], multipliers);
        [at[0], at[1], at[2], period, multipliers[0].re, multipliers[0].im, multipliers[2].re]
    };
    // Neville's scheme at zero
    let masses = [2e-4, 1e-4, 5e-5];
    let mut rows = masses.map(cycle);
    for order in 1..masses.len() {
        for k in (order..masses.len()).rev() {
            let (near, far) = (masses[k], masses[k - order]);
            rows[k] = std::array::from_fn(|i| (far * rows[k][i] - near * rows[k - 1][i]) / (far - near));
        }
    }
    let limit = rows[masses.len() - 1];
    println!("without: {limit:?}");
    let (angle, rate) = (0.200_310_900_544_f64, -0.199_832_473_005);
    assert_near("angle", -limit[0], angle, 1e-6);
    assert_near("rate", -limit[1], rate, 1e-6);
    assert_near("the other's", -limit[2], rate * (2.0 * angle).cos(), 1e-6);
    assert_near("period", limit[3], 3.882_463_752_852, 1e-5);
    assert_near("multiplier", limit[4], -0.190_099_841_066, 1e-4);
    assert_near("multiplier", limit[5], 0.557_598_776_682, 1e-4);
    assert_near("third multiplier", limit[6], 0.0, 1e-4);
}

/// Where a walk from the limit cycle is when the next standing leg is upright: time, the other leg's angle to it, both rates.
/// So late after the impact that its unsteadiness within a step has settled.
fn upright(method: &str, h: f64) -> DVector<f64> {
    let mut plant = Plant::new(&by("compass-gait", method, h)).expect("a walker");
    let angle = |state: &State| state.x[2] + state.x[3];
    let mut before = plant.state().clone();
    for steps in 0.. {
        assert!(f64::from(steps) * h < 2.0, "it does not walk");
        advance(&mut plant);
        let now = plant.state().clone();
        // the right leg swings first, and is upright twice: swinging forward beside the left one, and standing
        if f64::from(steps) * h > 0.9 && angle(&before) < 0.0 && angle(&now) >= 0.0 {
            let pair = [before, now];
            let (mut low, mut high) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if angle(&extrapolated(&pair, middle, h)) < 0.0 { low = middle } else { high = middle }
            }
            let state = extrapolated(&pair, high, h);
            return DVector::from_vec(vec![f64::from(steps) * h + high, state.x[2], state.xdot[2], state.xdot[3]]);
        }
        before = now;
    }
    unreachable!()
}

/// Slope of the logarithms of error and step over many steps, for the moment of the impact within a step makes single errors
/// jump; and the error at 1 ms.
fn order(method: &str, exact: &DVector<f64>) -> (f64, f64) {
    let steps = (0..24).map(|k| 4e-3 * 0.92_f64.powi(k));
    let points: Vec<_> = steps.map(|h| (h.ln(), (upright(method, h) - exact).norm().ln())).collect();
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x));
    (slope, (y + slope * (1e-3_f64.ln() - x)).exp())
}

/// Impulses at the end of a step make any method one of first order where a leg pivots; forces in every stage do not.
#[test]
fn the_compass_gait_converges_with_the_order_of_the_method() {
    let expected =
        [("SemiImplicitEuler", 0.8), ("MoreauJean", 0.8), ("MidpointMoreau", 0.8), ("Rk4", 0.8), ("Rk4Impact", 1.8)];
    let exact = upright("EventDriven", 1e-3);
    for (method, least) in expected {
        let (slope, error) = order(method, &exact);
        println!("{method:<18} order {slope:.2}, error at 1 ms {error:.1e}");
        assert!(slope > least, "{method}: order {slope}");
    }
}
