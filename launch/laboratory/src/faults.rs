//! `biped faults`: injects every [`Fault`] into real processes. It checks that nothing hangs, that reports are correct, and that no files
//! or processes remain.
//!
//! | what | where |
//! |---|---|
//! | starting, finding and signalling processes | [`test_session`] |
//! | trials in parallel | [`parallel`] |
//! | kill −9, and restarted processes | [`kill`] |
//! | SIGSTOP, stalled recorders | [`stop`] |
//! | bad commands | [`commands`] |
//! | processes that do not belong to a session | [`peers`] |
//! | concurrent launchers, foreign files in place of the session's, and noisy controllers | [`neighbours`] |
//! | full shared memory | [`memory`] |
//! | a full disk under a recording | [`disk`] |

mod commands;
mod disk;
mod kill;
mod memory;
mod neighbours;
mod parallel;
mod peers;
mod stop;
pub mod test_session;

use clap::Args;
use parallel::in_parallel;
use shared::exit::{Exit, Failure, check_interrupt_after_results};
use shared::output::{prepare_folder, print_text, write_atomically, write_failure};
use shared::progress::BatchProgress;
use std::fmt;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;
use test_session::{FaultTrial, SessionRole, TrialOutcome};

/// Time limit for a restarted process to drive the robot.
const RESPAWN: Duration = Duration::from_millis(250);
/// Number of failures that are reported for each kind.
const MAX_LISTED: usize = 3;

/// Arguments of `biped faults`.
#[derive(Args)]
pub struct FaultsArgs {
    /// Few trials of each kind: takes half a minute
    #[arg(long)]
    quick: bool,
    /// Write the table into this folder, as faults.md and faults.csv
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed of the times and kinds of faults; default: random
    #[arg(long)]
    seed: Option<u64>,
    #[arg(from_global)]
    quiet: bool,
    /// Only the kinds of fault whose name contains this text
    #[arg(long, value_name = "WORDS")]
    only: Option<String>,
}

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    Kill(SessionRole),
    KillAtCall(SessionRole),
    KillAndRespawn(SessionRole),
    StopAndContinue(SessionRole),
    StopForEver(SessionRole),
    StoppedLauncher,
    StalledRecorder,
    FullMemory,
    FillingMemory,
    FullDisk,
    FilledDisk,
    FileLimit,
    Flood,
    EveryOther,
    Second(SessionRole),
    OtherContract,
    Race,
    ForeignFile,
    MuchOutput,
}

use Fault::*;
use SessionRole::{Controller, Launcher, Plant};

/// All kinds, with the number of trials of the full and of the quick run. [`KillAtCall`] has at most as many trials as there are calls.
const FAULTS: [(Fault, usize, usize); 28] = [
    (Second(Plant), 5, 1),
    (Second(Controller), 5, 1),
    (Second(Launcher), 5, 1),
    (OtherContract, 1, 1),
    (Race, 50, 2),
    (ForeignFile, 30, 3),
    (MuchOutput, 10, 1),
    (KillAndRespawn(Plant), 100, 2),
    (KillAndRespawn(Controller), 100, 2),
    (StopAndContinue(Plant), 10, 1),
    (StopAndContinue(Controller), 10, 1),
    (StopAndContinue(Launcher), 10, 1),
    (StopForEver(Plant), 10, 1),
    (StopForEver(Controller), 10, 1),
    (StoppedLauncher, 1, 0),
    (StalledRecorder, 1, 0),
    (FullMemory, 30, 2),
    (FillingMemory, 30, 2),
    (FullDisk, 10, 1),
    (FilledDisk, 10, 1),
    (FileLimit, 10, 1),
    (EveryOther, 1_000_000, 2_000),
    (Flood, 1_000_000, 2_000),
    (Kill(Plant), 1000, 4),
    (Kill(Controller), 1000, 4),
    (Kill(Launcher), 1000, 4),
    (KillAtCall(Plant), usize::MAX, 0),
    (KillAtCall(Controller), usize::MAX, 0),
];

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Kill(role) => write!(f, "kill -9 of the {} at a random time", role.title()),
            KillAtCall(role) => write!(f, "kill -9 of the {} at a system call", role.title()),
            KillAndRespawn(role) => write!(f, "kill -9 of the {}, restarted", role.title()),
            StopAndContinue(role) => write!(f, "{} stopped for up to 2 s", role.title()),
            StopForEver(role) => write!(f, "{} stopped for ever", role.title()),
            StoppedLauncher => f.write_str("launcher stopped until the others have ended"),
            StalledRecorder => f.write_str("recorder stopped in real time"),
            FullMemory => f.write_str("/dev/shm too small"),
            FillingMemory => f.write_str("/dev/shm filled meanwhile"),
            FullDisk => f.write_str("disk of a recording too small"),
            FilledDisk => f.write_str("disk of a recording filled meanwhile"),
            FileLimit => f.write_str("recording that reaches the limit of files"),
            Flood => f.write_str("bad commands beside good ones"),
            EveryOther => f.write_str("bad commands instead of good ones"),
            Second(role) => write!(f, "second {}", role.title()),
            OtherContract => f.write_str("peer with another schema, model, rate or pace"),
            Race => f.write_str("three launchers of one session at once"),
            ForeignFile => f.write_str("pipe, link or folder where a session's file belongs"),
            MuchOutput => f.write_str("controller that writes bytes that are no text"),
        }
    }
}

/// The results of one kind of fault.
struct FaultRow {
    fault: Fault,
    trials: usize,
    failures: Vec<String>,
    times: Vec<Duration>,
    remark: String,
}

impl FaultRow {
    fn new(fault: Fault, trials: Vec<FaultTrial>) -> FaultRow {
        let (mut times, mut failures, mut remark) = (vec![], vec![], String::new());
        let count = trials.len();
        for trial in trials {
            match trial {
                Ok(TrialOutcome { time, remark: last }) => {
                    times.extend(time);
                    remark = if last.is_empty() { remark } else { last };
                }
                Err(error) => failures.push(error),
            }
        }
        times.sort_unstable();
        FaultRow { fault, trials: count, failures, times, remark }
    }

    fn median(&self) -> Option<Duration> {
        self.times.get(self.times.len() / 2).copied()
    }

    fn cells(&self) -> [String; 6] {
        let text =
            |time: Option<Duration>| time.map_or(String::new(), |time| format!("{:.0}", time.as_secs_f64() * 1e3));
        let passed = self.trials - self.failures.len();
        let (median, greatest) = (text(self.median()), text(self.times.last().copied()));
        [self.fault.to_string(), self.trials.to_string(), passed.to_string(), median, greatest, self.remark.clone()]
    }
}

const HEAD: &str = "| fault | trials | passed | median ms | greatest ms | |\n|---|---|---|---|---|---|\n";

/// Runs the table.
///
/// # Errors
/// A trial that failed.
pub fn run(args: &FaultsArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let wanted = |fault: Fault| args.only.as_ref().is_none_or(|name| fault.to_string().contains(name));
    if !FAULTS.into_iter().any(|(fault, ..)| wanted(fault)) {
        return Err(Failure::new(Exit::Usage, "no fault has the text of --only in its name"));
    }
    let files = [("faults.md", "Seed "), ("faults.csv", "fault,trials,")];
    args.out.as_deref().map_or(Ok(()), |folder| prepare_folder(folder, &files))?;
    let seed = args.seed.unwrap_or_else(|| fastrand::u64(..1 << 32));
    let mut random = fastrand::Rng::with_seed(seed);
    let quick = if args.quick { " --quick" } else { "" };
    print_text(format_args!("biped faults{quick} --seed {seed}\n\n{HEAD}"));
    let (mut rows, mut failures) = (vec![], vec![]);
    for (fault, whole, few) in FAULTS.into_iter().filter(|(fault, ..)| wanted(*fault)) {
        let trials = if args.quick { few } else { whole };
        if trials == 0 || stop.load(Relaxed) {
            continue;
        }
        let mut row = FaultRow::new(fault, fault.trials(trials, &mut random, args.quiet, stop));
        if let (KillAndRespawn(_), false, Some(median)) =
            (fault, args.quick, row.median().filter(|time| *time > RESPAWN))
        {
            row.failures.push(format!("a new process drives after {median:?}, not {RESPAWN:?}"));
        }
        print_text(format_args!("| {} |\n", row.cells().join(" | ")));
        let lines = row.failures.iter().take(MAX_LISTED).map(|failure| format!("{fault}: {failure}"));
        failures.extend(lines);
        rows.push(row);
    }
    if let Some(folder) = &args.out {
        write(folder, &rows, seed).map_err(|error| write_failure(folder, &error))?;
    }
    check_interrupt_after_results(stop)?;
    match rows.iter().map(|row| row.failures.len()).sum() {
        0_usize => Ok(()),
        count => Err(Failure::new(Exit::Fault, format!("{count} trials failed, such as\n{}", failures.join("\n")))),
    }
}

fn write(folder: &std::path::Path, rows: &[FaultRow], seed: u64) -> std::io::Result<()> {
    let mut csv = String::from("fault,trials,passed,median_ms,greatest_ms,remark\n");
    let mut markdown = format!("Seed {seed}.\n\n{HEAD}");
    for cells in rows.iter().map(FaultRow::cells) {
        markdown += &format!("| {} |\n", cells.join(" | "));
        csv += &(cells.map(|cell| format!("\"{}\"", cell.replace('"', "'"))).join(",") + "\n");
    }
    write_atomically(&folder.join("faults.md"), &markdown)?;
    write_atomically(&folder.join("faults.csv"), &csv)
}

impl Fault {
    /// Runs `count` trials.
    fn trials(self, count: usize, random: &mut fastrand::Rng, quiet: bool, stop: &AtomicBool) -> Vec<FaultTrial> {
        let chance = &mut random.fork(); // the same for this kind, independently of the numbers that other kinds draw
        let times = |count: usize, trial: &mut dyn FnMut(usize) -> FaultTrial| {
            let progress = BatchProgress::new(quiet, count, 0, "trials");
            let all = (0..count).take_while(|_| !stop.load(Relaxed)).map(|nth| {
                let outcome = trial(nth);
                progress.add_done(1);
                outcome
            });
            let all: Vec<FaultTrial> = all.collect();
            progress.finish();
            all
        };
        match self {
            Kill(victim) => in_parallel(count, chance, quiet, stop, &|_, chance| kill::at_random(victim, chance)),
            KillAtCall(victim) => match kill::calls(victim) {
                Err(error) => vec![Err(error)],
                Ok(calls) => {
                    let step = (calls.len() / count).max(1);
                    let first = if step > 1 { chance.usize(0..step) } else { 0 };
                    let chosen: Vec<_> = calls.iter().skip(first).step_by(step).collect();
                    in_parallel(chosen.len(), chance, quiet, stop, &|nth, _| kill::at_call(victim, chosen[nth]))
                }
            },
            KillAndRespawn(victim) => kill::and_respawn(victim, count, chance).unwrap_or_else(|error| vec![Err(error)]),
            StopAndContinue(victim) => match stop::reference() {
                Err(error) => vec![Err(error)],
                Ok(reference) => times(count, &mut |_| stop::and_continue(victim, &reference, chance)),
            },
            StopForEver(victim) => in_parallel(count, chance, quiet, stop, &|_, chance| stop::for_ever(victim, chance)),
            StoppedLauncher => times(count, &mut |_| stop::the_launcher_for_ever()),
            StalledRecorder => times(count, &mut |_| stop::the_recorder(5)),
            FullMemory | FillingMemory | FullDisk | FilledDisk if !memory::is_permitted() => {
                vec![Err("mount namespaces are not permitted here".into())]
            }
            FullMemory => times(count, &mut |_| memory::full(1 << chance.u32(5..16), None)),
            FillingMemory => times(count, &mut |_| {
                memory::full(chance.u64(100..200) << 10, Some(Duration::from_millis(chance.u64(0..600))))
            }),
            FullDisk => times(count, &mut |_| disk::small(chance.u64(20..32), None)),
            FilledDisk => times(count, &mut |_| disk::small(200, Some(Duration::from_millis(chance.u64(100..400))))),
            FileLimit => times(count, &mut |_| disk::limited(chance.u64(20..40))),
            Flood => vec![commands::flood(count as u64, chance)],
            EveryOther => vec![commands::every_other(count as u64, chance)],
            Second(role) => times(count, &mut |_| peers::second(role)),
            OtherContract => times(count, &mut |_| peers::other_contract()),
            Race => times(count, &mut |_| neighbours::race()),
            ForeignFile => times(count, &mut |_| neighbours::foreign_file(chance)),
            MuchOutput => times(count, &mut |_| neighbours::much_output(chance)),
        }
    }
}
