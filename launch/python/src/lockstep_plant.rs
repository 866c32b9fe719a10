//! A plant of one's own in a session, in lockstep: the protocol of docs/WIRE.md around a [`PlantPort`] and a [`CommandPipeline`].

use biped_c::failure::{BIPED_NO_PLANT, BIPED_STOPPED, CallFailure};
use messages::clock::{now_ns, random};
use messages::peer_environment::PeerEnvironment;
use messages::port::{Action, Pace, PlantPort, Verdict};
use messages::wire::{Encoders, PlantState, Reply, Sensors, Stamp, Torques, Truth};
use plant::command_pipeline::CommandPipeline;
use plant::process::{AnswerWait, Waited};

/// A plant's end of a session.
pub struct LockstepPlant {
    port: PlantPort,
    commands: CommandPipeline,
    /// The last sensors; their number is 0 before the first ones.
    sensors: Sensors,
    /// Control rate [Hz], and number of control periods.
    rate: f64,
    periods: u64,
    has_controller: bool,
    wait: AnswerWait,
    /// When the last command was taken [ns], and how long the plant had waited for it [ns].
    answered_ns: u64,
    wait_ns: u64,
}

impl LockstepPlant {
    /// Joins the session of an environment as its plant.
    pub fn join(environment: PeerEnvironment) -> Result<LockstepPlant, CallFailure> {
        let PeerEnvironment { session, contract, patience, scene, .. } = environment;
        if contract.pace != Pace::Lockstep {
            return Err(CallFailure::misuse("this plant goes in lockstep alone: leave out --realtime"));
        }
        let stamp = Stamp { run: random().max(1), epoch: random(), ..Stamp::default() };
        Ok(LockstepPlant {
            port: PlantPort::open(&session, &contract)?,
            commands: CommandPipeline::new(&scene, stamp.run),
            sensors: Sensors { stamp, ..Sensors::default() },
            rate: scene.rate,
            periods: scene.periods(),
            has_controller: scene.controller.is_some(),
            wait: AnswerWait::new(patience),
            answered_ns: 0,
            wait_ns: 0,
        })
    }

    /// Sends these encoder counts and the truth that belongs to them, and waits for the answer while `keeps_waiting` returns true. Returns
    /// the torques of the drives for the control period that begins; none at the end of the scene.
    pub fn exchange(
        &mut self,
        counts: [i64; 8],
        truth: Truth,
        keeps_waiting: impl FnMut() -> bool,
    ) -> Result<Option<Torques>, CallFailure> {
        if self.has_ended() {
            return Err(CallFailure::misuse("the run has ended: its last exchange returned no torques"));
        }
        let sent = now_ns();
        let Stamp { seq, .. } = self.sensors.stamp;
        let truth = self.completed(truth, sent);
        let stamp = Stamp { seq: seq + 1, sim_ns: (seq as f64 * 1e9 / self.rate).round() as u64, ..self.sensors.stamp };
        let stamp = Stamp { mono_ns: sent, ..stamp };
        self.sensors = Sensors { stamp, encoders: Encoders { counts }, last: u64::from(stamp.seq > self.periods) };
        self.port.send(self.sensors)?;
        self.port.record(Truth { stamp, encoders: self.sensors.encoders, ..truth })?;
        if self.has_ended() {
            self.port.finish();
            return Ok(None);
        }
        self.refuse_requests()?;
        if self.has_controller {
            self.wait_for_answer(keeps_waiting)?;
        }
        (self.answered_ns, self.wait_ns) = (now_ns(), now_ns() - sent);
        Ok(Some(self.commands.torques(&self.sensors)))
    }

    /// Whether the last sensors have been sent.
    pub fn has_ended(&self) -> bool {
        self.sensors.last != 0
    }

    /// Simulated time of the last sensors [s].
    pub fn time(&self) -> f64 {
        self.sensors.stamp.time()
    }

    /// State of the drives.
    pub fn state(&self) -> PlantState {
        self.commands.state()
    }

    /// Tells the controller that the run ends before its time.
    pub fn leave(&mut self) -> Result<(), CallFailure> {
        if !self.has_ended() {
            (self.sensors.last, self.sensors.stamp.seq) = (1, self.sensors.stamp.seq + 1);
            self.sensors.stamp.mono_ns = now_ns();
            self.port.send(self.sensors)?;
            self.port.wait_for_tunnel();
        }
        Ok(())
    }

    /// The truth, completed with the session's data on the period that ends with it: commands, counters and times.
    fn completed(&mut self, truth: Truth, now: u64) -> Truth {
        self.commands.tally_mut().unrecorded = self.port.unrecorded();
        let (commands, newest) = (&self.commands, self.commands.newest());
        Truth {
            state: commands.state() as u32,
            age: commands.age() as u32,
            tally: *commands.tally(),
            telemetry: newest.telemetry,
            command: newest.stamp,
            asked: newest.torques,
            plant_ns: if self.answered_ns == 0 { 0 } else { now - self.answered_ns },
            wait_ns: self.wait_ns,
            reply_ns: commands.reply_ns(&self.sensors.stamp),
            ..truth
        }
    }

    /// Waits for the answer to the last sensors. Before the first command was accepted, only an accepted answer counts.
    fn wait_for_answer(&mut self, mut keeps_waiting: impl FnMut() -> bool) -> Result<(), CallFailure> {
        self.wait.begin(self.sensors.stamp.mono_ns);
        loop {
            match self.wait.poll(&mut self.port, &mut self.commands, &self.sensors)? {
                Waited::Answered => return Ok(()),
                Waited::Received => (),
                Waited::Nothing => {
                    self.refuse_requests()?;
                    self.wait.heartbeat(&self.port, &self.sensors)?;
                    if !keeps_waiting() {
                        return Err(CallFailure::new(BIPED_STOPPED, "interrupted"));
                    }
                }
            }
            self.wait.check(&self.commands).map_err(|error| CallFailure::new(BIPED_NO_PLANT, error.to_string()))?;
        }
    }

    /// Refuses all requests, because a plant of one's own serves none.
    fn refuse_requests(&mut self) -> Result<(), CallFailure> {
        while let Some(pending) = self.port.next_request()? {
            let verdict = match Action::decode(&pending.request) {
                Ok(action) if action.is_for_controller() => Verdict::WrongProcess,
                Ok(_) => Verdict::NotServed,
                Err(verdict) => verdict,
            };
            self.commands.tally_mut().requests += 1;
            let (stamp, state) = (self.sensors.stamp, self.commands.state() as u64);
            self.port.answer(pending, Reply { stamp, verdict: verdict as u64, state })?;
        }
        Ok(())
    }
}
