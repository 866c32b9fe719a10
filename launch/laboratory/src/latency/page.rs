//! The page: drawings, table and targets in one self-contained file.

use super::draw;
use super::results::{Results, micros};
use records::report::plot::escaped;
use records::report::themed_svg;
use records::view::page::article;
use shared::exit::Failure;
use shared::output::{MARK, prepare_folder, write_atomically};
use std::fmt::Write;
use std::io;
use std::path::Path;

/// Creates the folder before the work, and checks that its files can be replaced.
///
/// # Errors
/// A folder that cannot be created, or a file of another program.
pub fn prepare(folder: &Path) -> Result<(), Failure> {
    let drawings = draw::names().map(|name| (format!("{name}.svg"), MARK));
    let others = [("latency.json".into(), "{\n"), ("latency.html".into(), MARK)];
    prepare_folder(folder, &drawings.chain(others).collect::<Vec<_>>())
}

/// Draws everything and writes it into the folder, each drawing as SVG and all together as `latency.html`.
///
/// # Errors
/// Errors of the file system, with the file's name.
pub fn write(folder: &Path, results: &Results) -> io::Result<()> {
    let drawings = draw::all(results);
    for (name, svg) in &drawings {
        write_atomically(&folder.join(name).with_extension("svg"), svg)?;
    }
    let parts = [
        ("host", escaped(&results.host.to_string())),
        ("drawings", drawings.iter().map(|(_, svg)| themed_svg(svg)).collect()),
        ("targets", targets(results)),
        ("series", series(results)),
        ("counts", counts(results)),
    ];
    let page = article("Latency and jitter", include_str!("page.html"), &parts);
    write_atomically(&folder.join("latency.html"), &page)
}

fn targets(results: &Results) -> String {
    results.targets.iter().fold(String::new(), |mut text, target| {
        let (class, verdict) = if target.met { ("good", "met") } else { ("bad", "not met") };
        let _ = writeln!(
            text,
            "<tr><td>{}</td><td>{:.2}</td><td>{:.1}</td><td class=\"{class}\">{verdict}</td></tr>",
            escaped(target.name),
            target.ratio,
            target.limit,
        );
        text
    })
}

fn series(results: &Results) -> String {
    results.series.iter().fold(String::new(), |mut text, series| {
        let numbers = series.spread.numbers();
        let times = [numbers.median_ns, numbers.p99_ns, numbers.p99_9_ns, numbers.max_ns].map(micros);
        let _ = writeln!(
            text,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escaped(series.section),
            escaped(series.metric),
            times.join("</td><td>"),
            numbers.samples,
        );
        text
    })
}

fn counts(results: &Results) -> String {
    results.counts.iter().fold(String::new(), |mut text, count| {
        let (section, metric) = (escaped(count.section), escaped(count.metric));
        let _ = writeln!(text, "<tr><td>{section}</td><td>{metric}</td><td>{}</td></tr>", count.value);
        text
    })
}
