//! A recording, read message by message in constant memory; one that was cut short, up to its last good chunk.

use super::{METADATA, Topic, protobuf};
use crate::exit::{Exit, Failure};
use bytemuck::bytes_of_mut;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use messages::scene::Scene;
use messages::wire::{Command, SCHEMA_HASH, Sensors, Telemetry, Truth};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// No record of ours is longer; a damaged length asks for more [bytes].
const LONGEST: usize = 1 << 28;

/// A recording that is being read.
pub struct Reader {
    path: PathBuf,
    file: File,
    records: LinearReader,
    channels: HashMap<u16, String>,
    /// Of the metadata record: scene, schema and version.
    about: BTreeMap<String, String>,
    /// Bytes that were read so far.
    pub read: u64,
    /// Why the file ends before its end, once that is known.
    pub cut: Option<String>,
}

/// A message.
pub struct Item {
    /// Name of its topic.
    pub topic: String,
    /// By the clock of the file [ns].
    pub time: u64,
    /// What of it we know.
    pub content: Content,
}

/// What a message has; what other topics have of it is zero.
pub enum Content {
    /// `/sensors`.
    Sensors(Sensors),
    /// `/command`.
    Command(Command),
    /// `/telemetry`.
    Telemetry(Telemetry),
    /// `/truth`.
    Truth(Box<Truth>),
    /// For people.
    Other,
}

impl Reader {
    /// Opens a file and reads as far as it says of what run it is.
    ///
    /// # Errors
    /// If it is not there, no MCAP file, no recording of ours, or of another wire format.
    pub fn open(path: &Path) -> Result<Reader, Failure> {
        let refuse = |why: String| Err(Failure::new(Exit::Usage, format!("{}: {why}", path.display())));
        let file = match File::open(path) {
            Ok(file) if file.metadata().is_ok_and(|about| about.is_file()) => file,
            Ok(_) => return refuse("this is no file".into()),
            Err(error) => return refuse(format!("cannot be opened: {error}")),
        };
        let options = LinearReaderOptions::default()
            .with_record_length_limit(LONGEST)
            .with_prevalidate_chunk_crcs(true)
            .with_skip_end_magic(true);
        let records = LinearReader::new_with_options(options);
        let (channels, about) = (HashMap::new(), BTreeMap::new());
        let mut reader = Reader { path: path.into(), file, records, channels, about, read: 0, cut: None };
        while reader.about.is_empty() {
            // what is ours says so before its first message
            if reader.record().is_none_or(|message| message.is_some()) {
                let why = reader.cut.map_or_else(String::new, |why| format!(" ({why})"));
                return refuse(format!("this is no recording of `biped run --record`{why}"));
            }
        }
        let (ours, theirs) = (format!("{SCHEMA_HASH:016x}"), reader.word("schema").to_string());
        match ours == theirs {
            true => Ok(reader),
            false => Err(Failure::new(
                Exit::Incompatible,
                format!(
                    "{}: its wire schema is {theirs}, ours is {ours}: use the version that wrote it",
                    path.display()
                ),
            )),
        }
    }

    /// A word of the metadata.
    pub fn word(&self, key: &str) -> &str {
        self.about.get(key).map_or("unknown", String::as_str)
    }

    /// The scene that was run.
    ///
    /// # Errors
    /// If its text is damaged.
    pub fn scene(&self) -> Result<Scene, Failure> {
        let damaged = |error| format!("{}: its scene is damaged: {error}", self.path.display());
        toml::from_str(self.word("scene")).map_err(|error| Failure::new(Exit::Usage, damaged(error)))
    }

    /// The next message; none at the end, or where the file is cut short.
    pub fn next(&mut self) -> Option<Item> {
        loop {
            if let Some(item) = self.record()? {
                return Some(item);
            }
        }
    }

    /// The next truth, put together from all its topics; the messages between come with it.
    pub fn next_truth(&mut self, latest: &mut Truth) -> Option<()> {
        loop {
            match self.next()?.content {
                Content::Sensors(sensors) => latest.encoders = sensors.encoders,
                Content::Command(command) => (latest.command, latest.asked) = (command.stamp, command.torques),
                Content::Telemetry(telemetry) => latest.telemetry = telemetry,
                Content::Truth(truth) => {
                    let Truth { command, asked, telemetry, encoders, .. } = *latest;
                    *latest = Truth { command, asked, telemetry, encoders, ..*truth };
                    return Some(());
                }
                Content::Other => (),
            }
        }
    }

    /// The next record: a message, something else, or the end.
    fn record(&mut self) -> Option<Option<Item>> {
        loop {
            let event = match self.records.next_event()? {
                Ok(event) => event,
                Err(error) => {
                    self.cut = Some(error.to_string());
                    return None;
                }
            };
            let (opcode, data) = match event {
                LinearReadEvent::ReadRequest(wanted) => {
                    match self.file.read(self.records.insert(wanted)) {
                        Ok(count) => {
                            self.read += count as u64;
                            self.records.notify_read(count);
                        }
                        Err(error) => {
                            self.cut = Some(error.to_string());
                            return None;
                        }
                    }
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            match mcap::parse_record(opcode, data) {
                Ok(Record::Metadata(metadata)) if metadata.name == METADATA => self.about = metadata.metadata,
                Ok(Record::Channel(channel)) => _ = self.channels.insert(channel.id, channel.topic),
                Ok(Record::Message { header, data }) => {
                    let topic = self.channels.get(&header.channel_id).cloned().unwrap_or_default();
                    match content(&topic, &data) {
                        Some(content) => return Some(Some(Item { topic, time: header.log_time, content })),
                        None => self.cut = Some(format!("a message of {topic} is damaged")),
                    }
                }
                Ok(_) => (),
                Err(error) => self.cut = Some(error.to_string()),
            }
            return if self.cut.is_some() { None } else { Some(None) };
        }
    }
}

fn content(topic: &str, data: &[u8]) -> Option<Content> {
    let read = |topic: Topic, bytes: &mut [u8]| protobuf::decode(topic.message(), data, bytes);
    Some(match Topic::ALL.into_iter().find(|known| known.name() == topic) {
        Some(topic @ Topic::Sensors) => {
            let mut sensors = Sensors::default();
            read(topic, bytes_of_mut(&mut sensors))?;
            Content::Sensors(sensors)
        }
        Some(topic @ Topic::Command) => {
            let mut command = Command::default();
            read(topic, bytes_of_mut(&mut command))?;
            Content::Command(command)
        }
        Some(topic @ Topic::Telemetry) => {
            let mut telemetry = Telemetry::default();
            read(topic, bytes_of_mut(&mut telemetry))?;
            Content::Telemetry(telemetry)
        }
        Some(topic @ Topic::Truth) => {
            let mut truth = Box::<Truth>::default();
            read(topic, bytes_of_mut(&mut *truth))?;
            Content::Truth(truth)
        }
        None => Content::Other,
    })
}
