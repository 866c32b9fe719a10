//! Problems with exact solutions.

use super::{ContactRows, G, H, PIVOTED, assemble, assert_near, on_body, point_mass, solve};
use biped_plant::contact::tangents;
use messages::scene::Law;

/// Scene 1. The printed program lifts a sliding block; Coulomb's law does not.
#[test]
fn a_slider_hops_under_the_printed_program_and_stays_down_under_coulombs_law() {
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

/// Scene 13 as one step: two feet of one body, eight contacts, rank six.
#[test]
fn eight_contacts_carry_the_weight_at_rest_in_any_order() {
    let (mass, weight) = (14.0, 14.0 * G * H);
    let inverse = [1. / mass, 1. / mass, 1. / mass, 1. / 0.8, 1. / 0.7, 1. / 0.2];
    let mut corners = Vec::new();
    for y in [-0.12, -0.04, 0.04, 0.12] {
        corners.extend([[0.1, y, -0.3], [-0.06, y, -0.3]]);
    }
    let mut random = fastrand::Rng::with_seed(2);
    for law in PIVOTED {
        // One step of free fall from rest, with a small sideways push and rotation.
        let xdot = [2e-3, 1e-3, -G * H, 1e-4, -2e-4, 3e-4];
        for _ in 0..50 {
            random.shuffle(&mut corners);
            let contacts: Vec<ContactRows> = corners.iter().map(|&c| on_body(c)).collect();
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

/// Scene 15: the ground carries a light mass that carries a heavy one.
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
            // A contains 1/heavy beside 1/light, so f is known to eps·ratio.
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

/// Friction along the second tangent: a block driven along the first tangent starts to slip along the second, and stops along both.
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

/// Scenes 5 and 6: a slender rocking block lands on one edge, a squat one on both.
#[test]
fn a_rocking_block_loses_energy_as_housner_predicts() {
    for law in [Law::Complementarity, Law::Aligned] {
        for (b, h, mu, exact) in [(0.1, 0.4, 0.2, 0.911764705882), (0.5, 0.3, 5.0, 0.0)] {
            // Half-width b, half-height h. Before the impact it turns about the right edge at ω. Then the left edge lands.
            let (mass, omega) = (1.0_f64, 1.0);
            let inertia = mass * (b * b + h * h) / 3.0;
            let point = |x: f64| [vec![0., 1., -x], vec![1., 0., -h], vec![0.; 3]];
            // (x, z, pitch), v = v_c + ω (z, -x); the point (b, -h) rests.
            let xdot = [omega * h, omega * b, omega];
            let problem = assemble(law, &[point(b), point(-b)], &[1. / mass, 1. / mass, 1. / inertia], &xdot, mu);
            assert!(problem.drift[0].abs() < 1e-15 && problem.drift[problem.tangents + 1] > 0.0);
            let mirrored: Vec<f64> = xdot.iter().zip([1., -1., 1.]).map(|(x, s)| x * s).collect();
            let problem = assemble(law, &[point(b), point(-b)], &[1. / mass, 1. / mass, 1. / inertia], &mirrored, mu);
            let (solver, _) = solve(&problem, law);
            let stride = 1 + problem.tangents;
            // Rotation rate from the normal velocities of both points.
            let after = (solver.velocity[stride] - solver.velocity[0]) / (2.0 * b);
            assert_near("omega+/omega-", after, exact, 1e-11);
        }
    }
}

/// Landing: the printed laws stop at once, the others may close the gap.
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
    wrong.drift[0] *= 1.001; // the solution of a slightly different problem
    let (mut solver, _) = solve(&wrong, Law::Aligned);
    let report = solver.measure_impulse(&problem, Law::Aligned, &solver.impulse.clone());
    assert!(report.natural_map > 1e-6, "{report:?}");
    let report = solver.measure_impulse(&problem, Law::Aligned, &[0.0; 3]);
    assert!(report.natural_map > 1e-3, "{report:?}");
}
