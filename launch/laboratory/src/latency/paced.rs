//! Runs at 1 kHz of the clock: a link without a plant, then the whole walk. The host's floor is measured at the same time.

use super::bench::Bench;
use super::floor::{Floor, PERIOD_NS, late};
use super::host::Usage;
use super::initiator::Initiator;
use super::results::Results;
use super::second_process::Order;
use super::spread::Spread;
use super::terms::null_plant;
use super::watch::HostWatch;
use messages::clock::now_ns;
use messages::port::{Contract, Pace, RecorderPort, Waiting};
use messages::wire::{Sensors, Stamp};
use sessions::children::{self, RoleProcess};
use sessions::open::open_with_timeout;
use sessions::realtime::{RealtimeArgs, minimize_timer_slack};
use shared::exit::{Exit, Failure};
use shared::output::log;
use std::process::Stdio;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// The sections.
pub const LINK: &str = "1 kHz, no plant";
pub const WALK: &str = "1 kHz, walk";
/// Metric of the host's floor in each section.
pub const FLOOR: &str = "wake of the host's floor";
/// Interval between two readings of the truth topic; its buffer holds 4 s.
const TRUTH_POLL: Duration = Duration::from_millis(20);
/// Time for the controller to receive the plant's end message.
const GOODBYE: Duration = Duration::from_secs(1);

/// Sends sensors at each deadline; they are answered at once. Round trips are measured from their deadline.
///
/// # Errors
/// A link that breaks, a refusal of required real time, or Ctrl-C.
pub fn link(bench: &mut Bench, results: &mut Results, system: RealtimeArgs) -> Result<(), Failure> {
    bench.begin_group("1 kHz without a plant");
    bench.step(LINK)?;
    minimize_timer_slack();
    let (session, waiting) = (bench.session()?, Waiting::Hybrid);
    let mut initiator = Initiator::open(&session, &null_plant(), waiting, bench.stop)?;
    bench.peer.order(&Order::Echo { session: session.name().into(), waiting, system: system.for_child(1) })?;
    initiator.first_exchange()?;
    let (mut wake, mut trip, mut skipped) = (Spread::new()?, Spread::new()?, 0);
    let begin = now_ns() + 20 * PERIOD_NS; // time to get ready
    let end = begin + (bench.plan.paced_s * 1e9) as u64;
    let floor = Floor::start(begin, system.for_child(0))?;
    system.for_child(0).apply()?;
    let before = Usage::of("thread-self");
    let (mut deadline, mut seq) = (begin, 1);
    while deadline < end && !bench.stop.load(Relaxed) {
        let missed = late(deadline);
        wake.add_due(missed, PERIOD_NS);
        skipped += missed / PERIOD_NS;
        deadline += missed / PERIOD_NS * PERIOD_NS;
        seq += 1;
        let stamp = Stamp { seq, mono_ns: now_ns(), ..Stamp::default() };
        initiator.exchange(Sensors { stamp, ..Sensors::default() })?;
        trip.add_due(initiator.received_ns - deadline, PERIOD_NS);
        deadline += PERIOD_NS;
    }
    let used = Usage::of("thread-self").since(before);
    results.put(LINK, FLOOR, &floor.finish()?);
    results.put(LINK, "wake", &wake);
    results.put(LINK, "round trip from the deadline", &trip);
    initiator.end(results, LINK)?;
    results.count(LINK, "skipped periods", skipped as f64);
    usage(results, LINK, used);
    Ok(())
}

/// The walk paced by the clock. Plant and controller are separate processes; this process records.
///
/// # Errors
/// A role that fails, a robot that falls, or Ctrl-C.
pub fn walk(bench: &mut Bench, results: &mut Results, system: RealtimeArgs) -> Result<(), Failure> {
    bench.begin_group("the walk at 1 kHz");
    bench.step(WALK)?;
    let (session, seconds) = (bench.session()?, bench.plan.paced_s);
    let contract = Contract::of(&super::walk::scene(seconds)?, Pace::RealTime);
    let mut port = open_with_timeout(|| RecorderPort::open(&session, &contract))?;
    let arguments = |child| {
        let scene = ["walk", "--realtime", "--session", session.name(), "--set"].map(String::from);
        [&scene[..], &[format!("duration={seconds}")], &system.for_child(child).arguments()[..]].concat()
    };
    let mut roles = vec![
        RoleProcess::start("plant", &arguments(0), &[], Stdio::null(), &bench.counter.bar)?,
        RoleProcess::start("controller", &arguments(1), &[], Stdio::null(), &bench.counter.bar)?,
    ];
    let plant = format!("{0}/task/{0}", roles[0].pid());
    let (mut watch, mut floor, mut before, mut after) = (HostWatch::new()?, None, Usage::default(), Usage::default());
    let mut ended_early = false;
    loop {
        std::thread::sleep(TRUTH_POLL);
        let ended = roles.iter_mut().map(|role| role.try_wait().is_some()).collect::<Vec<_>>()[0];
        while let Some(truth) = port.read()? {
            watch.take(&truth);
        }
        match roles.iter_mut().find_map(|role| role.outcome().err()) {
            // On a busy host the watchdog may end the run, or the robot may fall. This is a result, not an error.
            Some(failure) if failure.exit == Exit::Fault => {
                bench.counter.bar.suspend(|| log(format_args!("{WALK}: ended early: {}", failure.message)));
                ended_early = true;
                break;
            }
            Some(failure) => return Err(failure),
            None if ended => break,
            None => (),
        }
        match &floor {
            None if watch.periods() > 0 => {
                floor = Some(Floor::start(watch.begin_ns(), system.for_child(0))?);
                before = Usage::of(&plant);
            }
            Some(_) if watch.periods() < (seconds * 1e3) as u64 => after = Usage::of(&plant),
            _ => (),
        }
        bench.stopped()?;
    }
    match ended_early {
        true => children::terminate_all(&mut roles, || ()),
        false => children::wait_for_all(&mut roles, GOODBYE, || ()),
    }
    while let Some(truth) = port.read()? {
        watch.take(&truth);
    }
    if let Some(floor) = floor {
        results.put(WALK, FLOOR, &floor.finish()?);
    }
    watch.report(results, WALK);
    results.count(WALK, "ended early", f64::from(u8::from(ended_early)));
    usage(results, WALK, after.since(before));
    Ok(())
}

fn usage(results: &mut Results, section: &'static str, used: Usage) {
    results.count(section, "page faults without a disk", used.faults[0]);
    results.count(section, "page faults with a disk", used.faults[1]);
    results.count(section, "context switches, voluntary", used.switches[0]);
    results.count(section, "context switches, others", used.switches[1]);
}
