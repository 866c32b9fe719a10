//! The plant's side of the conversation with its controller, in lockstep or on time.

use crate::Simulation;
use crate::desk::Desk;
use crate::process::{Next, Options, ProcessError, Shell};
use crate::remarks::Remarks;
use crate::watchdog::Mode;
use messages::clock::{Patience, now_ns, sleep_until};
use messages::port::{Pace, PlantPort};
use messages::scene::Scene;
use messages::wire::{Sensors, Stamp, Stamped};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// The conversation and what it has to remember.
pub(crate) struct Link<'a> {
    pub port: PlantPort,
    pace: Pace,
    stop: &'a AtomicBool,
    patience: Patience,
    limit: Duration,
    is_driven: bool,
    /// Control period in real time [ns].
    period_ns: u64,
    /// Real time at which the period began [ns]; 0: with the first command.
    deadline: u64,
    desk: Desk,
    remarks: Remarks,
    /// When the controller last heard of us [ns].
    alive: u64,
}

impl<'a> Link<'a> {
    pub fn new(scene: &Scene, port: PlantPort, options: Options, stop: &'a AtomicBool) -> Self {
        Link {
            port,
            pace: options.pace,
            stop,
            patience: Patience::new("controller", options.patience),
            limit: options.patience,
            is_driven: scene.controller.is_some(),
            period_ns: ((1e9 / scene.rate / options.speed).round() as u64).max(1),
            deadline: 0,
            desk: Desk::default(),
            remarks: Remarks::default(),
            alive: 0,
        }
    }

    /// One exchange: sensors and truth out, commands in, requests served. Whatever can wait is done while the controller
    /// computes.
    pub fn exchange(
        &mut self,
        simulation: &mut Simulation,
        sensors: &Sensors,
        shell: &Shell,
    ) -> Result<Next, ProcessError> {
        self.port.send(*sensors)?;
        self.port.record(shell.truth(simulation, sensors))?;
        self.remarks.on(simulation);
        self.go_on()?;
        if sensors.last != 0 {
            return Ok(Next::Period { late_ns: 0 });
        }
        if self.serve(simulation, sensors)? == Next::Afresh {
            return Ok(Next::Afresh);
        }
        simulation.prepare();
        match self.pace {
            Pace::Lockstep => self.answer(simulation, sensors),
            Pace::RealTime => self.on_time(simulation, sensors),
        }
    }

    /// Waits for the answer to these very sensors; before the first command, for one that is accepted.
    fn answer(&mut self, simulation: &mut Simulation, sensors: &Sensors) -> Result<Next, ProcessError> {
        self.patience.renew();
        self.alive = sensors.stamp.mono_ns;
        while self.is_driven {
            match self.port.wait()? {
                Some(command) => {
                    simulation.receive(&command);
                    let stamp = command.stamp;
                    // nothing that a damaged one says is believed
                    let answers =
                        command.is_sound() && stamp.run == sensors.stamp.run && stamp.ack == sensors.stamp.seq;
                    if answers && simulation.intake().has_begun() {
                        break;
                    }
                }
                None if self.serve(simulation, sensors)? == Next::Afresh => return Ok(Next::Afresh),
                None => self.sign_of_life(sensors)?,
            }
            self.remarks.on(simulation); // above all why no command has been accepted yet
            self.go_on()?;
            if self.patience.is_over() {
                let met = simulation.intake().tally().to_string();
                let met = if met.is_empty() { met } else { format!("; {met}") };
                return Err(ProcessError::NoController(self.limit, met));
            }
        }
        Ok(Next::Period { late_ns: 0 })
    }

    /// Sleeps until the period is over in reality too, then hears the newest command; time stands still before the first
    /// one. A deadline missed by whole periods is moved by them: they are left out, never made up for.
    fn on_time(&mut self, simulation: &mut Simulation, sensors: &Sensors) -> Result<Next, ProcessError> {
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
        simulation.intake().tally_mut().skipped += overrun;
        self.deadline += overrun * self.period_ns;
        while let Some(command) = self.port.take()? {
            simulation.receive(&command);
        }
        self.abandoned(simulation)?;
        Ok(Next::Period { late_ns })
    }

    /// A plant whose drives are off waits for somebody to re-arm them, but not for ever.
    fn abandoned(&mut self, simulation: &mut Simulation) -> Result<(), ProcessError> {
        if simulation.mode() != Mode::Fault {
            self.patience.renew();
        } else if self.patience.is_over() {
            return Err(ProcessError::Silent(simulation.intake().age()));
        }
        Ok(())
    }

    /// Serves whoever is at the desk, and stays there while time stands still.
    fn serve(&mut self, simulation: &mut Simulation, sensors: &Sensors) -> Result<Next, ProcessError> {
        loop {
            while let Some(asked) = self.port.asked()? {
                let (reply, next) = self.desk.handle(&asked.request, simulation)?;
                self.port.answer(asked, reply)?;
                if next == Next::Afresh {
                    self.deadline = 0;
                    return Ok(next);
                }
            }
            if !self.desk.stands_still(sensors.stamp.seq) {
                return Ok(Next::Period { late_ns: 0 });
            }
            self.go_on()?;
            self.deadline = if self.deadline == 0 { 0 } else { now_ns() };
            self.patience.renew();
            self.sign_of_life(sensors)?;
            std::thread::sleep(DESK);
        }
    }

    /// Now and then the controller gets the same sensors again: it hears that we live, and what a link that loses messages,
    /// such as one to another machine, may have lost. It answers them as before.
    fn sign_of_life(&mut self, sensors: &Sensors) -> Result<(), ProcessError> {
        if now_ns() - self.alive > SIGN_OF_LIFE {
            self.alive = now_ns();
            self.port.send(Sensors { stamp: Stamp { mono_ns: self.alive, ..sensors.stamp }, ..*sensors })?;
        }
        Ok(())
    }

    fn go_on(&self) -> Result<(), ProcessError> {
        if self.stop.load(Relaxed) { Err(ProcessError::Interrupted) } else { Ok(()) }
    }
}

/// While time stands still, the desk is looked at this often.
const DESK: Duration = Duration::from_millis(1);
/// And the controller hears of us this often [ns].
const SIGN_OF_LIFE: u64 = 100_000_000;
