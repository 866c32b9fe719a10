//! The rules of a plant. This program is its controller and a recorder.

use super::driver::Driver;
use super::program::{END_LIMIT, Ended, ProgramSetup, ProgramUnderTest};
use super::refusals::{self, ProgramRole};
use super::report::{Finding, RuleReport};
use super::stamps::Stamps;
use controller::Controller;
use messages::clock::random;
use messages::port::Pace;
use messages::wire::{Command, REFUSALS, STATES, Sensors, Stamp, Stamped, Truth};
use nix::sys::signal::Signal;
use std::f64::consts::TAU;
use std::time::{Duration, Instant};

const YOURS: &str = "Your own plant";
const LOCKSTEP: &str = "A control period, step 3";
const VALIDATION: &str = "A control period, step 4";
/// Simulated time of a run [s].
const DURATION: f64 = 0.5;
/// Control periods before an event.
const SHORT: u64 = 20;

/// Checks all rules of a plant.
pub fn check(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let mut scene = host.scene.clone();
    scene.duration = DURATION;
    let host = &ProgramSetup { command: host.command.clone(), scene, ..*host };
    let refusals = |host: &ProgramSetup, report: &mut RuleReport| refusals::check(host, ProgramRole::Plant, report);
    report.each(host, &[whole_session, succession, refusals, silence, on_time])
}

/// Commands that must not be accepted before the first good one: description, index into [`REFUSALS`], and the defect.
type PlantFlaw = (&'static str, usize, fn(&mut Command));
const RAW: [PlantFlaw; 2] = [
    ("without the magic", 0, |command| command.stamp.magic ^= 1),
    ("whose check sum is wrong", 3, |command| command.torques.torque[2] += 1.0),
];
const SEALED: [PlantFlaw; 5] = [
    ("for another run", 1, |command| command.stamp.run ^= 1),
    ("for sensors that were not sent yet", 5, |command| command.stamp.ack += 1),
    ("with a torque that is no number", 6, |command| command.torques.torque[4] = f64::NAN),
    ("beyond four times the torque limit", 7, |command| command.torques.torque[1] = 1e6),
    ("of another schema", 0, |command| command.stamp.schema ^= 1),
];

/// One session from start to end.
fn whole_session(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let environment = host.environment(Pace::Lockstep);
    let mut driver = Driver::new(host, &environment)?;
    let start = Instant::now();
    let mut program = host.start(&environment)?;
    let first = driver.next(&mut program).and_then(|first| match first.stamp.seq {
        1 => Ok(format!("after {} ms", start.elapsed().as_millis())),
        other => Err(format!("number {other} came")),
    });
    if !report.rule("opens the session with its contract, and sends sensors number 1", YOURS, first) {
        return Ok(());
    }
    let is_member = program.is_member_of(&environment.session).then(String::new);
    let is_member = is_member.ok_or_else(|| "it does not hold the file …_members open".into());
    report.rule("is a member of the session, by its lock", "Topics", is_member);
    report.rule("encoders count from the zero angle of the scene", YOURS, at_the_start(host, &driver.sensors));
    report.rule("waits for the answer", LOCKSTEP, driver.silence());

    let mut refused = [0; REFUSALS.len()];
    let good = driver.answer()?;
    for (flaws, is_sealed) in [(&RAW[..], false), (&SEALED[..], true)] {
        for (what, reason, spoil) in flaws {
            let mut bad = good;
            spoil(&mut bad);
            if is_sealed {
                bad.stamp.check = bad.check_sum();
            }
            driver.send_raw_command(bad)?;
            refused[*reason] += 1;
            report.rule(&format!("a command {what} is not accepted"), VALIDATION, driver.silence());
        }
    }
    driver.send_raw_command(good)?;
    let went = driver.next(&mut program).and_then(|_| driver.drive(&mut program, SHORT));
    let went = went.map(|()| String::new());
    if !report.rule("goes on with a good one, in lockstep", LOCKSTEP, went) {
        return Ok(());
    }
    driver.send_raw_command(good)?;
    refused[4] += 1;
    report.rule("an earlier command is not accepted as the answer", VALIDATION, driver.silence());
    driver.stamp = Stamp { epoch: random(), seq: 0, ..driver.stamp };
    let taken = driver.drive(&mut program, 2 * SHORT).map(|()| String::new());
    report.rule("a controller with another epoch takes over", VALIDATION, taken);

    let periods = (DURATION * host.scene.rate).round() as u64;
    let went = driver.drive(&mut program, u64::MAX).and_then(|()| match driver.sensors.stamp.seq {
        last if last == periods + 1 => Ok(format!("number {last}")),
        other => Err(format!("number {other} was the last, not {}", periods + 1)),
    });
    if !report.rule("runs to the scene's end, and says so by `last` = 1", YOURS, went) {
        return Ok(());
    }
    let ended = program.end(END_LIMIT).and_then(|ended| ended.in_order(&[]));
    report.rule("then ends in order within 3 s, with exit code 0", YOURS, ended);
    driver.receive_sensors()?; // the rest of the truth messages
    std::mem::take(&mut driver.stamps).report(report, false);
    report.rule(
        "records a Truth with each Sensors, with the same stamp",
        YOURS,
        is_complete(&driver.truths, periods + 1),
    );
    let tally = driver.truths.last().map(|truth| truth.tally).unwrap_or_default();
    let wrong: Vec<String> = REFUSALS
        .iter()
        .enumerate()
        .filter(|(reason, _)| tally.refused[*reason] != refused[*reason])
        .map(|(k, why)| format!("{} instead of {} {why}", tally.refused[k], refused[k]))
        .collect();
    let finding = if wrong.is_empty() { Ok(String::new()) } else { Err(wrong.join("; ")) };
    report.rule("counts every refusal by its reason", VALIDATION, finding);
    let takeovers = match tally.takeovers {
        1 => Ok(String::new()),
        other => Err(format!("{other} instead of 1")),
    };
    report.rule("counts controllers that take over", VALIDATION, takeovers);
    Ok(())
}

/// The first encoder counts must be those of the scene's start, to one count.
fn at_the_start(host: &ProgramSetup, sensors: &Sensors) -> Finding {
    let count = TAU / f64::from(host.scene.plant.encoder_bits).exp2();
    for (joint, (&angle, &counts)) in host.scene.initial.joints.iter().zip(&sensors.encoders.counts).enumerate() {
        let wanted = (angle / count).round() as i64;
        if (counts - wanted).abs() > 1 {
            return Err(format!("joint {joint} begins at {counts} counts instead of {wanted} ({angle} rad)"));
        }
    }
    Ok(String::new())
}

/// There must be as many truth messages as sensors, each with a valid check sum and of the same run.
fn is_complete(truths: &[Truth], wanted: u64) -> Finding {
    for (truth, number) in truths.iter().zip(1..) {
        if !truth.is_sound() {
            return Err(format!("number {number} is not sealed"));
        }
        if truth.stamp.seq != number || truth.stamp.run != truths[0].stamp.run {
            return Err(format!("received number {} instead of {number}", truth.stamp.seq));
        }
    }
    match truths.len() as u64 {
        count if count == wanted => Ok(format!("{count} records")),
        count => Err(format!("{count} records of {wanted}")),
    }
}

/// A killed and restarted plant, a second plant, and TERM.
fn succession(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let environment = host.environment(Pace::Lockstep);
    let mut driver = Driver::new(host, &environment)?;
    let mut program = host.start(&environment)?;
    if driver.next(&mut program).and_then(|_| driver.drive(&mut program, SHORT)).is_err() {
        return Ok(()); // already reported
    }
    let run = driver.sensors.stamp.run;
    program.signal(Signal::SIGKILL);
    program.end(END_LIMIT)?;
    driver.stamps = Stamps::default();
    let mut program = host.start(&environment)?;
    let other = driver.next(&mut program).and_then(|first| match (first.stamp.run == run, first.stamp.seq) {
        (true, _) => Err(format!("run {run:x} is that of the one before: draw it at random")),
        (false, 1) => Ok(String::new()),
        (false, other) => Err(format!("it began with number {other}")),
    });
    if !report.rule("killed and restarted in the same session, it begins another run", YOURS, other) {
        return Ok(());
    }
    driver.controller = Controller::new(&host.scene).map_err(|error| error.to_string())?;
    let mut second = host.start(&environment)?;
    let refused = second.end(host.patience).and_then(|ended| ended.by_refusing());
    report.rule("a second one beside it ends with a sentence", "Topics", refused);
    let goes_on = driver.drive(&mut program, SHORT).map(|()| String::new());
    report.rule("and the first goes on", "Topics", goes_on);
    program.signal(Signal::SIGTERM);
    check_end(&mut driver, &mut program, "TERM ends it", END_LIMIT, report, |ended| {
        ended.in_order(&[refusals::INTERRUPTED])
    });
    Ok(())
}

/// Checks that the plant ends in time and in an allowed way, and that its last sensors announce the end.
fn check_end(
    driver: &mut Driver,
    program: &mut ProgramUnderTest,
    what: &str,
    limit: Duration,
    report: &mut RuleReport,
    how: impl Fn(&Ended) -> Finding,
) {
    let start = Instant::now();
    while !program.has_ended() && start.elapsed() < limit {
        let _ = driver.receive_sensors();
    }
    let _ = driver.receive_sensors();
    let ended = program.end(Duration::ZERO).and_then(|ended| how(&ended));
    report.rule(&format!("{what} within {:.0} s", limit.as_secs_f64()), YOURS, ended);
    let last = match driver.sensors.last {
        0 => Err("it ended without a last message".into()),
        _ => Ok(String::new()),
    };
    report.rule("and its last sensors have `last` = 1", YOURS, last);
}

/// A controller that becomes silent in lockstep.
fn silence(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let mut environment = host.environment(Pace::Lockstep);
    environment.patience = Duration::from_secs(1);
    let mut driver = Driver::new(host, &environment)?;
    let mut program = host.start(&environment)?;
    if driver.next(&mut program).and_then(|_| driver.drive(&mut program, SHORT)).is_ok() {
        let limit = environment.patience + END_LIMIT;
        let what = "a silent controller ends it, after its patience, with a sentence,";
        check_end(&mut driver, &mut program, what, limit, report, Ended::by_refusing);
    }
    Ok(())
}

/// In real time: the number of sensors, and the state of the drives when commands stop.
fn on_time(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let mut host = ProgramSetup { command: host.command.clone(), scene: host.scene.clone(), ..*host };
    host.scene.duration = 1e6;
    let environment = host.environment(Pace::RealTime);
    let mut driver = Driver::new(&host, &environment)?;
    let mut program = host.start(&environment)?;
    let why = match driver.next(&mut program) {
        Ok(first) if first.last == 0 => None,
        Ok(_) => Some(program.end(END_LIMIT)?.to_string()),
        Err(why) => Some(why),
    };
    if let Some(why) = why {
        report.note(&format!("it does not run in real time: {why}"));
        return Ok(());
    }
    let (start, span) = (Instant::now(), Duration::from_secs_f64(2.0 * DURATION));
    while start.elapsed() < span {
        let command = driver.answer()?;
        driver.send_raw_command(command)?;
        while !driver.receive_sensors()? && start.elapsed() < span {}
    }
    let (periods, wanted) = (driver.sensors.stamp.seq, span.as_secs_f64() * host.scene.rate);
    report.note(&format!("in real time {periods} control periods of {wanted:.0} came within {} s", span.as_secs_f64()));
    let until = Instant::now() + Duration::from_millis(300);
    while Instant::now() < until {
        driver.receive_sensors()?;
    }
    let limits = [0.01, 0.1].map(|limit: f64| ((limit * host.scene.rate).round() as u32).max(1));
    let wrong = driver.truths.iter().find(|truth| {
        !matches!((truth.age, truth.state), (_, 0 | 5)) && {
            let late = (truth.age > limits[0]) as usize + (truth.age > limits[1]) as usize;
            (truth.state == 4) != (late == 1) || late == 2
        }
    });
    let seen = |state: u32| driver.truths.iter().any(|truth| truth.state == state);
    let state = |truth: &Truth| STATES.get(truth.state as usize).copied().unwrap_or("?");
    let finding = match wrong {
        Some(truth) => Err(format!("at an age of {} periods its state was {}", truth.age, state(truth))),
        None if !seen(4) || !seen(5) => Err("its truth shows no damp, or no fault".into()),
        None => Ok(String::new()),
    };
    report.rule(
        "holds up to 10 ms, damps up to 100 ms, then faults, when no command comes",
        "A control period, step 5",
        finding,
    );
    program.signal(Signal::SIGTERM);
    check_end(&mut driver, &mut program, "TERM ends it", END_LIMIT, report, |ended| {
        ended.in_order(&[refusals::INTERRUPTED])
    });
    Ok(())
}
