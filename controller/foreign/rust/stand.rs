//! A controller of your own as a process: a spring and a damper at each joint hold the robot upright.
//!
//!     cargo build --release --example own_process
//!     biped run stand --controller target/release/examples/own_process     # started by biped
//!     biped plant stand --session lab &                                    # or attached to a session by its name
//!     cargo run --release --example own_process -- --session lab
//!
//! BIPED_SESSION=lab in the environment means the same as `--session lab`.

use messages::controller_program::{Answer, Outcome, ProgramController, run};
use messages::scene::Scene;
use messages::wire::{Encoders, Torques};
use std::process::ExitCode;

const STIFFNESS: f64 = 1000.0; // [N·m/rad]
const DAMPING: f64 = 20.0; // [N·m·s/rad]

/// A spring and a damper at each joint.
pub struct Stand {
    scene: Scene,
    wanted: [f64; 8],         // [rad]
    before: Option<[f64; 8]>, // angles of the last period; none before the first one [rad]
}

impl ProgramController for Stand {
    fn new(scene: &Scene) -> Outcome<Stand> {
        let wanted = scene.initial.joints.as_slice().try_into().map_err(|_| "this robot does not have eight joints")?;
        Ok(Stand { scene: scene.clone(), wanted, before: None })
    }

    fn tick(&mut self, encoders: &Encoders) -> Outcome<Answer> {
        let (rate, limit) = (self.scene.rate, self.scene.plant.torque_limit); // [Hz], [N·m]
        let count = std::f64::consts::TAU / 2f64.powi(self.scene.plant.encoder_bits as i32); // [rad]
        let angle = encoders.counts.map(|counts| count * counts as f64);
        let before = self.before.replace(angle).unwrap_or(angle);
        let torque = |k: usize| STIFFNESS * (self.wanted[k] - angle[k]) - DAMPING * (angle[k] - before[k]) * rate;
        let torque = std::array::from_fn(|k| torque(k).clamp(-limit, limit));
        Ok(Answer { torques: Torques { torque }, ..Answer::default() })
    }
}

fn main() -> ExitCode {
    run::<Stand>()
}
