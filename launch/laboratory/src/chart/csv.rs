//! `chart.csv`: one row for each measurement; the source of all drawings.

use shared::csv;
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

    /// Name in the table.
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
pub struct Measurement {
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
    /// Value.
    pub error: f64,
    /// CPU time per simulated time [-].
    pub cost: f64,
    /// CPU time per step [µs].
    pub us_per_step: f64,
}

/// The whole table.
pub fn table(rows: &[Measurement]) -> String {
    let cells = |row: &Measurement| {
        // Times vary between runs: three digits are significant.
        let [cost, us] = [row.cost, row.us_per_step].map(|time| format!("{time:.2e}").parse().unwrap_or(time));
        let [scene, engine, method, metric] = [&row.scene, &row.engine, &row.method, &row.metric].map(String::clone);
        let [dt, error, cost, us] = [row.dt, row.error, cost, us].map(number);
        vec![row.view.name().into(), scene, engine, method, dt, metric, error, cost, us]
    };
    let header = HEADER.split(',').map(String::from).collect();
    csv::text([header].into_iter().chain(rows.iter().map(cells)))
}

/// The rows of a table. Its first lines may be remarks that start with `#`. No number may be negative.
///
/// # Errors
/// The first line that is not a row.
pub fn parse(text: &str) -> Result<Vec<Measurement>, String> {
    let lines = csv::rows(text)?;
    let header = lines.first().map_or(String::new(), |cells| cells.join(","));
    if header != HEADER {
        return Err(format!("the first line is `{header}`, but it must be `{HEADER}`"));
    }
    let refused = |i: usize, cells: &[String]| format!("row {} is no measurement: `{}`", i + 1, cells.join(","));
    lines.iter().enumerate().skip(1).map(|(i, cells)| row(cells).ok_or_else(|| refused(i, cells))).collect()
}

fn row(cells: &[String]) -> Option<Measurement> {
    let [view, scene, engine, method, dt, metric, error, cost, us_per_step] =
        <[String; 9]>::try_from(cells.to_vec()).ok()?;
    let number = |cell: String| cell.parse().ok().filter(|value| *value >= 0.0);
    let value = |cell: String| if cell.is_empty() { Some(f64::NAN) } else { number(cell) };
    Some(Measurement {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_survives_writing_and_reading() {
        let row = |method: &str, cost| Measurement {
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
        assert!(parse(&short).expect_err("no row").contains("row 2"));
        for negative in ["-1e-3,stop,1e-4,1.0,1.0", "1e-3,stop,-1e-4,1.0,1.0", "1e-3,stop,1e-4,1.0,NaN"] {
            let row = format!("{HEADER}\nprecision,slide,other,plain,{negative}\n");
            assert!(parse(&row).expect_err("no number").contains("row 2"), "{negative}");
        }
    }
}
