//! The plant's side of the conversation with its controller, in lockstep or on time.

use crate::Simulation;
use crate::log::PlantLog;
use crate::process::{ExchangeOutcome, Options, PeriodTiming, ProcessError};
use crate::request_handler::RequestHandler;
use crate::watchdog::Mode;
use messages::clock::{Timeout, now_ns, sleep_until};
use messages::port::{Pace, PlantPort};
use messages::scene::Scene;
use messages::wire::{Sensors, Stamp, Stamped};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// The conversation and what it has to remember.
pub(crate) struct ControllerConnection<'a> {
    pub port: PlantPort,
    pace: Pace,
    stop: &'a AtomicBool,
    patience: Timeout,
    limit: Duration,
    is_driven: bool,
    /// Control period in real time [ns].
    period_ns: u64,
    /// Real time at which the period began [ns]; 0: with the first command.
    deadline: u64,
    requests: RequestHandler,
    log: PlantLog,
    /// When the controller last heard of us [ns].
    last_sent_ns: u64,
}

impl<'a> ControllerConnection<'a> {
    pub fn new(scene: &Scene, port: PlantPort, options: Options, stop: &'a AtomicBool) -> Self {
        ControllerConnection {
            port,
            pace: options.pace,
            stop,
            patience: Timeout::new("controller", options.patience),
            limit: options.patience,
            is_driven: scene.controller.is_some(),
            period_ns: ((1e9 / scene.rate / options.speed).round() as u64).max(1),
            deadline: 0,
            requests: RequestHandler::default(),
            log: PlantLog::default(),
            last_sent_ns: 0,
        }
    }

    /// One exchange: sensors and truth out, commands in, requests served. Whatever can wait is done while the controller
    /// computes.
    pub fn exchange(
        &mut self,
        simulation: &mut Simulation,
        sensors: &Sensors,
        timing: &PeriodTiming,
    ) -> Result<ExchangeOutcome, ProcessError> {
        self.port.send(*sensors)?;
        self.port.record(timing.truth(simulation, sensors))?;
        self.log.update(simulation);
        self.check_stop()?;
        if sensors.last != 0 {
            return Ok(ExchangeOutcome::Advance { late_ns: 0 });
        }
        if self.serve(simulation, sensors)? == ExchangeOutcome::Restart {
            return Ok(ExchangeOutcome::Restart);
        }
        simulation.get_ready();
        match self.pace {
            Pace::Lockstep => self.answer(simulation, sensors),
            Pace::RealTime => self.on_time(simulation, sensors),
        }
    }

    /// Waits for the answer to these very sensors; before the first command, for one that is accepted.
    fn answer(&mut self, simulation: &mut Simulation, sensors: &Sensors) -> Result<ExchangeOutcome, ProcessError> {
        self.patience.renew();
        self.last_sent_ns = sensors.stamp.mono_ns;
        while self.is_driven {
            match self.port.wait()? {
                Some(command) => {
                    simulation.receive(&command);
                    let stamp = command.stamp;
                    // nothing that a damaged one says is believed
                    let answers =
                        command.is_sound() && stamp.run == sensors.stamp.run && stamp.ack == sensors.stamp.seq;
                    if answers && simulation.commands().has_command() {
                        break;
                    }
                }
                None if self.serve(simulation, sensors)? == ExchangeOutcome::Restart => {
                    return Ok(ExchangeOutcome::Restart);
                }
                None => self.heartbeat(sensors)?,
            }
            self.log.update(simulation); // above all why no command has been accepted yet
            self.check_stop()?;
            if self.patience.is_over() {
                let met = simulation.commands().tally().to_string();
                let met = if met.is_empty() { met } else { format!("; {met}") };
                return Err(ProcessError::NoController(self.limit, met));
            }
        }
        Ok(ExchangeOutcome::Advance { late_ns: 0 })
    }

    /// Sleeps until the period is over in reality too, then hears the newest command; time stands still before the first
    /// one. A deadline missed by whole periods is moved by them: they are left out, never made up for.
    fn on_time(&mut self, simulation: &mut Simulation, sensors: &Sensors) -> Result<ExchangeOutcome, ProcessError> {
        if self.deadline == 0 {
            let next = self.answer(simulation, sensors)?;
            self.deadline = now_ns();
            return Ok(next);
        }
        self.deadline += self.period_ns;
        while now_ns() < self.deadline && !self.stop.load(Relaxed) {
            sleep_until(self.deadline);
        }
        let late_ns = now_ns().saturating_sub(self.deadline);
        let overrun = late_ns / self.period_ns;
        simulation.commands().tally_mut().skipped += overrun;
        self.deadline += overrun * self.period_ns;
        while let Some(command) = self.port.take()? {
            simulation.receive(&command);
        }
        self.check_abandoned(simulation)?;
        Ok(ExchangeOutcome::Advance { late_ns })
    }

    /// A plant whose drives are off waits for somebody to re-arm them, but not for ever.
    fn check_abandoned(&mut self, simulation: &mut Simulation) -> Result<(), ProcessError> {
        if simulation.mode() != Mode::Fault {
            self.patience.renew();
        } else if self.patience.is_over() {
            return Err(ProcessError::Silent(simulation.commands().age()));
        }
        Ok(())
    }

    /// Serves whoever is at the requests, and stays there while time stands still.
    fn serve(&mut self, simulation: &mut Simulation, sensors: &Sensors) -> Result<ExchangeOutcome, ProcessError> {
        loop {
            while let Some(asked) = self.port.next_request()? {
                let (reply, next) = self.requests.handle(&asked.request, simulation)?;
                self.port.answer(asked, reply)?;
                if next == ExchangeOutcome::Restart {
                    self.deadline = 0;
                    return Ok(next);
                }
            }
            if !self.requests.is_paused(sensors.stamp.seq) {
                return Ok(ExchangeOutcome::Advance { late_ns: 0 });
            }
            self.check_stop()?;
            self.deadline = if self.deadline == 0 { 0 } else { now_ns() };
            self.patience.renew();
            self.heartbeat(sensors)?;
            std::thread::sleep(PAUSE_POLL);
        }
    }

    /// Now and then the controller gets the same sensors again: it hears that we live, and what a link that loses messages,
    /// such as one to another machine, may have lost. It answers them as before.
    fn heartbeat(&mut self, sensors: &Sensors) -> Result<(), ProcessError> {
        if now_ns() - self.last_sent_ns > HEARTBEAT_NS {
            self.last_sent_ns = now_ns();
            self.port.send(Sensors { stamp: Stamp { mono_ns: self.last_sent_ns, ..sensors.stamp }, ..*sensors })?;
        }
        Ok(())
    }

    fn check_stop(&self) -> Result<(), ProcessError> {
        if self.stop.load(Relaxed) { Err(ProcessError::Interrupted) } else { Ok(()) }
    }
}

/// While time stands still, the requests is looked at this often.
const PAUSE_POLL: Duration = Duration::from_millis(1);
/// And the controller hears of us this often [ns].
const HEARTBEAT_NS: u64 = 100_000_000;
