//! The requests that a session answered. A run without requests is reproducible bit for bit. A run with requests is
//! reproducible together with this list.

use messages::legible;
use messages::port::{Action, GaitRequest, Verdict};
use messages::robot::Body;
use messages::session::user_name;
use messages::wire::{REQUESTS, Served};
use serde::Serialize;

/// Number of requests that are stored; further ones are only counted.
const MAX_STORED: usize = 1000;

/// The requests of a run, in the order of the answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RequestLog {
    /// The first [`MAX_STORED`] requests.
    pub list: Vec<RequestRecord>,
    /// Number of all requests.
    pub count: u64,
}

/// An answered request. Only the values that its kind has are present.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RequestRecord {
    /// Simulated time at which it took effect [s].
    pub time_s: f64,
    /// Kind, as named in the wire format.
    pub kind: &'static str,
    /// `done`, or the reason for the refusal.
    pub answer: &'static str,
    /// The other user who sent it through a share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub user: Option<String>,
    /// Push: index of the body in the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<usize>,
    /// Push: impulse in the world frame [N·s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impulse_ns: Option<[f64; 3]>,
    /// Push: duration [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_s: Option<f64>,
    /// Step: number of control periods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periods: Option<u64>,
    /// Reset: seed of the new run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Set: period of two steps [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Set: walking speed [m/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<f64>,
}

impl RequestRecord {
    /// The record of a wire message.
    pub fn new(served: &Served) -> RequestRecord {
        let mut record = RequestRecord {
            time_s: served.stamp.time(),
            kind: REQUESTS.get(served.request.kind as usize).copied().unwrap_or("unknown"),
            answer: Verdict::text(served.verdict),
            user: served.request.other_user().map(user_name),
            body: None,
            impulse_ns: None,
            over_s: None,
            periods: None,
            seed: None,
            period_s: None,
            speed_mps: None,
        };
        match Action::decode(&served.request) {
            Ok(Action::Push { body, impulse, duration }) => {
                (record.body, record.impulse_ns, record.over_s) = (Some(body), Some(impulse), Some(duration));
            }
            Ok(Action::Step { periods }) => record.periods = Some(periods),
            Ok(Action::Reset { seed }) => record.seed = seed,
            Ok(Action::Gait(GaitRequest::Set { period, speed })) => {
                (record.period_s, record.speed_mps) = (period, speed)
            }
            Ok(Action::Pause | Action::Resume | Action::Rearm | Action::Gait(GaitRequest::Stop)) | Err(_) => (),
        }
        record
    }

    /// One line of text. A body has the name that the scene's bodies give it.
    pub fn text(&self, bodies: &[Body]) -> String {
        let named = |index: usize| bodies.get(index).map_or(index.to_string(), |body| format!("`{}`", body.name));
        let RequestRecord { kind, answer, time_s, .. } = self;
        let values = [
            self.impulse_ns.map(|[x, y, z]| [x, y, z].map(legible).join(",") + " N·s"),
            self.body.map(|body| format!("body {}", named(body))),
            self.periods.map(|periods| format!("{periods} periods")),
            self.seed.map(|seed| format!("seed {seed}")),
            self.period_s.map(|period| format!("period {} s", legible(period))),
            self.speed_mps.map(|speed| format!("speed {} m/s", legible(speed))),
        ];
        let values: String = values.into_iter().flatten().map(|value| format!(" {value}")).collect();
        let refused = match *answer == Verdict::text(Verdict::Done as u64) {
            true => String::new(),
            false => format!(" (refused: {answer})"),
        };
        let user = self.user.as_ref().map_or(String::new(), |user| format!(" by {user}"));
        format!("{kind}{values} at {time_s:.3} s{user}{refused}")
    }
}

impl RequestLog {
    /// Adds a request.
    pub fn push(&mut self, served: &Served) {
        self.count += 1;
        if self.list.len() < MAX_STORED {
            self.list.push(RequestRecord::new(served));
        }
    }

    /// The first few requests as text. Empty without requests.
    pub fn text(&self, bodies: &[Body]) -> String {
        const SHOWN: usize = 5;
        let mut texts: Vec<String> = self.list.iter().take(SHOWN).map(|request| request.text(bodies)).collect();
        if self.count > SHOWN as u64 {
            texts.push(format!("{} more", self.count - SHOWN as u64));
        }
        texts.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::scene::Scene;
    use messages::wire::{Stamp, Stamped};

    fn served(ask: Action, verdict: Verdict) -> Served {
        let stamp = Stamp { sim_ns: 1_500_000_000, ..Stamp::default() };
        Served { stamp, request: ask.encode().sealed(), verdict: verdict as u64 }
    }

    #[test]
    fn the_text_of_a_request_contains_its_values_and_its_answer() {
        let push = Action::Push { body: 4, impulse: [0.0, 3.0, 0.0], duration: 0.05 };
        let record = RequestRecord::new(&served(push, Verdict::Done));
        let bodies = Scene::default().bodies;
        assert_eq!(record.text(&bodies), "push 0,3,0 N·s body `trunk` at 1.500 s");
        assert_eq!(record.text(&[]), "push 0,3,0 N·s body 4 at 1.500 s");
        let json = serde_json::to_value(&record).unwrap();
        let keys = json.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
        assert_eq!(keys, ["answer", "body", "impulse_ns", "kind", "over_s", "time_s"]);
        for (speed, words) in [(99.0, "99"), (1e300, "1e300")] {
            let set = served(Action::Gait(GaitRequest::Set { period: None, speed: Some(speed) }), Verdict::OutOfRange);
            let text = RequestRecord::new(&set).text(&bodies);
            assert_eq!(text, format!("set speed {words} m/s at 1.500 s (refused: a number is out of range)"));
        }
    }

    #[test]
    fn the_list_is_bounded_and_the_count_is_exact() {
        let mut requests = RequestLog::default();
        assert_eq!(requests.text(&[]), "");
        (0..5000).for_each(|_| requests.push(&served(Action::Pause, Verdict::Done)));
        assert_eq!((requests.list.len(), requests.count), (MAX_STORED, 5000));
        assert!(requests.text(&[]).ends_with("; 4995 more"));
    }
}
