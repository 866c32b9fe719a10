//! Claims about the contact laws and their solver, against exact answers.

use messages::scene::Law;
use plant::contact::{Memory, Problem, Report, Solver, tangents};

const G: f64 = 9.81;
const H: f64 = 1e-3;
/// The laws that are solved by pivoting along the problem's own tangents; the others are in `laws.rs`.
const PIVOTED: [Law; 4] = [Law::EnergyQp, Law::EnergyQpGap, Law::Complementarity, Law::Aligned];

/// One row of K^T: normal, then the tangents x and y of the world.
type Rows = [Vec<f64>; 3];

/// A = K^T H^-1 K and b = K^T xdot for diagonal H; the first tangent turned along the free slip.
fn assemble(law: Law, contacts: &[Rows], inverse_inertia: &[f64], xdot: &[f64], mu: f64) -> Problem {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut problem = Problem::default();
    problem.reset(contacts.len(), tangents(law));
    problem.friction.fill(mu);
    let mut rows = Vec::new();
    for [normal, x, y] in contacts {
        let (vx, vy) = (dot(x, xdot), dot(y, xdot));
        let slip = vx.hypot(vy);
        let (c, s) = if slip > 0.0 { (vx / slip, vy / slip) } else { (1.0, 0.0) };
        let turn = |c: f64, s: f64| x.iter().zip(y).map(|(x, y)| c * x + s * y).collect::<Vec<_>>();
        rows.push(normal.clone());
        rows.push(turn(c, s));
        if problem.tangents == 2 {
            rows.push(turn(-s, c));
        }
    }
    let m = problem.rows();
    for (i, row) in rows.iter().enumerate() {
        let weighted: Vec<f64> = row.iter().zip(inverse_inertia).map(|(k, h)| k * h).collect();
        for (j, other) in rows.iter().enumerate() {
            problem.delassus[i * m + j] = dot(&weighted, other);
        }
        problem.drift[i] = dot(row, xdot);
    }
    problem
}

/// A point r fixed to a rigid body with coordinates (v, omega) at its centre of mass.
fn on_body([x, y, z]: [f64; 3]) -> Rows {
    [vec![0., 0., 1., y, -x, 0.], vec![1., 0., 0., 0., z, -y], vec![0., 1., 0., -z, 0., x]]
}

fn point_mass(law: Law, mass: f64, speed: f64, mu: f64) -> Problem {
    let rows = [vec![0., 0., 1.], vec![1., 0., 0.], vec![0., 1., 0.]];
    assemble(law, &[rows], &[1.0 / mass; 3], &[speed, 0.0, -G * H], mu)
}

fn solve(problem: &Problem, law: Law) -> (Solver, Report) {
    let mut solver = Solver::default();
    let report = solver.solve(problem, law, &mut Memory::default());
    assert!(report.own <= 1e-10 && !report.fallback, "{law:?} {report:?}");
    (solver, report)
}

fn assert_near(what: &str, value: f64, exact: f64, tolerance: f64) {
    assert!((value - exact).abs() <= tolerance * (1.0 + exact.abs()), "{what}: {value}, not {exact}");
}

/// Scene 1. The program as printed lifts a slider; the conditions it was meant to have do not.
#[test]
fn a_slider_hops_under_the_printed_program_and_stays_down_under_coulomb() {
    let (mu, speed, mass) = (0.5, 1.0, 3.0);
    let (solver, report) = solve(&point_mass(Law::EnergyQp, mass, speed, mu), Law::EnergyQp);
    let slip = (speed - mu * G * H) / (1.0 + mu * mu);
    assert_near("v_F", solver.velocity[1], slip, 1e-14);
    assert_near("v_N", solver.velocity[0], mu * slip, 1e-14);
    assert_near("hop [m]", (mu * speed / (1.0 + mu * mu)).powi(2) / (2.0 * G), 8.15e-3, 5e-6);
    assert!(report.natural_map > 0.1 && report.signorini > 0.1, "(19) must be seen to fail: {report:?}");
    for law in [Law::Complementarity, Law::Aligned] {
        let (solver, report) = solve(&point_mass(law, mass, speed, mu), law);
        assert_near("v_N", solver.velocity[0], 0.0, 1e-15);
        assert_near("v_F", solver.velocity[1], speed - mu * G * H, 1e-15);
        assert_near("f_N", solver.impulse[0], mass * G * H, 1e-14);
        assert!(report.slip_misalignment < 1e-12 && report.signorini < 1e-15, "{report:?}");
    }
}

/// The multipliers of contact.rs: f_N (v_N - mu |v_F|) = 0 and v_N >= mu |v_F| instead of (18), (19).
#[test]
fn the_printed_program_has_the_multipliers_that_its_lagrangian_gives() {
    let mut random = fastrand::Rng::with_seed(1);
    let mut violated = 0;
    for _ in 0..2000 {
        let (problem, _) = random_problem(&mut random, Law::EnergyQp);
        let (solver, report) = solve(&problem, Law::EnergyQp);
        violated += usize::from(report.signorini > 1e-6);
        for i in 0..problem.contacts {
            let (k, mu) = (2 * i, problem.friction[i]);
            let root = |k: usize| problem.delassus[k * problem.rows() + k].sqrt();
            let (f, v) = (solver.impulse[k], solver.velocity[k] - mu * solver.velocity[k + 1].abs());
            let scale = step_scale(&problem, &solver);
            assert!(v / root(k) >= -1e-10 * scale, "v_N < mu |v_F| by {v}");
            assert!(f * v <= 1e-10 * scale * scale, "f_N (v_N - mu |v_F|) = {}", f * v);
        }
    }
    assert!(violated > 1000, "(19) held in all but {violated} of 2000 problems");
}

/// Scene 13 at the level of one step: two feet of one body, eight corners, rank six.
#[test]
fn eight_corners_carry_the_weight_and_stand_still_in_any_order() {
    let (mass, weight) = (14.0, 14.0 * G * H);
    let inverse = [1. / mass, 1. / mass, 1. / mass, 1. / 0.8, 1. / 0.7, 1. / 0.2];
    let mut corners = Vec::new();
    for y in [-0.12, -0.04, 0.04, 0.12] {
        corners.extend([[0.1, y, -0.3], [-0.06, y, -0.3]]);
    }
    let mut random = fastrand::Rng::with_seed(2);
    for law in PIVOTED {
        // Falling for one step from rest, pushed a little to the side and turned.
        let xdot = [2e-3, 1e-3, -G * H, 1e-4, -2e-4, 3e-4];
        for _ in 0..50 {
            random.shuffle(&mut corners);
            let contacts: Vec<Rows> = corners.iter().map(|&c| on_body(c)).collect();
            let problem = assemble(law, &contacts, &inverse, &xdot, 0.7);
            let (solver, report) = solve(&problem, law);
            let normal: f64 = solver.impulse.iter().step_by(1 + problem.tangents).sum();
            assert!(report.energy_gain < 0.0);
            if law == Law::Aligned {
                assert_near("sum of f_N", normal, weight, 1e-12);
                solver.velocity.iter().for_each(|&v| assert_near("v", v, 0.0, 1e-15));
            }
            if law == Law::Complementarity {
                assert_near("sum of f_N", normal, weight, 1e-12);
                solver.velocity.iter().step_by(2).for_each(|&v| assert_near("v_N", v, 0.0, 1e-15));
            }
        }
    }
}

#[test]
fn a_contact_given_twice_moves_as_if_given_once() {
    for law in PIVOTED {
        let one = point_mass(law, 2.0, 0.3, 0.4);
        let rows = [vec![0., 0., 1.], vec![1., 0., 0.], vec![0., 1., 0.]];
        let two = assemble(law, &[rows.clone(), rows], &[0.5; 3], &[0.3, 0.0, -G * H], 0.4);
        let (one, two) = (solve(&one, law).0, solve(&two, law).0);
        let stride = 1 + tangents(law);
        for k in 0..stride {
            assert_near("v", two.velocity[k], one.velocity[k], 1e-15);
            assert_near("sum of f", two.impulse[k] + two.impulse[k + stride], one.impulse[k], 1e-15);
        }
    }
}

/// Scene 15: the ground holds a light mass that holds a heavy one.
#[test]
fn a_heavy_mass_on_a_light_one_is_held_at_every_ratio() {
    for ratio in [1.0, 1e2, 1e4, 1e6] {
        for law in PIVOTED {
            let (light, heavy) = (1.0, ratio);
            // Vertical and horizontal velocity of each; the second contact is between them.
            let ground = [vec![1., 0., 0., 0.], vec![0., 0., 1., 0.], vec![0.; 4]];
            let between = [vec![-1., 1., 0., 0.], vec![0., 0., -1., 1.], vec![0.; 4]];
            let inverse = [1. / light, 1. / heavy, 1. / light, 1. / heavy];
            let problem = assemble(law, &[ground, between], &inverse, &[-G * H, -G * H, 0., 0.], 0.5);
            let (solver, report) = solve(&problem, law);
            let second = 1 + problem.tangents;
            // A itself carries 1/heavy beside 1/light, so f is known to eps·ratio.
            let known = 1e-14 + 4.0 * f64::EPSILON * ratio;
            assert_near("f on the ground", solver.impulse[0], (light + heavy) * G * H, known);
            assert_near("f between", solver.impulse[second], heavy * G * H, known);
            assert!(report.pivots <= 20, "{report:?}");
        }
    }
}

#[test]
fn friction_sticks_inside_the_cone_and_slides_outside() {
    for (speed, sticks) in [(0.49, true), (0.51, false)] {
        for law in [Law::Complementarity, Law::Aligned] {
            let (solver, _) = solve(&point_mass(law, 1.0, speed * G * H, 0.5), law);
            assert_eq!(solver.velocity[1].abs() < 1e-15, sticks, "{law:?} at {speed}");
        }
    }
}

/// The second tangent is resisted: a block driven along one tangent, whose slip starts across it, stops both ways.
#[test]
fn two_tangents_resist_a_slip_at_45_degrees_to_the_given_direction() {
    let mut problem = point_mass(Law::Aligned, 1.0, 0.0, 0.5);
    for (slip, sticks) in [(0.2, true), (2.0, false)] {
        let slip = slip * G * H;
        problem.drift[1] = slip;
        problem.drift[2] = slip;
        let (solver, report) = solve(&problem, Law::Aligned);
        let (t1, t2) = (solver.velocity[1], solver.velocity[2]);
        assert_eq!(t1.abs() < 1e-15 && t2.abs() < 1e-15, sticks);
        assert!((t1 - t2).abs() < 1e-15, "by symmetry both tangents slow down alike: {t1}, {t2}");
        let friction = solver.impulse[1].abs() + solver.impulse[2].abs();
        assert!(friction <= 0.5 * solver.impulse[0] * (1.0 + 1e-12));
        assert!(report.slip_misalignment < 1e-7);
    }
}

/// Scene 10: a rod pushed into the ground, half-length 1, J = 1/3, tan(angle) = 2, v = 1.
#[test]
fn a_painleve_rod_jams_above_four_thirds() {
    let mass = 2.0;
    let (s, c) = (2.0 / 5.0_f64.sqrt(), 1.0 / 5.0_f64.sqrt());
    // Tip at (c, -s) from the centre; coordinates (x, z, pitch), velocity of the tip = v + pitch rate × r.
    let tip = [vec![0., 1., c], vec![1., 0., s], vec![0.; 3]];
    for law in [Law::Complementarity, Law::Aligned] {
        for (mu, jams) in [(1.30, false), (1.34, true), (2.0, true)] {
            let drop = 1e-9;
            let problem =
                assemble(law, std::slice::from_ref(&tip), &[1. / mass, 1. / mass, 3. / mass], &[1., -drop, 0.], mu);
            let (solver, report) = solve(&problem, law);
            let energy = 0.5 * mass;
            if jams {
                assert_near("f_N", solver.impulse[0], 0.3 * mass, 1e-8);
                assert_near("f_F", solver.impulse[1], -0.4 * mass, 1e-8);
                assert_near("energy ratio", 1.0 + report.energy_gain / energy, 0.6, 1e-8);
            } else {
                assert!(solver.velocity[1] > 0.99 && solver.velocity[0].abs() < 1e-15, "slides: {:?}", solver.velocity);
            }
        }
    }
}

/// Scenes 5 and 6: the impact of a rocking block lands on one corner when slender, on both when squat.
#[test]
fn a_rocking_block_loses_what_housner_says() {
    for law in [Law::Complementarity, Law::Aligned] {
        for (b, h, mu, exact) in [(0.1, 0.4, 0.2, 0.911764705882), (0.5, 0.3, 5.0, 0.0)] {
            // Half-width b, half-height h; before the impact it turns about the right corner at omega, and the left lands.
            let (mass, omega) = (1.0_f64, 1.0);
            let inertia = mass * (b * b + h * h) / 3.0;
            let corner = |x: f64| [vec![0., 1., -x], vec![1., 0., -h], vec![0.; 3]];
            // (x, z, pitch), v = v_c + omega (z, -x); the corner (b, -h) rests.
            let xdot = [omega * h, omega * b, omega];
            let problem = assemble(law, &[corner(b), corner(-b)], &[1. / mass, 1. / mass, 1. / inertia], &xdot, mu);
            assert!(problem.drift[0].abs() < 1e-15 && problem.drift[problem.tangents + 1] > 0.0);
            let mirrored: Vec<f64> = xdot.iter().zip([1., -1., 1.]).map(|(x, s)| x * s).collect();
            let problem = assemble(law, &[corner(b), corner(-b)], &[1. / mass, 1. / mass, 1. / inertia], &mirrored, mu);
            let (solver, _) = solve(&problem, law);
            let stride = 1 + problem.tangents;
            // Turning rate from the normal velocities of the corners.
            let after = (solver.velocity[stride] - solver.velocity[0]) / (2.0 * b);
            assert_near("omega+/omega-", after, exact, 1e-11);
        }
    }
}

/// Landing: the paper's laws stop at once, the others may close the gap.
#[test]
fn a_falling_point_lands_exactly_on_the_ground() {
    let gap = 2e-4;
    for law in PIVOTED {
        let mut problem = point_mass(law, 1.0, 0.0, 0.5);
        problem.drift[0] = -0.3;
        problem.approach[0] = gap / H;
        let (solver, report) = solve(&problem, law);
        let exact = if matches!(law, Law::EnergyQp | Law::Complementarity) { 0.0 } else { -gap / H };
        assert_near("v_N", solver.velocity[0], exact, 1e-15);
        assert!(report.energy_gain < 0.0);
    }
}

#[test]
fn a_wrong_impulse_shows_in_the_residual() {
    let problem = point_mass(Law::Aligned, 1.0, 1.0, 0.5);
    let mut wrong = problem.clone();
    wrong.drift[0] *= 1.001; // as if the answer of a slightly different problem were given to this one
    let (mut solver, _) = solve(&wrong, Law::Aligned);
    let report = solver.measure_impulse(&problem, Law::Aligned, &solver.impulse.clone());
    assert!(report.natural_map > 1e-6, "{report:?}");
    let report = solver.measure_impulse(&problem, Law::Aligned, &[0.0; 3]);
    assert!(report.natural_map > 1e-3, "{report:?}");
}

#[test]
fn nothing_touching_and_nothing_moving_need_no_impulse() {
    for law in PIVOTED {
        let mut problem = Problem::default();
        problem.reset(0, tangents(law));
        assert!(solve(&problem, law).0.impulse.is_empty());
        let mut problem = point_mass(law, 1.0, 0.0, 0.5);
        problem.drift.fill(0.0);
        assert_eq!(solve(&problem, law).0.impulse.iter().sum::<f64>(), 0.0);
    }
}

#[test]
fn not_a_number_is_reported_and_ends() {
    for law in PIVOTED {
        for spoil in [true, false] {
            let mut problem = point_mass(law, 1.0, 1.0, 0.5);
            if spoil {
                problem.drift[0] = f64::NAN;
            } else {
                problem.delassus.fill(f64::NAN);
            }
            let report = Solver::default().solve(&problem, law, &mut Memory::default());
            assert!(report.natural_map.is_nan(), "{report:?}");
        }
    }
}

fn step_scale(problem: &Problem, solver: &Solver) -> f64 {
    let m = problem.rows();
    let root = |k: usize| problem.delassus[k * m + k].sqrt();
    (0..m).map(|k| (solver.impulse[k] * root(k)).abs().max((problem.drift[k] / root(k)).abs())).fold(0.0, f64::max)
}

/// A random mechanism: few or many coordinates, inertias to 1 : 1e6, contacts repeated or nearly so, fast and slow, high
/// and low friction. Also the decimal exponent of the spread of inertias.
fn random_problem(random: &mut fastrand::Rng, law: Law) -> (Problem, u32) {
    let contacts = random.usize(1..=8);
    let dof = random.usize(3..=14);
    let spread = [0.0, 1.0, 3.0, 6.0][random.usize(0..4)];
    let inverse: Vec<f64> = (0..dof).map(|_| 10f64.powf(spread * random.f64())).collect();
    let vector = |random: &mut fastrand::Rng| (0..dof).map(|_| 2.0 * random.f64() - 1.0).collect::<Vec<f64>>();
    let rigid = dof >= 6 && random.bool();
    let mut rows: Vec<Rows> = Vec::new();
    for i in 0..contacts {
        if i > 0 && random.f64() < 0.2 {
            let again = rows[random.usize(0..i)].clone();
            rows.push(again);
        } else if rigid {
            // Corners of a foot: coplanar points of one body, rank at most six.
            let mut row = on_body([random.f64() - 0.5, random.f64() - 0.5, -0.5]);
            row.iter_mut().for_each(|r| r.resize(dof, 0.0));
            rows.push(row);
        } else {
            rows.push([vector(random), vector(random), vector(random)]);
        }
    }
    let size = 10f64.powf(4.0 * random.f64() - 4.0);
    let xdot: Vec<f64> = vector(random).iter().map(|v| v * size).collect();
    let mu = [0.0, 0.2, 0.7, 1.5][random.usize(0..4)];
    let mut problem = assemble(law, &rows, &inverse, &xdot, mu);
    for approach in &mut problem.approach {
        *approach = if random.bool() { 0.0 } else { size * random.f64() };
    }
    (problem, spread as u32)
}

/// The energy minimum has one velocity; so has Coulomb's law for a foot at ordinary friction that resists both tangents.
/// Remembering the last basis must not be seen in it, while corners come and go. With one slip direction per corner, and
/// these nearly parallel, corners can also jam each other: (17)-(22) then have several solutions, of which each is found.
#[test]
fn a_remembered_basis_gives_the_velocity_of_a_fresh_start() {
    let corners = [[0.1, 0.04, -0.3], [0.1, -0.04, -0.3], [-0.06, 0.04, -0.3], [-0.06, -0.04, -0.3]];
    let inverse = [1. / 14., 1. / 14., 1. / 14., 1. / 0.8, 1. / 0.7, 1. / 0.2];
    for law in PIVOTED {
        let mut random = fastrand::Rng::with_seed(3);
        let (mut memory, mut solver) = (Memory::default(), Solver::default());
        let (mut warm, mut others) = (0, 0);
        let mut xdot = [0.0, 0.0, -G * H, 0.0, 0.0, 0.0];
        let mut touching = vec![0, 1, 2, 3];
        for step in 0..3000 {
            for (k, v) in xdot.iter_mut().enumerate() {
                let rest = if k == 2 { -G * H } else { 0.0 };
                *v += 0.02 * (rest - *v) + 2e-4 * (random.f64() - 0.5);
            }
            if step % 50 == 0 {
                touching = (0..4).filter(|_| random.f64() < 0.7).collect();
                random.shuffle(&mut touching);
            }
            let contacts: Vec<Rows> = touching.iter().map(|&c| on_body(corners[c])).collect();
            let mut problem = assemble(law, &contacts, &inverse, &xdot, 0.7);
            problem.id.clone_from(&touching);
            let (fresh, _) = solve(&problem, law);
            let report = solver.solve(&problem, law, &mut memory);
            assert!(report.own <= 1e-10 && !report.fallback, "{report:?}");
            warm += usize::from(report.warm);
            let difference =
                solver.velocity.iter().zip(&fresh.velocity).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            others += usize::from(difference > 1e-10 * G * H);
        }
        println!("{law:?}: {warm} of 3000 steps warm, {others} with another velocity");
        assert!(others == 0 || law == Law::Complementarity, "{law:?}: {others} of 3000 steps differ");
        assert!(warm > 2000, "{law:?}: {warm} of 3000 steps warm");
    }
}

/// Every random problem is solved, whatever its rank or scale, and energy never rises.
#[test]
fn random_problems_are_solved() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1995);
    println!("seed {seed}");
    let mut failed = 0;
    let mut random = fastrand::Rng::with_seed(seed);
    for law in PIVOTED {
        let (mut pivots, mut fallbacks, mut worst, mut gain) = (Vec::new(), [0; 2], 0.0_f64, f64::NEG_INFINITY);
        let mut unsolved = 0;
        let mut solver = Solver::default();
        for _ in 0..40_000 {
            let (problem, spread) = random_problem(&mut random, law);
            let report = solver.solve(&problem, law, &mut Memory::default());
            fallbacks[usize::from(spread > 3)] += usize::from(report.fallback);
            unsolved += usize::from(report.own.is_nan() || report.own > 1e-10);
            worst = worst.max(report.own);
            gain = gain.max(report.energy_gain / step_scale(&problem, &solver).powi(2));
            pivots.push(report.pivots);
        }
        pivots.sort_unstable();
        let at = |p: f64| pivots[(p * (pivots.len() - 1) as f64) as usize];
        println!(
            "{law:?}: residual {worst:.1e}, energy gain {gain:.1e}, fallbacks {fallbacks:?} (mass ratio to 1e3, 1e6), unsolved {unsolved}, pivots median {} p99.9 {} max {}",
            at(0.5),
            at(0.999),
            at(1.0),
        );
        assert!(gain <= 1e-12, "{law:?}: energy rose");
        failed += unsolved;
    }
    assert_eq!(failed, 0);
}
