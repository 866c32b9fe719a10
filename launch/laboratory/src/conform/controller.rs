//! The rules of a controller. This program is its plant, with a simulated robot.

use super::program::{END_LIMIT, ProgramSetup, ProgramUnderTest};
use super::refusals::{self, ProgramRole};
use super::report::RuleReport;
use super::robot::{SILENCE, SimulatedRobot, simulation};
use super::stamps::Stamps;
use messages::clock::{now_ns, sleep_until};
use messages::port::Pace;
use messages::wire::{Sensors, Stamp, Stamped};
use nix::sys::signal::Signal;
use std::time::{Duration, Instant};

const ENVIRONMENT: &str = "Your own controller";
const PERIOD: &str = "A control period, step 2";
/// Control periods of a session.
const LONG: usize = 300;
/// Control periods of a session that checks whether a new run resets the controller.
const SHORT: usize = 50;
/// Number of sensor messages that are sent at once.
const BURST: u64 = 5;
/// Duration in real time over which punctual answers are counted.
const ON_TIME: Duration = Duration::from_secs(1);

/// Checks all rules of a controller.
pub fn check(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let refusals =
        |host: &ProgramSetup, report: &mut RuleReport| refusals::check(host, ProgramRole::Controller, report);
    report.each(host, &[whole_session, succession, refusals, on_time])
}

/// One session from start to end.
fn whole_session(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let environment = host.environment(Pace::Lockstep);
    let mut robot = SimulatedRobot::new(host, &environment)?;
    let start = Instant::now();
    let mut program = host.start(&environment)?;
    let first = robot.ask(&mut program, robot.simulation.sensors());
    let took = || format!("after {} ms", start.elapsed().as_millis());
    let rule = "opens the session with its contract, and answers within its patience";
    if !report.rule(rule, ENVIRONMENT, first.map(|_| took())) {
        return Ok(());
    }
    let is_member = program.is_member_of(&environment.session).then(String::new);
    let is_member = is_member.ok_or_else(|| "it does not hold the file …_members open".into());
    report.rule("is a member of the session, by its lock", "Topics", is_member);

    let again = robot.torques;
    let answer = robot.ask(&mut program, robot.simulation.sensors());
    let same = answer.and_then(|answer| match answer.torques == again {
        true => Ok(String::new()),
        false => Err("it had other torques".into()),
    });
    report.rule("sensors that come again get the same answer again", PERIOD, same);

    let first_run = robot.walk(&mut program, LONG);
    let went = first_run.as_ref().map(|_| format!("{LONG} control periods")).map_err(Clone::clone);
    let goes_on = report.rule("answers sensors after sensors in lockstep", PERIOD, went);
    if goes_on {
        report.rule("answers each of them once", PERIOD, robot.silence());
        damage(&mut robot, &mut program, report);
        burst(&mut robot, &mut program, report);
    }
    let (clamped, count) = (robot.stamps.clamped, robot.stamps.count);
    let before = std::mem::take(&mut robot.stamps);
    before.report(report, true);
    if clamped > 0 {
        report.note(&format!("{clamped} of {count} commands ask for more than the drives' {} N·m", robot.limit));
    }
    if !goes_on {
        return Ok(());
    }

    robot.simulation = simulation(host)?;
    let second_run = robot.walk(&mut program, SHORT);
    let differs = second_run.and_then(|second_run| {
        let first_run = first_run.unwrap_or_default();
        match second_run.iter().zip(&first_run).position(|(new, old)| new != old) {
            None => Ok(String::new()),
            Some(at) => {
                Err(format!("the same sensors got other torques than in the first run, from number {} on", at + 1))
            }
        }
    });
    let numbers = std::mem::take(&mut robot.stamps).first_break();
    let finding = differs.and_then(|said| numbers.map_or(Ok(said), Err));
    report.rule("takes a new run as a new robot, and counts from 1 again", PERIOD, finding);

    let last = robot.simulation.sensors();
    let sent = robot.port.send(Sensors { last: 1, ..last });
    sent.map_err(|error| error.to_string())?;
    let ended = program.end(END_LIMIT).and_then(|ended| ended.in_order(&[]));
    report.rule("`last` = 1 ends it in order within 3 s, with exit code 0", PERIOD, ended);
    let said = robot.port.try_receive().map_err(|error| error.to_string())?;
    let said = said.map_or(Ok(String::new()), |command| Err(format!("command {} came", command.stamp.seq)));
    report.rule("`last` = 1 gets no answer", PERIOD, said);
    Ok(())
}

/// A defect of sensors and the function that causes it.
type ControllerFlaw = (&'static str, fn(&mut Sensors));

/// Damaged sensors must not be answered; good ones afterwards must be.
fn damage(robot: &mut SimulatedRobot, program: &mut ProgramUnderTest, report: &mut RuleReport) {
    let good = robot.simulation.sensors().sealed();
    let kinds: [ControllerFlaw; 3] = [
        ("whose check sum is wrong", |sensors| sensors.encoders.counts[3] ^= 1 << 7),
        ("without the magic", |sensors| sensors.stamp.magic ^= 1),
        ("of another schema", |sensors| {
            sensors.stamp.schema ^= 1;
            sensors.stamp.check = sensors.check_sum();
        }),
    ];
    for (what, spoil) in kinds {
        let mut bad = good;
        spoil(&mut bad);
        let passed = robot.port.send_raw(bad).map_err(|error| error.to_string());
        report.rule(
            &format!("sensors {what} are not answered"),
            "Every message",
            passed.and_then(|()| robot.silence()),
        );
    }
    let answer = robot.walk(program, 1).map(|_| String::new());
    report.rule("good ones afterwards are", "Every message", answer);
}

/// Of several sensors at once, the newest must be answered.
fn burst(robot: &mut SimulatedRobot, program: &mut ProgramUnderTest, report: &mut RuleReport) {
    let first = robot.simulation.sensors();
    let nth = |nth: u64| {
        let stamp = Stamp { seq: first.stamp.seq + nth, mono_ns: now_ns(), ..first.stamp };
        Sensors { stamp, ..first }
    };
    program.signal(Signal::SIGSTOP);
    std::thread::sleep(SILENCE); // until it has stopped
    let sent = (0..BURST).try_for_each(|n| robot.port.send(nth(n))).map_err(|error| error.to_string());
    program.signal(Signal::SIGCONT);
    let newest = first.stamp.seq + BURST - 1;
    let expected = Sensors { stamp: Stamp { seq: newest, ..first.stamp }, ..first };
    let answer = sent.and_then(|()| robot.answer(program, &expected));
    let finding = answer.and_then(|answer| match answer.stamp.ack == newest {
        true => Ok(String::new()),
        false => Err(format!("of sensors {} to {newest} it answered {}", first.stamp.seq, answer.stamp.ack)),
    });
    report.rule(&format!("of {BURST} sensors at once it answers the newest"), PERIOD, finding);
}

/// A killed and restarted controller, a second controller, and TERM.
fn succession(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let environment = host.environment(Pace::Lockstep);
    let mut robot = SimulatedRobot::new(host, &environment)?;
    let mut program = host.start(&environment)?;
    if robot.walk(&mut program, SHORT).is_err() {
        return Ok(()); // already reported
    }
    let epoch = robot.ask(&mut program, robot.simulation.sensors())?.stamp.epoch;
    program.signal(Signal::SIGKILL);
    program.end(END_LIMIT)?;
    robot.stamps = Stamps::default();
    let mut program = host.start(&environment)?;
    let answer = robot.ask(&mut program, robot.simulation.sensors());
    let other = answer.and_then(|answer| match answer.stamp.epoch == epoch {
        true => Err(format!("epoch {epoch:x} is that of the one before: draw it at random")),
        false => Ok(String::new()),
    });
    report.rule("killed and restarted in the same session, it answers under another epoch", "Every message", other);
    let drives = robot.walk(&mut program, SHORT).and_then(|_| match robot.simulation.commands().tally().refused {
        refused if refused.iter().any(|&count| count > 0) => Err(robot.simulation.commands().tally().to_string()),
        _ => Ok(String::new()),
    });
    if !report.rule("and drives the robot from where it is", "A control period", drives) {
        return Ok(());
    }

    let mut second = host.start(&environment)?;
    let start = Instant::now();
    let mut walks = Ok(vec![]);
    while walks.is_ok() && !second.has_ended() && start.elapsed() < host.patience + END_LIMIT {
        walks = robot.walk(&mut program, 1);
    }
    let refused = second.end(Duration::ZERO).and_then(|ended| ended.by_refusing());
    report.rule("a second one beside it ends with a sentence", "Topics", refused);
    let walks = walks.and_then(|_| robot.walk(&mut program, SHORT));
    report.rule("and the first drives on", "Topics", walks.map(|_| String::new()));

    program.signal(Signal::SIGTERM);
    let ended = program.end(END_LIMIT).and_then(|ended| ended.in_order(&[refusals::INTERRUPTED]));
    report.rule("TERM ends it in order within 3 s", ENVIRONMENT, ended);
    Ok(())
}

/// In real time. The result is a remark, because speed is not a rule.
fn on_time(host: &ProgramSetup, report: &mut RuleReport) -> Result<(), String> {
    let environment = host.environment(Pace::RealTime);
    let mut robot = SimulatedRobot::new(host, &environment)?;
    let mut program = host.start(&environment)?;
    if let Err(instead) = robot.walk(&mut program, 1) {
        report.rule("answers in real time", "A control period, step 3", Err(instead));
        return Ok(());
    }
    let period = (1e9 / host.scene.rate) as u64;
    let mut deadline = now_ns();
    let (mut replies, mut periods) = (vec![], 0);
    let start = Instant::now();
    while start.elapsed() < ON_TIME {
        let (sensors, sent) = (robot.simulation.sensors(), now_ns());
        let stamp = Stamp { mono_ns: sent, ..sensors.stamp };
        robot.port.send(Sensors { stamp, ..sensors }).map_err(|error| error.to_string())?;
        deadline = (deadline + period).max(sent);
        sleep_until(deadline);
        while let Some(command) = robot.port.try_receive().map_err(|error| error.to_string())? {
            robot.simulation.receive(&command);
        }
        let reply = robot.simulation.commands().reply_ns(&stamp);
        replies.extend((reply > 0).then_some(reply));
        periods += 1;
        if robot.simulation.advance().is_err() {
            break;
        }
    }
    let share = 100.0 * replies.len() as f64 / f64::from(periods);
    replies.sort_unstable();
    let answered = match replies.get(replies.len() / 2) {
        Some(median) => Ok(format!(
            "{share:.1} % of {periods} periods of {:.1} ms in time, median {:.0} µs",
            period as f64 * 1e-6,
            *median as f64 * 1e-3
        )),
        None => Err(format!("none of {periods} periods was answered in time")),
    };
    report.rule("answers in real time", "A control period, step 3", answered);
    Ok(())
}
