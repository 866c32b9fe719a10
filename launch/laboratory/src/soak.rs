//! `biped soak`: a long walk during which memory, open files, shared memory and latency of the processes are monitored.

use crate::faults::test_session::{SessionRole, TestSession, is_finite, walk};
use crate::subject::Subject;
use clap::Args;
use messages::port::{Action, Contract, Pace, RecorderPort, ask};
use messages::scene::Scene;
use messages::session::Session;
use messages::wire::Truth;
use records::recording::{McapRecorder, RecordArgs, RecordingEnd};
use shared::csv;
use shared::exit::{Exit, Failure, check_interrupt_after_results};
use shared::output::{log, prepare_folder, print_text, write_atomically, write_failure};
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Number of samples, at equal intervals.
const SAMPLES: u32 = 30;
/// The walk is reset after this time, so that resets are tested as well [simulated s].
const WALK: f64 = 600.0;
/// The walk is also reset when the trunk is below this height: on a machine that is too busy for real time the robot falls [m].
const UP: f64 = 0.5;
/// Allowed growth of a process's memory between the first and the last sample [kB].
const FLAT: f64 = 1024.0;

/// Arguments of `biped soak`.
#[derive(Args)]
pub struct SoakArgs {
    /// Duration [min]
    #[arg(long, default_value_t = 60.0, value_name = "M", value_parser = minutes)]
    minutes: f64,
    /// Run in real time instead of as fast as possible
    #[arg(long)]
    realtime: bool,
    #[command(flatten)]
    record: RecordArgs,
    /// Write every sample into this folder, as soak.csv
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A monitored quantity and its allowed growth.
const COLUMNS: [(&str, f64); 8] = [
    ("memory of the plant [kB]", FLAT),
    ("memory of the controller [kB]", FLAT),
    ("open files of the plant", 0.0),
    ("open files of the controller", 0.0),
    ("files of the session", 0.0),
    ("shared memory [kB]", FLAT),
    ("sensors to command, median [µs]", f64::INFINITY),
    ("sensors to command, p99 [µs]", f64::INFINITY),
];

/// A sample: the time since the start [s], and the columns.
type Sample = (f64, [f64; COLUMNS.len()]);

fn minutes(text: &str) -> Result<f64, String> {
    let good = text.parse().ok().filter(|minutes| (0.1..=1e6).contains(minutes));
    good.ok_or_else(|| "a number of minutes from 0.1 to 1000000 is needed".into())
}

/// Runs the soak test.
///
/// # Errors
/// A quantity that grows, or a process that ends.
pub fn run(args: &SoakArgs, stop: &AtomicBool) -> Result<(), Failure> {
    args.out.as_deref().map_or(Ok(()), |folder| prepare_folder(folder, &[("soak.csv", "time_s,")]))?;
    let fault = |error: String| Failure::new(Exit::Fault, error);
    let (pace, name) = if args.realtime { (Pace::RealTime, "real time") } else { (Pace::Lockstep, "lockstep") };
    let (_, scene) = walk(&["duration=1000000"]).map_err(fault)?;
    let recorder = args.record.recorder(&scene)?;
    let time = Duration::from_secs_f64(args.minutes * 60.0);
    let Soaked { samples, simulated, falls, end } = soak(&scene, recorder, pace, time, stop).map_err(fault)?;
    if let Some(folder) = &args.out {
        write_atomically(&folder.join("soak.csv"), &table(&samples)).map_err(|error| write_failure(folder, &error))?;
    }
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return Err(Failure::new(Exit::Interrupted, "interrupted before the first sample"));
    };
    let (minutes, hours) = (last.0 / 60.0, simulated / 3600.0);
    let count = samples.len();
    print_text(format_args!("{name}, {minutes:.1} min, {hours:.2} h simulated, {falls} falls, {count} samples\n\n"));
    print_text("| | first | last | slope per hour |\n|---|---|---|---|\n");
    let mut grown = vec![];
    for (column, (what, limit)) in COLUMNS.iter().enumerate() {
        let (from, to) = (first.1[column], last.1[column]);
        print_text(format_args!("| {what} | {from:.1} | {to:.1} | {:.1} |\n", slope(&samples, column)));
        if to - from > *limit {
            grown.push(format!("{what} grew from {from:.1} to {to:.1}"));
        }
    }
    check_interrupt_after_results(stop)?;
    match (grown.is_empty(), end.filter(|end| end.exit != Exit::Ok)) {
        (true, None) => Ok(()),
        (true, Some(end)) => Err(Failure::new(end.exit, end.message)),
        (false, _) => Err(fault(grown.join("; "))),
    }
}

/// The result.
struct Soaked {
    samples: Vec<Sample>,
    /// Simulated time of walking [s].
    simulated: f64,
    /// Number of falls.
    falls: u32,
    /// Why the recording ended before the walk.
    end: Option<RecordingEnd>,
}

fn table(samples: &[Sample]) -> String {
    let names = ["time_s"].into_iter().chain(COLUMNS.iter().map(|(name, _)| *name)).map(String::from).collect();
    let row = |(time, values): &Sample| {
        [format!("{time:.1}")].into_iter().chain(values.map(|value| value.to_string())).collect::<Vec<_>>()
    };
    csv::text([names].into_iter().chain(samples.iter().map(row)))
}

/// Walks for a time and takes samples.
fn soak(
    scene: &Scene,
    mut recorder: Option<McapRecorder>,
    pace: Pace,
    time: Duration,
    stop: &AtomicBool,
) -> Result<Soaked, String> {
    let test_session = TestSession::empty();
    let session = &test_session.session;
    let message = |error: &dyn ToString| error.to_string();
    let mut port = RecorderPort::open(session, &Contract::of(scene, pace)).map_err(|e| message(&e))?;
    let start_role = |role: SessionRole| {
        let how: &[&str] = if pace == Pace::RealTime { &["--realtime"] } else { &[] };
        Subject::biped(
            &[&[role.name(), "walk", "--set", "duration=1000000", "--session", session.name()], how].concat(),
        )
    };
    let mut roles = [start_role(SessionRole::Plant)?, start_role(SessionRole::Controller)?];
    let numbers = [test_session.wait_for(SessionRole::Plant)?, test_session.wait_for(SessionRole::Controller)?];
    let (start, interval) = (Instant::now(), time / SAMPLES);
    let (mut samples, mut replies, mut truth, mut walked) = (vec![], vec![], Truth::default(), 0.0);
    let (mut reset, mut falls, mut end) = (0, 0, None); // the last run that was ended
    // the first interval is a warm-up
    let mut due = interval;
    while start.elapsed() < time + interval && !stop.load(Relaxed) {
        while let Some(next) = port.read().map_err(|e| message(&e))? {
            is_finite(&next)?;
            if next.stamp.run != truth.stamp.run {
                walked += seconds(&truth);
            }
            truth = *next;
            if let Some(Err(early)) = recorder.as_mut().map(|recorder| recorder.push(&truth)) {
                log(format_args!("{}; the walk goes on", early.message));
                (recorder, end) = (None, Some(early));
            }
            replies.extend(Some(truth.reply_ns).filter(|ns| *ns > 0));
        }
        if roles.iter_mut().any(Subject::has_ended) {
            let ends = roles.map(|role| role.end(Duration::from_secs(20)));
            return Err(format!("a process ended after {:.0} s: {ends:?}", start.elapsed().as_secs_f64()));
        }
        let has_fallen = truth.stamp.seq > 1 && truth.base_position[2] < UP;
        let limit = if reset == 0 { 1.0 } else { WALK }; // the first reset is part of warming up
        if (has_fallen || seconds(&truth) > limit) && reset != truth.stamp.run {
            ask(session, Action::Reset { seed: None }).map_err(|e| message(&e))?;
            reset = truth.stamp.run;
            falls += u32::from(has_fallen);
        }
        if start.elapsed() > due {
            samples.push((start.elapsed().as_secs_f64(), sample(session, numbers, &mut replies)));
            due += interval;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let end = recorder.map(McapRecorder::finish).and_then(Result::err).or(end);
    Ok(Soaked { samples, simulated: walked + seconds(&truth), falls, end })
}

fn sample(session: &Session, [plant, controller]: [u32; 2], replies: &mut Vec<u64>) -> [f64; COLUMNS.len()] {
    let files = session.shm_files();
    let kilobytes = files.iter().filter_map(|path| path.symlink_metadata().ok()).map(|file| file.blocks() / 2);
    replies.sort_unstable();
    let at = |share: f64| replies.get((replies.len() as f64 * share) as usize).map_or(0.0, |ns| *ns as f64 * 1e-3);
    let values = [
        memory(plant),
        memory(controller),
        handles(plant),
        handles(controller),
        files.len() as f64,
        kilobytes.sum::<u64>() as f64,
        at(0.5),
        at(0.99),
    ];
    replies.clear();
    values
}

fn seconds(truth: &Truth) -> f64 {
    truth.stamp.time()
}

/// Resident memory of a process without shared memory [kB]. Shared memory is reserved at the start and counted separately; its pages
/// become resident at their first use, for example when a recorder lags.
fn memory(number: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{number}/status")).unwrap_or_default();
    let kilobytes = |key: &str| -> Option<f64> {
        status.lines().find_map(|line| line.strip_prefix(key))?.split_whitespace().next()?.parse().ok()
    };
    kilobytes("VmRSS:").zip(kilobytes("RssShmem:")).map_or(0.0, |(all, shared)| all - shared)
}

/// Open files of a process.
fn handles(number: u32) -> f64 {
    std::fs::read_dir(format!("/proc/{number}/fd")).map_or(0, Iterator::count) as f64
}

/// Least-squares slope of a column [1/h].
fn slope(samples: &[Sample], column: usize) -> f64 {
    let count = samples.len() as f64;
    let mean = |value: &dyn Fn(&Sample) -> f64| samples.iter().map(value).sum::<f64>() / count;
    let (time, level) = (mean(&|sample| sample.0), mean(&|sample| sample.1[column]));
    let spread = mean(&|sample| (sample.0 - time).powi(2));
    3600.0 * mean(&|sample| (sample.0 - time) * (sample.1[column] - level)) / spread.max(f64::MIN_POSITIVE)
}
