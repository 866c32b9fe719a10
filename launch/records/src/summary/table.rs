//! The summary as a table for the terminal and the page. It contains only the values that apply to the run.

use super::Summary;
use std::fmt::{self, Display};

/// Least peak torque of a robot whose torques and powers have one decimal [N·m]. Those of a small robot would be printed as zeros.
const LEAST_TORQUE: f64 = 0.95;

impl Summary {
    /// The outcome of a run to its end: of a robot that steps, which could have fallen, and of another one.
    pub fn success(&self) -> &'static str {
        if self.steps > 0 { "no fall" } else { "completed" }
    }

    /// The lines of the table: name, and value with unit. Values that do not apply or were not measured are omitted.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let end = self.duration_s.max(0.0); // NaN, in a run without records, becomes 0
        let outcome = match (self.fall_time_s, self.cut_short_by) {
            (Some(time), None) => format!("FELL after {time:.2} s"),
            (Some(time), Some(cause)) => format!("FELL after {time:.2} s, CUT SHORT after {end:.2} s: {cause}"),
            (None, Some(cause)) => format!("CUT SHORT after {end:.2} s: {cause}"),
            (None, None) => self.success().into(),
        };
        let simulated = match self.wall_s {
            0.0 => format!("{end:.2} s"),
            wall => {
                let speed = |time: f64| format!("{time:.3} s, {:.0} x real time", end / time);
                let loop_alone =
                    if self.loop_s > 0.0 { format!(", the loop alone {}", speed(self.loop_s)) } else { String::new() };
                let has = |kinds: &[&str]| self.requests.iter().any(|request| kinds.contains(&request.kind));
                let restarted = if has(&["reset"]) { ", with the runs before a reset" } else { "" };
                let paused = if has(&["pause", "step"]) { ", pauses included" } else { "" };
                format!("{end:.2} s in {}{restarted}{loop_alone}{paused}", speed(wall))
            }
        };
        let heading = match self.yaw_deg {
            yaw if yaw.is_nan() => "no yaw, for the x axis of the base is vertical".into(),
            yaw => format!("yaw {:+.2} deg", without_negative_zero(yaw, 2)),
        };
        let sideways = format!("{:+.4} m, {heading}", without_negative_zero(self.lateral_m, 4));
        let period = format!("{:.4} s, std {:.1} ms", self.period_s, 1e3 * self.period_std_s);
        let support = format!(
            "tilt {:.3} deg, ZMP margin {:.1} mm",
            self.foot_tilt_max_deg,
            without_negative_zero(1e3 * self.zmp_margin_m, 1)
        );
        let residuals =
            format!("Signorini {}, natural map {}", scientific(self.signorini_max), scientific(self.natural_map_max));
        let cost = format!("{:.2} of the full model's time", self.model_cost_ratio);
        let is_smaller = self.model_cost_ratio.is_finite() && self.model_cost_ratio != 1.0;
        let (walks, is_driven) = (self.steps > 0, self.peak_torque_nm.iter().any(|torque| *torque != 0.0));
        let is_weak = self.peak_torque_nm.iter().all(|torque| torque.abs() < LEAST_TORQUE);
        // Residuals and energy are shown even if they are NaN, because NaN indicates a failure.
        let lines = [
            ("outcome", true, outcome),
            ("robot", true, self.robot.clone()),
            ("simulated", true, simulated),
            ("processes", self.processes > 0, self.processes.to_string()),
            ("distance", self.distance_m.is_finite(), format!("{:.3} m", without_negative_zero(self.distance_m, 3))),
            ("sideways", self.lateral_m.is_finite(), sideways),
            ("speed", self.speed_mps.is_finite(), format!("{:.4} m/s", without_negative_zero(self.speed_mps, 4))),
            ("steps", walks, self.steps.to_string()),
            ("period of two steps", walks && self.period_s.is_finite(), period),
            ("x2 min", walks && self.x2_min_m.is_finite(), format!("{:.2} mm", 1e3 * self.x2_min_m)),
            ("peak torque, L to R", is_driven, format!("{} N·m", list(&self.peak_torque_nm, is_weak))),
            ("peak power, L to R", is_driven, format!("{} W", list(&self.peak_power_w, is_weak))),
            ("support foot", self.zmp_margin_m.is_finite(), support),
            ("contact residuals", true, residuals),
            (
                "energy gain",
                self.energy_gain_max_j != f64::NEG_INFINITY,
                format!("{} J, {} fallbacks", scientific(self.energy_gain_max_j), self.fallbacks),
            ),
            (
                "energy made",
                self.kinetic_max_j > 0.0,
                format!(
                    "{} J, lost in flight {} J, of {} J of motion at most",
                    scientific(self.energy_made_j),
                    scientific(self.energy_lost_j),
                    scientific(self.kinetic_max_j)
                ),
            ),
            ("trajectory hash", true, self.trajectory_hash.clone()),
            ("link", !self.link_text.is_empty(), self.link_text.clone()),
            ("requests", !self.requests_text.is_empty(), self.requests_text.clone()),
            ("not finite", self.dropped > 0, format!("{} records skipped", self.dropped)),
            ("recording", self.recording_ended_by.is_some(), self.recording_ended_by.clone().unwrap_or_default()),
            ("model", !self.model.is_empty(), self.model.clone()),
            ("cost of the model", is_smaller, cost),
        ];
        lines.into_iter().filter(|line| line.1).map(|(name, _, value)| (name, value)).collect()
    }
}

impl Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        writeln!(out, "{}", self.scene)?;
        self.lines().iter().try_for_each(|(name, value)| writeln!(out, "  {name:<20} {value}"))
    }
}

/// Peak values of all joints: with one decimal, or those of a weak robot with two digits.
fn list(values: &[f64], is_weak: bool) -> String {
    let shown = |value: &f64| if is_weak { scientific(*value) } else { format!("{value:.1}") };
    values.iter().map(shown).collect::<Vec<_>>().join(" ")
}

/// A number with two digits, in scientific notation if it is small or large. Zero is written as 0.
pub fn scientific(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        0.995..9.95 => format!("{value:.1}"),
        _ => format!("{value:.1e}"),
    }
}

/// Avoids the minus sign of a value that is printed as zero with this number of decimals.
fn without_negative_zero(value: f64, decimals: i32) -> f64 {
    if value.abs() < 0.5 * 10_f64.powi(-decimals) { 0.0 } else { value }
}

#[cfg(test)]
mod tests {
    use crate::analysis::synthetic::SyntheticWalk;
    use crate::summary::tests::summary;
    use shared::exit::{Exit, Failure};

    #[test]
    fn the_outcome_of_a_run_that_was_cut_short_names_the_cause() {
        let outcome = |exit| {
            let walk = SyntheticWalk::new(0.06);
            let truths = (0..500).map(|seq| walk.truth(seq, seq as f64 * 1e-3));
            summary(truths).with_end(Some(&Failure::new(exit, "why"))).lines()[0].1.clone()
        };
        for exit in [Exit::PeerMissing, Exit::Fault, Exit::SharedMemory, Exit::Unsolved, Exit::Interrupted] {
            let text = outcome(exit);
            assert!(text.starts_with("CUT SHORT after 0.50 s: ") && text.ends_with(exit.cause().unwrap()), "{text}");
        }
        assert!(!outcome(Exit::Fell).contains("CUT SHORT"), "a fall is an outcome of its own");
        assert_eq!(summary([]).lines()[0].1, "completed");
    }

    #[test]
    fn no_value_that_is_printed_as_zero_has_a_minus_sign() {
        let mut summary = summary([SyntheticWalk::new(0.06).truth(0, 0.0)]);
        for value in [-0.0, -0.000_04] {
            (summary.lateral_m, summary.yaw_deg, summary.distance_m) = (value, 100.0 * value, 10.0 * value);
            (summary.speed_mps, summary.zmp_margin_m) = (value, value);
            let table = summary.to_string();
            assert!(!table.contains("-0.0"), "{table}");
        }
    }

    #[test]
    fn peak_values_are_not_printed_as_zeros_whatever_the_size_of_the_robot() {
        let mut summary = summary([SyntheticWalk::new(0.06).truth(0, 0.0)]);
        for scale in [1e-12, 1e-6, 0.01, 0.05, 1.0, 1e3] {
            summary.peak_torque_nm = [6.5, 6.1, 17.3, 15.7, 15.7, 17.3, 5.8, 5.5].map(|torque| scale * torque);
            summary.peak_power_w = [3.9, 5.1, 12.0, 24.3, 24.1, 12.1, 4.8, 3.9].map(|power| scale * power);
            for (name, exact) in
                [("peak torque, L to R", summary.peak_torque_nm), ("peak power, L to R", summary.peak_power_w)]
            {
                let (_, text) = summary.lines().into_iter().find(|line| line.0 == name).unwrap();
                let shown = text.split(' ').filter_map(|word| word.parse::<f64>().ok()).collect::<Vec<_>>();
                assert_eq!(shown.len(), exact.len(), "{text}");
                assert!(shown.iter().zip(exact).all(|(shown, exact)| (shown - exact).abs() <= 0.05 * exact), "{text}");
            }
        }
        assert!(summary.lines().iter().any(|line| line.1.starts_with("6500.0 6100.0 ")));
    }

    #[test]
    fn values_that_were_not_measured_are_omitted() {
        let walk = SyntheticWalk::new(0.06);
        for count in [0, 1, 2, 2000, 2200] {
            let summary = summary((0..count).map(|seq| walk.truth(seq, seq as f64 * 1e-3)));
            let table = summary.to_string();
            assert!(!table.contains("NaN") && !table.contains("inf"), "{count} records: {table}");
            assert_eq!(table.contains("speed"), count > 1, "{table}");
        }
    }
}
