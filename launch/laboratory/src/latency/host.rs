//! The machine, and its other load during the measurement.

use serde::Serialize;
use std::fmt;

/// Share of time taken by the hypervisor above which the results are invalid.
const STEAL: f64 = 0.01;
/// Share of time taken by other programs above which the results get a remark.
const OTHERS: f64 = 0.1;

/// The machine, and how its processor time was used.
#[derive(Clone, Debug, Serialize)]
pub struct Host {
    pub processor: String,
    pub processors: usize,
    pub kernel: String,
    /// Share of processor time that the hypervisor gave to other guests.
    pub steal: f64,
    /// Share taken by other programs on this machine.
    pub others: f64,
    #[serde(skip)]
    begin: ProcessorTimes,
}

/// Processor time since boot [ticks].
#[derive(Clone, Copy, Debug, Default)]
struct ProcessorTimes {
    all: f64,
    idle: f64,
    steal: f64,
    ours: f64,
}

impl Host {
    /// This machine; its load is measured from now on.
    pub fn watch() -> Host {
        let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
        let info = read("/proc/cpuinfo");
        let name = info
            .lines()
            .find_map(|line| line.strip_prefix("model name"))
            .map_or("unknown processor", |rest| rest.trim_start_matches([' ', '\t', ':']));
        Host {
            processor: name.into(),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            kernel: read("/proc/sys/kernel/osrelease").trim().into(),
            steal: 0.0,
            others: 0.0,
            begin: ProcessorTimes::now(),
        }
    }

    /// Ends the measurement of load, after every process of ours has been reaped.
    pub fn finish(&mut self) {
        let (begin, end) = (self.begin, ProcessorTimes::now());
        let all = (end.all - begin.all).max(1.0);
        self.steal = (end.steal - begin.steal) / all;
        let busy = all - (end.idle - begin.idle) - (end.steal - begin.steal);
        self.others = ((busy - (end.ours - begin.ours)) / all).clamp(0.0, 1.0);
    }

    /// Whether the results are valid.
    pub fn is_valid(&self) -> bool {
        self.steal <= STEAL
    }

    /// An assessment of the results.
    pub fn remark(&self) -> String {
        let [steal, others] = [self.steal, self.others].map(|share| 100.0 * share);
        if !self.is_valid() {
            return format!("INVALID: the hypervisor gave {steal:.1} % of the time to others");
        }
        let busy = if self.others > OTHERS { "busy: look at medians and ratios only; " } else { "" };
        format!("{busy}other programs took {others:.0} % of the time, the hypervisor {steal:.1} %")
    }
}

impl fmt::Display for Host {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} x {}, Linux {}; {}", self.processors, self.processor, self.kernel, self.remark())
    }
}

impl ProcessorTimes {
    fn now() -> ProcessorTimes {
        // cpu user nice system idle iowait irq softirq steal …, man proc_stat
        let stat = std::fs::read_to_string("/proc/stat").unwrap_or_default();
        let first = stat.lines().next().unwrap_or_default();
        let ticks: Vec<f64> =
            first.split_whitespace().skip(1).take(8).map(|word| word.parse().unwrap_or(0.0)).collect();
        let at = |i: usize| ticks.get(i).copied().unwrap_or(0.0);
        ProcessorTimes { all: ticks.iter().sum(), idle: at(3) + at(4), steal: at(7), ours: Usage::of("self").ticks }
    }
}

/// Resources that a process has used.
#[derive(Clone, Copy, Debug, Default)]
pub struct Usage {
    /// Minor and major page faults.
    pub faults: [f64; 2],
    /// Voluntary and involuntary context switches.
    pub switches: [f64; 2],
    /// Processor time, including its reaped children.
    ticks: f64,
}

impl Usage {
    /// Usage by the process with this number; zeros if the process does not exist.
    pub fn of(process: &str) -> Usage {
        let read = |name: &str| std::fs::read_to_string(format!("/proc/{process}/{name}")).unwrap_or_default();
        // Fields 10, 12 and 14 to 17 of man proc_pid_stat. The process name before them may contain any character.
        let stat = read("stat");
        let fields: Vec<f64> =
            stat.rsplit(')').next().unwrap_or_default().split_whitespace().map(|w| w.parse().unwrap_or(0.0)).collect();
        let at = |number: usize| fields.get(number - 3).copied().unwrap_or(0.0);
        let status = read("status");
        let line = |name: &str| {
            let found = status.lines().find_map(|line| line.strip_prefix(name));
            found.and_then(|rest| rest.trim().parse().ok()).unwrap_or(0.0)
        };
        Usage {
            faults: [at(10), at(12)],
            switches: [line("voluntary_ctxt_switches:"), line("nonvoluntary_ctxt_switches:")],
            ticks: (14..=17).map(at).sum(),
        }
    }

    /// The difference since an earlier reading.
    pub fn since(self, before: Usage) -> Usage {
        let less = |now: [f64; 2], then: [f64; 2]| [(now[0] - then[0]).max(0.0), (now[1] - then[1]).max(0.0)];
        Usage {
            faults: less(self.faults, before.faults),
            switches: less(self.switches, before.switches),
            ticks: self.ticks - before.ticks,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_sees_itself_work() {
        let before = Usage::of("self");
        let memory = std::hint::black_box(vec![1_u8; 64 << 20]);
        std::thread::sleep(std::time::Duration::from_millis(2));
        let used = Usage::of("self").since(before);
        assert!(used.faults[0] > 100.0 && memory.len() > 1, "{used:?}");
        assert!(Usage::of("no-such-process").faults == [0.0; 2]);
    }

    #[test]
    fn steal_makes_figures_invalid() {
        let mut host = Host::watch();
        host.finish();
        assert!(Host { steal: 0.0, ..host.clone() }.is_valid());
        let stolen = Host { steal: 0.05, ..host };
        assert!(!stolen.is_valid() && stolen.remark().contains("5.0 %"), "{}", stolen.remark());
    }
}
