//! Claims about the certificate: residuals of one contact, computed by hand.

use super::mechanism::of_rows;
use super::{assert_near, point_mass};
use biped_plant::contact::{Memory, Problem, Report, Solver};
use messages::scene::Law;

/// Inverse mass of the point [1/kg].
const A: f64 = 2.0;
const MU: f64 = 0.5;
const ROUNDING: f64 = 1e-14;

/// The residuals of an impulse f that leaves a point mass with velocity v, each (normal, x, y).
fn of(f: [f64; 3], v: [f64; 3]) -> Report {
    let free = [0, 1, 2].map(|k| v[k] - A * f[k]);
    let rows = [vec![0., 0., 1.], vec![1., 0., 0.], vec![0., 1., 0.]];
    let problem = of_rows(2, &rows, &[A; 3], &[free[1], free[2], free[0]], MU);
    Solver::default().measure_impulse(&problem, Law::Cone, &f)
}

/// f_N v_N counts with either sign: penetration is as wrong as pulling.
#[test]
fn an_impulse_with_normal_velocity_of_either_sign_violates_signorini() {
    // Stopped from 6.5 m/s except .5 m/s: V = 6.5 and F = V/A = 3.25, of which f lacks .25.
    let sinks = of([3.0, 0.0, 0.0], [-0.5, 0.0, 0.0]);
    assert_near("f_N v_N", sinks.signorini, 1.5 / (3.25 * 6.5), ROUNDING);
    assert_near("natural map", sinks.natural_map, 1.0 / 13.0, ROUNDING);
    // Thrown back at .5 m/s from 5.5 m/s: F = |f| = 3, and f exceeds by .5 F/V.
    let rises = of([3.0, 0.0, 0.0], [0.5, 0.0, 0.0]);
    assert_near("f_N v_N", rises.signorini, 1.5 / (3.0 * 5.5), ROUNDING);
    assert_near("natural map", rises.natural_map, 1.0 / 11.0, ROUNDING);
}

#[test]
fn the_natural_map_of_one_contact_equals_values_computed_by_hand() {
    let edge = MU.hypot(1.0);
    let friction = |f: f64| [4.0, f, 0.0];
    for (what, f, v, exact) in [
        ("it falls freely", [0.0; 3], [-1.0, 0.0, 0.0], 1.0),
        ("it rises freely", [0.0; 3], [1.0, 0.3, 0.0], 0.0),
        ("it stands", friction(-1.0), [0.0; 3], 0.0),
        // full friction against the slip
        ("it slides", friction(-2.0), [0.0, 0.7, 0.0], 0.0),
        // no friction: without impulse it fell at 8 m/s and slid
        ("it slides without friction", friction(0.0), [0.0, 0.6, 0.0], edge * 0.6 / 8f64.hypot(0.6)),
        // friction of 3 where 2 is allowed: V = √(8² + 6²) = 10, F = 5; the nearest point is 1/edge away
        ("it sticks beyond the cone", friction(-3.0), [0.0; 3], 1.0 / edge / 5.0),
    ] {
        let report = of(f, v);
        assert_near(what, report.natural_map, exact, ROUNDING);
        let enters = if v[0] < 0.0 { 1.0 } else { 0.0 }; // with all of V
        assert_eq!(report.signorini, enters, "{what}: {report:?}");
    }
}

/// A slip of a millionth of that without impulse still has a direction, which friction must oppose.
#[test]
fn friction_that_does_not_oppose_even_a_slow_slip_is_detected() {
    for degrees in [0.0, 10.0, 90.0, 180.0] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let f = [4.0, -2.0 * cos, 2.0 * sin];
        for part in [1e-1, 1e-3, 1e-5, 1e-7] {
            let free = A * f.iter().map(|f| f * f).sum::<f64>().sqrt();
            for direction in [0.3_f64, 2.0] {
                // world and contact rotated alike
                let turned = |x: f64, y: f64| {
                    let (s, c) = direction.sin_cos();
                    [c * x - s * y, s * x + c * y]
                };
                let ([fx, fy], [vx, vy]) = (turned(f[1], f[2]), turned(part * free, 0.0));
                let report = of([f[0], fx, fy], [0.0, vx, vy]);
                let exact = if part < 1e-6 { 0.0 } else { f64::to_radians(degrees) };
                let what = format!("angle of {degrees}° at {part:e}");
                assert_near(&what, report.slip_misalignment, exact, 10.0 * f64::EPSILON / part);
            }
        }
    }
}

/// So does a friction of a millionth of the impulse: across the slip it is wrong by a right angle.
#[test]
fn even_a_small_friction_across_the_slip_is_detected() {
    for (friction, exact) in [(1e-2, 90.0), (1e-4, 90.0), (1e-5, 90.0), (1e-7, 0.0)] {
        let report = of([4.0, 0.0, 4.0 * friction], [0.0, 0.7, 0.0]);
        assert_near(
            &format!("{friction:e} of the impulse"),
            report.slip_misalignment,
            f64::to_radians(exact),
            ROUNDING,
        );
    }
}

/// At great friction the projection of (f − F/V v̂) hides a contact that enters the ground while it slips: the shift μ|v_F| is greater than
/// its approach. So the approach counts by itself.
#[test]
fn a_contact_that_slips_into_the_ground_counts_fully_at_any_friction() {
    let rows = [vec![0., 0., 1.], vec![1., 0., 0.], vec![0., 1., 0.]];
    for friction in [0.0, 0.5, 10.0, 1e3, 1e6] {
        let problem = of_rows(2, &rows, &[A; 3], &[0.8, 0.0, -0.6], friction);
        let report = Solver::default().measure_impulse(&problem, Law::Cone, &[0.0; 3]);
        assert!((0.6 - ROUNDING..=1.0).contains(&report.natural_map), "μ = {friction}: {}", report.natural_map);
    }
}

/// Residuals are relative: they do not depend on the units of mass and time.
#[test]
fn residuals_do_not_depend_on_units() {
    let wrong = |mass: f64, speed: f64| {
        let mut problem: Problem = point_mass(Law::Cone, mass, speed, MU);
        problem.drift[0] = -0.7 * speed;
        Solver::default().measure_impulse(&problem, Law::Cone, &[mass * speed, 0.1 * mass * speed, 0.0])
    };
    let one = wrong(1.0, 1.0);
    assert!(one.natural_map > 0.1 && one.signorini > 0.1 && one.slip_misalignment > 0.1, "{one:?}");
    for (mass, speed) in [(1e-6, 1.0), (1e6, 1e-5), (3.0, 1e4)] {
        let report = wrong(mass, speed);
        assert_near("natural map", report.natural_map, one.natural_map, ROUNDING);
        assert_near("f_N v_N", report.signorini, one.signorini, ROUNDING);
        assert_near("angle", report.slip_misalignment, one.slip_misalignment, ROUNDING);
    }
}

/// Newton's method evaluates a scaled problem, the certificate evaluates the problem as posed. Where bodies of 1 kg and 1e14 kg touch, the
/// two can differ by rounding: in some of these problems Newton's method meets its tolerance, but the natural map is up to 1e-3.
#[test]
fn an_impulse_that_the_certificate_refuses_is_flagged() {
    let given: Problem = serde_json::from_str(include_str!("../data/beyond_certificate.json")).expect("a problem");
    let mut random = fastrand::Rng::with_seed(1);
    let mut refused = 0;
    for _ in 0..200 {
        let mut problem = given.clone();
        problem.drift.iter_mut().for_each(|b| *b *= 1.0 + 1e-3 * (random.f64() - 0.5));
        let report = Solver::default().solve(&problem, Law::Cone, &mut Memory::default());
        refused += u32::from(report.own > 1e-4);
        assert!(report.own <= 1e-4 || report.fallback, "{report:?}");
    }
    println!("{refused} of 200 impulses are refused");
    assert!(refused > 0, "not the problem that this test needs");
}

/// The tip of a rod at 27° to the ground, which has to leave it by a nanometre in a tenth of a second. Friction of 2 jams it, so it does not move.
/// An impulse along the rod 1e9 times as great as the one that stops it seems to move it, by the rounding of A f.
#[test]
fn a_jammed_contact_is_not_certified_by_the_rounding_of_a_huge_impulse() {
    let [normal, along] = [0.45, 0.89];
    let rows = [vec![normal], vec![along], vec![0.0]];
    for speed in [1e-8, 1e-6, 1e-4] {
        let mut problem = of_rows(2, &rows, &[1.0], &[-0.01], 2.0);
        problem.approach = vec![-speed];
        let mut solver = Solver::default();
        let report = solver.solve(&problem, Law::Cone, &mut Memory::default());
        println!("{speed:e} m/s: f_N = {:.1e} N·s, {report:?}", solver.impulse[0]);
        assert!(report.fallback && report.natural_map >= 1e-6, "{speed:e} m/s: {report:?}");
    }
}
