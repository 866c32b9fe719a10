//! Tables in Markdown, printed and written.

use super::args::{Study, StudyArgs};
use shared::exit::Failure;
use shared::output::{prepare_folder, print_text, write_atomically, write_failure};
use std::fmt::Write;
use std::io;
use std::path::Path;

/// A table in Markdown.
pub fn table(rows: &[Vec<String>]) -> String {
    let widest = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows.first().map_or(0, Vec::len)).map(widest).collect();
    let mut text = String::new();
    for (i, row) in rows.iter().enumerate() {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!(" {cell:<width$} |"));
        let _ = writeln!(text, "|{}", cells.collect::<String>());
        if i == 0 {
            let rule = widths.iter().map(|width| format!("{}|", "-".repeat(width + 2)));
            let _ = writeln!(text, "|{}", rule.collect::<String>());
        }
    }
    text
}

/// Prints tables. With `--out`, also writes them: all into one Markdown file, and each into a file of comma-separated values.
///
/// # Errors
/// A folder that cannot be written.
pub fn publish(args: &StudyArgs, markdown: &str, tables: &[(&str, String)]) -> Result<(), Failure> {
    print_text(markdown);
    match &args.out {
        None => Ok(()),
        Some(folder) => write(folder, args.study, markdown, tables).map_err(|error| write_failure(folder, &error)),
    }
}

/// Creates the folder before the work, and checks that the files of this study can be replaced.
///
/// # Errors
/// A folder that cannot be created, or a file of another program.
pub fn prepare(folder: &Path, study: Study) -> Result<(), Failure> {
    let first = match study {
        Study::Problems => "family",
        Study::Pushes => "gait",
        Study::Margins | Study::Laws | Study::Attraction | Study::Endurance => "case",
    };
    let name = format!("{study:?}").to_lowercase();
    let (markdown, csv) = (format!("| {first} "), format!("{first},"));
    let mut files = vec![(format!("{name}.md"), markdown.as_str()), (format!("{name}.csv"), &csv)];
    if let Study::Pushes = study {
        files.push((format!("{name}-walks.csv"), "walks,"));
    }
    prepare_folder(folder, &files)
}

fn write(folder: &Path, study: Study, markdown: &str, tables: &[(&str, String)]) -> io::Result<()> {
    let name = format!("{study:?}").to_lowercase();
    write_atomically(&folder.join(format!("{name}.md")), markdown)?;
    tables.iter().try_for_each(|(of, csv)| write_atomically(&folder.join(format!("{name}{of}.csv")), csv))
}
