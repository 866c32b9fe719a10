//! The counters of the plant as a sentence.

use super::declaration::Tally;
use super::names::REFUSALS;
use std::fmt;

/// One sentence that lists every counter of a disturbance that is not zero; empty if all are zero.
impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let counts = [
            (self.skipped, "period", " skipped"),
            (self.held, "period", " on old torques"),
            (self.damped, "period", " damped"),
            (self.faulted, "period", " with the drives off"),
            (self.lost, "command", " lost"),
            (self.takeovers, "controller", " replaced"),
            (self.unrecorded, "period", " not recorded"),
        ];
        let say = |count: u64, what: &str, how: &str| {
            (count > 0).then(|| format!("{count} {what}{}{how}", if count == 1 { "" } else { "s" }))
        };
        let counted = counts.iter().filter_map(|&(count, what, how)| say(count, what, how));
        let refused = self.refused.iter().zip(REFUSALS);
        let refused = refused.filter_map(|(&count, reason)| say(count, "command", &format!(" refused: {reason}")));
        f.write_str(&counted.chain(refused).collect::<Vec<_>>().join("; "))
    }
}
