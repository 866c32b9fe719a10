//! Real-time settings of a process, applied before its loop begins: locked memory, scheduler, processor affinity, timer slack.

use crate::host_environment::{HostEnvironment, Privilege};
use clap::Args;
use messages::port::Pace;
use messages::session::Session;
use messages::wire::{FNV_START, fnv1a};
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

/// Default priority under SCHED_FIFO: above the kernel's interrupt threads (50), below its watchdogs (99).
const DEFAULT_PRIORITY: u8 = 80;
/// Stack that is touched beforehand, so that no call in the loop causes a page fault [bytes].
const TOUCHED_STACK: usize = 512 << 10;

/// Real-time settings on the command line.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RealtimeArgs {
    /// Lock memory and use the real-time scheduler SCHED_FIFO at this priority (default: 80). Reports for each setting
    /// whether the system granted it; with `require`, a refusal is an error
    #[arg(long, value_name = "PRIO|require", num_args = 0..=1, require_equals = true, default_missing_value = "80",
        value_parser = parse_rt)]
    rt: Option<RtOption>,
    /// Run on this processor only; a command that starts both processes gives this one to the plant and the next one to the controller
    #[arg(long, value_name = "N")]
    cpu: Option<usize>,
}

/// Value of `--rt`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum RtOption {
    Priority(u8),
    Require,
}

fn parse_rt(text: &str) -> Result<RtOption, String> {
    match text.parse() {
        Ok(priority @ 1..=99) => Ok(RtOption::Priority(priority)),
        _ if text == "require" => Ok(RtOption::Require),
        _ => Err("a priority from 1 to 99 is needed, or `require`".into()),
    }
}

/// One setting that the system may refuse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Setting {
    LockMemory,
    TouchStack,
    Affinity(usize),
    Fifo(u8),
}

impl Setting {
    fn name(self) -> String {
        match self {
            Setting::LockMemory => "memory locked".into(),
            Setting::TouchStack => format!("{} kB of stack touched", TOUCHED_STACK >> 10),
            Setting::Affinity(number) => format!("processor {number}"),
            Setting::Fifo(priority) => format!("SCHED_FIFO at priority {priority}"),
        }
    }

    fn apply(self) -> Result<(), Errno> {
        match self {
            Setting::LockMemory => mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE),
            Setting::TouchStack => {
                black_box([0_u8; TOUCHED_STACK]);
                Ok(())
            }
            Setting::Affinity(number) => {
                let mut only = CpuSet::new();
                only.set(number).and_then(|()| sched_setaffinity(Pid::from_raw(0), &only))
            }
            Setting::Fifo(priority) => set_fifo(priority),
        }
    }

    /// Advice: how the user can get this setting granted.
    fn remedy(self) -> String {
        match self {
            Setting::LockMemory => HostEnvironment::detect().how_to_grant(Privilege::LockMemory),
            Setting::TouchStack => "`ulimit -s unlimited`".into(),
            Setting::Affinity(_) => format!("--cpu with one of the processors {}", ranges(&allowed_processors())),
            Setting::Fifo(priority) => HostEnvironment::detect().how_to_grant(Privilege::Fifo(priority)),
        }
    }
}

fn set_fifo(priority: u8) -> Result<(), Errno> {
    let priority = priority.try_into().map(ThreadPriority::Crossplatform).map_err(|_| Errno::EINVAL)?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| match error {
        thread_priority::Error::OS(code) => Errno::from_raw(code),
        _ => Errno::EINVAL,
    })
}

impl RealtimeArgs {
    /// Checks that the settings fit the pace. A lockstep loop never sleeps, so under a real-time scheduler it would block its
    /// processor for all other threads.
    ///
    /// # Errors
    /// If `--rt` is given in lockstep.
    pub fn check_pace(self, pace: Pace) -> Result<(), Failure> {
        match (self.rt, pace) {
            (Some(_), Pace::Lockstep) => Err(Failure::new(
                Exit::Usage,
                "--rt needs --realtime: in lockstep there are no deadlines, and the two processes never sleep",
            )),
            _ => Ok(()),
        }
    }

    /// Whether the user chose the processor, so that the process must not move.
    pub fn names_processor(self) -> bool {
        self.cpu.is_some()
    }

    /// Applies all settings to the calling thread and its memory. Call it after all memory is allocated and before the loop begins.
    /// Returns one line for each setting.
    ///
    /// # Errors
    /// With `--rt=require`, the first refused setting.
    pub fn apply(self) -> Result<Vec<String>, Failure> {
        let mut lines = vec![];
        for setting in self.settings() {
            match setting.apply() {
                Ok(()) => lines.push(format!("real time: {}: granted", setting.name())),
                Err(errno) => {
                    let (name, remedy) = (setting.name(), setting.remedy());
                    let words = format!("{name}: refused ({}); what would grant it: {remedy}", errno.desc());
                    if self.rt == Some(RtOption::Require) {
                        return Err(Failure::new(Exit::Refused, format!("--rt=require: {words}")));
                    }
                    lines.push(format!("real time: {words}"));
                }
            }
        }
        Ok(lines)
    }

    fn settings(self) -> Vec<Setting> {
        let fifo = self.rt.map(|option| match option {
            RtOption::Priority(priority) => Setting::Fifo(priority),
            RtOption::Require => Setting::Fifo(DEFAULT_PRIORITY),
        });
        // The scheduler comes last, because locking memory takes long and must not run under it.
        let memory = fifo.map(|_| [Setting::LockMemory, Setting::TouchStack]);
        memory.into_iter().flatten().chain(self.cpu.map(Setting::Affinity)).chain(fifo).collect()
    }

    /// The settings for a child of `run`: plant (0) or controller (1), each on its own processor.
    pub fn for_child(self, child: usize) -> RealtimeArgs {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        // A processor that does not exist stays unchanged: the system refuses it later.
        let next = |cpu| if cpu < processors { (cpu + child) % processors } else { cpu };
        RealtimeArgs { cpu: self.cpu.map(next), ..self }
    }

    /// The settings as command-line arguments.
    pub fn arguments(self) -> Vec<String> {
        let rt = self.rt.map(|option| match option {
            RtOption::Priority(priority) => format!("--rt={priority}"),
            RtOption::Require => "--rt=require".into(),
        });
        rt.into_iter().chain(self.cpu.map(|cpu| format!("--cpu={cpu}"))).collect()
    }
}

/// Tries to lock memory and to use the real-time scheduler. For each, returns the remedy if the system refuses it. Call it in a
/// separate thread, because granted settings stay in effect.
pub fn missing_privileges() -> [Option<String>; 2] {
    [Setting::LockMemory, Setting::Fifo(DEFAULT_PRIORITY)]
        .map(|setting| setting.apply().err().map(|_| setting.remedy()))
}

/// Pins the calling thread to the first (0), second (1), … of the processors that it may use, if there are that many.
pub fn pin_to_nth(nth: usize) {
    set_affinity(allowed_processors().into_iter().skip(nth).take(1));
}

/// Pins the calling thread to every second processor that it may use, beginning with the first (0) or the second (1), if there are two.
/// Both processes of a lockstep run spin; on the same processor, a period would take twice as long. Returns the processor on which
/// both sides of the session should meet while the machine is busy; sessions differ in it.
pub fn pin_to_half(side: usize, session: &Session) -> Option<usize> {
    let allowed = allowed_processors();
    if allowed.len() > 1 {
        set_affinity(allowed.iter().copied().skip(side).step_by(2));
    }
    let number = fnv1a(FNV_START, session.name().as_bytes()) as usize;
    allowed.get(number % allowed.len().max(1)).copied()
}

/// Processors that the calling thread may use.
fn allowed_processors() -> Vec<usize> {
    let allowed = sched_getaffinity(Pid::from_raw(0)).unwrap_or_default();
    (0..CpuSet::count()).filter(|cpu| allowed.is_set(*cpu) == Ok(true)).collect()
}

/// Ascending numbers as ranges, such as 0-3,8.
fn ranges(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|one, next| one + 1 == *next);
    let text = runs.map(|run| match run {
        [first, .., last] => format!("{first}-{last}"),
        _ => run.iter().map(usize::to_string).collect(),
    });
    text.collect::<Vec<_>>().join(",")
}

/// Sets the processors that the calling thread may use. The system ignores an empty set.
fn set_affinity(processors: impl Iterator<Item = usize>) {
    let mut set = CpuSet::new();
    processors.for_each(|cpu| _ = set.set(cpu));
    let _ = sched_setaffinity(Pid::from_raw(0), &set);
}

/// Smallest timer slack [ns]. Zero would restore the default.
const MIN_TIMER_SLACK: u64 = 1;

/// Minimizes the timer slack of the calling thread. By default Linux may extend a sleep by 50 µs to save power.
pub fn minimize_timer_slack() {
    // No known system refuses this; after a refusal, sleeps end as late as before.
    let _ = set_timerslack(MIN_TIMER_SLACK);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rt_takes_a_priority_or_require() {
        assert_eq!(
            (parse_rt("1"), parse_rt("99"), parse_rt("require")),
            (Ok(RtOption::Priority(1)), Ok(RtOption::Priority(99)), Ok(RtOption::Require))
        );
        for bad in ["0", "100", "-1", "", "yes"] {
            assert!(parse_rt(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn children_get_the_same_settings_on_different_processors() {
        let args = RealtimeArgs { rt: Some(RtOption::Priority(70)), cpu: Some(0) };
        assert_eq!(args.for_child(0).arguments(), ["--rt=70", "--cpu=0"]);
        let other = std::thread::available_parallelism().map_or(1, usize::from).min(2) - 1;
        assert_eq!(args.for_child(1).arguments(), ["--rt=70".to_string(), format!("--cpu={other}")]);
        assert!(RealtimeArgs::default().for_child(1).arguments().is_empty());
    }

    #[test]
    fn the_scheduler_is_set_last_and_only_on_request() {
        let all = RealtimeArgs { rt: Some(RtOption::Require), cpu: Some(1) }.settings();
        assert_eq!(
            all,
            [Setting::LockMemory, Setting::TouchStack, Setting::Affinity(1), Setting::Fifo(DEFAULT_PRIORITY)]
        );
        assert!(RealtimeArgs::default().settings().is_empty());
    }

    #[test]
    fn a_missing_processor_is_refused_with_a_remedy() {
        let setting = Setting::Affinity(1000);
        assert_eq!(setting.apply(), Err(Errno::EINVAL));
        let allowed = allowed_processors();
        let [first, last] = [allowed.first(), allowed.last()].map(|cpu| cpu.expect("one").to_string());
        let (remedy, words) = (setting.remedy(), format!("--cpu with one of the processors {first}"));
        assert!(remedy.starts_with(&words) && remedy.ends_with(&last), "{remedy}");
        assert_eq!(ranges(&[0, 1, 2, 3, 8, 10, 11]), "0-3,8,10-11");
    }
}
