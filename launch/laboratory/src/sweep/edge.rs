//! `--edge`: the values of a key at which survival changes. Neighbouring values that differ in survival are bisected.
//!
//! Survival need not be monotonic: every change between two neighbours is reported, and two changes between the same neighbours
//! are not seen.

use super::figures::{Survival, cells};
use super::grid::Grid;
use crate::batch::table::{Form, Row, Table};
use crate::study;
use messages::wire::{FNV_START, fnv1a};
use rayon::prelude::*;
use shared::csv;
use shared::exit::{Exit, Failure};
use shared::progress::BatchProgress;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// The table of the edges that an unfinished search has found.
const FOUND: &str = "edges-found.csv";
/// The default tolerance, relative to the range.
const TOLERANCE: f64 = 1e-3;

/// A change of survival.
pub struct Edge {
    /// Number of the run before the change; its other values hold for the edge too.
    pub run: usize,
    /// Value of the key [its unit].
    pub value: f64,
    /// The change is within this distance of the value [its unit].
    half_width: f64,
    /// Whether the robot survives above the value, and not below; otherwise below, and not above.
    above: bool,
    /// Whether the scene is refused on the other side, so that no robot falls there.
    pub refused: bool,
}

/// The tolerance of the arguments, or the default.
///
/// # Errors
/// If it is not greater than 0.
pub fn tolerance(given: Option<f64>, grid: &Grid) -> Result<f64, Failure> {
    let ends = [grid.axes[0].values.first(), grid.axes[0].values.last()].map(number);
    match given {
        None => Ok(TOLERANCE * (ends[1] - ends[0]).abs()),
        Some(tolerance) if tolerance > 0.0 && tolerance.is_finite() => Ok(tolerance),
        Some(tolerance) => {
            Err(Failure::new(Exit::Usage, format!("--tolerance {tolerance}: a number greater than 0 is needed")))
        }
    }
}

/// Finds every edge of the first axis. The edges found so far are in a table in `out`, with which an interrupted search goes on.
///
/// # Errors
/// Ctrl-C, a bad scene, or a table that cannot be written.
pub fn find(
    grid: &Grid,
    survival: &Survival,
    rows: &[Row],
    tolerance: f64,
    out: &Path,
    quiet: bool,
    stop: &AtomicBool,
) -> Result<Vec<Edge>, Failure> {
    let stride = rows.len() / grid.axes[0].values.len();
    let holds = |run: usize| survival.holds(&rows[run].results);
    let mut brackets: Vec<usize> = (0..rows.len() - stride).filter(|run| holds(*run) != holds(run + stride)).collect();
    brackets.sort_by_key(|run| (run % stride, run / stride));
    let (path, form) = (out.join(FOUND), form(grid, survival, tolerance, &brackets));
    let table = Table::resume(&path, &form)?;
    let missing: Vec<usize> = (0..brackets.len()).filter(|edge| !table.has(*edge)).collect();
    let counter = BatchProgress::new(quiet, brackets.len(), brackets.len() - missing.len(), "thresholds");
    let bisect = |&edge: &usize| {
        let run = brackets[edge];
        let [low, high] = [run, run + stride].map(|run| number(grid.axes[0].values.get(grid.runs[run][0])));
        let others = grid.settings(&grid.runs[run]).split_off(1);
        let survives = |value: f64| {
            let setting = format!("{}={value}", grid.axes[0].key);
            let scene = grid.scene(&[vec![setting], others.clone()].concat())?;
            Ok(survival.holds(&cells(&study::observe(&grid.axes[0].key, &scene, stop)?, &scene)))
        };
        let ends = bisected(low, high, holds(run), tolerance, survives)?;
        let above = holds(run) == (low > high);
        let outside = format!("{}={}", grid.axes[0].key, ends[usize::from(holds(run))]);
        let refused = study::is_refused(&grid.scene(&[vec![outside], others.clone()].concat())?);
        let (value, half_width) = middle(ends);
        table.append(edge, &[value.to_string(), half_width.to_string(), above.to_string(), refused.to_string()])?;
        counter.add_done(1);
        Ok(())
    };
    let done = missing.par_iter().try_for_each(bisect);
    counter.finish();
    let found: Vec<_> = table.finish()?;
    done.map_err(|failure: Failure| match failure.exit {
        Exit::Interrupted => {
            let (count, all) = (found.iter().flatten().count(), brackets.len());
            let words = format!("interrupted: {count} of {all} thresholds are in {}", path.display());
            Failure::new(Exit::Interrupted, format!("{words}; run the same command again to go on"))
        }
        _ => failure,
    })?;
    let _ = std::fs::remove_file(&path); // edges.csv has them all
    let edge = |(&run, row): (&usize, &Row)| Edge {
        run,
        value: number(row.results.first()),
        half_width: number(row.results.get(1)),
        above: row.results[2] == "true",
        refused: row.results[3] == "true",
    };
    Ok(brackets.iter().zip(found.iter().flatten()).map(edge).collect())
}

/// The form of the table of edges found so far: a row for each pair of neighbours that differ in survival.
fn form(grid: &Grid, survival: &Survival, tolerance: f64, brackets: &[usize]) -> Form {
    let condition = format!("{}{}{tolerance:e}", grid.form.begin, grid.title(survival));
    let hash =
        brackets.iter().fold(fnv1a(FNV_START, condition.as_bytes()), |hash, run| fnv1a(hash, &run.to_le_bytes()));
    let names = ["edge", "run", "value", "half_width", "above", "refused"];
    Form::new("edge", hash, brackets.iter().map(|run| vec![run.to_string()]).collect(), names, 4)
}

/// The ends of an interval with a change, `at_from` first. Half its width is at most `tolerance` if numbers are close enough.
fn bisected(
    mut from: f64,
    mut to: f64,
    at_from: bool,
    tolerance: f64,
    survives: impl Fn(f64) -> Result<bool, Failure>,
) -> Result<[f64; 2], Failure> {
    loop {
        let (middle, half) = middle([from, to]);
        if half <= tolerance || middle == from || middle == to {
            return Ok([from, to]);
        }
        *if survives(middle)? == at_from { &mut from } else { &mut to } = middle;
    }
}

/// The middle and half the width of an interval.
fn middle([from, to]: [f64; 2]) -> (f64, f64) {
    (0.5 * (from + to), 0.5 * (to - from).abs())
}

/// Sentences about the edges: at least one for each combination of the other values. `survives` says which runs do.
pub fn summary(grid: &Grid, edges: &[Edge], survives: &[bool]) -> String {
    let axis = &grid.axes[0];
    let (first, last, count) = (&axis.values[0], &axis.values[axis.values.len() - 1], axis.values.len());
    let stride = survives.len() / count;
    let line = |edge: &Edge| {
        let digits = (1.0 - edge.half_width.log10().floor()).clamp(0.0, 15.0) as usize;
        let (yes, no) = if edge.above { ("above", "below") } else { ("below", "above") };
        let Edge { value, half_width, .. } = edge;
        let otherwise = if edge.refused { "refused" } else { "not" };
        format!("{} = {value:.digits$} ± {half_width:.digits$}: survives {yes}, {otherwise} {no}\n", axis.key)
    };
    let row = |row: usize| {
        let others = grid.settings(&grid.runs[row]).split_off(1).join(" ");
        let begin = if others.is_empty() { others } else { others + ": " };
        let mut lines: Vec<String> = edges.iter().filter(|edge| edge.run % stride == row).map(line).collect();
        if lines.is_empty() {
            lines.push(match survives.iter().skip(row).step_by(stride).any(|survives| *survives) {
                true => format!("survival does not change with {} from {first} to {last}\n", axis.key),
                false => format!("no run with {} from {first} to {last} survives\n", axis.key),
            });
        }
        lines.iter().map(|line| format!("{begin}{line}")).collect::<String>()
    };
    let found: String = (0..stride).map(row).collect();
    let remark = "survival need not be monotonic: changes between two neighbours that survive alike are not found";
    format!("{found}{count} values of {} were compared; {remark}\n", axis.key)
}

/// The edges as a table.
pub fn table(grid: &Grid, edges: &[Edge]) -> String {
    let names =
        grid.axes.iter().map(|axis| axis.key.clone()).chain(["half_width", "survives", "refused"].map(String::from));
    let row = |edge: &Edge| {
        let others = grid.axes.iter().zip(&grid.runs[edge.run]).skip(1).map(|(axis, k)| axis.values[*k].clone());
        let side = if edge.above { "above" } else { "below" };
        let [value, half_width] = [edge.value, edge.half_width].map(|number| number.to_string());
        [value].into_iter().chain(others).chain([half_width, side.into(), edge.refused.to_string()]).collect::<Vec<_>>()
    };
    let rows = [names.collect::<Vec<_>>()].into_iter().chain(edges.iter().map(row));
    format!("# biped {} thresholds of survival\n{}", env!("CARGO_PKG_VERSION"), csv::text(rows))
}

fn number(text: Option<&String>) -> f64 {
    text.and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bisection_ends_within_the_tolerance_or_at_neighbouring_numbers() {
        for (from, to, at_from) in [(0.0, 1.0, true), (1.0, 0.0, false)] {
            let ends = bisected(from, to, at_from, 1e-3, |x| Ok(x < 0.7)).expect("no error");
            assert!(ends.map(|end| end < 0.7) == [at_from, !at_from], "{ends:?}");
            let (value, half) = middle(ends);
            assert!((value - 0.7).abs() <= half && half <= 1e-3, "{value} ± {half}");
            let (value, half) = middle(bisected(from, to, at_from, 1e-300, |x| Ok(x < 0.7)).expect("no error"));
            assert!((value - 0.7).abs() < 1e-15 && half < 1e-15, "{value} ± {half}");
        }
    }
}
