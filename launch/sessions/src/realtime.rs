//! What a process asks of the system before a real-time loop: no paging, no early eviction, its own processor.

use crate::place::{Place, Right};
use clap::Args;
use messages::port::Pace;
use nix::errno::Errno;
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::sys::mman::{MlockAllFlags, mlockall};
use nix::sys::prctl::set_timerslack;
use nix::unistd::Pid;
use serde::{Deserialize, Serialize};
use shared::exit::{Exit, Failure};
use std::hint::black_box;
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};

/// Priority under SCHED_FIFO when none is given: above the kernel's interrupt threads (50), below its watchdogs (99).
const PRIORITY: u8 = 80;
/// Stack that is touched beforehand, so that no call meets a new page in the loop [bytes].
const STACK: usize = 512 << 10;

/// How hard a process asks for real time.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RealtimeArgs {
    /// Lock memory and use the real-time scheduler SCHED_FIFO, at this priority (80 if none is given). Says of each step
    /// whether the system granted it; with `require`, a refusal is an error
    #[arg(long, value_name = "PRIO|require", num_args = 0..=1, require_equals = true, default_missing_value = "80",
        value_parser = wish)]
    rt: Option<Wish>,
    /// Stay on this processor; under `run` that is the plant's, and the controller takes the next one
    #[arg(long, value_name = "N")]
    cpu: Option<usize>,
}

/// Value of `--rt`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Wish {
    At(u8),
    Require,
}

fn wish(text: &str) -> Result<Wish, String> {
    match text.parse() {
        Ok(priority @ 1..=99) => Ok(Wish::At(priority)),
        _ if text == "require" => Ok(Wish::Require),
        _ => Err("a priority from 1 to 99 is needed, or `require`".into()),
    }
}

/// One thing that the system may refuse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Memory,
    Stack,
    Processor(usize),
    Fifo(u8),
}

impl Step {
    fn name(self) -> String {
        match self {
            Step::Memory => "memory locked".into(),
            Step::Stack => format!("{} kB of stack touched", STACK >> 10),
            Step::Processor(number) => format!("processor {number}"),
            Step::Fifo(priority) => format!("SCHED_FIFO at priority {priority}"),
        }
    }

    fn ask(self) -> Result<(), Errno> {
        match self {
            Step::Memory => mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE),
            Step::Stack => {
                black_box([0_u8; STACK]);
                Ok(())
            }
            Step::Processor(number) => {
                let mut only = CpuSet::new();
                only.set(number).and_then(|()| sched_setaffinity(Pid::from_raw(0), &only))
            }
            Step::Fifo(priority) => fifo(priority),
        }
    }

    /// The line that makes the system grant it.
    fn remedy(self) -> String {
        match self {
            Step::Memory => Place::here().grants(Right::Memory),
            Step::Stack => "`ulimit -s unlimited`".into(),
            Step::Processor(_) => format!("--cpu with one of those that `taskset -cp {}` names", std::process::id()),
            Step::Fifo(priority) => Place::here().grants(Right::Fifo(priority)),
        }
    }
}

fn fifo(priority: u8) -> Result<(), Errno> {
    let priority = priority.try_into().map(ThreadPriority::Crossplatform).map_err(|_| Errno::EINVAL)?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| match error {
        thread_priority::Error::OS(code) => Errno::from_raw(code),
        _ => Errno::EINVAL,
    })
}

impl RealtimeArgs {
    /// A real-time scheduler and a loop that never rests would take a processor from everybody: only what the clock
    /// paces may have it.
    ///
    /// # Errors
    /// `--rt` in lockstep.
    pub fn suits(self, pace: Pace) -> Result<(), Failure> {
        match (self.rt, pace) {
            (Some(_), Pace::Lockstep) => Err(Failure::new(
                Exit::Usage,
                "--rt needs --realtime: in lockstep nothing has a deadline, and the two processes never rest",
            )),
            _ => Ok(()),
        }
    }

    /// Asks the system for everything wished, for the calling thread and its memory; to be called when all memory is
    /// there and before the loop begins. Returns a line for each step.
    ///
    /// # Errors
    /// With `--rt=require`, the first refusal.
    pub fn prepare(self) -> Result<Vec<String>, Failure> {
        let mut lines = vec![];
        for step in self.steps() {
            match step.ask() {
                Ok(()) => lines.push(format!("real time: {}: granted", step.name())),
                Err(errno) => {
                    let words =
                        format!("{}: refused ({}); what would grant it: {}", step.name(), errno.desc(), step.remedy());
                    if self.rt == Some(Wish::Require) {
                        return Err(Failure::new(Exit::Refused, format!("--rt=require: {words}")));
                    }
                    lines.push(format!("real time: {words}"));
                }
            }
        }
        Ok(lines)
    }

    fn steps(self) -> Vec<Step> {
        let fifo = self.rt.map(|wish| match wish {
            Wish::At(priority) => Step::Fifo(priority),
            Wish::Require => Step::Fifo(PRIORITY),
        });
        // The scheduler comes last: nothing that takes long is done under it.
        let memory = fifo.map(|_| [Step::Memory, Step::Stack]);
        memory.into_iter().flatten().chain(self.cpu.map(Step::Processor)).chain(fifo).collect()
    }

    /// The same wishes for a child of `run`: plant (0) or controller (1), on a processor of its own.
    pub fn of_child(self, child: usize) -> RealtimeArgs {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        // One that does not exist is left for the system to refuse.
        let next = |cpu| if cpu < processors { (cpu + child) % processors } else { cpu };
        RealtimeArgs { cpu: self.cpu.map(next), ..self }
    }

    /// Them as arguments.
    pub fn arguments(self) -> Vec<String> {
        let rt = self.rt.map(|wish| match wish {
            Wish::At(priority) => format!("--rt={priority}"),
            Wish::Require => "--rt=require".into(),
        });
        rt.into_iter().chain(self.cpu.map(|cpu| format!("--cpu={cpu}"))).collect()
    }
}

/// What would grant locked memory and the real-time scheduler, if the system refuses them; for a thread of its own, which
/// gets what is granted.
pub fn refusals() -> [Option<String>; 2] {
    [Step::Memory, Step::Fifo(PRIORITY)].map(|step| step.ask().err().map(|_| step.remedy()))
}

/// Keeps the calling thread to the first (0), second (1) … of the processors that it may use, if there are so many.
pub fn keep_to(nth: usize) {
    confine(usable().into_iter().skip(nth).take(1));
}

/// Keeps the calling thread to every second of the processors that it may use, beginning with the first (0) or second (1), if
/// there are two: both sides of a lockstep run spin, and if the scheduler puts them on one, a period takes twice as long.
pub fn keep_apart(side: usize) {
    let usable = usable();
    if usable.len() > 1 {
        confine(usable.into_iter().skip(side).step_by(2));
    }
}

/// Processors that the calling thread may use.
fn usable() -> Vec<usize> {
    let allowed = sched_getaffinity(Pid::from_raw(0)).unwrap_or_default();
    (0..CpuSet::count()).filter(|cpu| allowed.is_set(*cpu) == Ok(true)).collect()
}

/// Lets the calling thread use these alone. None at all are refused by the system.
fn confine(processors: impl Iterator<Item = usize>) {
    let mut only = CpuSet::new();
    processors.for_each(|cpu| _ = only.set(cpu));
    let _ = sched_setaffinity(Pid::from_raw(0), &only);
}

/// Lets the calling thread's sleeps end on time: by default Linux may end them 50 µs late, to save power.
pub fn wake_on_time() {
    // Refused by no system that has it; if it were, sleeps would only be as late as before.
    let _ = set_timerslack(1);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wish_is_a_priority_or_to_require_one() {
        assert_eq!((wish("1"), wish("99"), wish("require")), (Ok(Wish::At(1)), Ok(Wish::At(99)), Ok(Wish::Require)));
        for bad in ["0", "100", "-1", "", "yes"] {
            assert!(wish(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn children_get_the_same_wishes_on_processors_of_their_own() {
        let args = RealtimeArgs { rt: Some(Wish::At(70)), cpu: Some(0) };
        assert_eq!(args.of_child(0).arguments(), ["--rt=70", "--cpu=0"]);
        let other = std::thread::available_parallelism().map_or(1, usize::from).min(2) - 1;
        assert_eq!(args.of_child(1).arguments(), ["--rt=70".to_string(), format!("--cpu={other}")]);
        assert!(RealtimeArgs::default().of_child(1).arguments().is_empty());
    }

    #[test]
    fn the_scheduler_is_asked_last_and_only_if_wished() {
        let all = RealtimeArgs { rt: Some(Wish::Require), cpu: Some(1) }.steps();
        assert_eq!(all, [Step::Memory, Step::Stack, Step::Processor(1), Step::Fifo(PRIORITY)]);
        assert!(RealtimeArgs::default().steps().is_empty());
    }

    #[test]
    fn a_processor_that_does_not_exist_is_refused_with_advice() {
        let step = Step::Processor(1000);
        assert_eq!(step.ask(), Err(Errno::EINVAL));
        assert!(step.remedy().contains("taskset -cp"));
    }
}
