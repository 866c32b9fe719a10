//! A controller of your own as a process: a spring and a damper at each joint hold the robot upright.
//!
//!     cargo build --release --example own_process
//!     biped run stand --controller target/release/examples/own_process     # started by biped
//!     biped plant stand --session lab &                                    # or attached to a session by its name
//!     cargo run --release --example own_process -- --session lab
//!
//! BIPED_SESSION=lab in the environment means the same as `--session lab`.

use messages::controller_session::{ControllerSession, ControllerSessionError};
use messages::scene::Scene;
use messages::wire::{Encoders, Telemetry, Torques};
use std::f64::consts::TAU;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

const STIFFNESS: f64 = 1000.0; // [N·m/rad]
const DAMPING: f64 = 40.0; // [N·m·s/rad]
const CUT_OFF: f64 = 150.0; // of the low-pass filter of the rates [Hz]
static STOP: AtomicBool = AtomicBool::new(false); // set by TERM and by Ctrl-C

/// Ends with the exit code of docs/WIRE.md.
pub fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let session = match &arguments[..] {
        [] => None,
        [option, name] if option == "--session" => Some(name.as_str()),
        _ => {
            return failure(2, format!("only --session NAME is understood, not {}", arguments.join(" ")));
        }
    };
    if let Err(error) = ctrlc::set_handler(|| STOP.store(true, Relaxed)) {
        return failure(4, format!("signals: {error}"));
    }
    match control(session) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure(error.exit_code(), error.to_string()),
    }
}

fn failure(code: u8, sentence: String) -> ExitCode {
    messages::log(format!("error: {sentence}"));
    ExitCode::from(code)
}

/// Answers every reading of the encoders until the plant's goodbye.
pub fn control(session: Option<&str>) -> Result<(), ControllerSessionError> {
    let (mut session, scene) = ControllerSession::join(session, &STOP)?;
    let mut stand = Stand::new(&scene);
    while let Some(reading) = session.wait(&STOP)? {
        if reading.begins {
            stand = Stand::new(&scene);
        }
        session.answer(stand.tick(&reading.encoders), Telemetry::default())?;
    }
    Ok(())
}

/// A spring and a damper at each joint.
struct Stand {
    /// Angles to hold [rad].
    target: [f64; 8],
    /// Angle of one encoder count [rad].
    count: f64,
    /// Control rate [Hz].
    rate: f64,
    /// Torque limit of the drives [N·m].
    limit: f64,
    /// Angles of the last period; none before the first one [rad].
    angle: Option<[f64; 8]>,
    /// Filtered joint rates [rad/s].
    speed: [f64; 8],
}

impl Stand {
    fn new(scene: &Scene) -> Stand {
        let mut target = [0.0; 8];
        target.iter_mut().zip(&scene.initial.joints).for_each(|(target, &angle)| *target = angle);
        let count = TAU / 2f64.powi(scene.plant.encoder_bits as i32);
        Stand { target, count, rate: scene.rate, limit: scene.plant.torque_limit, angle: None, speed: [0.0; 8] }
    }

    /// The torques of one control period.
    fn tick(&mut self, encoders: &Encoders) -> Torques {
        let angle = encoders.counts.map(|counts| self.count * counts as f64);
        let before = self.angle.replace(angle).unwrap_or(angle);
        let share = 1.0 - (-TAU * CUT_OFF / self.rate).exp();
        let torque = |joint: usize| {
            self.speed[joint] += share * ((angle[joint] - before[joint]) * self.rate - self.speed[joint]);
            let torque = STIFFNESS * (self.target[joint] - angle[joint]) - DAMPING * self.speed[joint];
            torque.clamp(-self.limit, self.limit)
        };
        Torques { torque: std::array::from_fn(torque) }
    }
}
