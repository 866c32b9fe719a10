//! The peer of a controller: a simulated robot.

use super::program::{ProgramSetup, ProgramUnderTest};
use super::report::Finding;
use super::stamps::{Expected, Stamps};
use messages::clock::{now_ns, random};
use messages::peer_environment::PeerEnvironment;
use messages::port::PlantPort;
use messages::wire::{Command, Sensors, Stamp, Torques};
use plant::Simulation;
use std::time::{Duration, Instant};

/// Time after which an answer counts as absent.
pub const SILENCE: Duration = Duration::from_millis(100);

/// The peer's side of a session: the robot, and the messages of the controller.
pub struct SimulatedRobot {
    pub port: PlantPort,
    pub simulation: Simulation,
    pub stamps: Stamps,
    pub limit: f64,
    patience: Duration,
    /// Torques of the latest answer.
    pub torques: Torques,
}

impl SimulatedRobot {
    pub fn new(host: &ProgramSetup, environment: &PeerEnvironment) -> Result<SimulatedRobot, String> {
        let port = PlantPort::open(&environment.session, &environment.contract).map_err(|error| error.to_string())?;
        let simulation = simulation(host)?;
        let (stamps, limit) = (Stamps::default(), host.scene.plant.torque_limit);
        Ok(SimulatedRobot { port, simulation, stamps, limit, patience: host.patience, torques: Torques::default() })
    }

    /// Sends these sensors and waits for a command; an error says why there is none.
    pub fn ask(&mut self, program: &mut ProgramUnderTest, sensors: Sensors) -> Result<Command, String> {
        let sensors = Sensors { stamp: Stamp { mono_ns: now_ns(), ..sensors.stamp }, ..sensors };
        self.port.send(sensors).map_err(|error| error.to_string())?;
        self.answer(program, &sensors)
    }

    /// Waits for the command that answers these sensors.
    pub fn answer(&mut self, program: &mut ProgramUnderTest, sensors: &Sensors) -> Result<Command, String> {
        let start = Instant::now();
        loop {
            if let Some(command) = self.port.wait().map_err(|error| error.to_string())? {
                let Stamp { run, seq, sim_ns, mono_ns, .. } = sensors.stamp;
                let expected = Expected { run, ack: seq, sim_ns, sent_ns: [mono_ns, now_ns()] };
                self.stamps.check_command(&command, expected, self.limit);
                self.torques = command.torques;
                return Ok(command);
            }
            let missing = format_args!("no answer to sensors {}", sensors.stamp.seq);
            program.may_answer(missing, start, self.patience)?;
        }
    }

    /// Runs control periods in lockstep; returns the torques of each.
    pub fn walk(&mut self, program: &mut ProgramUnderTest, periods: usize) -> Result<Vec<Torques>, String> {
        let mut torques = vec![];
        for _ in 0..periods {
            let command = self.ask(program, self.simulation.sensors())?;
            self.simulation.receive(&command);
            self.simulation.advance().map_err(|error| format!("our robot cannot go on: {error}"))?;
            torques.push(command.torques);
        }
        Ok(torques)
    }

    /// Checks that no more commands arrive.
    pub fn silence(&mut self) -> Finding {
        let start = Instant::now();
        while start.elapsed() < SILENCE {
            if let Some(command) = self.port.wait().map_err(|error| error.to_string())? {
                return Err(format!("received command {}, for sensors {}", command.stamp.seq, command.stamp.ack));
            }
        }
        Ok(String::new())
    }
}

/// A robot at the start of the scene, in a run without a fixed end.
pub fn simulation(host: &ProgramSetup) -> Result<Simulation, String> {
    let mut scene = host.scene.clone();
    scene.duration = 1e6;
    Simulation::new(&scene, random(), random()).map_err(|error| error.to_string())
}
