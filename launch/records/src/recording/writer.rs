//! A run, written while it goes on: whatever stops it, the file is readable up to its last chunk.

use super::events::{EventDetector, LogMessage};
use super::foxglove_scene::FoxgloveScene;
use super::mcap_file::{CHUNK, McapWriter, create, header, json_channel, json_message};
use super::protobuf::{self, Codec};
use super::topic::{METADATA, RecordingTopic};
use crate::analysis::RequestRecord;
use mcap::McapResult;
use mcap::records::Metadata;
use messages::load;
use messages::scene::Scene;
use messages::wire::{Command, SCHEMA_HASH, Sensors, Served, Stamp, Stamped, Truth};
use std::collections::BTreeMap;
use std::fs::File;
use std::time::{Duration, Instant, SystemTime};

/// A killed run loses no more than this, and no more than a [`CHUNK`].
const FLUSH: Duration = Duration::from_millis(500);
/// Time between two pictures [ns].
const PICTURE_NS: u64 = 20_000_000;

/// Writes a recording.
pub struct RecordingWriter {
    file: McapWriter,
    topics: [u16; RecordingTopic::ALL.len()],
    codecs: [Codec; RecordingTopic::ALL.len()],
    events: u16,
    drawing: FoxgloveScene,
    noticed: EventDetector,
    before: Option<Truth>,
    /// What the clock of the file is ahead of simulated time: the length of earlier runs [ns].
    ahead_ns: u64,
    flushed: Instant,
    /// Of the chunk so far [bytes].
    waiting: usize,
    encoded: Vec<u8>,
}

impl RecordingWriter {
    /// Begins an empty file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(file: File, scene: &Scene) -> McapResult<RecordingWriter> {
        let mut file = create(file)?;
        let about = [
            ("scene", load::text(scene)),
            ("schema", format!("{SCHEMA_HASH:016x}")),
            ("version", env!("CARGO_PKG_VERSION").into()),
            // The one look at the calendar: for people, and for logs beside this one. No message has it.
            ("begun", prost_types::Timestamp::from(SystemTime::now()).to_string()),
        ];
        let metadata = about.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
        file.write_metadata(&Metadata { name: METADATA.into(), metadata })?;
        let descriptors = protobuf::descriptors();
        let mut topics = [0; RecordingTopic::ALL.len()];
        for (id, topic) in topics.iter_mut().zip(RecordingTopic::ALL) {
            let schema = file.add_schema(&format!("biped.{}", topic.message().name), "protobuf", &descriptors)?;
            *id = file.add_channel(schema, topic.name(), "protobuf", &BTreeMap::new())?;
        }
        let events = json_channel::<super::events::LogMessage>(&mut file, "/events", "foxglove.Log")?;
        Ok(RecordingWriter {
            drawing: FoxgloveScene::begin(&mut file, scene)?,
            file,
            topics,
            codecs: RecordingTopic::ALL.map(RecordingTopic::codec),
            events,
            noticed: EventDetector::default(),
            before: None,
            ahead_ns: 0,
            flushed: Instant::now(),
            waiting: 0,
            encoded: vec![],
        })
    }

    /// Takes the next truth; whether the file has grown by a chunk.
    ///
    /// # Errors
    /// If the file cannot be written, as on a full disk.
    pub fn push(&mut self, truth: &Truth) -> McapResult<bool> {
        let before = self.before.replace(*truth);
        if let Some(before) = before.filter(|before| before.stamp.run != truth.stamp.run) {
            self.ahead_ns = self.ahead_ns.saturating_add(before.stamp.sim_ns).saturating_add(PICTURE_NS);
            self.noticed = EventDetector::default();
        }
        let before = before.filter(|before| before.stamp.run == truth.stamp.run);
        let time = self.ahead_ns.saturating_add(truth.stamp.sim_ns);
        let Truth { stamp, command, asked: torques, encoders, telemetry, .. } = *truth;
        let is_new =
            before.is_none_or(|before| before.command.seq != command.seq || before.command.epoch != command.epoch);
        if command != Stamp::default() && is_new {
            let command = Command { stamp: command, torques, telemetry };
            self.put(RecordingTopic::Command, time, command.stamp.seq, bytemuck::bytes_of(&command))?;
            self.put(RecordingTopic::Telemetry, time, command.stamp.seq, bytemuck::bytes_of(&telemetry))?;
        }
        let sensors = Sensors { stamp, encoders, last: 0 }.sealed();
        self.put(RecordingTopic::Sensors, time, stamp.seq, bytemuck::bytes_of(&sensors))?;
        self.put(RecordingTopic::Truth, time, stamp.seq, bytemuck::bytes_of(truth))?;
        for log in self.noticed.of(truth, time) {
            json_message(&mut self.file, self.events, time, &log)?;
        }
        if before.is_none_or(|before| before.stamp.sim_ns / PICTURE_NS < stamp.sim_ns / PICTURE_NS) {
            self.drawing.draw(&mut self.file, truth, time)?;
        }
        let is_full = self.waiting > CHUNK || self.flushed.elapsed() > FLUSH;
        if is_full {
            self.file.flush()?;
            (self.flushed, self.waiting) = (Instant::now(), 0);
        }
        Ok(is_full)
    }

    /// Takes a request that was answered.
    ///
    /// # Errors
    /// As [`RecordingWriter::push`].
    pub fn served(&mut self, served: &Served) -> McapResult<()> {
        let before = self.before.as_ref().map(|before| before.stamp);
        // that of another run, which a reset has begun, is told at the end of this one
        let sim_ns = before.filter(|before| before.run != served.stamp.run).unwrap_or(served.stamp).sim_ns;
        let time = self.ahead_ns.saturating_add(sim_ns);
        self.put(RecordingTopic::Served, time, served.stamp.seq, bytemuck::bytes_of(served))?;
        json_message(&mut self.file, self.events, time, &LogMessage::warning(time, RequestRecord::new(served).text()))
    }

    fn put(&mut self, topic: RecordingTopic, time: u64, seq: u64, bytes: &[u8]) -> McapResult<()> {
        self.encoded.clear();
        self.codecs[topic as usize].encode(bytes, &mut self.encoded);
        self.waiting += self.encoded.len();
        let header = header(self.topics[topic as usize], time, seq);
        self.file.write_to_known_channel(&header, &self.encoded)
    }

    /// Ends the file in order: with its index.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> McapResult<()> {
        self.file.finish().map(drop)
    }
}
