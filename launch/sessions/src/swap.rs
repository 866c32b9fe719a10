//! Hot swap: another controller takes the robot over while it walks.
//!
//! A successor is started while the one before still drives, and waits for its place, all else being ready. When it is
//! time the one before is asked to end, and the place is free. In lockstep the plant's desk lets time stand still at that
//! very control period, until the successor drives. In real time the watchdog bridges the gap. The plant moves from the
//! torques of the one to those of the other (`plant/src/handover.rs`).

use crate::children::{self, Role};
use messages::port::{Action, Contract, Pace, ask};
use messages::session::Session;
use messages::wire::Stamp;
use nix::unistd::{Pid, getpgid};
use shared::exit::{Exit, Failure};
use std::collections::VecDeque;
use std::str::FromStr;
use std::time::{Duration, Instant};

/// What a successor still needs once it is a member of the session.
const SETTLING: Duration = Duration::from_millis(100);
/// Members are looked for this often.
const LOOK: Duration = Duration::from_millis(20);
/// Time for the one before to leave in order.
const LEAVE: Duration = Duration::from_secs(2);

/// When which program takes over.
#[derive(Clone, Debug, PartialEq)]
pub struct Swap {
    /// Simulated time [s].
    pub time: f64,
    /// As of `--controller`.
    pub command: String,
}

impl FromStr for Swap {
    type Err = String;

    fn from_str(text: &str) -> Result<Swap, String> {
        let parts = text.split_once('=').and_then(|(time, command)| Some((time.trim().parse().ok()?, command.trim())));
        match parts {
            Some((time, command)) if (0.0..f64::INFINITY).contains(&time) && !command.is_empty() => {
                Ok(Swap { time, command: command.into() })
            }
            _ => Err("a simulated time and a command are needed, such as 3=\"python3 walk.py\"".into()),
        }
    }
}

/// The controllers that are still to come.
pub struct Succession {
    session: Session,
    contract: Contract,
    /// With one that does not join.
    patience: Duration,
    left: VecDeque<Swap>,
    /// The next one.
    heir: Option<Heir>,
    looked: Instant,
}

struct Heir {
    role: Role,
    started: Instant,
    /// Since when it has been a member of the session.
    joined: Option<Instant>,
}

impl Succession {
    /// In order of time.
    pub fn new(swaps: &[Swap], session: &Session, contract: &Contract, patience: Duration) -> Succession {
        let mut left = swaps.to_vec();
        left.sort_by(|a, b| a.time.total_cmp(&b.time));
        let (left, session) = (left.into(), session.clone());
        Succession { session, contract: *contract, patience, left, heir: None, looked: Instant::now() }
    }

    /// Looks whether it is time for the next one, by the stamp of the latest truth, and lets it take the incumbent's place.
    ///
    /// # Errors
    /// If it cannot be started, or fails before its time.
    pub fn look(
        &mut self,
        now: &Stamp,
        incumbent: &mut Role,
        start: impl FnOnce(&str) -> Result<Role, Failure>,
        mut meanwhile: impl FnMut(),
    ) -> Result<(), Failure> {
        let Some(next) = self.left.front().cloned().filter(|_| now.seq > 0) else { return Ok(()) };
        if self.heir.is_none() {
            self.heir = Some(Heir { role: start(&next.command)?, started: Instant::now(), joined: None });
            self.stand_still_at(next.time);
        }
        let is_ready = self.is_ready()?; // or it has failed
        let is_due = is_ready && now.sim_ns as f64 * 1e-9 >= next.time - 0.5 / self.contract.rate;
        if let Some(heir) = self.heir.take_if(|_| is_due) {
            incumbent.ask_to_end();
            children::wait(std::slice::from_mut(incumbent), LEAVE, &mut meanwhile);
            *incumbent = heir.role; // whoever has not left is killed
            self.left.pop_front();
            if self.left.is_empty() && self.contract.pace == Pace::Lockstep {
                let _ = ask(&self.session, Action::Resume);
            }
        }
        Ok(())
    }

    /// In lockstep, lets time run to this one [s], and stand still there. A plant without a desk goes on.
    fn stand_still_at(&self, time: f64) {
        if self.contract.pace == Pace::RealTime {
            return;
        }
        if let Ok(reply) = ask(&self.session, Action::Pause) {
            let there = ((time * self.contract.rate).round() as u64).saturating_add(1);
            let periods = there.saturating_sub(reply.stamp.seq);
            let _ = (periods > 0).then(|| ask(&self.session, Action::Step { periods }));
        }
    }

    /// Whether the next one waits for nothing but its place.
    fn is_ready(&mut self) -> Result<bool, Failure> {
        let Some(heir) = &mut self.heir else { return Ok(false) };
        if heir.role.ended().is_some() {
            heir.role.verdict()?;
            return Err(Failure::new(Exit::PeerMissing, "the successor ended before its turn came"));
        }
        if heir.joined.is_none() && self.looked.elapsed() > LOOK {
            self.looked = Instant::now();
            let group = heir.role.number();
            let of_it = |member: u32| i32::try_from(member).is_ok_and(|member| group_of(member) == group);
            heir.joined = self.session.members().into_iter().any(of_it).then(Instant::now);
        }
        if heir.joined.is_none() && heir.started.elapsed() > self.patience {
            let words = format!("the successor did not join within {:?}", self.patience);
            return Err(Failure::new(Exit::PeerMissing, words));
        }
        Ok(heir.joined.is_some_and(|joined| joined.elapsed() > SETTLING))
    }

    /// What has not come about.
    pub fn rest(&self) -> Option<String> {
        let next = self.left.front()?;
        Some(format!("`{}` was to take over at t {} s, but did not", next.command, next.time))
    }
}

/// Number of a process's group; 0 if it has ended.
fn group_of(member: i32) -> u32 {
    getpgid(Some(Pid::from_raw(member))).map_or(0, |group| group.as_raw().unsigned_abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swap_is_a_time_and_a_command() {
        let good = Swap { time: 2.5, command: "python3 a=b.py".into() };
        assert_eq!("2.5=python3 a=b.py".parse(), Ok(good));
        for bad in ["python3", "=x", "-1=x", "NaN=x", "3="] {
            assert!(bad.parse::<Swap>().is_err(), "{bad}");
        }
    }
}
