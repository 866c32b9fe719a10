//! Known defects of the compared laws: negative controls.

use super::support::*;
use biped_plant::contact::{ContactSpring, Memory, Problem, Solver};
use messages::scene::Law;

/// A convex program lifts a sliding contact, with a gap or without, with a round or a square cone: v_N = μ |v_F|.
#[test]
fn every_energy_minimum_lifts_a_slider() {
    let (mu, speed) = (0.5, 1.0);
    for law in [Law::EnergyQpGap, Law::ConeQp] {
        let (solver, report) = solve(&point_mass(3.0, [speed, 0.0, -G * H], mu), law);
        let slip = (speed - mu * G * H) / (1.0 + mu * mu);
        assert_near("v_F", solver.velocity[1], slip, 1e-8);
        assert_near("v_N", solver.velocity[0], mu * slip, 1e-8);
        assert!(report.own <= 1e-10 && report.natural_map > 0.1 && report.signorini > 0.1, "{report:?}");
    }
}

/// Friction bounded by the impulse of the step before misses an impact: the landing slips, where Coulomb's law sticks.
#[test]
fn lagged_friction_slips_at_impact() {
    let (mu, fall, slip) = (0.7, 1.0, 0.3);
    let problem = point_mass(2.0, [slip, 0.0, -fall], mu);
    let (exact, _) = solve(&problem, Law::Cone);
    assert_near("v_F under Coulomb's law", exact.velocity[1], 0.0, 1e-12);
    let mut memory = Memory::default();
    let mut solver = Solver::default();
    let report = solver.solve(&problem, Law::Lagged, &mut memory);
    assert_near("v_F", solver.velocity[1], slip, 1e-12);
    assert!(report.own <= 1e-10 && report.natural_map > 0.01, "{report:?}");
    // One step later, the impulse of the impact is the bound.
    solver.solve(&point_mass(2.0, [slip, 0.0, -G * H], mu), Law::Lagged, &mut memory);
    assert_near("v_F a step later", solver.velocity[1], 0.0, 1e-10);
}

/// A Gauss-Seidel sweep on masses 1 : r leaves r/(1 + r) of the error, and the law stops with the rest.
#[test]
fn sweeps_converge_at_the_rate_of_the_mass_ratio() {
    for ratio in [1.0, 10.0, 100.0, 1000.0] {
        let problem = heavy_on_light(ratio);
        let missing = |count| {
            let (solver, report) = solve(&problem, Law::Sweep(count));
            (solver.impulse[3] / (ratio * G * H) - 1.0, report)
        };
        let ((before, _), (after, report)) = (missing(20), missing(21));
        println!("mass ratio {ratio}: a sweep leaves {:.6} of the error, {after:.1e} after 21", after / before);
        assert_near("contraction", after / before, ratio / (1.0 + ratio), 1e-4);
        assert!(ratio < 10.0 || report.natural_map > 1e-3, "the residual must show it: {report:?}");
    }
}

/// z'' + 2 ζ ω z' + ω² z = 0 in semi-implicit Euler steps is stable if and only if ω h < 2 (√(1 + ζ²) - ζ).
#[test]
fn a_spring_is_stable_up_to_the_theoretical_step() {
    for (zeta, exact) in [(0.0, 2.0), (0.1, 1.810), (1.0, 0.8284)] {
        let theory = 2.0 * ((1.0_f64 + zeta * zeta).sqrt() - zeta);
        assert!((theory - exact).abs() < 1e-3);
        let (mut stable, mut blown) = (0.5 * theory, 1.5 * theory);
        while blown - stable > 1e-4 {
            let middle = 0.5 * (stable + blown);
            if grows(zeta, middle) { blown = middle } else { stable = middle }
        }
        println!("zeta {zeta}: stable up to omega h = {stable:.4}, {theory:.4} by theory");
        assert!((stable / theory - 1.0).abs() < 0.01, "zeta {zeta}: {stable}, not {theory}");
    }
}

/// Whether a mass at rest on its spring, displaced by a millionth of its compression, oscillates with growing amplitude.
fn grows(zeta: f64, omega_h: f64) -> bool {
    let (mass, stiffness) = (2.0_f64, 1e5_f64);
    let h = omega_h / (stiffness / mass).sqrt();
    let rest = -mass * G / stiffness;
    let (mut gap, mut speed) = (rest * (1.0 + 1e-6), 0.0);
    let (mut solver, mut memory) = (Solver::default(), Memory::default());
    for _ in 0..5000 {
        let mut problem: Problem = point_mass(mass, [0.0, 0.0, speed - G * h], 0.5);
        problem.gap[0] = gap;
        problem.before[0] = speed;
        problem.spring = ContactSpring { stiffness, damping_ratio: zeta, h };
        solver.solve(&problem, Law::SpringDamper, &mut memory);
        speed = solver.velocity[0];
        gap += h * speed;
        if (gap / rest - 1.0).abs() > 1e-3 {
            return true;
        }
    }
    false
}

/// A friction of 1e12 hides from a law's own scale that a contact enters the ground. Some laws solve this point, and none that does not hides it.
#[test]
fn a_contact_that_enters_the_ground_is_never_certified() {
    let problem = point_mass(1.0, [0.5, 0.0, -1.0], 1e12);
    let mut entered = 0;
    for law in Law::ALL.into_iter().filter(|law| *law != Law::SpringDamper) {
        let (solver, report) = solve(&problem, law);
        println!("{law}: v_N {}, {report:?}", solver.velocity[0]);
        if solver.velocity[0] < -0.6 {
            entered += 1;
            assert!(report.fallback && report.own > 0.5 && report.signorini > 0.5, "{law}: {report:?}");
        }
    }
    assert!(entered > 2, "too few laws lose the contact to show anything");
}
