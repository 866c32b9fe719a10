//! Bad commands over the real link: a faulty controller is connected to a real plant.

use super::test_session::{FaultTrial, LIMIT, TestSession, TrialOutcome, is_finite, walk};
use crate::subject::Subject;
use controller::Controller;
use messages::port::{Contract, ControllerPort, Pace, RecorderPort};
use messages::scene::Scene;
use messages::wire::{Command, REFUSALS, Sensors, Stamp, Stamped, Truth};
use plant::Simulation;
use std::time::{Duration, Instant};
use strum::VariantArray;

/// Bad commands before each good one.
const BEFORE: usize = 8;
/// Time for the plant to read a bad command before the next one replaces it.
const READ: Duration = Duration::from_micros(10);

/// Time limit of a flood.
const LONGEST: Duration = Duration::from_secs(1800);

/// The defect of a bad command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray)]
pub enum CommandFlaw {
    /// A torque is not a number.
    NotANumber,
    /// A torque is infinite.
    Infinite,
    /// A torque beyond every drive's limit.
    Huge,
    /// A repeated command.
    Duplicated,
    /// A sequence number below the previous one.
    Stale,
    /// A flipped bit.
    Flipped,
    /// A wrong run number.
    WrongRun,
    /// An answer to sensors that have not been sent.
    Early,
}

impl CommandFlaw {
    /// Gives a good command this defect; `sent` is the previous command.
    fn spoil(self, good: Command, sent: &Command, random: &mut fastrand::Rng) -> Command {
        let (mut bad, joint) = (good, random.usize(0..good.torques.torque.len()));
        let torque = &mut bad.torques.torque[joint];
        match self {
            CommandFlaw::NotANumber => *torque = f64::NAN,
            CommandFlaw::Infinite => *torque = if random.bool() { f64::INFINITY } else { f64::NEG_INFINITY },
            CommandFlaw::Huge => *torque = 10.0_f64.powf(random.f64() * 300.0 + 3.0),
            CommandFlaw::Duplicated => return *sent,
            CommandFlaw::Stale => bad.stamp.seq = sent.stamp.seq - random.u64(0..sent.stamp.seq),
            CommandFlaw::WrongRun => bad.stamp.run ^= random.u64(1..),
            CommandFlaw::Early => bad.stamp.ack += random.u64(2..1000),
            CommandFlaw::Flipped => {
                let mut bytes = bytemuck::bytes_of(&good.sealed()).to_vec();
                let bit = random.usize(0..8 * bytes.len());
                bytes[bit / 8] ^= 1 << (bit % 8);
                return bytemuck::pod_read_unaligned(&bytes);
            }
        }
        bad.sealed()
    }
}

/// A faulty controller, a real plant, and a recorder.
struct FaultyController {
    port: ControllerPort,
    listener: RecorderPort,
    plant: Subject,
    controller: Controller,
    /// The last good command.
    sent: Command,
    /// The newest truth.
    truth: Truth,
    _stage: TestSession,
}

impl FaultyController {
    fn start(scene: &Scene, settings: &str) -> Result<FaultyController, String> {
        let test_session = TestSession::empty();
        let contract = Contract::of(scene, Pace::Lockstep);
        let port = ControllerPort::open(&test_session.session, &contract).map_err(message)?;
        let listener = RecorderPort::open(&test_session.session, &contract).map_err(message)?;
        let plant = ["plant", "walk", "--set", settings, "--patience", "2", "--session", test_session.session.name()];
        let (plant, controller) = (Subject::biped(&plant)?, Controller::new(scene).map_err(message)?);
        let (sent, truth) = (Command::default(), Truth::default());
        Ok(FaultyController { port, listener, plant, controller, sent, truth, _stage: test_session })
    }

    /// The next sensors after those answered last.
    fn ask(&mut self) -> Result<Sensors, String> {
        let start = Instant::now();
        loop {
            match self.port.wait().map_err(message)? {
                Some(sensors) if sensors.stamp.seq != self.sent.stamp.ack => return Ok(sensors),
                _ if self.plant.has_ended() => return Err(format!("the plant has ended: {}", self.plant.output())),
                _ if self.sent.stamp.ack > 0 && start.elapsed() > LIMIT => return Err("the plant is silent".into()),
                _ => (),
            }
        }
    }

    /// The correct answer, not yet sent. Its sequence number leaves room for bad commands before it.
    fn answer(&mut self, sensors: &Sensors) -> Result<Command, String> {
        let torques = self.controller.tick(&sensors.encoders).map_err(message)?;
        let (asked, seq) = (sensors.stamp, self.sent.stamp.seq + 1 + BEFORE as u64);
        let stamp = Stamp { run: asked.run, epoch: 1, seq, ack: asked.seq, sim_ns: asked.sim_ns, ..Stamp::default() };
        Ok(Command { stamp, torques, telemetry: self.controller.telemetry() }.sealed())
    }

    fn listen(&mut self, mut check: impl FnMut(&Truth) -> Result<(), String>) -> Result<(), String> {
        while let Some(truth) = self.listener.read().map_err(message)? {
            is_finite(&truth)?;
            check(&truth)?;
            self.truth = *truth;
        }
        Ok(())
    }

    fn refused(&self) -> u64 {
        self.truth.tally.refused.iter().sum()
    }

    fn outcome(&self, how: &str, start: Instant) -> TrialOutcome {
        let refused = self.truth.tally.refused.iter().zip(REFUSALS).filter(|(count, _)| **count > 0);
        let refused: Vec<String> = refused.map(|(count, reason)| format!("{count} {reason}")).collect();
        let (walked, took) = (self.truth.stamp.time(), start.elapsed().as_secs_f64());
        TrialOutcome {
            time: None,
            remark: format!("refused: {}; {walked:.0} s walked {how}, in {took:.0} s", refused.join(", ")),
        }
    }
}

fn message(error: impl ToString) -> String {
    error.to_string()
}

/// Floods a walk with bad commands, [`BEFORE`] before each good one. All must be refused, and the walk must equal the one without them bit
/// for bit.
pub fn flood(count: u64, random: &mut fastrand::Rng) -> FaultTrial {
    let (_, scene) = walk(&["duration=100000"])?;
    let (mut faulty, start) = (FaultyController::start(&scene, "duration=100000")?, Instant::now());
    // the same walk without the flood, here
    let mut undisturbed = Simulation::new(&scene, 1, 1).map_err(message)?;
    let mut hashes = vec![0, undisturbed.truth().hash];
    while faulty.refused() < count {
        if start.elapsed() > LONGEST {
            return Err(format!("after {LONGEST:?} only {} were refused: the machine is too busy", faulty.refused()));
        }
        let sensors = faulty.ask()?;
        let good = faulty.answer(&sensors)?;
        // No bad commands before the first good one: some of them repeat a good command or have an older number.
        for _ in 0..if faulty.sent.stamp.ack > 0 { BEFORE } else { 0 } {
            let flaw = CommandFlaw::VARIANTS[random.usize(0..CommandFlaw::VARIANTS.len())];
            // it answers the previous sensors, so that the plant continues to wait for the good command
            let near = Command { stamp: Stamp { ack: sensors.stamp.seq - 1, ..good.stamp }, ..good };
            faulty.port.send_raw(flaw.spoil(near, &faulty.sent, random)).map_err(message)?;
            let begin = Instant::now();
            while begin.elapsed() < READ {
                std::thread::yield_now(); // the plant may need this processor
            }
        }
        faulty.port.send_raw(good).map_err(message)?;
        faulty.sent = good;
        let stamp = Stamp { ack: undisturbed.sensors().stamp.seq, ..undisturbed.sensors().stamp };
        undisturbed.receive(&Command { stamp, ..good }.sealed());
        undisturbed.advance().map_err(message)?;
        hashes.push(undisturbed.truth().hash);
        faulty.listen(|truth| match hashes.get(truth.stamp.seq as usize) == Some(&truth.hash) {
            true => Ok(()),
            false => Err(format!("at period {} the walk differs from the walk without bad commands", truth.stamp.seq)),
        })?;
    }
    Ok(faulty.outcome("bit for bit as without them", start))
}

/// Every second answer must be refused. The walk continues with the torques of the previous period.
pub fn every_other(count: u64, random: &mut fastrand::Rng) -> FaultTrial {
    let (_, scene) = walk(&["duration=100000"])?;
    let (mut faulty, start) = (FaultyController::start(&scene, "duration=100000")?, Instant::now());
    while faulty.refused() < count {
        let sensors = faulty.ask()?;
        let good = faulty.answer(&sensors)?;
        let bad = [CommandFlaw::NotANumber, CommandFlaw::Infinite, CommandFlaw::Huge][random.usize(0..3)];
        let is_bad = sensors.stamp.seq > 1 && sensors.stamp.seq % 2 == 0;
        faulty.port.send_raw(if is_bad { bad.spoil(good, &faulty.sent, random) } else { good }).map_err(message)?;
        faulty.sent = good;
        faulty.listen(|truth| match truth.base_position[2] > 0.2 {
            true => Ok(()),
            false => Err(format!("the robot fell at period {}", truth.stamp.seq)),
        })?;
    }
    Ok(faulty.outcome("upright", start))
}
