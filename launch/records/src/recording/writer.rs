//! Writes a recording during the run. If the run is killed, the file is readable up to its last chunk.

use super::events::{EventDetector, LogMessage};
use super::foxglove_scene::FoxgloveScene;
use super::mcap_file::{CHUNK_BYTES, McapWriter, create, header, json_channel, json_message};
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

/// Longest time between flushes. A killed run loses at most this time, and at most [`CHUNK_BYTES`] of data.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);
/// Period of the messages for the 3-D panel [ns].
const SCENE_PERIOD_NS: u64 = 20_000_000;

/// Writes a recording.
pub struct RecordingWriter {
    file: McapWriter,
    topics: [u16; RecordingTopic::ALL.len()],
    codecs: [Codec; RecordingTopic::ALL.len()],
    events: u16,
    scene: FoxgloveScene,
    event_detector: EventDetector,
    previous: Option<Truth>,
    /// Log time minus simulated time: the total length of earlier runs in the file [ns].
    time_offset_ns: u64,
    /// Time of the latest flush.
    flushed: Instant,
    /// Length of the current chunk.
    unflushed_bytes: usize,
    /// Buffer for an encoded message.
    encoded: Vec<u8>,
}

impl RecordingWriter {
    /// Starts a recording in an empty file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(file: File, scene: &Scene) -> McapResult<RecordingWriter> {
        let mut file = create(file)?;
        let metadata = [
            ("scene", load::text(scene)),
            ("schema", format!("{SCHEMA_HASH:016x}")),
            ("version", env!("CARGO_PKG_VERSION").into()),
            // The only calendar time in the file, for comparison with other logs. No message contains one.
            ("begun", prost_types::Timestamp::from(SystemTime::now()).to_string()),
        ];
        let metadata = metadata.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
        file.write_metadata(&Metadata { name: METADATA.into(), metadata })?;
        let descriptors = protobuf::descriptors();
        let mut topics = [0; RecordingTopic::ALL.len()];
        for (id, topic) in topics.iter_mut().zip(RecordingTopic::ALL) {
            let schema = file.add_schema(&format!("biped.{}", topic.message().name), "protobuf", &descriptors)?;
            *id = file.add_channel(schema, topic.name(), "protobuf", &BTreeMap::new())?;
        }
        let events = json_channel::<super::events::LogMessage>(&mut file, "/events", "foxglove.Log")?;
        Ok(RecordingWriter {
            scene: FoxgloveScene::new(&mut file, scene)?,
            file,
            topics,
            codecs: RecordingTopic::ALL.map(RecordingTopic::codec),
            events,
            event_detector: EventDetector::default(),
            previous: None,
            time_offset_ns: 0,
            flushed: Instant::now(),
            unflushed_bytes: 0,
            encoded: vec![],
        })
    }

    /// Writes the next record. Returns true if a chunk was flushed to the file.
    ///
    /// # Errors
    /// If the file cannot be written, for example because the disk is full.
    pub fn push(&mut self, truth: &Truth) -> McapResult<bool> {
        let previous = self.previous.replace(*truth);
        if let Some(previous) = previous.filter(|previous| previous.stamp.run != truth.stamp.run) {
            self.time_offset_ns =
                self.time_offset_ns.saturating_add(previous.stamp.sim_ns).saturating_add(SCENE_PERIOD_NS);
            self.event_detector = EventDetector::default();
        }
        let previous = previous.filter(|previous| previous.stamp.run == truth.stamp.run);
        let time = self.time_offset_ns.saturating_add(truth.stamp.sim_ns);
        let Truth { stamp, command, asked: torques, encoders, telemetry, .. } = *truth;
        let is_new = previous
            .is_none_or(|previous| previous.command.seq != command.seq || previous.command.epoch != command.epoch);
        if command != Stamp::default() && is_new {
            let command = Command { stamp: command, torques, telemetry };
            self.write_message(RecordingTopic::Command, time, command.stamp.seq, bytemuck::bytes_of(&command))?;
            self.write_message(RecordingTopic::Telemetry, time, command.stamp.seq, bytemuck::bytes_of(&telemetry))?;
        }
        let sensors = Sensors { stamp, encoders, last: 0 }.sealed();
        self.write_message(RecordingTopic::Sensors, time, stamp.seq, bytemuck::bytes_of(&sensors))?;
        self.write_message(RecordingTopic::Truth, time, stamp.seq, bytemuck::bytes_of(truth))?;
        for log in self.event_detector.detect(truth, time) {
            json_message(&mut self.file, self.events, time, &log)?;
        }
        if previous.is_none_or(|previous| previous.stamp.sim_ns / SCENE_PERIOD_NS < stamp.sim_ns / SCENE_PERIOD_NS) {
            self.scene.write(&mut self.file, truth, time)?;
        }
        let is_full = self.unflushed_bytes > CHUNK_BYTES || self.flushed.elapsed() > FLUSH_INTERVAL;
        if is_full {
            self.file.flush()?;
            (self.flushed, self.unflushed_bytes) = (Instant::now(), 0);
        }
        Ok(is_full)
    }

    /// Writes an answered request.
    ///
    /// # Errors
    /// As [`RecordingWriter::push`].
    pub fn served(&mut self, served: &Served) -> McapResult<()> {
        let previous = self.previous.as_ref().map(|previous| previous.stamp);
        // A reset request has the stamp of the new run. It is logged at the end of the old run.
        let sim_ns = previous.filter(|previous| previous.run != served.stamp.run).unwrap_or(served.stamp).sim_ns;
        let time = self.time_offset_ns.saturating_add(sim_ns);
        self.write_message(RecordingTopic::Served, time, served.stamp.seq, bytemuck::bytes_of(served))?;
        let text = RequestRecord::new(served).text(self.scene.bodies());
        json_message(&mut self.file, self.events, time, &LogMessage::warning(time, text))
    }

    fn write_message(&mut self, topic: RecordingTopic, time: u64, seq: u64, bytes: &[u8]) -> McapResult<()> {
        self.encoded.clear();
        self.codecs[topic as usize].encode(bytes, &mut self.encoded);
        self.unflushed_bytes += self.encoded.len();
        let header = header(self.topics[topic as usize], time, seq);
        self.file.write_to_known_channel(&header, &self.encoded)
    }

    /// Completes the file with its index.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> McapResult<()> {
        self.file.finish().map(drop)
    }
}
