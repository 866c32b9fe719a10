//! Reads a recording message by message in constant memory. A truncated recording is read up to its last valid chunk.

use super::protobuf::Codec;
use super::record_stream::{RecordStream, parse_record};
use super::topic::{METADATA, RecordingTopic};
use bytemuck::bytes_of_mut;
use mcap::records::Record;
use messages::file;
use messages::load::{parse, validate};
use messages::port::{Action, Verdict};
use messages::scene::Scene;
use messages::wire::{Command, SCHEMA_HASH, Sensors, Served, Stamp, Telemetry, Truth};
use shared::exit::{Exit, Failure};
use std::collections::{BTreeMap, HashMap, VecDeque};
use std::path::Path;
use std::sync::Arc;

/// A recording that is being read.
pub struct RecordingReader {
    records: RecordStream,
    channels: HashMap<u16, Channel>,
    codecs: [Codec; RecordingTopic::ALL.len()],
    /// Content of the metadata record: scene, schema, version and time of the first record.
    metadata: BTreeMap<String, String>,
    scene: Scene,
    /// Answered requests that [`RecordingReader::take_granted`] has not returned yet.
    served: VecDeque<Served>,
    /// The reason why nothing can be read after this point, once it is known.
    pub truncated_by: Option<String>,
}

/// Topic, if it contains wire messages, and its name.
type Channel = (Option<RecordingTopic>, Arc<str>);

/// A message of a recording.
pub struct RecordedMessage {
    /// Name of the topic.
    pub topic: Arc<str>,
    /// Log time [ns].
    pub time: u64,
    /// Decoded content.
    pub payload: Payload,
}

/// Decoded content of a message. Fields that the recording stores in another topic are zero.
pub enum Payload {
    /// `/sensors`.
    Sensors(Sensors),
    /// `/command`.
    Command(Command),
    /// `/telemetry`.
    Telemetry(Telemetry),
    /// `/truth`.
    Truth(Box<Truth>),
    /// `/served`.
    Served(Box<Served>),
    /// A message for visualisation, which is not decoded.
    Other,
}

impl RecordingReader {
    /// The failure that reports that the recording in this file has no data of a kind.
    pub fn lacks(&self, path: &Path, what: &str) -> Failure {
        let why =
            self.truncated_by.as_ref().map_or_else(String::new, |why| format!(", because it is cut short: {why}"));
        Failure::new(Exit::Usage, format!("{}: the recording contains no {what}{why}", path.display()))
    }

    /// Opens a file, reads its metadata and validates the scene.
    ///
    /// # Errors
    /// If the file does not exist, is not a recording of this program, has another wire format, or contains an invalid scene.
    pub fn open(path: &Path) -> Result<RecordingReader, Failure> {
        let refuse = |why: String| Err(Failure::new(Exit::Usage, format!("{}: {why}", path.display())));
        let file = match file::open(path) {
            Ok(file) => file,
            Err(error) => return refuse(format!("cannot be opened: {error}")),
        };
        let (records, codecs) = (RecordStream::new(file)?, RecordingTopic::ALL.map(RecordingTopic::codec));
        let (channels, metadata) = (HashMap::new(), BTreeMap::new());
        let mut reader = RecordingReader {
            records,
            channels,
            codecs,
            metadata,
            scene: Scene::default(),
            served: VecDeque::new(),
            truncated_by: None,
        };
        while reader.metadata.is_empty() {
            // Our recordings begin with the metadata record, before any message.
            if reader.next_record().is_none_or(|message| message.is_some()) {
                let why = reader.truncated_by.map_or_else(String::new, |why| format!(" ({why})"));
                return refuse(format!("this is no recording of `biped run --record`{why}"));
            }
        }
        let (ours, theirs) = (format!("{SCHEMA_HASH:016x}"), reader.metadata("schema").to_string());
        if ours != theirs {
            let message = format!("its wire schema is {theirs}, ours is {ours}: use the version that wrote it");
            return Err(Failure::new(Exit::Incompatible, format!("{}: {message}", path.display())));
        }
        let origin = format!("the scene in {}", path.display());
        reader.scene = parse(reader.metadata("scene"), &origin)?;
        validate(&reader.scene, &origin)?;
        Ok(reader)
    }

    /// A value of the metadata record.
    pub fn metadata(&self, key: &str) -> &str {
        self.metadata.get(key).map_or("unknown", String::as_str)
    }

    /// The recorded scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The next message. `None` at the end or where the file is truncated.
    pub fn next_message(&mut self) -> Option<RecordedMessage> {
        loop {
            if let Some(message) = self.next_record()? {
                return Some(message);
            }
        }
    }

    /// Reads on to the next record of `/truth`, completes it from the other topics, and returns its log time [ns].
    pub fn next_truth(&mut self, latest: &mut Truth) -> Option<u64> {
        loop {
            let RecordedMessage { time, payload, .. } = self.next_message()?;
            match payload {
                Payload::Sensors(sensors) => latest.encoders = sensors.encoders,
                Payload::Command(command) => (latest.command, latest.asked) = (command.stamp, command.torques),
                Payload::Telemetry(telemetry) => latest.telemetry = telemetry,
                Payload::Truth(truth) => {
                    let Truth { command, asked, telemetry, encoders, .. } = *latest;
                    *latest = Truth { command, asked, telemetry, encoders, ..*truth };
                    return Some(time);
                }
                Payload::Served(served) => self.served.push_back(*served),
                Payload::Other => (),
            }
        }
    }

    /// True if the recording has a topic for requests. Recordings of earlier versions have none.
    pub fn has_request_topic(&self) -> bool {
        self.channels.values().any(|(topic, _)| *topic == Some(RecordingTopic::Served))
    }

    /// Removes and returns the granted requests for which `is_due` is true. Refused requests are dropped.
    pub fn take_granted(&mut self, is_due: impl Fn(&Stamp, Action) -> bool) -> Vec<Action> {
        let mut asks = vec![];
        self.served.retain(|served| match Action::decode(&served.request) {
            Ok(ask) if served.verdict == Verdict::Done as u64 => {
                let is_due = is_due(&served.stamp, ask);
                asks.extend(is_due.then_some(ask));
                !is_due
            }
            _ => false,
        });
        asks
    }

    /// Bytes of the file that have been read.
    pub fn bytes_read(&self) -> u64 {
        self.records.bytes_read()
    }

    /// Processes the next record. `None` at the end, `Some(None)` for a record that is not a message.
    fn next_record(&mut self) -> Option<Option<RecordedMessage>> {
        let record = self.records.next()?.and_then(|(opcode, data)| parse_record(opcode, data));
        match record {
            Ok(Record::Metadata(metadata)) if metadata.name == METADATA => self.metadata = metadata.metadata,
            Ok(Record::Channel(channel)) => {
                let topic = RecordingTopic::ALL.into_iter().find(|known| known.name() == channel.topic);
                self.channels.insert(channel.id, (topic, channel.topic.into()));
            }
            Ok(Record::Message { header, data }) => {
                let (topic, name) = self.channels.get(&header.channel_id).cloned().unwrap_or_default();
                match topic.map_or(Some(Payload::Other), |topic| decode(topic, &self.codecs[topic as usize], &data)) {
                    Some(payload) => {
                        return Some(Some(RecordedMessage { topic: name, time: header.log_time, payload }));
                    }
                    None => self.truncated_by = Some(format!("a message of {name} is damaged")),
                }
            }
            Ok(Record::Footer(footer)) if footer.summary_start == 0 => {
                self.truncated_by = Some("the file has no index".into())
            }
            Ok(_) => (),
            Err(error) => self.truncated_by = Some(error.to_string()),
        }
        if self.truncated_by.is_some() { None } else { Some(None) }
    }
}

/// Decodes a message of a topic. `None` if it is damaged.
fn decode(topic: RecordingTopic, codec: &Codec, data: &[u8]) -> Option<Payload> {
    Some(match topic {
        RecordingTopic::Sensors => {
            let mut sensors = Sensors::default();
            codec.decode(data, bytes_of_mut(&mut sensors))?;
            Payload::Sensors(sensors)
        }
        RecordingTopic::Command => {
            let mut command = Command::default();
            codec.decode(data, bytes_of_mut(&mut command))?;
            Payload::Command(command)
        }
        RecordingTopic::Telemetry => {
            let mut telemetry = Telemetry::default();
            codec.decode(data, bytes_of_mut(&mut telemetry))?;
            Payload::Telemetry(telemetry)
        }
        RecordingTopic::Truth => {
            let mut truth = Box::<Truth>::default();
            codec.decode(data, bytes_of_mut(&mut *truth))?;
            Payload::Truth(truth)
        }
        RecordingTopic::Served => {
            let mut served = Box::<Served>::default();
            codec.decode(data, bytes_of_mut(&mut *served))?;
            Payload::Served(served)
        }
    })
}
