//! `biped convert`: a recording as CSV tables (one per topic, or one for all topics), or as a repaired MCAP file.

use super::reader::{Payload, RecordingReader};
use super::reindex;
use super::topic::RecordingTopic;
use ::csv::Writer;
use bytemuck::bytes_of;
use clap::Args;
use messages::wire::{Message, Truth};
use shared::args::parse_output;
use shared::csv;
use shared::exit::{Failure, check_interrupt};
use shared::output::{
    AtomicFile, create_failure, create_folder, log, print_text, refuse_overwriting_input, write_failure,
};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// First bytes of every table: an existing file is replaced only if it begins with them.
const HEAD: &[u8] = b"time_s,";

/// Arguments of `biped convert`.
#[derive(Args)]
pub struct ConvertArgs {
    /// The recording
    file: PathBuf,
    #[command(flatten)]
    to: ConvertTarget,
}

/// The output format.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct ConvertTarget {
    /// Write one table per topic into this folder: sensors.csv, command.csv, telemetry.csv, truth.csv, served.csv (requests)
    #[arg(long, value_name = "DIR", value_parser = parse_output)]
    csv: Option<PathBuf>,
    /// Write one table into this file: a row per control period, with the latest values of all topics
    #[arg(long, value_name = "FILE", value_parser = parse_output)]
    table: Option<PathBuf>,
    /// Write a complete MCAP file with index, even if the recording is truncated
    #[arg(long, value_name = "FILE", value_parser = parse_output)]
    mcap: Option<PathBuf>,
}

/// Converts a recording.
///
/// # Errors
/// See [`RecordingReader::open`]. Also if an output file cannot be written.
pub fn run(args: &ConvertArgs, stop: &AtomicBool) -> Result<(), Failure> {
    if let Some(file) = &args.to.mcap {
        return reindex::run(&args.file, file, stop);
    }
    let mut reader = RecordingReader::open(&args.file)?;
    let tables = match (&args.to.csv, &args.to.table) {
        (Some(folder), _) => table_per_topic(&mut reader, &args.file, folder, stop)?,
        (_, Some(file)) => joint_table(&mut reader, &args.file, file, stop)?,
        (None, None) => vec![],
    };
    if tables.is_empty() {
        return Err(reader.lacks(&args.file, "messages to convert"));
    }
    tables.into_iter().try_for_each(CsvTable::finish)?;
    if let Some(why) = reader.truncated_by {
        log(format_args!("{} is cut short: {why}; the tables contain everything before that", args.file.display()));
    }
    Ok(())
}

/// Writes a table per topic.
fn table_per_topic(
    reader: &mut RecordingReader,
    from: &Path,
    into: &Path,
    stop: &AtomicBool,
) -> Result<Vec<CsvTable>, Failure> {
    create_folder(into)?;
    let mut tables = BTreeMap::new();
    while let Some(message) = reader.next_message() {
        check_interrupt(stop)?;
        let (topic, bytes) = match &message.payload {
            Payload::Sensors(sensors) => (RecordingTopic::Sensors, bytes_of(sensors)),
            Payload::Command(command) => (RecordingTopic::Command, bytes_of(command)),
            Payload::Telemetry(telemetry) => (RecordingTopic::Telemetry, bytes_of(telemetry)),
            Payload::Truth(truth) => (RecordingTopic::Truth, bytes_of(&**truth)),
            Payload::Served(served) => (RecordingTopic::Served, bytes_of(&**served)),
            Payload::Other => continue,
        };
        if !tables.contains_key(topic.name()) {
            let path = into.join(format!("{}.csv", &topic.name()[1..]));
            tables.insert(topic.name(), CsvTable::create(from, path, topic, topic.omitted())?);
        }
        if let Some(table) = tables.get_mut(topic.name()) {
            table.row(message.time, bytes)?;
        }
    }
    Ok(tables.into_values().collect())
}

/// Writes one table: a row per record of `/truth`, completed by the latest messages of the other topics.
fn joint_table(
    reader: &mut RecordingReader,
    from: &Path,
    path: &Path,
    stop: &AtomicBool,
) -> Result<Vec<CsvTable>, Failure> {
    let (mut table, mut truth) = (None, Truth::default());
    while let Some(time) = reader.next_truth(&mut truth) {
        check_interrupt(stop)?;
        let table = match &mut table {
            Some(table) => table,
            none => none.insert(CsvTable::create(from, path.into(), RecordingTopic::Truth, &[])?),
        };
        table.row(time, bytes_of(&truth))?;
    }
    Ok(table.into_iter().collect())
}

/// A table that is being written. The file appears under its name only when it is complete.
struct CsvTable {
    path: PathBuf,
    draft: AtomicFile,
    file: Writer<File>,
    message: &'static Message,
    omitted: &'static [&'static str],
    rows: u64,
}

impl CsvTable {
    fn create(
        input: &Path,
        path: PathBuf,
        topic: RecordingTopic,
        omitted: &'static [&'static str],
    ) -> Result<CsvTable, Failure> {
        refuse_overwriting_input(input, &path)?;
        let failed = |error| write_failure(&path, &error);
        let draft = AtomicFile::create(&path, HEAD).map_err(|error| create_failure(&path, &error))?;
        let file = csv::writer(draft.file.try_clone().map_err(failed)?);
        let message = topic.message();
        let mut table = CsvTable { path, draft, file, message, omitted, rows: 0 };
        let mut names = vec!["time_s".to_string()];
        columns(message, omitted, "", &mut names);
        table.line(&names)?;
        Ok(table)
    }

    fn row(&mut self, time: u64, bytes: &[u8]) -> Result<(), Failure> {
        let mut cells = vec![format!("{}.{:09}", time / 1_000_000_000, time % 1_000_000_000)];
        values(self.message, self.omitted, bytes, &mut cells);
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

/// Names of the columns, such as `stamp.seq` or `angle[3]`.
fn columns(message: &Message, omitted: &[&str], prefix: &str, names: &mut Vec<String>) {
    for field in message.fields.iter().filter(|field| !omitted.contains(&field.name)) {
        let name = format!("{prefix}{}", field.name);
        match (field.message(), field.shape().1) {
            (Some(inner), _) => columns(inner, &[], &format!("{name}."), names),
            (None, Some(count)) => names.extend((0..count).map(|index| format!("{name}[{index}]"))),
            (None, None) => names.push(name),
        }
    }
}

/// Values of the columns. The decimal numbers determine the binary values exactly.
fn values(message: &Message, omitted: &[&str], bytes: &[u8], cells: &mut Vec<String>) {
    for field in message.fields.iter().filter(|field| !omitted.contains(&field.name)) {
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
