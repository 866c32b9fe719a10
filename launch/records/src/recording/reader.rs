//! A recording, read message by message in constant memory; one that was cut short, up to its last good chunk.

use super::protobuf::Codec;
use super::record_stream::RecordStream;
use super::topic::{METADATA, RecordingTopic};
use bytemuck::bytes_of_mut;
use mcap::records::Record;
use messages::file;
use messages::load::{parse, validate};
use messages::port::{Ask, Verdict};
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
    /// Of the metadata record: scene, schema, version and when it began.
    about: BTreeMap<String, String>,
    scene: Scene,
    /// RequestLog that were answered, and that nobody has taken out yet.
    served: VecDeque<Served>,
    /// Why the file ends before its end, once that is known.
    pub cut: Option<String>,
}

/// What its messages are, and what it is called.
type Channel = (Option<RecordingTopic>, Arc<str>);

/// A message.
pub struct RecordedMessage {
    /// Name of its topic.
    pub topic: Arc<str>,
    /// By the clock of the file [ns].
    pub time: u64,
    /// What of it we know.
    pub content: Payload,
}

/// What a message has; what other topics have of it is zero.
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
    /// For people.
    Other,
}

impl RecordingReader {
    /// Opens a file and reads as far as it says of what run it is; the scene is checked like any other.
    ///
    /// # Errors
    /// If it is not there, no MCAP file, no recording of ours, of another wire format, or of a scene that cannot be run.
    pub fn open(path: &Path) -> Result<RecordingReader, Failure> {
        let refuse = |why: String| Err(Failure::new(Exit::Usage, format!("{}: {why}", path.display())));
        let file = match file::open(path) {
            Ok(file) => file,
            Err(error) => return refuse(format!("cannot be opened: {error}")),
        };
        let (records, codecs) = (RecordStream::of(file), RecordingTopic::ALL.map(RecordingTopic::codec));
        let (channels, about) = (HashMap::new(), BTreeMap::new());
        let mut reader = RecordingReader {
            records,
            channels,
            codecs,
            about,
            scene: Scene::default(),
            served: VecDeque::new(),
            cut: None,
        };
        while reader.about.is_empty() {
            // what is ours says so before its first message
            if reader.record().is_none_or(|message| message.is_some()) {
                let why = reader.cut.map_or_else(String::new, |why| format!(" ({why})"));
                return refuse(format!("this is no recording of `biped run --record`{why}"));
            }
        }
        let (ours, theirs) = (format!("{SCHEMA_HASH:016x}"), reader.word("schema").to_string());
        if ours != theirs {
            let words = format!("its wire schema is {theirs}, ours is {ours}: use the version that wrote it");
            return Err(Failure::new(Exit::Incompatible, format!("{}: {words}", path.display())));
        }
        let origin = format!("the scene in {}", path.display());
        reader.scene = parse(reader.word("scene"), &origin)?;
        validate(&reader.scene, &origin)?;
        Ok(reader)
    }

    /// A word of the metadata.
    pub fn word(&self, key: &str) -> &str {
        self.about.get(key).map_or("unknown", String::as_str)
    }

    /// The scene that was run.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The next message; none at the end, or where the file is cut short.
    pub fn next(&mut self) -> Option<RecordedMessage> {
        loop {
            if let Some(item) = self.record()? {
                return Some(item);
            }
        }
    }

    /// The next truth, put together from all its topics; the messages between come with it. Its time by the clock of the file [ns].
    pub fn next_truth(&mut self, latest: &mut Truth) -> Option<u64> {
        loop {
            let RecordedMessage { time, content, .. } = self.next()?;
            match content {
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

    /// Whether it has a topic of requests, as recordings of earlier versions have not.
    pub fn tells_requests(&self) -> bool {
        self.channels.values().any(|(topic, _)| *topic == Some(RecordingTopic::Served))
    }

    /// Takes out the requests that were granted and took effect by now, as `is_due` sees it.
    pub fn granted(&mut self, is_due: impl Fn(&Stamp, Ask) -> bool) -> Vec<Ask> {
        let mut asks = vec![];
        self.served.retain(|served| match Ask::of(&served.request) {
            Ok(ask) if served.verdict == Verdict::Done as u64 => {
                let is_due = is_due(&served.stamp, ask);
                asks.extend(is_due.then_some(ask));
                !is_due
            }
            _ => false,
        });
        asks
    }

    /// Bytes of the file that the messages so far are from.
    pub fn read(&self) -> u64 {
        self.records.read()
    }

    /// The next record: a message, something else, or the end.
    fn record(&mut self) -> Option<Option<RecordedMessage>> {
        let record = self.records.next()?.and_then(|(opcode, data)| mcap::parse_record(opcode, data));
        match record {
            Ok(Record::Metadata(metadata)) if metadata.name == METADATA => self.about = metadata.metadata,
            Ok(Record::Channel(channel)) => {
                let topic = RecordingTopic::ALL.into_iter().find(|known| known.name() == channel.topic);
                self.channels.insert(channel.id, (topic, channel.topic.into()));
            }
            Ok(Record::Message { header, data }) => {
                let (topic, name) = self.channels.get(&header.channel_id).cloned().unwrap_or_default();
                match topic.map_or(Some(Payload::Other), |topic| content(topic, &self.codecs[topic as usize], &data)) {
                    Some(content) => {
                        return Some(Some(RecordedMessage { topic: name, time: header.log_time, content }));
                    }
                    None => self.cut = Some(format!("a message of {name} is damaged")),
                }
            }
            Ok(Record::Footer(footer)) if footer.summary_start == 0 => {
                self.cut = Some("it was not ended in order".into())
            }
            Ok(_) => (),
            Err(error) => self.cut = Some(error.to_string()),
        }
        if self.cut.is_some() { None } else { Some(None) }
    }
}

/// What a message of a topic has; none if it is damaged.
fn content(topic: RecordingTopic, codec: &Codec, data: &[u8]) -> Option<Payload> {
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
