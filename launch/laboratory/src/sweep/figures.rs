//! The results of a run as cells of the table, and the condition of survival.

use crate::batch::table::Row;
use crate::study::{RunOutcome, is_refused};
use messages::load::suggest;
use messages::scene::Scene;
use serde_json::Value;

/// Columns of the figures, by their names in summary.json. Those that depend on the machine are not among them.
const FIGURES: [&str; 35] = [
    "fall_time_s",
    "duration_s",
    "distance_m",
    "lateral_m",
    "yaw_deg",
    "speed_mps",
    "period_s",
    "period_std_s",
    "x2_min_m",
    "steps",
    "peak_torque_nm[0]",
    "peak_torque_nm[1]",
    "peak_torque_nm[2]",
    "peak_torque_nm[3]",
    "peak_torque_nm[4]",
    "peak_torque_nm[5]",
    "peak_torque_nm[6]",
    "peak_torque_nm[7]",
    "foot_tilt_max_deg",
    "zmp_margin_m",
    "lateral_max_m",
    "hop_max_m",
    "peak_force_n",
    "penetration_max_m",
    "com_speed_end_mps",
    "signorini_max",
    "natural_map_max",
    "energy_gain_max_j",
    "energy_made_j",
    "energy_lost_j",
    "kinetic_max_j",
    "fallbacks",
    "commands_lost",
    "periods_held",
    HASH,
];
/// The only figure that is no number.
pub const HASH: &str = "trajectory_hash";
/// The first column of the results.
pub const OUTCOME: &str = "outcome";
/// The last column: why a run failed.
pub const ERROR: &str = "error";
/// Outcome of a run with a fall, of one that failed, and of one that is refused before its first control period. Any other outcome is that
/// of the run's summary.
const FELL: &str = "fell";
pub const FAILED: &str = "failed";
pub const REFUSED: &str = "refused";

/// Names of the columns of the results.
pub fn names() -> impl Iterator<Item = &'static str> {
    [OUTCOME].into_iter().chain(FIGURES).chain([ERROR])
}

/// The cells of the outcome of a scene. Figures that were not measured are empty.
pub fn cells(outcome: &RunOutcome, scene: &Scene) -> Vec<String> {
    let (word, summary, error) = match outcome {
        Ok(summary) if summary.fell => (FELL, serde_json::to_value(summary), ""),
        Ok(summary) => (summary.success(), serde_json::to_value(summary), ""),
        Err(words) if is_refused(scene) => (REFUSED, Ok(Value::Null), words.as_str()),
        Err(words) => (FAILED, Ok(Value::Null), words.as_str()),
    };
    let summary = summary.unwrap_or_default();
    let figures = FIGURES.iter().map(|name| text(&summary, name));
    [word.into()].into_iter().chain(figures).chain([error.replace('\n', "; ")]).collect()
}

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    Survives,
    /// It fell or failed, or its figure is beyond the limit.
    DoesNot,
    /// Its scene is refused, so no robot fell.
    Refused,
}

/// The runs with an outcome, by their numbers.
pub fn with_outcome<'a>(rows: &'a [Row], outcome: &str) -> Vec<(usize, &'a Row)> {
    rows.iter().enumerate().filter(|(_, row)| row.results[0] == outcome).collect()
}

/// The sentence that says why a run failed or is refused; empty for any other one.
pub fn reason(row: &Row) -> &str {
    row.results.last().map_or("", String::as_str)
}

/// A figure with the digits that summary.json has.
fn text(summary: &Value, name: &str) -> String {
    let (key, index) = name.split_once('[').unwrap_or((name, ""));
    let value = match index.trim_end_matches(']').parse::<usize>() {
        Ok(index) => &summary[key][index],
        Err(_) => &summary[key],
    };
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        number => number.to_string(),
    }
}

/// The condition of survival: no fall and no failure, and, if given, a figure below or above a limit.
pub struct Survival {
    figure: usize,
    /// Whether the figure must be below the limit, and the limit; `None` if it is only drawn.
    limit: Option<(bool, f64)>,
    condition: String,
}

impl Survival {
    /// Reads `FIGURE<LIMIT` or `FIGURE>LIMIT`. Without a text, only falls and failures count.
    ///
    /// # Errors
    /// An unknown figure, or a limit that is no number.
    pub fn parse(text: Option<&str>) -> Result<Survival, String> {
        let Some(text) = text else {
            return Ok(Survival {
                figure: index("distance_m").unwrap_or_default(),
                limit: None,
                condition: String::new(),
            });
        };
        let parts = text.find(['<', '>']).map(|at| (text[..at].trim(), &text[at..at + 1], text[at + 1..].trim()));
        let (name, sign, limit) = parts.ok_or("give a figure with a limit, for example distance_m<0.001")?;
        let figure = index(name).filter(|_| name != HASH).ok_or_else(|| {
            let figures = "the figures are the columns of sweep.csv, such as distance_m or period_std_s";
            format!("there is no figure `{name}`; {figures}{}", suggest(name, FIGURES))
        })?;
        let condition = format!(", {name} {sign} {limit}");
        let limit = limit.parse().ok().filter(|limit: &f64| limit.is_finite());
        let limit = limit.ok_or("the limit is no finite number")?;
        Ok(Survival { figure, limit: Some((sign == "<", limit)), condition })
    }

    /// Whether a run with these results survived. A figure that was not measured is beyond every limit.
    pub fn holds(&self, results: &[String]) -> bool {
        let is_within = |(below, limit): (bool, f64)| match self.value(results) {
            value if below => value < limit,
            value => value > limit,
        };
        ![FELL, FAILED, REFUSED].contains(&results[0].as_str()) && self.limit.is_none_or(is_within)
    }

    /// What became of a run with these results.
    pub fn fate(&self, results: &[String]) -> Fate {
        match results[0] == REFUSED {
            true => Fate::Refused,
            false if self.holds(results) => Fate::Survives,
            false => Fate::DoesNot,
        }
    }

    /// Share of the runs that survive, of those that are not refused; NaN if all are.
    pub fn share(&self, rows: &[Row]) -> f64 {
        let count = |fate: Fate| rows.iter().filter(|row| self.fate(&row.results) == fate).count() as f64;
        let survivors = count(Fate::Survives);
        survivors / (survivors + count(Fate::DoesNot))
    }

    /// The condition on the figure, with a comma before it; empty without one.
    pub fn condition(&self) -> &str {
        &self.condition
    }

    /// Name of the figure.
    pub fn name(&self) -> &'static str {
        FIGURES[self.figure]
    }

    /// Its limit.
    pub fn limit(&self) -> Option<f64> {
        self.limit.map(|(_, limit)| limit)
    }

    /// Its value in these results; NaN if it was not measured.
    pub fn value(&self, results: &[String]) -> f64 {
        results[1 + self.figure].parse().unwrap_or(f64::NAN)
    }
}

fn index(name: &str) -> Option<usize> {
    FIGURES.iter().position(|known| *known == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_decides_on_survival_only_with_a_limit() {
        let cells = |outcome: &str, distance: &str| {
            let figures = FIGURES.map(|name| if name == "distance_m" { distance } else { "" });
            [&[outcome][..], &figures, &[""]].concat().into_iter().map(String::from).collect::<Vec<_>>()
        };
        let holds = |text: Option<&str>, outcome, distance| {
            Survival::parse(text).expect("a survival").holds(&cells(outcome, distance))
        };
        assert!(holds(None, "no fall", "7") && holds(None, "completed", ""));
        assert!(!holds(None, "fell", "7") && !holds(None, "failed", "") && !holds(None, "refused", ""));
        assert!(holds(Some("distance_m<8"), "completed", "7") && !holds(Some("distance_m<7"), "completed", "7"));
        assert!(holds(Some("distance_m > 6"), "completed", "7") && !holds(Some("distance_m>6"), "fell", "7"));
        assert!(!holds(Some("distance_m<8"), "completed", "") && !holds(Some("distance_m>6"), "completed", ""));
    }
}
