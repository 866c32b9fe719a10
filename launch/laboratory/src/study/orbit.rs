//! Second table of `biped study attraction`: the return of the simulated robot to its orbit.
//!
//! The robot steps in place and is pushed sideways, in one run to each side. At the turning point of a step E_2 = −ω_2² x_2²/2, where x_2 is
//! the simulated distance of the centre of mass from the sole; the controller's estimates are not used. The deviation is half the difference
//! of the two runs, in which common effects cancel. By (41) it decays as e^(−k_E t).
//!
//! A deviation of one pair of runs has a scatter of a tenth, because landings differ by micrometres. So the table has the mean over 80 pushes,
//! eight sizes at ten times.

use super::pushes::{TimedPush, disturbed};
use controller::constants::Constants;
use controller::process::ProcessError;
use messages::load::load;
use messages::scene::Scene;
use rayon::prelude::*;
use shared::exit::Failure;
use shared::list::SCENES;
use std::sync::atomic::AtomicBool;

/// Gains k_E of (39) [1/s].
const GAINS: [f64; 3] = [4.0, 2.0, 0.0];
/// Impulses of the pushes [N·s].
const IMPULSES: [f64; 8] = [0.75, 0.85, 0.95, 1.05, 1.15, 1.25, 1.35, 1.5];
/// Times of the pushes, about halfway between a turning point and an exchange of support, and the end of the run [s].
const TIMES: [f64; 10] = [5.0, 5.005, 5.01, 5.015, 5.02, 5.025, 5.03, 5.035, 5.04, 5.045];
const END: f64 = 7.5;
/// Steps in the table, and the steps over which the rate is measured.
const SHOWN: usize = 6;
const MEASURED: usize = 2;

/// The rows. The first one names the columns.
///
/// # Errors
/// Ctrl-C, or a bad scene (excluded by a test).
pub fn rows(stop: &AtomicBool) -> Result<Vec<Vec<String>>, Failure> {
    let headings = (0..SHOWN).map(|step| format!("step {step}"));
    let first = ["E_2 after a push, of its first deviation".into()];
    let mut rows = vec![first.into_iter().chain(headings).chain(["rate 1/s".into()]).collect()];
    for gain in GAINS {
        let scene = load("stamp", &[format!("duration={END}"), format!("controller.energy_gain={gain}")], SCENES)?;
        let step = 0.5 * scene.controller.as_ref().map_or(f64::NAN, |controller| controller.period);
        let deviations = deviations(&scene, stop)?;
        let shares: Vec<f64> = deviations.iter().map(|deviation| deviation / deviations[0]).collect();
        let rate = -shares[MEASURED].ln() / (MEASURED as f64 * step);
        let theory: Vec<f64> = (0..SHOWN).map(|k| (-gain * k as f64 * step).exp()).collect();
        for (who, shares, rate) in [("the robot", shares, rate), ("by (41)", theory, gain)] {
            let cells = shares.iter().map(|share| format!("{share:.2}"));
            rows.push(
                [format!("k_E = {gain}, {who}")].into_iter().chain(cells).chain([format!("{rate:.2}")]).collect(),
            );
        }
    }
    Ok(rows)
}

/// Mean deviations of E_2 at the turning points from the step of the push on [m²/s²].
fn deviations(scene: &Scene, stop: &AtomicBool) -> Result<Vec<f64>, Failure> {
    let omega = Constants::of(scene).map_err(ProcessError::from)?.omega[1];
    let energies = |time: f64, impulse: f64| -> Result<Vec<f64>, Failure> {
        let recorder = disturbed(scene, &[TimedPush { time, impulse: [0.0, impulse, 0.0] }], stop)?.recorder;
        let after = recorder.gait.complete().iter().filter(|step| step.start > time);
        Ok(after.map(|step| -0.5 * (omega * step.x2_min).powi(2)).take(SHOWN).collect())
    };
    let pushes: Vec<_> = TIMES.iter().flat_map(|&time| IMPULSES.map(|impulse| (time, impulse))).collect();
    let deviation = |&(time, impulse): &(f64, f64)| -> Result<Vec<f64>, Failure> {
        let [left, right] = [energies(time, impulse)?, energies(time, -impulse)?];
        Ok(left.iter().zip(&right).map(|(left, right)| 0.5 * (left - right)).collect())
    };
    let all = pushes.par_iter().map(deviation).collect::<Result<Vec<_>, _>>()?;
    let mean = |step: usize| all.iter().filter_map(|own| own.get(step)).sum::<f64>() / all.len() as f64;
    Ok((0..SHOWN).map(mean).collect())
}
