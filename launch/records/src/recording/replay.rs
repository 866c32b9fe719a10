//! `biped replay`: feeds recorded sensors to a controller, or recorded torques to a plant. The results must equal the
//! recorded ones bit for bit.

use super::reader::RecordingReader;
use clap::Args;
use controller::Controller;
use controller::process::ProcessError;
use messages::port::Action;
use messages::scene::{LinkScene, Scene};
use messages::wire::{Command, Encoders, Stamp, Stamped, Truth};
use plant::Simulation;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::interrupt::UnderWay;
use shared::output::print_text;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Number of sensor messages that are stored for late commands: four seconds at 1 kHz.
const MAX_STORED_SENSORS: usize = 4096;

/// Arguments of `biped replay`.
#[derive(Args)]
pub struct ReplayArgs {
    /// The recording
    file: PathBuf,
    /// Feed the recorded torques to a plant and compare its states, instead of feeding the sensors to a controller
    #[arg(long)]
    plant: bool,
}

/// The result of a comparison.
#[derive(Default)]
struct Comparison {
    /// Number of compared commands or states.
    count: u64,
    /// Number of those that are not equal bit for bit.
    differ: u64,
    /// Greatest difference of a component.
    greatest: f64,
    /// Time of the first difference [s].
    first: Option<f64>,
    /// Number of controllers or plants that were created.
    starts: u64,
    /// The reason why the comparison ended early.
    ended_early: Option<String>,
    /// True if the plant answered requests and the recording has no topic for them.
    has_unrecorded_requests: bool,
    /// Number of recorded requests that were repeated.
    repeated_requests: u64,
}

impl Comparison {
    /// Compares one command or state.
    fn compare(&mut self, time_ns: u64, ours: &[f64], theirs: &[f64]) {
        self.count += 1;
        if ours.iter().zip(theirs).any(|(ours, theirs)| ours.to_bits() != theirs.to_bits()) {
            self.differ += 1;
            self.first.get_or_insert(time_ns as f64 * 1e-9);
            let differences = ours.iter().zip(theirs).map(|(ours, theirs)| (ours - theirs).abs());
            self.greatest = differences.fold(self.greatest, f64::max);
        }
    }
}

/// Replays a recording.
///
/// # Errors
/// If anything differs. See also [`RecordingReader::open`].
pub fn run(args: &ReplayArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let mut reader = RecordingReader::open(&args.file)?;
    let comparison = if args.plant { plant(&mut reader, stop)? } else { controller(&mut reader, stop)? };
    let (what, unit) = if args.plant { ("states", "m, rad or their rates") } else { ("commands", "N·m") };
    let Comparison { count, differ, greatest, first, starts, ended_early, has_unrecorded_requests, repeated_requests } =
        comparison;
    print_text(format_args!("{}: {count} {what} compared, {differ} differ\n", args.file.display()));
    if starts > 1 {
        print_text(format_args!("restarted {} times, as recorded\n", starts - 1));
    }
    if repeated_requests > 0 {
        print_text(format_args!("{repeated_requests} recorded requests repeated\n"));
    }
    if let Some(ended_early) = ended_early {
        print_text(format_args!("{ended_early}\n"));
    }
    if let Some(why) = &reader.truncated_by {
        print_text(format_args!("the recording is cut short after that: {why}\n"));
    }
    let hint = if has_unrecorded_requests { "; the plant answered requests that are not recorded" } else { "" };
    match first {
        Some(first) => Err(Failure::new(
            Exit::Fault,
            format!("{differ} of {count} {what} differ, first at {first:.3} s, by up to {greatest:.3e} {unit}{hint}"),
        )),
        None if count == 0 => Err(reader.lacks(&args.file, &format!("{what} to compare"))),
        None => Ok(()),
    }
}

/// Feeds recorded sensors to a controller and compares each command with the recorded answer to the same sensors.
fn controller(reader: &mut RecordingReader, stop: &AtomicBool) -> Result<Comparison, Failure> {
    let scene = reader.scene().clone();
    let (mut comparison, mut truth) = (Comparison::default(), Truth::default());
    let (mut controller, mut last, mut sensors) =
        (None::<Controller>, Stamp::default(), VecDeque::<(Stamp, Encoders)>::new());
    let mut run = None;
    while reader.next_truth(&mut truth).is_some() {
        check_interrupt(stop)?;
        let Truth { stamp, command, asked, encoders, .. } = truth;
        if run.replace(stamp.run) != Some(stamp.run) {
            sensors.clear(); // sequence numbers restart with each run
        }
        if (command.run, command.epoch, command.seq) != (last.run, last.epoch, last.seq) && command.run == stamp.run {
            if (command.run, command.epoch) != (last.run, last.epoch) {
                let (seq, ack) = (command.seq.saturating_sub(1), command.ack.saturating_sub(1));
                (controller, last) = (None, Stamp { seq, ack, ..command });
                comparison.starts += 1;
            }
            // Sensors between the last two answered ones have no recorded answer. Either the controller did not receive
            // them, or the plant did not receive the commands.
            let between = command.ack.saturating_sub(last.ack.saturating_add(1));
            let lost = command.seq.saturating_sub(last.seq.saturating_add(1));
            let received = match lost {
                lost if lost >= between => last.ack.saturating_add(1)..=command.ack, // empty if a command is repeated
                0 => command.ack..=command.ack,
                _ => {
                    let time = stamp.time();
                    let reason = "sensors and commands were lost together, so the inputs of the controller are unknown";
                    comparison.ended_early = Some(format!("comparison ended at {time:.3} s: {reason}"));
                    return Ok(comparison);
                }
            };
            let controller = match &mut controller {
                Some(controller) => controller,
                none => {
                    let first = sensors.iter().find(|(stamp, _)| received.contains(&stamp.seq));
                    let started = none.insert(Controller::new(&scene).map_err(ProcessError::from)?);
                    started.begin_at(first.map_or(0.0, |(stamp, _)| stamp.time()));
                    started
                }
            };
            let mut torques = None;
            for &(Stamp { seq, .. }, ref encoders) in sensors.iter().filter(|(stamp, _)| received.contains(&stamp.seq))
            {
                for ask in reader.take_granted(|at, ask| ask.is_for_controller() && at.run == stamp.run && at.ack < seq)
                {
                    if let Action::Gait(request) = ask {
                        controller.carry_out(request).map_err(ProcessError::from)?;
                        comparison.repeated_requests += 1;
                    }
                }
                torques = Some(controller.tick(encoders).map_err(ProcessError::from)?.torque);
            }
            if let Some(torques) = torques {
                comparison.compare(stamp.sim_ns, &torques, &asked.torque);
            }
            last = command;
        }
        sensors.push_back((stamp, encoders));
        if sensors.len() > MAX_STORED_SENSORS {
            sensors.pop_front();
        }
    }
    Ok(comparison)
}

/// Feeds recorded torques to a plant and compares each state with the recorded one.
fn plant(reader: &mut RecordingReader, stop: &AtomicBool) -> Result<Comparison, Failure> {
    // The recorded commands already contain the effects of the link.
    let mut scene = Scene { link: LinkScene::default(), ..reader.scene().clone() };
    let (mut comparison, mut truth) = (Comparison::default(), Truth::default());
    let mut simulation = None::<Simulation>;
    let _under_way = UnderWay::begin("nothing is compared");
    while reader.next_truth(&mut truth).is_some() {
        check_interrupt(stop)?;
        let Truth { stamp, command, asked: torques, telemetry, .. } = truth;
        comparison.has_unrecorded_requests |= truth.tally.requests > 0 && !reader.has_request_topic();
        let simulation = match &mut simulation {
            Some(simulation) if simulation.sensors().stamp.run == stamp.run => {
                for ask in reader.take_granted(|at, _| at.run == stamp.run && at.seq < stamp.seq) {
                    comparison.repeated_requests += u64::from(repeat(simulation, ask));
                }
                if command.run == stamp.run {
                    simulation.receive(&Command { stamp: command, torques, telemetry }.sealed());
                }
                simulation.advance()?;
                simulation
            }
            other => {
                comparison.starts += 1;
                for ask in reader.take_granted(|at, ask| at.run != stamp.run || matches!(ask, Action::Reset { .. })) {
                    if let Action::Reset { seed: Some(seed) } = ask {
                        (scene.plant.seed, comparison.repeated_requests) = (seed, comparison.repeated_requests + 1);
                    }
                }
                other.insert(Simulation::new(&scene, stamp.run, stamp.epoch)?)
            }
        };
        comparison.compare(stamp.sim_ns, &state(&simulation.truth()), &state(&truth));
    }
    Ok(comparison)
}

/// Repeats a request. Returns true if it has an effect on the plant.
fn repeat(simulation: &mut Simulation, ask: Action) -> bool {
    match ask {
        Action::Push { body, impulse, duration } => simulation.push(body, impulse, duration),
        Action::Rearm => {
            simulation.commands().rearm();
            true
        }
        // A pause is not recorded, a reset starts another run, and the controller handles requests to the gait.
        Action::Pause | Action::Resume | Action::Step { .. } | Action::Reset { .. } | Action::Gait(_) => false,
    }
}

/// Position and velocity of the base and the joints.
fn state(truth: &Truth) -> Vec<f64> {
    let Truth { base_position, base_orientation, base_velocity, base_spin, angle, rate, .. } = truth;
    [&base_position[..], base_orientation, base_velocity, base_spin, angle, rate].concat()
}
