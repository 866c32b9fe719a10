//! A controller of your own as a process: a spring and a damper at each joint hold the robot upright.
//!
//!     cargo build --release --example own_process
//!     biped run stand --controller target/release/examples/own_process     # started by biped
//!     biped plant stand --session lab &                                    # or attached to a session by its name
//!     target/release/examples/own_process --session lab

use messages::controller_program::{Answer, Outcome, ProgramController, run};
use messages::scene::Scene;
use messages::wire::{Encoders, Torques};
use std::process::ExitCode;

const STIFFNESS: f64 = 1000.0; // [N·m/rad]
const DAMPING: f64 = 20.0; // [N·m·s/rad]

/// A spring and a damper at each joint.
pub struct Stand {
    scene: Scene,
    before: Option<[f64; 8]>, // angles of the last period; none before the first one [rad]
}

impl ProgramController for Stand {
    fn new(scene: &Scene) -> Outcome<Stand> {
        Ok(Stand { scene: scene.clone(), before: None })
    }

    fn tick(&mut self, encoders: &Encoders) -> Outcome<Answer> {
        let (wanted, limit) = (self.scene.initial.angles(), self.scene.plant.torque_limit); // [rad], [N·m]
        let angle = encoders.angles(self.scene.plant.radians_per_count());
        let before = self.before.replace(angle).unwrap_or(angle);
        let rate = |k: usize| (angle[k] - before[k]) * self.scene.rate; // [rad/s]
        let torque = |k| (STIFFNESS * (wanted[k] - angle[k]) - DAMPING * rate(k)).clamp(-limit, limit);
        Ok(Answer::from(Torques { torque: std::array::from_fn(torque) }))
    }
}

fn main() -> ExitCode {
    run::<Stand>()
}
