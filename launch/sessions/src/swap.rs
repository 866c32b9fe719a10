//! Hot swap: another controller takes over the robot while it walks.
//!
//! The successor is started while its predecessor is still in control. It initializes itself, joins the session, and waits for the
//! place of the controller. When the time has come, the predecessor is terminated, which frees the place. In lockstep the plant is
//! paused at exactly that control period until the successor is in control. In real time the watchdog bridges the gap. The plant
//! blends from the torques of the predecessor to those of the successor (`plant/src/handover.rs`).

use crate::children::{self, RoleProcess};
use messages::legible;
use messages::port::{Action, Contract, Pace, ask};
use messages::session::Session;
use messages::wire::Stamp;
use nix::unistd::{Pid, getpgid};
use shared::exit::{Exit, Failure};
use std::collections::VecDeque;
use std::str::FromStr;
use std::time::{Duration, Instant};

/// Time that a successor needs from joining the session until it is ready.
const READY_DELAY: Duration = Duration::from_millis(100);
/// Interval at which the members of the session are listed.
const MEMBERS_POLL: Duration = Duration::from_millis(20);
/// Time that the predecessor has to exit after SIGTERM before it is killed.
const EXIT_TIMEOUT: Duration = Duration::from_secs(2);

/// One planned swap.
#[derive(Clone, Debug, PartialEq)]
pub struct Swap {
    /// Simulated time [s].
    pub time: f64,
    /// Command of the successor, as for `--controller`.
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

/// The swaps that are still to come.
pub struct SwapSchedule {
    session: Session,
    contract: Contract,
    /// Time that a successor has to join the session.
    patience: Duration,
    pending: VecDeque<Swap>,
    /// The successor of the next swap, once it is started.
    successor: Option<Successor>,
    last_poll: Instant,
}

struct Successor {
    role: RoleProcess,
    started: Instant,
    /// When it was first seen as a member of the session.
    joined: Option<Instant>,
}

impl SwapSchedule {
    /// Sorts the swaps by time.
    pub fn new(swaps: &[Swap], session: &Session, contract: &Contract, patience: Duration) -> SwapSchedule {
        let mut pending = swaps.to_vec();
        pending.sort_by(|a, b| a.time.total_cmp(&b.time));
        let (pending, session) = (pending.into(), session.clone());
        SwapSchedule { session, contract: *contract, patience, pending, successor: None, last_poll: Instant::now() }
    }

    /// Starts the successor of the next swap if it is not started yet, and performs the swap when it is due. `now` is the stamp of the
    /// latest truth. `meanwhile` is called while the predecessor exits.
    ///
    /// # Errors
    /// If the successor cannot be started, or fails before it takes over.
    pub fn poll(
        &mut self,
        now: &Stamp,
        controller: &mut RoleProcess,
        start: impl FnOnce(&str) -> Result<RoleProcess, Failure>,
        mut meanwhile: impl FnMut(),
    ) -> Result<(), Failure> {
        let Some(next) = self.pending.front().cloned().filter(|_| now.seq > 0) else { return Ok(()) };
        if self.successor.is_none() {
            self.successor = Some(Successor { role: start(&next.command)?, started: Instant::now(), joined: None });
            self.pause_at(next.time);
        }
        let is_ready = self.is_ready()?;
        let half_period = 0.5 / self.contract.rate; // rounds to the nearest control period
        let is_due = is_ready && now.time() >= next.time - half_period;
        if let Some(successor) = self.successor.take_if(|_| is_due) {
            controller.terminate();
            children::wait_for_all(std::slice::from_mut(controller), EXIT_TIMEOUT, &mut meanwhile);
            *controller = successor.role; // dropping the predecessor kills it if it still runs
            self.pending.pop_front();
            if self.pending.is_empty() && self.contract.pace == Pace::Lockstep {
                let _ = ask(&self.session, Action::Resume);
            }
        }
        Ok(())
    }

    /// In lockstep, runs the plant up to a simulated time [s] and pauses it there. A plant without a control service runs on.
    fn pause_at(&self, time: f64) {
        if self.contract.pace == Pace::RealTime {
            return;
        }
        if let Ok(reply) = ask(&self.session, Action::Pause) {
            let target = ((time * self.contract.rate).round() as u64).saturating_add(1);
            let periods = target.saturating_sub(reply.stamp.seq);
            let _ = (periods > 0).then(|| ask(&self.session, Action::Step { periods }));
        }
    }

    /// Whether the successor is ready to take over.
    ///
    /// # Errors
    /// If it has exited, or does not join in time.
    fn is_ready(&mut self) -> Result<bool, Failure> {
        let Some(successor) = &mut self.successor else { return Ok(false) };
        if successor.role.try_wait().is_some() {
            successor.role.outcome()?;
            return Err(Failure::new(Exit::PeerMissing, "the successor exited before it took over"));
        }
        if successor.joined.is_none() && self.last_poll.elapsed() > MEMBERS_POLL {
            self.last_poll = Instant::now();
            let group = successor.role.pid(); // a foreign program leads a process group
            let is_in_group = |member: u32| i32::try_from(member).is_ok_and(|member| group_of(member) == group);
            successor.joined = self.session.members().into_iter().any(is_in_group).then(Instant::now);
        }
        if successor.joined.is_none() && successor.started.elapsed() > self.patience {
            let words = format!("the successor did not join within {} s", self.patience.as_secs_f64());
            return Err(Failure::new(Exit::PeerMissing, words));
        }
        Ok(successor.joined.is_some_and(|joined| joined.elapsed() > READY_DELAY))
    }

    /// A message about the first swap that has not been performed, if there is one.
    pub fn unfinished(&self) -> Option<String> {
        let next = self.pending.front()?;
        let has_started = self.successor.as_ref().is_some_and(|successor| successor.joined.is_some());
        let why = if has_started { "the run ended before" } else { "it did not start" };
        Some(format!("`{}` could not take over at t = {} s: {why}", next.command, legible(next.time)))
    }
}

/// ID of the process group of a process; 0 if it has exited.
fn group_of(member: i32) -> u32 {
    getpgid(Some(Pid::from_raw(member))).map_or(0, |group| group.as_raw().unsigned_abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swap_needs_a_time_and_a_command() {
        let good = Swap { time: 2.5, command: "python3 a=b.py".into() };
        assert_eq!("2.5=python3 a=b.py".parse(), Ok(good));
        for bad in ["python3", "=x", "-1=x", "NaN=x", "3="] {
            assert!(bad.parse::<Swap>().is_err(), "{bad}");
        }
    }
}
