//! `biped convert`: a recording as tables, one for each topic of numbers, or one of all of them; or as a whole MCAP file.

use super::reader::{Content, Reader};
use super::rewrite;
use super::topic::Topic;
use ::csv::Writer;
use bytemuck::bytes_of;
use clap::Args;
use messages::wire::{Message, Truth};
use shared::csv;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::{AtomicFile, create_folder, log, print_text, write_failure};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// What every table begins with.
const HEAD: &[u8] = b"time_s,";

/// Arguments of `biped convert`.
#[derive(Args)]
pub struct ConvertArgs {
    /// The recording
    file: PathBuf,
    #[command(flatten)]
    to: To,
}

/// What it is made into.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct To {
    /// Write sensors.csv, command.csv, telemetry.csv, truth.csv and, of what was asked at the desks, served.csv into this folder
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    /// Write one table into this file: a row for each control period, with the latest of every topic
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Write it anew as an MCAP file with its index, also if it was cut short
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
}

/// Converts it.
///
/// # Errors
/// See [`Reader::open`]; or if the folder cannot be written.
pub fn run(args: &ConvertArgs, stop: &AtomicBool) -> Result<(), Failure> {
    if let Some(file) = &args.to.mcap {
        return rewrite::run(&args.file, file, stop);
    }
    let mut reader = Reader::open(&args.file)?;
    let tables = match (&args.to.csv, &args.to.table) {
        (Some(folder), _) => each(&mut reader, folder, stop)?,
        (_, Some(file)) => all(&mut reader, file, stop)?,
        (None, None) => vec![],
    };
    if tables.is_empty() {
        let words = format!("{}: there is nothing in it to make tables of", args.file.display());
        return Err(Failure::new(Exit::Usage, words));
    }
    tables.into_iter().try_for_each(Table::finish)?;
    if let Some(why) = reader.cut {
        log(format_args!("{} is cut short: {why}; the tables have all before that", args.file.display()));
    }
    Ok(())
}

/// All there is, in the table of its topic.
fn each(reader: &mut Reader, into: &Path, stop: &AtomicBool) -> Result<Vec<Table>, Failure> {
    create_folder(into)?;
    let mut tables = BTreeMap::new();
    while let Some(item) = reader.next() {
        check_interrupt(stop)?;
        let (topic, bytes) = match &item.content {
            Content::Sensors(sensors) => (Topic::Sensors, bytes_of(sensors)),
            Content::Command(command) => (Topic::Command, bytes_of(command)),
            Content::Telemetry(telemetry) => (Topic::Telemetry, bytes_of(telemetry)),
            Content::Truth(truth) => (Topic::Truth, bytes_of(&**truth)),
            Content::Served(served) => (Topic::Served, bytes_of(&**served)),
            Content::Other => continue,
        };
        if !tables.contains_key(topic.name()) {
            let path = into.join(format!("{}.csv", &topic.name()[1..]));
            tables.insert(topic.name(), Table::create(path, topic, topic.without())?);
        }
        if let Some(table) = tables.get_mut(topic.name()) {
            table.row(item.time, bytes)?;
        }
    }
    Ok(tables.into_values().collect())
}

/// A table of whole truths.
fn all(reader: &mut Reader, path: &Path, stop: &AtomicBool) -> Result<Vec<Table>, Failure> {
    let (mut table, mut truth) = (None, Truth::default());
    while let Some(time) = reader.next_truth(&mut truth) {
        check_interrupt(stop)?;
        let table = match &mut table {
            Some(table) => table,
            none => none.insert(Table::create(path.into(), Topic::Truth, &[])?),
        };
        table.row(time, bytes_of(&truth))?;
    }
    Ok(table.into_iter().collect())
}

/// A table that is being written; half of one is none.
struct Table {
    path: PathBuf,
    draft: AtomicFile,
    file: Writer<File>,
    message: &'static Message,
    without: &'static [&'static str],
    rows: u64,
}

impl Table {
    fn create(path: PathBuf, topic: Topic, without: &'static [&'static str]) -> Result<Table, Failure> {
        let failed = |error| write_failure(&path, &error);
        let draft = AtomicFile::create(&path, HEAD).map_err(failed)?;
        let file = csv::writer(draft.file.try_clone().map_err(failed)?);
        let message = topic.message();
        let mut table = Table { path, draft, file, message, without, rows: 0 };
        let mut names = vec!["time_s".to_string()];
        columns(message, without, "", &mut names);
        table.line(&names)?;
        Ok(table)
    }

    fn row(&mut self, time: u64, bytes: &[u8]) -> Result<(), Failure> {
        let mut cells = vec![format!("{}.{:09}", time / 1_000_000_000, time % 1_000_000_000)];
        values(self.message, self.without, bytes, &mut cells);
        self.rows += 1;
        self.line(&cells)
    }

    fn line(&mut self, cells: &[String]) -> Result<(), Failure> {
        self.file.write_record(cells).map_err(|error| write_failure(&self.path, &error))
    }

    fn finish(mut self) -> Result<(), Failure> {
        self.file.flush().and_then(|()| self.draft.commit()).map_err(|error| write_failure(&self.path, &error))?;
        print_text(format_args!("{}: {} rows\n", self.path.display(), self.rows));
        Ok(())
    }
}

/// Names of the columns: `stamp.seq`, `angle[3]`.
fn columns(message: &Message, without: &[&str], prefix: &str, names: &mut Vec<String>) {
    for field in message.fields.iter().filter(|field| !without.contains(&field.name)) {
        let name = format!("{prefix}{}", field.name);
        match (field.message(), field.shape().1) {
            (Some(inner), _) => columns(inner, &[], &format!("{name}."), names),
            (None, Some(count)) => names.extend((0..count).map(|index| format!("{name}[{index}]"))),
            (None, None) => names.push(name),
        }
    }
}

/// Their values; a number reads back exactly.
fn values(message: &Message, without: &[&str], bytes: &[u8], cells: &mut Vec<String>) {
    for field in message.fields.iter().filter(|field| !without.contains(&field.name)) {
        let value = &bytes[field.offset..field.offset + field.size()];
        if let Some(inner) = field.message() {
            values(inner, &[], value, cells);
            continue;
        }
        let kind = field.shape().0;
        cells.extend(value.chunks(if kind == "u32" { 4 } else { 8 }).map(|number| match kind {
            "u32" => bytemuck::pod_read_unaligned::<u32>(number).to_string(),
            "u64" => bytemuck::pod_read_unaligned::<u64>(number).to_string(),
            "i64" => bytemuck::pod_read_unaligned::<i64>(number).to_string(),
            _ => bytemuck::pod_read_unaligned::<f64>(number).to_string(),
        }));
    }
}
