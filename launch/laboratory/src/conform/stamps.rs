//! Rules for every message of either sender, and for every command.

use super::report::RuleReport;
use messages::wire::{Command, JOINTS, Stamp, Stamped};

const MESSAGE: &str = "Every message";
const PERIOD: &str = "A control period";
/// Greatest accepted torque [torque limits].
const NONSENSE: f64 = 4.0;
const FULL_SWING: f64 = 2.0;

/// Rules for single messages, and their sections.
const RULES: [(&str, &str); 7] = [
    ("every message is sealed: magic, schema, check sum", MESSAGE),
    ("run is the plant's run, and epoch stays the same", MESSAGE),
    ("seq counts its messages of a run from 1, without repeats or gaps", MESSAGE),
    ("ack is the number of the sensors answered; in sensors it is 0", MESSAGE),
    ("sim_ns is the simulated time, mono_ns the monotonic clock when it was sent", MESSAGE),
    ("torques are finite", PERIOD),
    ("torques pass the gate: at most four times the torque limit, no jump beyond twice", PERIOD),
];

/// The first violation of each rule by the messages of one process.
#[derive(Default)]
pub struct Stamps {
    broken: [Option<String>; RULES.len()],
    /// Stamp of the last message.
    before: Stamp,
    torque: [f64; JOINTS],
    /// Number of commands with a torque that the drives clamp.
    pub clamped: usize,
    /// Number of checked messages.
    pub count: usize,
}

/// The expected stamp.
#[derive(Clone, Copy)]
pub struct Expected {
    /// 0 if the sender chooses it.
    pub run: u64,
    pub ack: u64,
    pub sim_ns: u64,
    /// Earliest and latest time of sending.
    pub sent_ns: [u64; 2],
}

impl Stamps {
    /// Checks a message; returns whether its check sum is valid.
    pub fn check<M: Stamped>(&mut self, message: &M, expected: Expected) -> bool {
        let (stamp, before) = (*message.stamp(), self.before);
        self.count += 1;
        let number = stamp.seq;
        if !message.is_sound() {
            let what = if message.is_ours() { "check sum" } else { "magic or schema" };
            self.keep_first(0, || format!("the {what} of number {number} is wrong"));
            return false;
        }
        let is_first = before.seq == 0;
        let begins = before.run != stamp.run;
        let Expected { run, ack, sim_ns, sent_ns: [from, to] } = expected;
        if run != 0 && stamp.run != run {
            self.keep_first(1, || format!("number {number} is for run {:x}, not {run:x}", stamp.run));
        } else if stamp.run == 0 {
            self.keep_first(1, || "the run is number 0".into());
        } else if !is_first && stamp.epoch != before.epoch {
            self.keep_first(1, || format!("epoch {:x} became {:x} at number {number}", before.epoch, stamp.epoch));
        }
        let next = if begins { 1 } else { before.seq + 1 };
        if number != next {
            self.keep_first(2, || format!("received number {number} instead of {next}"));
        }
        if stamp.ack != ack {
            self.keep_first(3, || format!("number {number} has ack {} instead of {ack}", stamp.ack));
        }
        if stamp.sim_ns != sim_ns {
            self.keep_first(4, || format!("number {number} has sim_ns {} instead of {sim_ns}", stamp.sim_ns));
        } else if !(from..=to).contains(&stamp.mono_ns) {
            self.keep_first(4, || {
                format!("number {number} has mono_ns {}, which is not between {from} and {to}", stamp.mono_ns)
            });
        }
        self.before = stamp;
        true
    }

    /// Checks a command; returns whether its check sum is valid.
    pub fn check_command(&mut self, command: &Command, expected: Expected, limit: f64) -> bool {
        let begins = self.before.run != command.stamp.run;
        if !self.check(command, expected) {
            return false;
        }
        let (number, torque) = (command.stamp.seq, command.torques.torque);
        let before = if begins { [0.0; JOINTS] } else { self.torque };
        if let Some(joint) = torque.iter().position(|torque| !torque.is_finite()) {
            self.keep_first(5, || format!("torque[{joint}] of number {number} is {}", torque[joint]));
            return true;
        }
        for (joint, (&now, &then)) in torque.iter().zip(&before).enumerate() {
            if now.abs() > NONSENSE * limit {
                self.keep_first(6, || format!("torque[{joint}] of number {number} is {now} N·m"));
            } else if (now - then.clamp(-limit, limit)).abs() > FULL_SWING * limit {
                self.keep_first(6, || format!("torque[{joint}] of number {number} jumps from {then} to {now} N·m"));
            }
        }
        self.clamped += usize::from(torque.iter().any(|torque| torque.abs() > limit));
        self.torque = torque;
        true
    }

    /// Keeps the first violation of a rule.
    fn keep_first(&mut self, rule: usize, what: impl FnOnce() -> String) {
        self.broken[rule].get_or_insert_with(what);
    }

    /// The first violation, if any.
    pub fn first_break(self) -> Option<String> {
        self.broken.into_iter().flatten().next()
    }

    /// Reports all rules; those about torques only with `commands`.
    pub fn report(self, report: &mut RuleReport, commands: bool) {
        let count = if commands { RULES.len() } else { 5 };
        for ((rule, section), broken) in RULES.into_iter().zip(self.broken).take(count) {
            let remark = if rule == RULES[0].0 { format!("{} messages", self.count) } else { String::new() };
            report.rule(rule, section, broken.map_or(Ok(remark), Err));
        }
    }
}
