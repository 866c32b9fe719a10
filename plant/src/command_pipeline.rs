//! The command pipeline: from the commands that arrive to the torques of the drives.
//!
//! ```text
//!   port → injector (delay, loss, …) → validator → newest accepted command → its age → watchdog → hand-over → torques
//! ```
//! It uses simulated time only. The result is therefore the same in one process and in two, in lockstep and in real time.

use crate::handover::Handover;
use crate::inject::Injector;
use crate::validation::{Acceptance, CommandValidator};
use crate::watchdog::Watchdog;
use messages::scene::Scene;
use messages::wire::{Command, Encoders, JOINTS, PlantState, Sensors, Stamp, Tally, Torques};
use serde::{Deserialize, Serialize};

/// Joint rate from which on a joint without a recent command brakes with its greatest torque [rad/s]. It is eight times the greatest rate of the
/// walk, so a robot that stumbles brakes gently.
const FULL_BRAKE_RATE: f64 = 20.0;

/// The command pipeline of one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CommandPipeline {
    injector: Option<Injector>,
    validator: CommandValidator,
    watchdog: Watchdog,
    handover: Handover,
    /// Torques of the last period [N·m].
    applied: Torques,
    /// Damping of a joint without a recent command, D [N·m·s/rad].
    damping: f64,
    /// Control rate times radians per encoder count [rad/s].
    count_rate: f64,
    newest: Option<Command>,
    /// Whether the newest command was accepted after the last torques were computed.
    fresh: bool,
    state: PlantState,
    age: u64,
    before: Encoders,
    tally: Tally,
}

impl CommandPipeline {
    /// The pipeline for the run `run` of a scene.
    pub fn new(scene: &Scene, run: u64) -> CommandPipeline {
        CommandPipeline {
            injector: (!scene.link.is_perfect()).then(|| Injector::new(&scene.link, 1.0 / scene.rate)),
            validator: CommandValidator::new(run, scene.plant.torque_limit),
            watchdog: Watchdog::new(scene.rate),
            handover: Handover::new(scene.rate),
            applied: Torques::default(),
            damping: scene.plant.torque_limit / FULL_BRAKE_RATE,
            count_rate: scene.rate * scene.plant.radians_per_count(),
            newest: None,
            fresh: false,
            state: PlantState::Wait,
            age: 0,
            before: Encoders::default(),
            tally: Tally::default(),
        }
    }

    /// Receives a command in control period `now`, the number of the newest sensors. Until a command has been accepted, commands are
    /// not delayed: the run begins with the first one.
    pub fn receive(&mut self, command: &Command, now: u64) {
        match &mut self.injector {
            Some(injector) if self.newest.is_some() => injector.push(now, command),
            _ => self.validate(command, now),
        }
    }

    /// Torques for the control period that begins with these sensors [N·m].
    pub fn torques(&mut self, sensors: &Sensors) -> Torques {
        let now = sensors.stamp.seq;
        while let Some(command) = self.injector.as_mut().and_then(|injector| injector.pop(now)) {
            self.validate(&command, now);
        }
        let before = std::mem::replace(&mut self.before, sensors.encoders);
        let Some(newest) = &self.newest else { return Torques::default() };
        self.age = now - newest.stamp.ack;
        self.state = self.watchdog.update(self.age, std::mem::take(&mut self.fresh));
        let tally = &mut self.tally;
        match self.state {
            PlantState::Hold => tally.held += 1,
            PlantState::Damp => tally.damped += 1,
            PlantState::Fault => tally.faulted += 1,
            PlantState::Wait | PlantState::Run | PlantState::Paused => (),
        }
        self.applied = match self.state {
            PlantState::Damp => self.damping(&sensors.encoders, &before),
            PlantState::Fault => Torques::default(),
            PlantState::Wait | PlantState::Run | PlantState::Paused | PlantState::Hold => {
                self.handover.blend(newest.torques)
            }
        };
        self.applied
    }

    /// Ends a fault.
    pub fn rearm(&mut self) {
        self.watchdog.rearm();
    }

    /// Validates a command, and keeps it if it is accepted.
    fn validate(&mut self, command: &Command, now: u64) {
        match self.validator.validate(command, now) {
            Ok(Acceptance { lost, takeover }) => {
                self.tally.lost += lost;
                self.tally.takeovers += u64::from(takeover);
                if takeover {
                    self.handover.begin(self.applied);
                }
                (self.newest, self.fresh) = (Some(*command), true);
            }
            Err(reason) => self.tally.refused[reason as usize] += 1,
        }
    }

    /// τ = −D q̇, with rates from encoder differences.
    fn damping(&self, now: &Encoders, before: &Encoders) -> Torques {
        let rate = |joint: usize| (now.counts[joint] - before.counts[joint]) as f64 * self.count_rate;
        let torque: [f64; JOINTS] = std::array::from_fn(|joint| -self.damping * rate(joint));
        Torques { torque }
    }

    /// Whether a command has been accepted yet.
    pub fn has_command(&self) -> bool {
        self.newest.is_some()
    }

    /// The newest accepted command; before the first one, a command of zeros.
    pub fn newest(&self) -> Command {
        self.newest.unwrap_or_default()
    }

    /// Time from sending the sensors to sending the command that answers them; 0 if the newest command does not answer them [ns].
    pub fn reply_ns(&self, asked: &Stamp) -> u64 {
        let answer = self.newest.as_ref().filter(|newest| newest.stamp.ack == asked.seq);
        answer.map_or(0, |answer| answer.stamp.mono_ns.saturating_sub(asked.mono_ns))
    }

    /// State of the plant in the last control period.
    pub fn state(&self) -> PlantState {
        self.state
    }

    /// Age of the newest command in the last control period [control periods].
    pub fn age(&self) -> u64 {
        self.age
    }

    /// Counters so far.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Counters, for the process to add what only it can count.
    pub fn tally_mut(&mut self) -> &mut Tally {
        &mut self.tally
    }
}
