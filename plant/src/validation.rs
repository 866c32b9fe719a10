//! Validation of commands before they reach the drives.
//!
//! The checks follow the order of [`Refusal`]: version, run, sender, check sum, number, sensors answered, torques. Each reason has a
//! counter. A refused command changes nothing else.

use messages::wire::{Command, Refusal, Stamp, Stamped, Torques};

/// Largest torque that is accepted, over the limit of the drives [-]. The drives clamp torques up to this value.
const MAX_TORQUE_FACTOR: f64 = 4.0;
/// Largest change of a torque in one control period, over the limit of the drives [-]: from one limit to the other.
const MAX_JUMP_FACTOR: f64 = 2.0;
/// Number of replaced controllers that are remembered.
const REMEMBERED_CONTROLLERS: usize = 8;

/// Properties of an accepted command, apart from its torques.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Acceptance {
    /// Number of preceding commands that never arrived. A repeated answer is not one of them.
    pub lost: u64,
    /// Whether this command is the first one of a new controller process.
    pub takeover: bool,
}

/// Validates the commands of one run.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct CommandValidator {
    run: u64,
    /// Torque limit of the drives [N·m].
    limit: f64,
    /// Stamp of the last accepted command.
    last: Option<Stamp>,
    torques: Torques,
    replaced: [Option<u64>; REMEMBERED_CONTROLLERS],
}

impl CommandValidator {
    /// A validator for commands of the run `run` to drives with the torque limit `limit` [N·m].
    pub fn new(run: u64, limit: f64) -> CommandValidator {
        CommandValidator {
            run,
            limit,
            last: None,
            torques: Torques::default(),
            replaced: [None; REMEMBERED_CONTROLLERS],
        }
    }

    /// Validates a command that arrives while the newest sensors sent have the number `now`.
    ///
    /// A controller with another epoch takes over. The port ensures that only one controller is in the session at a time. Later
    /// commands of the replaced controller are refused.
    ///
    /// # Errors
    /// The first reason to refuse the command.
    pub fn validate(&mut self, command: &Command, now: u64) -> Result<Acceptance, Refusal> {
        let (stamp, torque) = (&command.stamp, &command.torques.torque);
        let before = self.last.filter(|last| last.epoch == stamp.epoch);
        let jump = |(torque, before): (&f64, &f64)| (torque - before).abs();
        let reason = if !command.is_ours() {
            Refusal::Version
        } else if stamp.run != self.run {
            Refusal::Run
        } else if before.is_none() && self.replaced.contains(&Some(stamp.epoch)) {
            Refusal::Owner
        } else if !command.is_sound() {
            Refusal::Damaged
        } else if before.is_some_and(|before| stamp.seq <= before.seq) {
            Refusal::Stale
        } else if stamp.ack > now {
            Refusal::Early
        } else if !torque.iter().all(|torque| torque.is_finite()) {
            Refusal::NotFinite
        } else if torque.iter().any(|torque| torque.abs() > MAX_TORQUE_FACTOR * self.limit) {
            Refusal::TooStrong
        } else if torque.iter().zip(&self.torques.torque).map(jump).any(|jump| jump > MAX_JUMP_FACTOR * self.limit) {
            Refusal::TooSteep
        } else {
            return Ok(self.accept(command));
        };
        Err(reason)
    }

    fn accept(&mut self, command: &Command) -> Acceptance {
        let last = self.last.replace(command.stamp);
        self.torques.torque = command.torques.torque.map(|torque| torque.clamp(-self.limit, self.limit));
        match last {
            None => Acceptance::default(),
            Some(last) if last.epoch == command.stamp.epoch => {
                Acceptance { lost: missing_between(&last, &command.stamp), takeover: false }
            }
            Some(last) => {
                self.replaced.rotate_right(1);
                self.replaced[0] = Some(last.epoch);
                Acceptance { lost: 0, takeover: true }
            }
        }
    }
}

/// Number of answers that never arrived between two commands of one controller. Repeats of an answer have numbers of their own, but they
/// answer the same sensors, so a gap counts in the numbers of both.
fn missing_between(before: &Stamp, after: &Stamp) -> u64 {
    let gap = |before: u64, after: u64| after.saturating_sub(before).saturating_sub(1);
    gap(before.seq, after.seq).min(gap(before.ack, after.ack))
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::wire::{REFUSALS, Stamp};

    const RUN: u64 = 7;

    fn command(epoch: u64, seq: u64, ack: u64, torque: f64) -> Command {
        let stamp = Stamp { run: RUN, epoch, seq, ack, ..Stamp::default() };
        Command { stamp, torques: Torques { torque: [torque; 8] }, ..Command::default() }.sealed()
    }

    fn validator() -> CommandValidator {
        CommandValidator::new(RUN, 40.0)
    }

    #[test]
    fn each_fault_is_refused_for_its_own_reason() {
        let good = command(1, 5, 3, 1.0);
        let resealed = |change: fn(&mut Command)| {
            let mut bad = command(1, 5, 3, 1.0);
            change(&mut bad);
            bad.sealed()
        };
        let raw = |change: fn(&mut Command)| {
            let mut bad = good;
            change(&mut bad);
            bad
        };
        let cases = [
            (raw(|c| c.stamp.magic ^= 1), Refusal::Version),
            (raw(|c| c.stamp.schema ^= 1), Refusal::Version),
            (resealed(|c| c.stamp.run = 8), Refusal::Run),
            (raw(|c| c.torques.torque[3] = 2.0), Refusal::Damaged),
            (resealed(|c| c.stamp.ack = 9), Refusal::Early),
            (resealed(|c| c.torques.torque[7] = f64::NAN), Refusal::NotFinite),
            (resealed(|c| c.torques.torque[0] = f64::INFINITY), Refusal::NotFinite),
            (resealed(|c| c.torques.torque[0] = 161.0), Refusal::TooStrong),
            (resealed(|c| c.torques.torque[0] = -81.0), Refusal::TooSteep),
        ];
        for (bad, reason) in cases {
            assert_eq!(validator().validate(&bad, 4), Err(reason), "{}", REFUSALS[reason as usize]);
        }
        assert_eq!(validator().validate(&good, 4), Ok(Acceptance::default()));
    }

    #[test]
    fn repeated_and_overtaken_commands_are_stale_and_gaps_are_counted() {
        let mut validator = validator();
        assert_eq!(validator.validate(&command(1, 1, 1, 0.0), 1), Ok(Acceptance::default()));
        assert_eq!(validator.validate(&command(1, 1, 1, 0.0), 2), Err(Refusal::Stale));
        assert_eq!(validator.validate(&command(1, 4, 4, 0.0), 4), Ok(Acceptance { lost: 2, takeover: false }));
        assert_eq!(validator.validate(&command(1, 3, 3, 0.0), 4), Err(Refusal::Stale));
    }

    /// Each case: number and answered sensors of the commands that arrive of a controller, and how many are lost in all. A pause repeats
    /// the sensors, and the plant reads only the newest of the answers.
    #[test]
    fn a_gap_counts_answers_that_never_arrived_and_not_their_repeats() {
        let cases: [(&[(u64, u64)], u64); 7] = [
            (&[(1, 1), (2, 2), (33, 3), (34, 4)], 0), // 30 repeats before the newest answer to sensors 3
            (&[(1, 1), (2, 2), (33, 2), (34, 3)], 0), // 30 repeats of an answer that had arrived
            (&[(1, 1), (4, 4)], 2),
            (&[(1, 1), (33, 3)], 1), // the answer to sensors 2 is lost, that to sensors 3 was repeated
            (&[(1, 1), (2, 9)], 0),  // the controller was late and left out sensors 2 to 8
            (&[(1, 1), (3, 9)], 1),
            (&[(1, 4), (3, 2)], 0), // a controller that answers old sensors
        ];
        for (arriving, lost) in cases {
            let mut validator = validator();
            let found = |&(seq, ack): &(u64, u64)| validator.validate(&command(1, seq, ack, 0.0), 9).map(|it| it.lost);
            assert_eq!(arriving.iter().map(found).sum::<Result<u64, _>>(), Ok(lost), "{arriving:?}");
        }
    }

    #[test]
    fn commands_of_a_replaced_controller_are_refused() {
        let mut validator = validator();
        assert_eq!(validator.validate(&command(1, 9, 1, 0.0), 1), Ok(Acceptance::default()));
        assert_eq!(validator.validate(&command(2, 1, 2, 0.0), 2), Ok(Acceptance { lost: 0, takeover: true }));
        assert_eq!(validator.validate(&command(1, 10, 2, 0.0), 2), Err(Refusal::Owner));
        assert_eq!(validator.validate(&command(2, 2, 2, 0.0), 2), Ok(Acceptance::default()));
    }

    /// A million commands with random faults. Every accepted command is finite, within four times the limit, of this run, and newer than
    /// the last one.
    #[test]
    fn only_valid_torques_are_accepted_of_any_commands() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut random = fastrand::Rng::with_seed(seed);
        let (mut validator, mut newest, mut passed, mut refused) = (validator(), (0, 0), 0, [0; REFUSALS.len()]);
        let flawed = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 200.0, -130.0];
        for now in 1..=1_000_000 {
            // a new controller takes over every thousand periods
            let epoch = 1 + now / 1000;
            let mut c = command(epoch, now, now, 80.0 * random.f64() - 40.0);
            let joint = random.usize(0..8);
            match random.u32(0..12) {
                0 => c.torques.torque[joint] = flawed[random.usize(0..flawed.len())],
                1 => c.stamp.seq = random.u64(0..now + 5),
                2 => c.stamp.ack = now + random.u64(0..5),
                3 => c.stamp.run = random.u64(0..10),
                4 => c.stamp.epoch = epoch - 1,
                _ => (),
            }
            let mut c = c.sealed();
            match random.u32(0..12) {
                0 => {
                    c.torques.torque[joint] = f64::from_bits(c.torques.torque[joint].to_bits() ^ 1 << random.u32(0..64))
                }
                1 => c.stamp.schema ^= 1 << random.u32(0..64),
                2 => c.stamp.check ^= 1 << random.u32(0..32),
                _ => (),
            }
            match validator.validate(&c, now) {
                Ok(_) => {
                    let Stamp { run, epoch, seq, ack, .. } = c.stamp;
                    assert!(c.torques.torque.iter().all(|torque| torque.abs() <= 160.0) && run == RUN, "{c:?}");
                    assert!(epoch != newest.0 || seq > newest.1, "{c:?}");
                    assert!(ack <= now, "{c:?}");
                    newest = (epoch, seq);
                    passed += 1;
                }
                Err(reason) => refused[reason as usize] += 1,
            }
        }
        assert!(passed > 100_000 && refused.iter().all(|count| *count > 100), "{passed} passed, refused {refused:?}");
    }
}
