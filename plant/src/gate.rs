//! The accept gate: which commands may reach the drives.
//!
//! It looks in the order of [`REFUSALS`](messages::wire::REFUSALS), from whom to what: version, run, owner, check sum,
//! number, sensors answered, torques. Each refusal has a counter; a refused command leaves no trace beside it.

use messages::wire::{Command, Stamped, Torques};

/// Torques beyond this many times the drives' limit are nonsense; up to it the drives clamp.
const NONSENSE: f64 = 4.0;
/// From limit to limit is the farthest that an honest command moves in one control period, in limits.
const FULL_SWING: f64 = 2.0;
/// Replaced controllers that are remembered.
const RETIRED: usize = 8;

/// Why a command is refused; the order is that of [`REFUSALS`](messages::wire::REFUSALS).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Magic or schema hash are not ours.
    Version,
    /// Meant for another run.
    Run,
    /// From a controller whose place another has taken.
    Owner,
    /// The check sum is wrong.
    Damaged,
    /// Not newer than the last accepted one: late, or seen before.
    Stale,
    /// Answers sensors not yet sent.
    Early,
    /// A torque is no number.
    NotFinite,
    /// A torque that no drive has.
    TooStrong,
    /// A torque that jumps farther than from limit to limit.
    TooSteep,
}

/// What an accepted command brought beside its torques.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Admission {
    /// Commands before it that never came.
    pub lost: u64,
    /// Whether it is the first of another controller process.
    pub takeover: bool,
}

/// The gate of one run.
#[derive(Clone, Debug)]
pub struct Gate {
    run: u64,
    /// Torque limit of the drives [N·m].
    limit: f64,
    /// Epoch and number of the last accepted command.
    owner: Option<(u64, u64)>,
    torques: Torques,
    retired: [Option<u64>; RETIRED],
}

impl Gate {
    /// For commands of the run `run` to drives of `limit` [N·m].
    pub fn new(run: u64, limit: f64) -> Gate {
        Gate { run, limit, owner: None, torques: Torques::default(), retired: [None; RETIRED] }
    }

    /// Lets a command pass that comes while the newest sensors sent are number `now`.
    ///
    /// A controller with another epoch takes over; that it may is the port's to see to, which has one place for
    /// controllers. What the one before left on its way then comes too late.
    ///
    /// # Errors
    /// The first reason to refuse it.
    pub fn admit(&mut self, command: &Command, now: u64) -> Result<Admission, Refusal> {
        let (stamp, torque) = (&command.stamp, &command.torques.torque);
        let owner = self.owner.filter(|(epoch, _)| *epoch == stamp.epoch);
        let jump = |(torque, before): (&f64, &f64)| (torque - before).abs();
        let reason = if !command.is_ours() {
            Refusal::Version
        } else if stamp.run != self.run {
            Refusal::Run
        } else if owner.is_none() && self.retired.contains(&Some(stamp.epoch)) {
            Refusal::Owner
        } else if !command.is_sound() {
            Refusal::Damaged
        } else if owner.is_some_and(|(_, seq)| stamp.seq <= seq) {
            Refusal::Stale
        } else if stamp.ack > now {
            Refusal::Early
        } else if !torque.iter().all(|torque| torque.is_finite()) {
            Refusal::NotFinite
        } else if torque.iter().any(|torque| torque.abs() > NONSENSE * self.limit) {
            Refusal::TooStrong
        } else if torque.iter().zip(&self.torques.torque).map(jump).any(|jump| jump > FULL_SWING * self.limit) {
            Refusal::TooSteep
        } else {
            return Ok(self.accept(command, owner));
        };
        Err(reason)
    }

    fn accept(&mut self, command: &Command, owner: Option<(u64, u64)>) -> Admission {
        let before = self.owner.replace((command.stamp.epoch, command.stamp.seq));
        self.torques.torque = command.torques.torque.map(|torque| torque.clamp(-self.limit, self.limit));
        match (owner, before) {
            (Some((_, seq)), _) => Admission { lost: command.stamp.seq - seq - 1, takeover: false },
            (None, Some((epoch, _))) => {
                self.retired.rotate_right(1);
                self.retired[0] = Some(epoch);
                Admission { lost: 0, takeover: true }
            }
            (None, None) => Admission::default(),
        }
    }
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

    fn gate() -> Gate {
        Gate::new(RUN, 40.0)
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
            assert_eq!(gate().admit(&bad, 4), Err(reason), "{}", REFUSALS[reason as usize]);
        }
        assert_eq!(gate().admit(&good, 4), Ok(Admission::default()));
    }

    #[test]
    fn what_was_seen_or_overtaken_is_stale_and_gaps_are_counted() {
        let mut gate = gate();
        assert_eq!(gate.admit(&command(1, 1, 1, 0.0), 1), Ok(Admission::default()));
        assert_eq!(gate.admit(&command(1, 1, 1, 0.0), 2), Err(Refusal::Stale));
        assert_eq!(gate.admit(&command(1, 4, 2, 0.0), 2), Ok(Admission { lost: 2, takeover: false }));
        assert_eq!(gate.admit(&command(1, 3, 2, 0.0), 2), Err(Refusal::Stale));
    }

    #[test]
    fn a_replaced_controller_never_comes_back() {
        let mut gate = gate();
        assert_eq!(gate.admit(&command(1, 9, 1, 0.0), 1), Ok(Admission::default()));
        assert_eq!(gate.admit(&command(2, 1, 2, 0.0), 2), Ok(Admission { lost: 0, takeover: true }));
        assert_eq!(gate.admit(&command(1, 10, 2, 0.0), 2), Err(Refusal::Owner));
        assert_eq!(gate.admit(&command(2, 2, 2, 0.0), 2), Ok(Admission::default()));
    }

    /// A million commands with random flaws: what passes is finite, within four limits, of the run, and never older.
    #[test]
    fn whatever_comes_only_sane_torques_pass() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut random = fastrand::Rng::with_seed(seed);
        let (mut gate, mut newest, mut passed, mut refused) = (gate(), (0, 0), 0, [0; REFUSALS.len()]);
        let flawed = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 200.0, -130.0];
        for now in 1..=1_000_000 {
            // every so often a new controller takes over
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
            match gate.admit(&c, now) {
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
