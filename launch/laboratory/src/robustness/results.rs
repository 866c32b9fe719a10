//! The results of a run as cells of the table.

use crate::study::RunOutcome;
use records::summary::Summary;

/// Columns of the results.
pub const NAMES: [&str; 8] =
    ["outcome", "fall_s", "speed_mps", "period_s", "period_std_ms", "drift_m", "tilt_deg", "hash"];
/// Outcome of a run without a fall.
pub const UP: &str = "up";
/// Column of the standard deviation of the period.
pub const PERIOD_STD: usize = 4;

/// The cells of an outcome. Those that do not apply are empty.
pub fn cells(outcome: &RunOutcome) -> Vec<String> {
    let mut cells = [const { String::new() }; NAMES.len()];
    match outcome {
        Err(words) => cells[0] = words.replace([',', '\n'], ";"),
        Ok(Summary { fall_time_s: Some(time), .. }) => {
            (cells[0], cells[1]) = ("fell".into(), format!("{time:.3}"));
        }
        Ok(up) => {
            let numbers = [
                (up.speed_mps, 4),
                (up.period_s, 4),
                (1e3 * up.period_std_s, 2),
                (up.lateral_max_m, 4),
                (up.foot_tilt_max_deg, 3),
            ];
            cells[0] = UP.into();
            for (cell, (value, digits)) in cells[2..].iter_mut().zip(numbers) {
                *cell = if value.is_finite() { format!("{value:.digits$}") } else { String::new() };
            }
            cells[NAMES.len() - 1] = up.trajectory_hash.clone();
        }
    }
    cells.into()
}
