//! What was asked of a run, and what became of it. A run that nobody spoke to repeats to the bit; one that somebody did, does with
//! these.

use messages::port::{Ask, Verdict};
use messages::wire::{REQUESTS, Served};
use serde::Serialize;

/// So many are listed; more are counted.
const LISTED: usize = 1000;

/// The requests of a run, in the order in which they were answered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RequestLog {
    /// The first of them.
    pub list: Vec<RequestRecord>,
    /// All.
    pub count: u64,
}

/// A request that was answered: its values are those of its kind alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RequestRecord {
    /// Simulated time at which it took effect [s].
    pub time_s: f64,
    /// As the wire names it.
    pub kind: &'static str,
    /// `done`, or why not.
    pub answer: &'static str,
    /// Number of the body that was pushed, in the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<usize>,
    /// Of a push, in the world [N·s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impulse_ns: Option<[f64; 3]>,
    /// Of a push [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_s: Option<f64>,
    /// Control periods that were to be run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periods: Option<u64>,
    /// Seed of the new run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Period of two steps [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Walking speed [m/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<f64>,
}

impl RequestRecord {
    /// As it came over the wire.
    pub fn of(served: &Served) -> RequestRecord {
        let mut asked = RequestRecord {
            time_s: served.stamp.sim_ns as f64 * 1e-9,
            kind: REQUESTS.get(served.request.kind as usize).copied().unwrap_or("unknown"),
            answer: Verdict::words(served.verdict),
            body: None,
            impulse_ns: None,
            over_s: None,
            periods: None,
            seed: None,
            period_s: None,
            speed_mps: None,
        };
        match Ask::of(&served.request) {
            Ok(Ask::Push { body, impulse, duration }) => {
                (asked.body, asked.impulse_ns, asked.over_s) = (Some(body), Some(impulse), Some(duration));
            }
            Ok(Ask::Step { periods }) => asked.periods = Some(periods),
            Ok(Ask::Reset { seed }) => asked.seed = seed,
            Ok(Ask::Set { period, speed }) => (asked.period_s, asked.speed_mps) = (period, speed),
            Ok(Ask::Pause | Ask::Resume | Ask::Rearm) | Err(_) => (),
        }
        asked
    }

    /// In a few words, for a line.
    pub fn words(&self) -> String {
        let RequestRecord { kind, answer, time_s, .. } = self;
        let values = [
            self.impulse_ns.map(|[x, y, z]| format!("{x},{y},{z} N·s")),
            self.body.map(|body| format!("body {body}")),
            self.periods.map(|periods| format!("{periods} periods")),
            self.seed.map(|seed| format!("seed {seed}")),
            self.period_s.map(|period| format!("period {period} s")),
            self.speed_mps.map(|speed| format!("speed {speed} m/s")),
        ];
        let values: String = values.into_iter().flatten().map(|value| format!(" {value}")).collect();
        let refused = match *answer == Verdict::words(Verdict::Done as u64) {
            true => String::new(),
            false => format!(" (refused: {answer})"),
        };
        format!("{kind}{values} at {time_s:.3} s{refused}")
    }
}

impl RequestLog {
    /// One more.
    pub fn push(&mut self, served: &Served) {
        self.count += 1;
        if self.list.len() < LISTED {
            self.list.push(RequestRecord::of(served));
        }
    }

    /// The first few in words; nothing if there were none.
    pub fn words(&self) -> String {
        const SHOWN: usize = 5;
        let mut words: Vec<String> = self.list.iter().take(SHOWN).map(RequestRecord::words).collect();
        if self.count > SHOWN as u64 {
            words.push(format!("{} more", self.count - SHOWN as u64));
        }
        words.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::wire::{Stamp, Stamped};

    fn served(ask: Ask, verdict: Verdict) -> Served {
        let stamp = Stamp { sim_ns: 1_500_000_000, ..Stamp::default() };
        Served { stamp, request: ask.request().sealed(), verdict: verdict as u64 }
    }

    #[test]
    fn a_request_is_told_with_its_values_and_its_answer() {
        let push = Ask::Push { body: 4, impulse: [0.0, 3.0, 0.0], duration: 0.05 };
        let asked = RequestRecord::of(&served(push, Verdict::Done));
        assert_eq!(asked.words(), "push 0,3,0 N·s body 4 at 1.500 s");
        let json = serde_json::to_value(&asked).unwrap();
        let keys = json.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
        assert_eq!(keys, ["answer", "body", "impulse_ns", "kind", "over_s", "time_s"]);
        let refused =
            RequestRecord::of(&served(Ask::Set { period: None, speed: Some(99.0) }, Verdict::OutOfRange)).words();
        assert_eq!(refused, "set speed 99 m/s at 1.500 s (refused: a number is out of range)");
    }

    #[test]
    fn however_many_there_are_the_list_is_bounded_and_the_count_true() {
        let mut requests = RequestLog::default();
        assert_eq!(requests.words(), "");
        (0..5000).for_each(|_| requests.push(&served(Ask::Pause, Verdict::Done)));
        assert_eq!((requests.list.len(), requests.count), (LISTED, 5000));
        assert!(requests.words().ends_with("; 4995 more"));
    }
}
