//! `chart.csv`: one row for each measurement; the source of all drawings.

use std::fmt::Write;
use strum::VariantArray;

/// The first line.
pub const HEADER: &str = "view,scene,engine,method,dt,metric,error,cpu_s_per_sim_s,us_per_step";
/// The engine of this project.
pub const OURS: &str = "biped";

/// The chart that a row is drawn in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray)]
pub enum View {
    /// Error against cost over step lengths.
    Precision,
    /// Time per step of 1 ms.
    Steps,
    /// Failures and thresholds.
    Failures,
    /// Size of the model against cost.
    Models,
}

impl View {
    /// The view with this name in the table.
    pub fn named(name: &str) -> Option<View> {
        View::VARIANTS.iter().copied().find(|view| view.name() == name)
    }

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            View::Precision => "precision",
            View::Steps => "step",
            View::Failures => "failure",
            View::Models => "model",
        }
    }
}

/// One measurement. A number that does not apply is NaN, and its cell is empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The chart that it is drawn in.
    pub view: View,
    /// Scene.
    pub scene: String,
    /// Simulator.
    pub engine: String,
    /// Law and integrator, or the setting of another simulator.
    pub method: String,
    /// Step [s].
    pub dt: f64,
    /// The measured quantity.
    pub metric: String,
    /// Its value.
    pub error: f64,
    /// CPU time per simulated time [-].
    pub cost: f64,
    /// CPU time per step [µs].
    pub us_per_step: f64,
}

/// The whole table.
pub fn table(rows: &[Row]) -> String {
    let mut text = format!("{HEADER}\n");
    for row in rows {
        let words = [row.view.name(), &row.scene, &row.engine, &row.method].map(cell).join(",");
        let [dt, error] = [row.dt, row.error].map(number);
        // Times vary between runs: three digits are significant.
        let [cost, us] = [row.cost, row.us_per_step].map(|time| number(format!("{time:.2e}").parse().unwrap_or(time)));
        let _ = writeln!(text, "{words},{dt},{},{error},{cost},{us}", cell(&row.metric));
    }
    text
}

/// The rows of a table. Its first lines may be remarks that start with `#`.
///
/// # Errors
/// The first line that is not a row.
pub fn parse(text: &str) -> Result<Vec<Row>, String> {
    let mut lines = text.lines().skip_while(|line| line.starts_with('#'));
    let header = lines.next().unwrap_or_default();
    if header != HEADER {
        return Err(format!("the first line is `{header}`, but it must be `{HEADER}`"));
    }
    lines.enumerate().map(|(i, line)| row(line).ok_or(format!("line {} is no row: `{line}`", i + 2))).collect()
}

fn row(line: &str) -> Option<Row> {
    let cells = split(line);
    let [view, scene, engine, method, dt, metric, error, cost, us_per_step] = <[String; 9]>::try_from(cells).ok()?;
    let value = |cell: String| if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() };
    Some(Row {
        view: View::named(&view)?,
        scene,
        engine,
        method,
        dt: value(dt)?,
        metric,
        error: value(error)?,
        cost: value(cost)?,
        us_per_step: value(us_per_step)?,
    })
}

fn number(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{value:?}") }
}

/// A text, quoted where it holds a comma.
fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// The cells of a line.
fn split(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for part in line.split_inclusive([',', '"']) {
        let (text, end) = match part.strip_suffix([',', '"']) {
            Some(text) => (text, part.chars().last()),
            None => (part, None),
        };
        let last = cells.len() - 1;
        cells[last].push_str(text);
        match end {
            Some('"') => quoted = !quoted,
            Some(',') if quoted => cells[last].push(','),
            Some(_) => cells.push(String::new()),
            None => {}
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_survives_writing_and_reading() {
        let row = |method: &str, cost| Row {
            view: View::Precision,
            scene: "slide".into(),
            engine: "other".into(),
            method: method.into(),
            dt: 1e-3,
            metric: "stop distance".into(),
            error: 0.1 + 0.2,
            cost,
            us_per_step: 2.5,
        };
        let rows = [row("Newton, elliptic", 1.25e-3), row("plain", f64::INFINITY)];
        assert_eq!(parse(&table(&rows)).expect("our own table"), rows);
        let empty = table(&[row("plain", f64::NAN)]);
        assert!(empty.ends_with(",,2.5\n") && parse(&empty).expect("ours")[0].cost.is_nan(), "{empty}");
    }

    #[test]
    fn a_bad_table_is_refused_in_one_sentence() {
        assert!(parse("a,b\n").expect_err("no header").contains("first line"));
        let short = format!("{HEADER}\nprecision,slide\n");
        assert!(parse(&short).expect_err("no row").contains("line 2"));
    }
}
