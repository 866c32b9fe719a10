//! `biped replay`: recorded sensors into a controller, or recorded torques into a plant; what comes out must be what was
//! recorded, bit for bit.

use super::reader::Reader;
use clap::Args;
use controller::Controller;
use controller::process::ProcessError;
use messages::port::Ask;
use messages::scene::{LinkScene, Scene};
use messages::wire::{Command, Stamp, Stamped, Truth};
use plant::Simulation;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::print_text;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Sensors that a late command may answer.
const RECENT: usize = 4096;

/// Arguments of `biped replay`.
#[derive(Args)]
pub struct ReplayArgs {
    /// The recording
    file: PathBuf,
    /// Feed the torques to a plant and compare its states, instead of the sensors to a controller
    #[arg(long)]
    plant: bool,
}

/// What a comparison found.
#[derive(Default)]
struct Comparison {
    /// Compared.
    count: u64,
    /// Not equal bit for bit.
    differ: u64,
    /// Greatest difference.
    greatest: f64,
    /// When the first one was [s].
    first: Option<f64>,
    /// Controllers or plants begun.
    beginnings: u64,
    /// What else is worth knowing.
    remark: Option<String>,
    /// Whether the plant answered a request that is not recorded, such as one by another program.
    is_asked: bool,
    /// Requests that were done here as they were there.
    done: u64,
}

impl Comparison {
    fn of(&mut self, time_ns: u64, ours: &[f64], theirs: &[f64]) {
        self.count += 1;
        if ours.iter().zip(theirs).any(|(ours, theirs)| ours.to_bits() != theirs.to_bits()) {
            self.differ += 1;
            self.first.get_or_insert(time_ns as f64 * 1e-9);
            let off = ours.iter().zip(theirs).map(|(ours, theirs)| (ours - theirs).abs());
            self.greatest = off.fold(self.greatest, f64::max);
        }
    }
}

/// Replays it.
///
/// # Errors
/// If anything differs; see also [`Reader::open`].
pub fn run(args: &ReplayArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let mut reader = Reader::open(&args.file)?;
    let found = if args.plant { plant(&mut reader, stop)? } else { controller(&mut reader, stop)? };
    let (what, unit) = if args.plant { ("states", "m, rad or their rates") } else { ("commands", "N·m") };
    let Comparison { count, differ, greatest, first, beginnings, remark, is_asked, done } = found;
    print_text(format_args!("{}: {count} {what} compared, {differ} differ\n", args.file.display()));
    if beginnings > 1 {
        print_text(format_args!("begun anew {} times, as recorded\n", beginnings - 1));
    }
    if done > 0 {
        print_text(format_args!("{done} recorded requests done again\n"));
    }
    if let Some(remark) = remark {
        print_text(format_args!("{remark}\n"));
    }
    if let Some(why) = reader.cut {
        print_text(format_args!("the file is cut short after them: {why}\n"));
    }
    let asked = if is_asked { "; the plant did what was asked for, which is not recorded" } else { "" };
    match first {
        Some(first) => Err(Failure::new(
            Exit::Fault,
            format!("{differ} of {count} {what} differ, first at {first:.3} s, by up to {greatest:.3e} {unit}{asked}"),
        )),
        None if count == 0 => Err(Failure::new(Exit::Usage, format!("there are no {what} in it to be compared"))),
        None => Ok(()),
    }
}

/// Recorded sensors to a controller: each of its commands beside the recorded one that answers the same sensors.
fn controller(reader: &mut Reader, stop: &AtomicBool) -> Result<Comparison, Failure> {
    let scene = reader.scene().clone();
    let (mut found, mut truth) = (Comparison::default(), Truth::default());
    let (mut controller, mut last, mut sensors) = (None::<Controller>, Stamp::default(), VecDeque::new());
    let mut run = None;
    while reader.next_truth(&mut truth).is_some() {
        check_interrupt(stop)?;
        let Truth { stamp, command, asked, encoders, .. } = truth;
        if run.replace(stamp.run) != Some(stamp.run) {
            sensors.clear(); // those of another run have the same numbers
        }
        if (command.run, command.epoch, command.seq) != (last.run, last.epoch, last.seq) && command.run == stamp.run {
            if (command.run, command.epoch) != (last.run, last.epoch) {
                let (seq, ack) = (command.seq.saturating_sub(1), command.ack.saturating_sub(1));
                (controller, last) = (None, Stamp { seq, ack, ..command });
                found.beginnings += 1;
            }
            // What came between the last two sensors that were answered was never heard, or its answers were lost.
            let between = command.ack.saturating_sub(last.ack.saturating_add(1));
            let lost = command.seq.saturating_sub(last.seq.saturating_add(1));
            let heard = match lost {
                lost if lost >= between => last.ack.saturating_add(1)..=command.ack, // none if it says the same again
                0 => command.ack..=command.ack,
                _ => {
                    let time = stamp.sim_ns as f64 * 1e-9;
                    let words = "sensors and commands were lost together: what it heard then is not known";
                    found.remark = Some(format!("at {time:.3} s {words}"));
                    return Ok(found);
                }
            };
            let controller = match &mut controller {
                Some(controller) => controller,
                none => none.insert(Controller::new(&scene).map_err(ProcessError::from)?),
            };
            let mut torques = None;
            for (seq, encoders) in sensors.iter().filter(|(seq, _)| heard.contains(seq)) {
                for ask in reader.granted(|at, ask| ask.is_for_controller() && at.run == stamp.run && at.ack < *seq) {
                    if let Ask::Set { period, speed } = ask {
                        controller.set(period, speed).map_err(ProcessError::from)?;
                        found.done += 1;
                    }
                }
                torques = Some(controller.tick(encoders).map_err(ProcessError::from)?.torque);
            }
            if let Some(torques) = torques {
                found.of(stamp.sim_ns, &torques, &asked.torque);
            }
            last = command;
        }
        sensors.push_back((stamp.seq, encoders));
        if sensors.len() > RECENT {
            sensors.pop_front();
        }
    }
    Ok(found)
}

/// Recorded torques to a plant: each of its states beside the recorded one.
fn plant(reader: &mut Reader, stop: &AtomicBool) -> Result<Comparison, Failure> {
    // What the link did to the commands is in the record already.
    let mut scene = Scene { link: LinkScene::default(), ..reader.scene().clone() };
    let (mut found, mut truth) = (Comparison::default(), Truth::default());
    let mut simulation = None::<Simulation>;
    while reader.next_truth(&mut truth).is_some() {
        check_interrupt(stop)?;
        let Truth { stamp, command, asked: torques, telemetry, .. } = truth;
        found.is_asked |= truth.tally.requests > 0 && !reader.tells_requests();
        let simulation = match &mut simulation {
            Some(simulation) if simulation.sensors().stamp.run == stamp.run => {
                for ask in reader.granted(|at, _| at.run == stamp.run && at.seq < stamp.seq) {
                    found.done += u64::from(again(simulation, ask));
                }
                if command.run == stamp.run {
                    simulation.hear(&Command { stamp: command, torques, telemetry }.sealed());
                }
                simulation.advance()?;
                simulation
            }
            other => {
                found.beginnings += 1;
                for ask in reader.granted(|at, ask| at.run != stamp.run || matches!(ask, Ask::Reset { .. })) {
                    if let Ask::Reset { seed: Some(seed) } = ask {
                        (scene.plant.seed, found.done) = (seed, found.done + 1);
                    }
                }
                other.insert(Simulation::new(&scene, stamp.run, stamp.epoch)?)
            }
        };
        found.of(stamp.sim_ns, &state(&simulation.truth()), &state(&truth));
    }
    Ok(found)
}

/// Does what the plant was asked for; whether it is of any effect here.
fn again(simulation: &mut Simulation, ask: Ask) -> bool {
    match ask {
        Ask::Push { body, impulse, duration } => simulation.push(body, impulse, duration),
        Ask::Rearm => {
            simulation.intake().rearm();
            true
        }
        // time that stands still is not recorded, a reset begins another run, and set-points are the controller's
        Ask::Pause | Ask::Resume | Ask::Step { .. } | Ask::Reset { .. } | Ask::Set { .. } => false,
    }
}

/// Pose and velocity of the base and the joints.
fn state(truth: &Truth) -> Vec<f64> {
    let Truth { base_position, base_orientation, base_velocity, base_spin, angle, rate, .. } = truth;
    [&base_position[..], base_orientation, base_velocity, base_spin, angle, rate].concat()
}
