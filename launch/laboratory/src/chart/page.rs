//! The page: every drawing with an explanation, in one self-contained file.

use super::cases::{ComparisonScene, LAW, word};
use super::csv::{Measurement, OURS, View};
use super::failures::{Cause, columns};
use super::models::GROUPS;
use super::steps::LOADS;
use super::{bounds, draw, failures};
use records::report::plot::escaped;
use records::report::themed_svg;
use records::view::page::article;
use shared::output::write_atomically;
use std::fmt::Write;
use std::io;
use std::path::Path;
use strum::VariantArray;

/// Draws all views and writes them into the folder, each as SVG and all together as `chart.html`.
///
/// # Errors
/// Errors of the file system, with the file's name.
pub fn write(folder: &Path, chosen: &[ComparisonScene], rows: &[Measurement], remark: &str) -> io::Result<()> {
    let views = [precision(chosen, rows), steps(rows), failures(chosen, rows), models(rows)];
    for (name, svg) in views.iter().flatten() {
        write_atomically(&folder.join(name).with_extension("svg"), svg)?;
    }
    let [precision, steps, failures, models] =
        views.map(|view| view.iter().map(|(_, svg)| themed_svg(svg)).collect::<String>());
    let parts = [
        ("remark", escaped(remark)),
        ("law", word(&LAW)),
        ("precision", precision),
        ("bounds", bounds(chosen, rows)),
        ("steps", steps),
        ("failures", failures),
        ("causes", causes()),
        ("thresholds", thresholds(rows)),
        ("models", models),
    ];
    let page = article("Speed against accuracy", include_str!("page.html"), &parts);
    write_atomically(&folder.join("chart.html"), &page)
}

/// Names of all drawings of these scenes.
pub fn drawings(chosen: &[ComparisonScene]) -> Vec<String> {
    let precision = chosen.iter().map(|case| format!("precision-{}", case.name));
    let steps = LOADS.iter().map(|(scene, ..)| format!("step-{scene}"));
    let models = GROUPS.iter().map(|group| format!("model-{}", group.name));
    precision.chain(steps).chain(["failures".into()]).chain(models).collect()
}

/// Names of files and drawings.
type Drawings = Vec<(String, String)>;

fn precision(chosen: &[ComparisonScene], rows: &[Measurement]) -> Drawings {
    let drawing = |case: &ComparisonScene| Some((format!("precision-{}", case.name), draw::precision(case, rows)?));
    chosen.iter().filter_map(drawing).collect()
}

fn steps(rows: &[Measurement]) -> Drawings {
    let drawing =
        |(scene, title, _): (&str, &str, f64)| Some((format!("step-{scene}"), draw::steps(scene, title, rows)?));
    LOADS.into_iter().filter_map(drawing).collect()
}

fn failures(chosen: &[ComparisonScene], rows: &[Measurement]) -> Drawings {
    draw::failures(&columns(chosen), rows).map(|svg| ("failures".into(), svg)).into_iter().collect()
}

fn models(rows: &[Measurement]) -> Drawings {
    GROUPS.iter().filter_map(|group| Some((format!("model-{}", group.name), draw::models(group, rows)?))).collect()
}

/// The table of costs below an error bound, if other engines were measured.
fn bounds(chosen: &[ComparisonScene], rows: &[Measurement]) -> String {
    let lines = bounds::table(chosen, rows);
    let line = |(i, cells): (usize, &Vec<String>)| {
        let tag = if i == 0 { "th" } else { "td" };
        let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let table: String = lines.iter().enumerate().map(line).collect();
    if table.is_empty() { table } else { format!("{BOUNDS}<div class=\"scroll\"><table>\n{table}</table></div>\n") }
}

/// Text above the table of costs.
const BOUNDS: &str = "<p>The cheapest run within the error bound, in CPU time per simulated time, compared with the fastest and the most \
                      accurate setting of MuJoCo at 1 ms.</p>\n";

/// The legend of the map.
fn causes() -> String {
    Cause::VARIANTS.iter().fold(String::new(), |mut text, cause| {
        let (letter, name) = cause.name().split_at(1);
        let _ = write!(text, "<li><b>{letter}</b>{name}: {}</li>", cause.rule());
        text
    })
}

/// The table of thresholds, measured and exact.
fn thresholds(rows: &[Measurement]) -> String {
    let mut text = String::new();
    let of =
        |row: &Measurement, kind: &str| row.view == View::Failures && row.engine == OURS && row.metric.ends_with(kind);
    for measured in rows.iter().filter(|row| of(row, failures::MEASURED)) {
        let quantity = measured.metric.trim_end_matches(failures::MEASURED);
        let same = |row: &&Measurement| {
            of(row, failures::EXACT)
                && (&row.scene, &row.method) == (&measured.scene, &measured.method)
                && row.metric.starts_with(quantity)
        };
        let exact = rows.iter().find(same).map_or(f64::NAN, |row| row.error);
        let decimals = 6_usize.saturating_sub(exact.log10().max(0.0) as usize); // seven digits
        let _ = writeln!(
            text,
            "<tr><td>{}</td><td>{}</td><td>{quantity}</td><td>{:.decimals$}</td><td>{exact:.decimals$}</td></tr>",
            escaped(&measured.scene),
            escaped(&measured.method),
            measured.error,
        );
    }
    text
}
