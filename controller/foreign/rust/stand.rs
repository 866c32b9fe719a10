//! A controller of your own as a process: a spring and a damper at each joint hold the robot upright.
//!
//!     cargo build --release --example own_process
//!     biped run stand --controller target/release/examples/own_process     # started by biped
//!     biped plant stand --session lab &                                    # or attached to a session by its name
//!     cargo run --release --example own_process -- --session lab
//!
//! BIPED_SESSION=lab in the environment means the same as `--session lab`.

use messages::controller_session::{ControllerSession, ControllerSessionError};
use messages::wire::{Telemetry, Torques};
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
            eprintln!("error: only --session NAME is understood, not {}", arguments.join(" "));
            return ExitCode::from(2);
        }
    };
    if let Err(error) = ctrlc::set_handler(|| STOP.store(true, Relaxed)) {
        eprintln!("error: signals: {error}");
        return ExitCode::from(4);
    }
    match control(session) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

/// Answers every reading of the encoders until the plant's goodbye.
pub fn control(session: Option<&str>) -> Result<(), ControllerSessionError> {
    let (mut session, scene) = ControllerSession::join(session, &STOP)?;
    let count = TAU / 2f64.powi(scene.plant.encoder_bits as i32); // [rad]
    let share = 1.0 - (-TAU * CUT_OFF / scene.rate).exp(); // of the newest rate in the filtered one
    let (mut angle, mut rate) = ([0.0; 8], [0.0; 8]);
    while let Some(reading) = session.wait(&STOP)? {
        let now = reading.encoders.counts.map(|counts| count * counts as f64);
        if reading.begins {
            (angle, rate) = (now, [0.0; 8]);
        }
        for joint in 0..8 {
            rate[joint] += share * ((now[joint] - angle[joint]) * scene.rate - rate[joint]);
        }
        angle = now;
        let torque = |joint: usize| STIFFNESS * (scene.initial.joints[joint] - angle[joint]) - DAMPING * rate[joint];
        let limit = scene.plant.torque_limit;
        let torques = Torques { torque: std::array::from_fn(|joint| torque(joint).clamp(-limit, limit)) };
        session.answer(torques, Telemetry::default())?;
    }
    Ok(())
}
