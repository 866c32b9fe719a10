//! Claims about the contact laws: against each other, against exact solutions, and about known defects.

mod known_defects;
#[path = "../common/mechanism.rs"]
mod mechanism;
mod random;
mod support;

use biped_plant::contact::{Memory, Problem, Solver, tangents};
use mechanism::{CORNERS, INVERSE, stirring_foot};
use messages::scene::{Iteration, Law, PlantScene};
use support::*;

/// Coulomb's law with a round cone, or with facets.
const COULOMB: [Law; 6] = [
    Law::Facets(4),
    Law::Facets(8),
    Law::Facets(16),
    Law::Cone,
    Law::FixedPoint(Iteration::Tresca),
    Law::FixedPoint(Iteration::Aclm),
];

/// Scene 1: a slider along x stays down and slows by μ g h.
#[test]
fn a_slider_stays_down_and_slows_by_coulombs_law() {
    let (mu, speed, mass) = (0.5, 1.0, 3.0);
    for law in COULOMB {
        let (solver, report) = solve(&point_mass(mass, [speed, 0.0, -G * H], mu), law);
        assert!(report.own <= 1e-10 && !report.fallback, "{law} {report:?}");
        assert_near("v_N", solver.velocity[0], 0.0, 1e-10);
        assert_near("v_F", solver.velocity[1], speed - mu * G * H, 1e-10);
        assert_near("f_N", solver.impulse[0], mass * G * H, 1e-10);
    }
}

/// A round cone slows a slider equally in every direction. d facets brake too little between their vertices, by at most 1 - cos(pi/d).
#[test]
fn a_round_cone_is_isotropic() {
    let (mu, speed) = (0.5, 1.0);
    for degrees in 0..90 {
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        let slip = |law| {
            let (solver, _) = solve(&point_mass(2.0, [speed * cos, speed * sin, -G * H], mu), law);
            [solver.velocity[1] * cos + solver.velocity[2] * sin, solver.velocity[2] * cos - solver.velocity[1] * sin]
        };
        let [along, across] = slip(Law::Cone);
        assert_near("along", along, speed - mu * G * H, 1e-13);
        assert_near("across", across, 0.0, 1e-13);
        for d in [4, 8, 16] {
            let least = (std::f64::consts::PI / f64::from(d)).cos();
            let braked = (speed - slip(Law::Facets(d))[0]) / (mu * G * H);
            assert!((least - 1e-9..=1.0 + 1e-9).contains(&braked), "{d} facets at {degrees} deg: {braked}");
        }
    }
}

/// Slip speeds lie between those for the polygons inside and outside the disc.
#[test]
fn the_cone_lies_between_the_bounds_of_its_polygons() {
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..2000 {
        let mu = 1.5 * random.f64();
        let velocity = [random.f64() - 0.5, random.f64() - 0.5, -0.3 * random.f64()];
        let slip = |law, mu| {
            let (solver, _) = solve(&point_mass(1.0, velocity, mu), law);
            solver.velocity[1].hypot(solver.velocity[2])
        };
        for d in [4, 8, 16] {
            let outside = mu / (std::f64::consts::PI / f64::from(d)).cos();
            let (most, least) = (slip(Law::Facets(d), mu), slip(Law::Facets(d), outside));
            let round = slip(Law::Cone, mu);
            assert!(least - 1e-10 <= round && round <= most + 1e-10, "{d} facets: {least} <= {round} <= {most}");
        }
    }
}

/// Landing: laws that may close the gap land exactly on the ground.
#[test]
fn a_falling_point_lands_exactly_on_the_ground() {
    let gap = 2e-4;
    for law in [&COULOMB[..], &[Law::Lagged, Law::ConeQp, Law::EnergyQpGap, Law::Sweep(50)]].concat() {
        let mut problem = point_mass(1.0, [0.0, 0.0, -0.3], 0.5);
        problem.approach[0] = gap / H;
        let (solver, report) = solve(&problem, law);
        assert_near("v_N", solver.velocity[0], -gap / H, 1e-10);
        assert!(report.energy_gain < 0.0);
    }
}

/// Scene 15: the ground carries a light mass that carries a heavy one, under every law whose conditions hold at the end.
#[test]
fn a_heavy_mass_on_a_light_one_is_held_at_every_ratio() {
    for ratio in [1.0, 1e2, 1e4, 1e6] {
        for law in [&COULOMB[..], &[Law::Lagged, Law::ConeQp]].concat() {
            let (solver, report) = solve(&heavy_on_light(ratio), law);
            assert!(report.own <= 1e-10, "{law} at {ratio}: {report:?}");
            // A residual of 1e-10 in v is one of 1e-10 ratio in f. A solution exact to rounding has eps ratio.
            let known = if law == Law::ConeQp { 1e-9 + 1e-13 * ratio } else { 1e-9 + 4.0 * f64::EPSILON * ratio };
            assert_near("f on the ground", solver.impulse[0], (1.0 + ratio) * G * H, known);
            assert_near("f between", solver.impulse[3], ratio * G * H, known);
        }
    }
}

/// The same with two cubes and eight contacts, under the default law: one of 1 kg carries one of 1e9 kg. The error is the remaining
/// compliance of the light one relative to the heavy one, eps times their ratio.
#[test]
fn a_cube_carries_one_a_billion_times_as_heavy() {
    let ratio = 1e9;
    let corners = [[0.05, 0.05], [0.05, -0.05], [-0.05, 0.05], [-0.05, -0.05]];
    let ground = corners.map(|[x, y]| on_body([x, y, -0.05]).map(|row| [row, vec![0.0; 6]].concat()));
    let between = corners.map(|[x, y]| {
        let [below, above] = [on_body([x, y, 0.05]), on_body([x, y, -0.05])];
        [0, 1, 2].map(|k| below[k].iter().map(|part| -part).chain(above[k].iter().copied()).collect())
    });
    let inverse = [1.0, 1.0, 1.0, 600.0, 600.0, 600.0];
    let inverse = [inverse, inverse.map(|part| part / ratio)].concat();
    let fall = [0.0, 0.0, -G * H, 0.0, 0.0, 0.0];
    let problem = assemble(2, &[ground, between].concat(), &inverse, &[fall, fall].concat(), 0.5);
    let (solver, report) = solve(&problem, PlantScene::default().law);
    let normal = |contacts: std::ops::Range<usize>| contacts.map(|i| solver.impulse[3 * i]).sum::<f64>();
    let creep = solver.velocity.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    println!("{:e} and {:e} N·s, creep {creep:.1e} m/s: {report:?}", normal(0..4), normal(4..8));
    assert!(report.own <= 1e-10 && !report.fallback, "{report:?}");
    let known = 1e-9 + 4.0 * f64::EPSILON * ratio;
    assert_near("on the ground", normal(0..4), (1.0 + ratio) * G * H, known);
    assert_near("between", normal(4..8), ratio * G * H, known);
    assert!(creep < 1e-8, "{creep}");
}

/// The paper's program needs a few more minima to give Coulomb's law: fewer if all contacts stick, more if one slides.
#[test]
fn fixed_points_reach_coulombs_law_in_few_energy_minima() {
    let corners: Vec<ContactRows> = CORNERS.map(on_body).into();
    for iteration in [Iteration::Tresca, Iteration::Aclm] {
        let law = Law::FixedPoint(iteration);
        for (name, push, range) in [("sticks", 1e-3, 1..=4), ("slides", 0.1, 2..=40)] {
            let problem = assemble(2, &corners, &INVERSE, &[push, 0.5 * push, -G * H, 0.0, 0.0, 3.0 * push], 0.5);
            let (solver, report) = solve(&problem, law);
            let (exact, _) = solve(&problem, Law::Cone);
            println!("{law}, a foot that {name}: {} minima", report.pivots);
            assert!(range.contains(&report.pivots) && !report.fallback, "{law}, {name}: {report:?}");
            for (v, exact) in solver.velocity.iter().zip(&exact.velocity) {
                assert_near("v", *v, *exact, 1e-9 * push);
            }
        }
    }
}

/// Where A has a unique solution, a remembered impulse does not change the velocity, while contacts open and close.
#[test]
fn a_warm_start_with_an_impulse_gives_the_velocity_of_a_cold_start() {
    for law in [&COULOMB[..], &[Law::ConeQp]].concat() {
        let (mut memory, mut solver, mut steps) = (Memory::default(), Solver::default(), [0, 0]);
        for (step, (touching, xdot)) in stirring_foot(1000).enumerate() {
            let contacts: Vec<ContactRows> = touching.iter().map(|&c| on_body(CORNERS[c])).collect();
            let mut problem = assemble(2, &contacts, &INVERSE, &xdot, 0.7);
            problem.id.clone_from(&touching);
            let (fresh, cold) = solve(&problem, law);
            let report = solver.solve(&problem, law, &mut memory);
            steps = [steps[0] + cold.pivots, steps[1] + report.pivots];
            assert!(report.own <= 1e-10 && !report.fallback, "{law}: {report:?}");
            for (v, fresh) in solver.velocity.iter().zip(&fresh.velocity) {
                assert!((v - fresh).abs() <= 1e-7 * G * H, "{law} at {step}: {v}, not {fresh}");
            }
        }
        println!("{law}: {} steps cold, {} warm, of 1000 problems", steps[0], steps[1]);
    }
}

/// The energy minima by pivoting and by interior points agree with one tangent.
///
/// Minima with residual e have (f - f')·A (f - f') <= e, so velocities differ by at most √e: 1e-5.
#[test]
fn the_energy_minimum_is_the_same_by_pivoting_and_by_interior_points() {
    for seed in 0..2000 {
        let problem = Draw { seed, tangents: 1, spread: (seed % 3) as f64, mu: 0.5 }.problem();
        let (pivoted, report) = solve(&problem, Law::EnergyQpGap);
        let (interior, other) = solve(&problem, Law::ConeQp);
        assert!(report.own <= 1e-10 && other.own <= 1e-10, "seed {seed}: {report:?} {other:?}");
        let m = problem.rows();
        let scale = step_scale(&problem, &pivoted);
        for k in 0..m {
            let root = problem.delassus[k * m + k].sqrt();
            let difference = (pivoted.velocity[k] - interior.velocity[k]) / root;
            assert!(difference.abs() <= 1e-5 * scale, "seed {seed}: v differs by {difference:e} of {scale:e}");
        }
    }
}

#[test]
fn no_contact_and_no_motion_need_no_impulse() {
    for law in Law::ALL {
        let mut problem = Problem::default();
        problem.reset(0, tangents(law));
        assert!(solve(&problem, law).0.impulse.is_empty());
        let mut problem = point_mass(1.0, [0.0; 3], 0.5);
        problem.drift.fill(0.0);
        assert_eq!(solve(&problem, law).0.impulse.iter().sum::<f64>(), 0.0);
    }
}

#[test]
fn nan_is_reported_and_ends_the_solver() {
    for law in Law::ALL {
        for spoil in [true, false] {
            let mut problem = point_mass(1.0, [1.0, 0.0, -G * H], 0.5);
            if spoil {
                problem.drift[0] = f64::NAN;
            } else {
                problem.delassus.fill(f64::NAN);
            }
            let report = Solver::default().solve(&problem, law, &mut Memory::default());
            assert!(report.natural_map.is_nan(), "{law} {report:?}");
        }
    }
}
