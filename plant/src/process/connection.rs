//! The plant's side of the exchange with its controller, in lockstep or in real time.

use super::answer_wait::{AnswerWait, Waited};
use super::control_loop::{ExchangeOutcome, PeriodTiming};
use super::error::{Options, PlantProcessError};
use super::log::PlantLog;
use super::request_handler::RequestHandler;
use crate::Simulation;
use messages::clock::{now_ns, sleep_until};
use messages::port::{Pace, PlantPort};
use messages::scene::Scene;
use messages::wire::{PlantState, Sensors};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// While simulated time stands still, the plant looks for requests this often.
const PAUSE_POLL: Duration = Duration::from_millis(1);

/// Connection of a plant to its controller.
pub(super) struct ControllerConnection<'a> {
    pub port: PlantPort,
    pace: Pace,
    stop: &'a AtomicBool,
    wait: AnswerWait,
    has_controller: bool,
    /// Control period in real time [ns].
    period_ns: u64,
    /// Real time at which the period began [ns]; 0 until the first command is accepted.
    deadline: u64,
    requests: RequestHandler,
    log: PlantLog,
}

impl<'a> ControllerConnection<'a> {
    pub fn new(scene: &Scene, port: PlantPort, options: Options, stop: &'a AtomicBool) -> Self {
        ControllerConnection {
            port,
            pace: options.pace,
            stop,
            wait: AnswerWait::new(options.patience),
            has_controller: scene.controller.is_some(),
            period_ns: ((1e9 / scene.rate / options.speed).round() as u64).max(1),
            deadline: 0,
            requests: RequestHandler::default(),
            log: PlantLog::default(),
        }
    }

    /// One exchange: sends sensors and truth, receives commands, and answers requests. Work that can wait is done while the
    /// controller computes.
    pub fn exchange(
        &mut self,
        simulation: &mut Simulation,
        sensors: &Sensors,
        timing: &PeriodTiming,
    ) -> Result<ExchangeOutcome, PlantProcessError> {
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
        simulation.prepare();
        match self.pace {
            Pace::Lockstep => self.wait_for_answer(simulation, sensors),
            Pace::RealTime => self.wait_for_deadline(simulation, sensors),
        }
    }

    /// Waits for the answer to these sensors. Before the first command it waits for one that is accepted.
    fn wait_for_answer(
        &mut self,
        simulation: &mut Simulation,
        sensors: &Sensors,
    ) -> Result<ExchangeOutcome, PlantProcessError> {
        self.wait.begin(sensors.stamp.mono_ns);
        while self.has_controller {
            match self.wait.poll(&mut self.port, simulation.commands(), sensors)? {
                Waited::Answered => break,
                Waited::Received => (),
                Waited::Nothing if self.serve(simulation, sensors)? == ExchangeOutcome::Restart => {
                    return Ok(ExchangeOutcome::Restart);
                }
                Waited::Nothing => self.wait.heartbeat(&self.port, sensors)?,
            }
            self.log.update(simulation); // reports why no command has been accepted yet
            self.check_stop()?;
            self.wait.check(simulation.commands())?;
        }
        Ok(ExchangeOutcome::Advance { late_ns: 0 })
    }

    /// Sleeps until the period has passed in real time, then takes the newest command. Before the first command simulated time
    /// stands still. A deadline that was missed by whole periods moves by these periods: they are skipped, not caught up.
    fn wait_for_deadline(
        &mut self,
        simulation: &mut Simulation,
        sensors: &Sensors,
    ) -> Result<ExchangeOutcome, PlantProcessError> {
        if self.deadline == 0 {
            let outcome = self.wait_for_answer(simulation, sensors)?;
            self.deadline = now_ns();
            return Ok(outcome);
        }
        self.deadline += self.period_ns;
        while now_ns() < self.deadline && !self.stop.load(Relaxed) {
            sleep_until(self.deadline);
        }
        let late_ns = now_ns().saturating_sub(self.deadline);
        let overrun = late_ns / self.period_ns;
        simulation.commands().tally_mut().skipped += overrun;
        self.deadline += overrun * self.period_ns;
        while let Some(command) = self.port.try_receive()? {
            simulation.receive(&command);
        }
        self.check_abandoned(simulation)?;
        Ok(ExchangeOutcome::Advance { late_ns })
    }

    /// A plant whose drives are off waits for a request to re-arm them, up to the timeout.
    fn check_abandoned(&mut self, simulation: &mut Simulation) -> Result<(), PlantProcessError> {
        if simulation.state() != PlantState::Fault {
            self.wait.restart();
        } else if self.wait.is_over() {
            return Err(PlantProcessError::Silent(simulation.commands().age()));
        }
        Ok(())
    }

    /// Answers requests, and returns only when simulated time may go on.
    fn serve(&mut self, simulation: &mut Simulation, sensors: &Sensors) -> Result<ExchangeOutcome, PlantProcessError> {
        loop {
            while let Some(pending) = self.port.next_request()? {
                let (reply, outcome) = self.requests.handle(&pending.request, simulation)?;
                self.port.answer(pending, reply)?;
                if outcome == ExchangeOutcome::Restart {
                    self.deadline = 0;
                    return Ok(outcome);
                }
            }
            if !self.requests.is_paused(sensors.stamp.seq) {
                return Ok(ExchangeOutcome::Advance { late_ns: 0 });
            }
            self.check_stop()?;
            self.deadline = if self.deadline == 0 { 0 } else { now_ns() };
            self.wait.restart();
            self.wait.heartbeat(&self.port, sensors)?;
            std::thread::sleep(PAUSE_POLL);
        }
    }

    fn check_stop(&self) -> Result<(), PlantProcessError> {
        if self.stop.load(Relaxed) { Err(PlantProcessError::Interrupted) } else { Ok(()) }
    }
}
