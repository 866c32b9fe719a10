//! The limit of the pendulum (31), (32) on finite feet, with steps at the times of the undisturbed gait.
//!
//! ```text
//!   ξ = x + v/ω,   dξ/dt = ω (ξ − p) + F g_e/(M ω)     |p| ≤ edge of the sole
//! ```
//! A push F at the height z acts on the pendulum as M g_e F with g_e = z ω²/g, because its moment about the foot counts. During the push and
//! after it, the zero-moment point p is at the edge of the sole that opposes the push.
//!
//! *Sagittal*: the next touchdown occurs at the time given by the lateral plane. The acceleration of the foot and the reach of the legs limit
//! the step. Then ξ, measured from the new foot, must lie in the set from which steps of full length, one each half period, can still
//! capture it: |ξ| ≤ p + r/(e^(ωT/2) − 1).
//!
//! *Lateral*: the feet are W_2 apart and there is no hip roll, so ξ must stay between the outer edges of the two soles. The zero-moment point
//! moves to the other foot when the centre of gravity is nearer to it.
//!
//! The diagonal directions have no bound.

use super::trial::{BEGIN, DURATION};
use crate::study::args::Direction;
use controller::constants::Constants;
use controller::error::ControllerError;
use controller::pendulum::{PendulumState, Propagator};
use controller::process::ProcessError;
use controller::support::Chain;
use controller::swing::MINIMUM_JERK_PEAK;
use messages::scene::Scene;
use messages::wire::Telemetry;
use records::analysis::RunAnalysis;
use sessions::run::in_process;
use shared::exit::{Failure, check_interrupt};
use std::sync::atomic::AtomicBool;

/// Reach of a leg, as a multiple of the height of the centre of gravity [-], and greatest acceleration of a foot [m/s²].
const REACH: f64 = 0.93;
const SWING: f64 = 25.0;
/// Impulse from the side that exceeds the limit in every phase [N·s], and number of bisections below it.
const LATERAL_MOST: f64 = 50.0;
const HALVINGS: usize = 30;

/// The undisturbed gait over one period, and the robot.
pub struct Pendulum {
    /// Telemetry of each control period of the gait.
    states: Vec<Telemetry>,
    omega: [f64; 2],
    /// Half-depth and half-width of a sole, distance of the soles, longest landing [m].
    edge: [f64; 2],
    width: f64,
    reach: f64,
    /// Impulse per shift of ξ that a sudden push makes [N·s/m].
    per_shift: [f64; 2],
    /// Half a period [s].
    step: f64,
    /// Control period [s].
    h: f64,
}

impl Pendulum {
    /// The limits of a scene's robot and gait.
    ///
    /// # Errors
    /// A bad scene, or Ctrl-C.
    pub fn of(scene: &Scene, stop: &AtomicBool) -> Result<Pendulum, Failure> {
        let settings = scene.controller.clone().ok_or(ControllerError::NoController).map_err(ProcessError::from)?;
        let chain = Chain::new(&scene.bodies).map_err(ProcessError::from)?;
        let omega = Constants::new(&chain, &settings, &scene.plant).map_err(ProcessError::from)?.omega;
        let scene = Scene { duration: BEGIN + settings.period, ..scene.clone() };
        let mut recorder = RunAnalysis::without_rows(&scene);
        let mut states = Vec::new();
        in_process(&scene, |truth| {
            check_interrupt(stop)?;
            recorder.push(truth);
            if truth.stamp.time() >= BEGIN {
                states.push(truth.telemetry);
            }
            Ok(())
        })?;
        let height = recorder.last.as_ref().map_or(f64::NAN, |row| row.derived.trunk_height);
        Ok(Pendulum {
            states,
            omega,
            edge: chain.sole_half,
            width: chain.leg_width(),
            reach: REACH * settings.com_height,
            per_shift: omega.map(|omega| chain.total_mass * scene.plant.gravity / (height * omega)),
            step: 0.5 * settings.period,
            h: 1.0 / scene.rate,
        })
    }

    /// Greatest impulse [N·s] at `share` of a period after [`BEGIN`]; infinite where there is no bound.
    pub fn limit(&self, direction: Direction, share: f64) -> f64 {
        let at = ((share * 2.0 * self.step / self.h) as usize).min(self.states.len().saturating_sub(1));
        let Some(state) = self.states.get(at) else { return f64::NAN };
        let left_stands = state.support == 0;
        match direction {
            Direction::Forward => self.sagittal(at, state, 1.0),
            Direction::Backward => self.sagittal(at, state, -1.0),
            Direction::Left => self.lateral(state, !left_stands),
            Direction::Right => self.lateral(state, left_stands),
            Direction::Front | Direction::Rear => f64::INFINITY,
        }
    }

    /// Shift of ξ that a push must cause so that ξ moves from `from` to `to` by the end of the push, with the zero-moment point at `p` [m].
    fn shift(omega: f64, p: f64, from: f64, to: f64) -> f64 {
        let growth = (omega * DURATION).exp();
        (to - p - (from - p) * growth) * omega * DURATION / (growth - 1.0)
    }

    fn sagittal(&self, at: usize, state: &Telemetry, sign: f64) -> f64 {
        let (omega, p) = (self.omega[0], self.edge[0]);
        let steps = |telemetry: &&Telemetry| telemetry.steps > state.steps;
        let until = self.states[at..].iter().position(|later| steps(&later)).unwrap_or_else(|| self.states.len() - at);
        let left = (until as f64 * self.h).max(DURATION);
        let foot = sign * state.swing[0];
        let before = self.states[at.saturating_sub(1)].swing[0];
        let speed = if at > 0 && self.states[at - 1].steps == state.steps {
            sign * (state.swing[0] - before) / self.h
        } else {
            0.0
        };
        let within = |time: f64| SWING / MINIMUM_JERK_PEAK * time * time;
        let landing = (foot + 0.5 * speed * left + within(left)).min(self.reach);
        let stride = self.reach.min(0.5 * within(self.step));
        let caught = p + stride / ((omega * self.step).exp() - 1.0);
        let at_end = (caught + landing - p) / (omega * (left - DURATION)).exp() + p;
        let now = sign * (state.pendulum[0] + state.pendulum[1] / omega);
        Self::shift(omega, p, now, at_end) * self.per_shift[0]
    }

    fn lateral(&self, state: &Telemetry, outward: bool) -> f64 {
        let (omega, edge) = (self.omega[1], self.edge[1]);
        let period = Propagator::new(omega, self.h);
        let bears = |impulse: f64| {
            let mut at = PendulumState { x: state.pendulum[2], v: state.pendulum[3] };
            let push = if outward { -impulse } else { impulse } * omega / (self.per_shift[1] * DURATION);
            for _ in 0..(DURATION / self.h) as usize {
                let over = at.x >= 0.5 * self.width; // the other foot carries the weight
                let p = if outward { -edge } else { edge + if over { self.width } else { 0.0 } };
                at = at.propagated(&period, push - omega * omega * p);
            }
            (-edge..=self.width + edge).contains(&(at.x + at.v / omega))
        };
        let (mut least, mut most) = (0.0, LATERAL_MOST);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (least + most);
            *if bears(middle) { &mut least } else { &mut most } = middle;
        }
        least
    }
}
