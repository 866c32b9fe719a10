//! `biped convert`: a recording as tables, one for each topic of numbers.

use super::{Content, Reader, Topic};
use crate::exit::{Exit, Failure, unless};
use crate::output::{folder, say, tell, unwritten};
use bytemuck::bytes_of;
use clap::Args;
use messages::wire::Message;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Arguments of `biped convert`.
#[derive(Args)]
pub struct ConvertArgs {
    /// The recording
    file: PathBuf,
    /// Write sensors.csv, command.csv, telemetry.csv and truth.csv into this folder
    #[arg(long, value_name = "DIR")]
    csv: PathBuf,
}

/// Converts it.
///
/// # Errors
/// See [`Reader::open`]; or if the folder cannot be written.
pub fn run(args: &ConvertArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let mut reader = Reader::open(&args.file)?;
    folder(&args.csv)?;
    let mut tables = BTreeMap::new();
    if let Err(failure) = fill(&mut reader, &args.csv, &mut tables, stop) {
        tables.values().for_each(|table: &Table| _ = std::fs::remove_file(&table.path)); // half of one is none
        return Err(failure);
    }
    if tables.is_empty() {
        return Err(Failure::new(
            Exit::Usage,
            format!("{}: there is nothing in it to make tables of", args.file.display()),
        ));
    }
    for table in tables.into_values() {
        table.finish()?;
    }
    if let Some(why) = reader.cut {
        tell(format_args!("{} is cut short: {why}; the tables have all before that", args.file.display()));
    }
    Ok(())
}

/// Takes all there is into the table of its topic.
fn fill(
    reader: &mut Reader,
    folder: &Path,
    tables: &mut BTreeMap<&'static str, Table>,
    stop: &AtomicBool,
) -> Result<(), Failure> {
    while let Some(item) = reader.next() {
        unless(stop)?;
        let (topic, bytes) = match &item.content {
            Content::Sensors(sensors) => (Topic::Sensors, bytes_of(sensors)),
            Content::Command(command) => (Topic::Command, bytes_of(command)),
            Content::Telemetry(telemetry) => (Topic::Telemetry, bytes_of(telemetry)),
            Content::Truth(truth) => (Topic::Truth, bytes_of(&**truth)),
            Content::Other => continue,
        };
        if !tables.contains_key(topic.name()) {
            tables.insert(topic.name(), Table::create(folder, topic)?);
        }
        if let Some(table) = tables.get_mut(topic.name()) {
            table.row(item.time, bytes)?;
        }
    }
    Ok(())
}

struct Table {
    path: PathBuf,
    file: BufWriter<File>,
    message: &'static Message,
    without: &'static [&'static str],
    rows: u64,
}

impl Table {
    fn create(folder: &Path, topic: Topic) -> Result<Table, Failure> {
        let path = folder.join(format!("{}.csv", &topic.name()[1..]));
        let file = File::create(&path).map_err(|error| unwritten(&path, &error))?;
        let (message, without) = (topic.message(), topic.without());
        let mut table = Table { path, file: BufWriter::new(file), message, without, rows: 0 };
        let mut names = vec!["time_s".to_string()];
        columns(message, without, "", &mut names);
        table.line(&names.join(","))?;
        Ok(table)
    }

    fn row(&mut self, time: u64, bytes: &[u8]) -> Result<(), Failure> {
        let mut text = format!("{}.{:09}", time / 1_000_000_000, time % 1_000_000_000);
        cells(self.message, self.without, bytes, &mut text);
        self.rows += 1;
        self.line(&text)
    }

    fn line(&mut self, text: &str) -> Result<(), Failure> {
        writeln!(self.file, "{text}").map_err(|error| unwritten(&self.path, &error))
    }

    fn finish(mut self) -> Result<(), Failure> {
        self.file.flush().map_err(|error| unwritten(&self.path, &error))?;
        say(format_args!("{}: {} rows\n", self.path.display(), self.rows));
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
fn cells(message: &Message, without: &[&str], bytes: &[u8], text: &mut String) {
    use std::fmt::Write;
    for field in message.fields.iter().filter(|field| !without.contains(&field.name)) {
        let value = &bytes[field.offset..field.offset + field.size()];
        if let Some(inner) = field.message() {
            cells(inner, &[], value, text);
            continue;
        }
        let kind = field.shape().0;
        for number in value.chunks(if kind == "u32" { 4 } else { 8 }) {
            let _ = match kind {
                "u32" => write!(text, ",{}", bytemuck::pod_read_unaligned::<u32>(number)),
                "u64" => write!(text, ",{}", bytemuck::pod_read_unaligned::<u64>(number)),
                "i64" => write!(text, ",{}", bytemuck::pod_read_unaligned::<i64>(number)),
                _ => write!(text, ",{}", bytemuck::pod_read_unaligned::<f64>(number)),
            };
        }
    }
}
