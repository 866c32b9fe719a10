//! The plant as a process: the one file of this crate that knows a clock, a peer and a stop request.
//!
//! [`simulate`] is the loop; what it exchanges with its controller, and how long it waits, is up to the caller: two
//! processes in lockstep or in real time ([`run`]), or a controller in the same process, with the same results.

use crate::{Plant, PlantError};
use messages::clock::{Patience, now_ns, random, sleep_until};
use messages::port::{Pace, PlantPort, PortError};
use messages::scene::Scene;
use messages::wire::{Command, Encoders, JOINTS, Sensors, Stamp, Telemetry, Torques, Truth};
use std::f64::consts::TAU;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// In real time, the newest torques are kept while they answer sensors not older than this [control periods].
const HOLD: u64 = 10;
/// Then the joints are only damped, up to this age; beyond it the run is a fault [control periods].
const DAMP: u64 = 100;
/// Damping of an abandoned joint [N·m·s/rad].
const DAMPING: f64 = 2.0;

/// Why a plant process ended before its time.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The link cannot be made or broke.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The simulation failed.
    #[error("plant: {0}")]
    Plant(#[from] PlantError),
    /// Nobody answered in lockstep, or nobody came.
    #[error("no controller answered within {0:?}{1}")]
    NoController(Duration, Rejected),
    /// The controller fell silent in real time.
    #[error("the controller has been silent for {0} control periods: torques are off")]
    Silent(u64),
    /// Ctrl-C or TERM.
    #[error("interrupted")]
    Interrupted,
}

/// Commands that the plant did not accept, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rejected {
    /// Magic, schema hash or check sum wrong.
    pub unsound: u64,
    /// Meant for another run.
    pub other_run: u64,
    /// Answers to sensors not yet sent.
    pub early: u64,
    /// Torques that are no numbers.
    pub not_finite: u64,
}

impl fmt::Display for Rejected {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let reasons = [
            (self.unsound, "damaged or of another version"),
            (self.other_run, "for another run"),
            (self.early, "ahead of the sensors"),
            (self.not_finite, "not finite"),
        ];
        reasons.iter().filter(|(count, _)| *count > 0).try_for_each(|(count, reason)| {
            write!(f, "; {count} command{} refused: {reason}", if *count == 1 { "" } else { "s" })
        })
    }
}

/// What a run met on its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Commands not accepted.
    pub rejected: Rejected,
    /// Whole control periods that real time was ahead and that were left out.
    pub skipped: u64,
    /// Control periods driven by torques older than the sensors.
    pub held: u64,
    /// Control periods damped for want of a command.
    pub damped: u64,
    /// Messages of truth that a recorder did not get.
    pub unrecorded: u64,
}

/// One sentence on whatever was not as it should be; empty if all was.
impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let counts = [
            (self.skipped, "periods skipped"),
            (self.held, "periods on old torques"),
            (self.damped, "periods damped"),
            (self.unrecorded, "periods not recorded"),
        ];
        let text = counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("; {count} {what}"));
        f.write_str((text.collect::<String>() + &self.rejected.to_string()).trim_start_matches("; "))
    }
}

/// How a plant process runs.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Lockstep or real time.
    pub pace: Pace,
    /// How long to wait for a controller.
    pub patience: Duration,
}

/// Runs a scene against the controller at the other end of `port`; a scene without one runs alone, without torques.
///
/// The controller is told of the end, also of an early one.
///
/// # Errors
/// See [`ProcessError`]; the tally is complete in any case.
pub fn run(scene: &Scene, port: PlantPort, options: Options, stop: &AtomicBool) -> (Tally, Result<(), ProcessError>) {
    let mut link = Link::new(scene, port, options, stop);
    let mut sent = Stamp::default();
    let result = simulate(scene, |sensors, truth| {
        sent = sensors.stamp;
        link.exchange(sensors, truth)
    });
    let goodbye = Sensors { stamp: Stamp { seq: sent.seq + 1, ..sent }, last: 1, ..Sensors::default() };
    let told = match result {
        Ok(()) => {
            link.port.finish();
            Ok(())
        }
        Err(_) => link.port.send(goodbye),
    };
    link.tally.rejected.unsound = link.port.unsound();
    link.tally.unrecorded = link.port.unrecorded();
    (link.tally, result.and(told.map_err(ProcessError::from)))
}

/// The loop: at each control period, `exchange` gets sensors and truth and gives the command for the period to come.
///
/// Sensors `seq` = 1 are those of time zero; the last ones carry `last` = 1 and want no answer.
///
/// # Errors
/// Whatever the plant or `exchange` fails with.
pub fn simulate<E: From<PlantError>>(
    scene: &Scene,
    mut exchange: impl FnMut(&Sensors, &Truth) -> Result<Command, E>,
) -> Result<(), E> {
    let mut plant = Plant::new(scene)?;
    let periods = (scene.duration * scene.rate).round() as u64;
    let (run, epoch) = (random(), random());
    let mut encoders = plant.encoders();
    let (mut plant_ns, mut wait_ns, mut telemetry) = (0, 0, Telemetry::default());
    for seq in 1..=periods + 1 {
        let sent = now_ns();
        let stamp = Stamp { run, epoch, seq, sim_ns: plant.time_ns(), mono_ns: sent, ..Stamp::default() };
        let sensors = Sensors { stamp, encoders, last: u64::from(seq > periods) };
        let truth = Truth { stamp, plant_ns, wait_ns, telemetry, ..plant.truth() };
        let command = exchange(&sensors, &truth)?;
        if seq <= periods {
            let answered = now_ns();
            encoders = plant.advance(&command.torques)?;
            (plant_ns, wait_ns, telemetry) = (now_ns() - answered, answered - sent, command.telemetry);
        }
    }
    Ok(())
}

/// The plant's side of the conversation.
struct Link<'a> {
    port: PlantPort,
    pace: Pace,
    stop: &'a AtomicBool,
    patience: Patience,
    limit: Duration,
    is_driven: bool,
    period_ns: u64,
    /// Control rate times radians per encoder count [rad/s].
    count_rate: f64,
    /// Real time at which the period began [ns]; 0 before the first.
    deadline: u64,
    newest: Command,
    before: Encoders,
    tally: Tally,
}

impl<'a> Link<'a> {
    fn new(scene: &Scene, port: PlantPort, options: Options, stop: &'a AtomicBool) -> Self {
        Link {
            port,
            pace: options.pace,
            stop,
            patience: Patience::new("controller", options.patience),
            limit: options.patience,
            is_driven: scene.controller.is_some(),
            period_ns: (1e9 / scene.rate).round() as u64,
            count_rate: scene.rate * TAU / f64::from(scene.plant.encoder_bits).exp2(),
            deadline: 0,
            newest: Command::default(),
            before: Encoders::default(),
            tally: Tally::default(),
        }
    }

    fn exchange(&mut self, sensors: &Sensors, truth: &Truth) -> Result<Command, ProcessError> {
        self.port.send(*sensors)?;
        self.port.record(*truth)?;
        if self.stop.load(Relaxed) {
            return Err(ProcessError::Interrupted);
        }
        match (self.pace, sensors.last) {
            (_, 1..) => Ok(Command::default()),
            (Pace::Lockstep, _) => self.answer(sensors),
            (Pace::RealTime, _) => self.on_time(sensors),
        }
    }

    /// Waits for the answer to these very sensors.
    fn answer(&mut self, sensors: &Sensors) -> Result<Command, ProcessError> {
        if !self.is_driven {
            return Ok(Command::default());
        }
        self.patience.renew();
        loop {
            match self.port.wait()? {
                Some(command) if self.accepts(&command, sensors) && command.stamp.ack == sensors.stamp.seq => {
                    return Ok(command);
                }
                _ if self.stop.load(Relaxed) => return Err(ProcessError::Interrupted),
                _ if self.patience.is_over() => {
                    self.tally.rejected.unsound = self.port.unsound();
                    return Err(ProcessError::NoController(self.limit, self.tally.rejected));
                }
                _ => (),
            }
        }
    }

    /// Sleeps until the period is over in reality too, then takes the newest command; time stands still before the
    /// first one.
    fn on_time(&mut self, sensors: &Sensors) -> Result<Command, ProcessError> {
        if self.deadline == 0 {
            self.newest = self.answer(sensors)?;
            self.deadline = now_ns();
        } else {
            self.deadline += self.period_ns;
            while now_ns() < self.deadline && !self.stop.load(Relaxed) {
                sleep_until(self.deadline);
            }
            let overrun = now_ns().saturating_sub(self.deadline) / self.period_ns;
            self.tally.skipped += overrun;
            self.deadline += overrun * self.period_ns;
            if let Some(command) = self.port.newest()?.filter(|command| self.accepts(command, sensors)) {
                self.newest = command;
            }
        }
        self.aged(sensors)
    }

    /// The newest command, if it is young enough for its age.
    fn aged(&mut self, sensors: &Sensors) -> Result<Command, ProcessError> {
        let before = std::mem::replace(&mut self.before, sensors.encoders);
        let age = if self.is_driven { sensors.stamp.seq - self.newest.stamp.ack } else { 0 };
        match age {
            0 => Ok(self.newest),
            1..=HOLD => {
                self.tally.held += 1;
                Ok(self.newest)
            }
            _ if age <= DAMP => {
                self.tally.damped += 1;
                let rate =
                    |joint: usize| (sensors.encoders.counts[joint] - before.counts[joint]) as f64 * self.count_rate;
                let torque: [f64; JOINTS] = std::array::from_fn(|joint| -DAMPING * rate(joint));
                Ok(Command { torques: Torques { torque }, ..self.newest })
            }
            _ => Err(ProcessError::Silent(age)),
        }
    }

    /// The gate: only a command of this run, for sensors already sent, with numbers for torques. (The port has
    /// already looked at magic, schema hash and check sum.)
    fn accepts(&mut self, command: &Command, sensors: &Sensors) -> bool {
        let rejected = &mut self.tally.rejected;
        let count = if command.stamp.run != sensors.stamp.run {
            &mut rejected.other_run
        } else if command.stamp.ack > sensors.stamp.seq {
            &mut rejected.early
        } else if !command.torques.torque.iter().all(|torque| torque.is_finite()) {
            &mut rejected.not_finite
        } else {
            return true;
        };
        *count += 1;
        false
    }
}
