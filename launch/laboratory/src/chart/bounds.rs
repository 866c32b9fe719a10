//! The cost of an error below a bound, compared with the cost of another engine that does not reach the bound.

use super::cases::ComparisonScene;
use super::csv::{Measurement, OURS, View};

/// The engine to compare with, and its step [s].
const MEASURE: (&str, f64) = ("MuJoCo", 1e-3);

/// One run of a scene: its error and its cost.
#[derive(Clone, Debug, PartialEq)]
struct BoundedRun<'a> {
    row: &'a Measurement,
    error: f64,
}

/// A table whose first row names the columns. For each scene it has our cheapest run within the bound, and the fastest and the most
/// accurate setting of the other engine at its usual step. Costs are CPU time per simulated time. Without that engine it is empty.
pub fn table(chosen: &[ComparisonScene], rows: &[Measurement]) -> Vec<Vec<String>> {
    let names = [
        "scene",
        "bound",
        "ours",
        "error",
        "cost",
        "MuJoCo's fastest",
        "error",
        "cost",
        "most accurate",
        "error",
        "cost",
    ];
    let mut table = vec![names.map(String::from).to_vec()];
    for case in chosen {
        let runs = runs(case, rows);
        let theirs = || runs.iter().filter(|run| run.row.engine == MEASURE.0 && run.row.dt == MEASURE.1);
        let fastest = theirs().min_by(|a, b| a.row.cost.total_cmp(&b.row.cost));
        let nearest = theirs().min_by(|a, b| a.error.total_cmp(&b.error));
        let within = runs.iter().filter(|run| run.row.engine == OURS && run.error <= case.bound);
        let ours = within.min_by(|a, b| a.row.cost.total_cmp(&b.row.cost));
        let (Some(fastest), Some(nearest)) = (fastest, nearest) else { continue };
        let mut line = vec![case.name.to_string(), format!("{:.0e}", case.bound)];
        for (run, dt) in [(ours, true), (Some(fastest), false), (Some(nearest), false)] {
            let cells = run.map(|run| {
                let step = if dt { format!(", {} ms", 1e3 * run.row.dt) } else { String::new() };
                [format!("{}{step}", run.row.method), format!("{:.0e}", run.error), format!("{:.2e}", run.row.cost)]
            });
            line.extend(cells.unwrap_or_else(|| ["none", "", ""].map(String::from)));
        }
        table.push(line);
    }
    if table.len() > 1 { table } else { Vec::new() }
}

/// Every measured run of a scene, with its largest error.
fn runs<'a>(case: &ComparisonScene, rows: &'a [Measurement]) -> Vec<BoundedRun<'a>> {
    let metrics = case.question.metrics();
    let of_case = |row: &&Measurement| row.view == View::Precision && row.scene == case.name;
    let mut runs: Vec<BoundedRun> = Vec::new();
    for row in rows.iter().filter(of_case).filter(|row| metrics.contains(&row.metric.as_str())) {
        let same = |run: &&mut BoundedRun| {
            (&run.row.engine, &run.row.method, run.row.dt) == (&row.engine, &row.method, row.dt)
        };
        match runs.iter_mut().rev().find(same) {
            Some(run) if row.error > run.error || row.error.is_nan() => run.error = row.error,
            Some(_) => {}
            None => runs.push(BoundedRun { row, error: row.error }),
        }
    }
    runs.retain(|run| run.error.is_finite() && run.row.cost.is_finite());
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::cases::chosen;

    fn row(engine: &str, method: &str, metric: &str, error: f64, cost: f64) -> Measurement {
        Measurement {
            view: View::Precision,
            scene: "slide".into(),
            engine: engine.into(),
            method: method.into(),
            dt: 1e-3,
            metric: metric.into(),
            error,
            cost,
            us_per_step: 1e3 * cost,
        }
    }

    #[test]
    fn the_cheapest_within_the_bound_stands_beside_the_fastest_and_the_nearest() {
        let case = chosen(&["slide".into()]).expect("a case");
        let mut rows = vec![
            row(OURS, "cheap and off", "stop", 1e-2, 1e-4),
            row(OURS, "near, not straight", "stop", 1e-9, 2e-4),
            row(OURS, "near, not straight", "straight", 1e-2, 2e-4),
            row(OURS, "near", "stop", 1e-9, 3e-4),
            row(OURS, "near and dear", "stop", 1e-12, 4e-4),
        ];
        assert!(table(&case, &rows).is_empty(), "nothing to compare with");
        rows.push(row("MuJoCo", "fast", "stop", 1e-1, 1e-3));
        rows.push(row("MuJoCo", "fine", "stop", 1e-2, 1e-2));
        let table = table(&case, &rows);
        assert_eq!(table[1][2..5], ["near, 1 ms", "1e-9", "3.00e-4"]);
        assert_eq!([&table[1][5], &table[1][8]], ["fast", "fine"]);
    }
}
