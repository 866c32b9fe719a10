//! The processor that both sides of a lockstep connection share while the machine is busy.

use super::busy_detector::Machine;
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::unistd::Pid;

/// Places the calling thread on its own processors, or on the one that both sides share.
#[derive(Debug)]
pub(super) struct Placement {
    shared: CpuSet,
    /// The processors of the thread before it moved to the shared one.
    own: Option<CpuSet>,
}

impl Placement {
    /// The shared processor has this number.
    pub fn new(processor: usize) -> Placement {
        let mut shared = CpuSet::new();
        let _ = shared.set(processor); // the system ignores an empty set
        Placement { shared, own: None }
    }

    /// Moves the thread: to the shared processor on a busy machine, back on an idle one. If the system refuses it, the thread stays where
    /// it is, and only the speed suffers.
    pub fn apply(&mut self, machine: Machine) {
        let target = match machine {
            Machine::Busy => {
                self.own = sched_getaffinity(CALLER).ok();
                Some(self.shared)
            }
            Machine::Idle => self.own.take(),
        };
        let _ = target.map(|processors| sched_setaffinity(CALLER, &processors));
    }
}

/// The calling thread.
const CALLER: Pid = Pid::from_raw(0);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_moves_to_the_shared_processor_and_back() {
        let own = sched_getaffinity(CALLER).expect("processors");
        let last = (0..CpuSet::count()).rev().find(|cpu| own.is_set(*cpu) == Ok(true)).expect("a processor");
        let mut placement = Placement::new(last);
        for _ in 0..2 {
            placement.apply(Machine::Busy);
            assert_eq!(sched_getaffinity(CALLER).expect("processors"), placement.shared);
            placement.apply(Machine::Idle);
            assert_eq!(sched_getaffinity(CALLER).expect("processors"), own);
        }
    }
}
