//! The table in the terminal and on the page: what applies to the run, in words.

use super::Summary;
use std::fmt::{self, Display};

impl Summary {
    /// The table: name and value with unit, only what applies to this run.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let outcome = match (self.fall_time_s, self.cut_short_by) {
            (Some(time), None) => format!("FELL after {time:.2} s"),
            (Some(time), Some(cause)) => {
                format!("FELL after {time:.2} s, CUT SHORT after {:.2} s: {cause}", self.duration_s)
            }
            (None, Some(cause)) => format!("CUT SHORT after {:.2} s: {cause}", self.duration_s),
            (None, None) if self.steps > 0 => "no fall".into(),
            (None, None) => "completed".into(),
        };
        let simulated = match self.wall_s {
            0.0 => format!("{:.2} s", self.duration_s),
            wall => format!("{:.2} s in {wall:.2} s, {:.0} x real time", self.duration_s, self.realtime_factor),
        };
        let mut lines = vec![
            ("outcome", outcome),
            ("robot", self.robot.clone()),
            ("simulated", simulated),
            ("processes", self.processes.to_string()),
            ("distance", format!("{:.3} m", tidy(self.distance_m))),
            ("sideways", format!("{:+.4} m, yaw {:+.2} deg", tidy(self.lateral_m), tidy(self.yaw_deg))),
            ("speed", format!("{:.4} m/s", tidy(self.speed_mps))),
        ];
        if self.steps > 0 {
            lines.push(("steps", self.steps.to_string()));
            lines.push((
                "period of two steps",
                format!("{:.4} s, std {:.1} ms", self.period_s, 1e3 * self.period_std_s),
            ));
            lines.push(("x2 min", format!("{:.2} mm", 1e3 * self.x2_min_m)));
        }
        if self.peak_torque_nm.iter().any(|torque| *torque != 0.0) {
            lines.push(("peak torque, L to R", format!("{} N m", list(&self.peak_torque_nm))));
            lines.push(("peak power, L to R", format!("{} W", list(&self.peak_power_w))));
        }
        if self.zmp_margin_m.is_finite() {
            lines.push((
                "support foot",
                format!("tilt {:.3} deg, ZMP margin {:.1} mm", self.foot_tilt_max_deg, 1e3 * self.zmp_margin_m),
            ));
        }
        let residuals = format!("Signorini {:.1e}, natural map {:.1e}", self.signorini_max, self.natural_map_max);
        lines.extend([
            ("contact residuals", residuals),
            ("energy gain", format!("{:.1e} J, {} fallbacks", self.energy_gain_max_j, self.fallbacks)),
            ("trajectory hash", self.trajectory_hash.clone()),
        ]);
        lines.retain(|(name, value)| (*name, value.as_str()) != ("processes", "0"));
        if !self.met.is_empty() {
            lines.push(("link", self.met.clone()));
        }
        if self.dropped > 0 {
            lines.push(("not finite", format!("{} records left out", self.dropped)));
        }
        if !self.model.is_empty() {
            lines.push(("model", self.model.clone()));
            let cost = match self.model_cost_ratio {
                1.0 => "that of the full model, which it is".into(),
                ratio => format!("{ratio:.2} of the full model's time for a step"),
            };
            lines.push(("cost of the model", cost));
        }
        lines
    }
}

impl Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        writeln!(out, "{}", self.scene)?;
        self.lines().iter().try_for_each(|(name, value)| writeln!(out, "  {name:<20} {value}"))
    }
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.1}")).collect::<Vec<_>>().join(" ")
}

/// Without the minus sign of a zero.
fn tidy(value: f64) -> f64 {
    if value.abs() < 5e-5 { 0.0 } else { value }
}

#[cfg(test)]
mod tests {
    use crate::exit::{Exit, Failure};
    use crate::record::fake::FakeWalk;
    use crate::summary::tests::summary;

    #[test]
    fn a_run_that_was_cut_short_says_by_what() {
        let outcome = |exit| {
            let fake = FakeWalk::new(0.06);
            let truths = (0..500).map(|seq| fake.truth(seq, seq as f64 * 1e-3));
            summary(truths).ended(Some(&Failure::new(exit, "why"))).lines()[0].1.clone()
        };
        for exit in [Exit::PeerMissing, Exit::Fault, Exit::SharedMemory, Exit::Unsolved, Exit::Interrupted] {
            let text = outcome(exit);
            assert!(text.starts_with("CUT SHORT after 0.50 s: ") && text.ends_with(exit.cause().unwrap()), "{text}");
        }
        assert!(!outcome(Exit::Fell).contains("CUT SHORT"), "a fall is an outcome of its own");
        assert_eq!(summary([]).lines()[0].1, "completed");
    }
}
