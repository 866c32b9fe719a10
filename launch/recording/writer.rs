//! A run, written while it goes on: whatever stops it, the file is readable up to the last flush.

use super::drawing::Drawing;
use super::events::Events;
use super::protobuf::{self, Codec};
use super::{METADATA, Topic};
use crate::exit::Failure;
use crate::output::unwritten;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, McapResult, WriteOptions};
use messages::load;
use messages::scene::Scene;
use messages::wire::{Command, SCHEMA_HASH, Sensors, Stamp, Stamped, Truth};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A killed run loses no more than this, and no more than a chunk of 1 MB.
const FLUSH: Duration = Duration::from_millis(500);
/// Time between two pictures [ns].
const PICTURE_NS: u64 = 20_000_000;

/// Writes a recording.
pub struct Writer {
    path: PathBuf,
    file: mcap::Writer<BufWriter<File>>,
    topics: [u16; 4],
    codecs: [Codec; 4],
    events: u16,
    drawing: Drawing,
    noticed: Events,
    before: Option<Truth>,
    /// What the clock of the file is ahead of simulated time: the length of earlier runs [ns].
    ahead_ns: u64,
    flushed: Instant,
    encoded: Vec<u8>,
}

impl Writer {
    /// Begins an empty file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(path: &Path, file: File, scene: &Scene) -> Result<Writer, Failure> {
        Writer::head(path, file, scene).map_err(|error| failed(path, &error))
    }

    fn head(path: &Path, file: File, scene: &Scene) -> McapResult<Writer> {
        let options =
            WriteOptions::new().compression(if cfg!(fuzzing) { None } else { Some(Compression::Lz4) }).library("biped");
        let mut file = options.create(BufWriter::new(file))?;
        let about = [
            ("scene", load::text(scene)),
            ("schema", format!("{SCHEMA_HASH:016x}")),
            ("version", env!("CARGO_PKG_VERSION").into()),
        ];
        let metadata = about.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
        file.write_metadata(&Metadata { name: METADATA.into(), metadata })?;
        let descriptors = protobuf::descriptors();
        let mut topics = [0; 4];
        for (id, topic) in topics.iter_mut().zip(Topic::ALL) {
            let schema = file.add_schema(&format!("biped.{}", topic.message().name), "protobuf", &descriptors)?;
            *id = file.add_channel(schema, topic.name(), "protobuf", &BTreeMap::new())?;
        }
        let events = json_channel::<super::events::Log>(&mut file, "/events", "foxglove.Log")?;
        Ok(Writer {
            path: path.into(),
            drawing: Drawing::begin(&mut file, scene)?,
            file,
            topics,
            codecs: Topic::ALL.map(Topic::codec),
            events,
            noticed: Events::default(),
            before: None,
            ahead_ns: 0,
            flushed: Instant::now(),
            encoded: vec![],
        })
    }

    /// Takes the next truth.
    ///
    /// # Errors
    /// If the file cannot be written, as on a full disk.
    pub fn push(&mut self, truth: &Truth) -> Result<(), Failure> {
        self.write(truth).map_err(|error| failed(&self.path, &error))
    }

    fn write(&mut self, truth: &Truth) -> McapResult<()> {
        let before = self.before.replace(*truth);
        if let Some(before) = before.filter(|before| before.stamp.run != truth.stamp.run) {
            self.ahead_ns += before.stamp.sim_ns + PICTURE_NS;
            self.noticed = Events::default();
        }
        let before = before.filter(|before| before.stamp.run == truth.stamp.run);
        let time = self.ahead_ns + truth.stamp.sim_ns;
        let Truth { stamp, command, asked: torques, encoders, telemetry, .. } = *truth;
        let is_new =
            before.is_none_or(|before| before.command.seq != command.seq || before.command.epoch != command.epoch);
        if command != Stamp::default() && is_new {
            let command = Command { stamp: command, torques, telemetry };
            self.put(Topic::Command, time, command.stamp.seq, bytemuck::bytes_of(&command))?;
            self.put(Topic::Telemetry, time, command.stamp.seq, bytemuck::bytes_of(&telemetry))?;
        }
        let sensors = Sensors { stamp, encoders, last: 0 }.sealed();
        self.put(Topic::Sensors, time, stamp.seq, bytemuck::bytes_of(&sensors))?;
        self.put(Topic::Truth, time, stamp.seq, bytemuck::bytes_of(truth))?;
        for log in self.noticed.of(truth, time) {
            json_message(&mut self.file, self.events, time, &log)?;
        }
        if before.is_none_or(|before| before.stamp.sim_ns / PICTURE_NS < stamp.sim_ns / PICTURE_NS) {
            self.drawing.draw(&mut self.file, truth, time)?;
        }
        if self.flushed.elapsed() > FLUSH {
            self.file.flush()?;
            self.flushed = Instant::now();
        }
        Ok(())
    }

    fn put(&mut self, topic: Topic, time: u64, seq: u64, bytes: &[u8]) -> McapResult<()> {
        self.encoded.clear();
        self.codecs[topic as usize].encode(bytes, &mut self.encoded);
        let header = header(self.topics[topic as usize], time, seq);
        self.file.write_to_known_channel(&header, &self.encoded)
    }

    /// Ends the file in order: with its index.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<(), Failure> {
        self.file.finish().map(drop).map_err(|error| failed(&self.path, &error))
    }
}

/// In the words of whatever is behind it, such as a full disk.
fn failed(path: &Path, error: &McapError) -> Failure {
    match error {
        McapError::Io(error) => unwritten(path, error),
        error => unwritten(path, error),
    }
}

/// A channel of messages that serde writes, with their schema.
pub(super) fn json_channel<M: schemars::JsonSchema>(
    file: &mut mcap::Writer<BufWriter<File>>,
    topic: &str,
    name: &str,
) -> McapResult<u16> {
    // Readers want one object, without references.
    let settings = schemars::generate::SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let schema = settings.into_generator().into_root_schema_for::<M>();
    let schema = file.add_schema(name, "jsonschema", schema.as_value().to_string().as_bytes())?;
    file.add_channel(schema, topic, "json", &BTreeMap::new())
}

pub(super) fn json_message(
    file: &mut mcap::Writer<BufWriter<File>>,
    channel: u16,
    time: u64,
    message: &impl serde::Serialize,
) -> McapResult<()> {
    let text = serde_json::to_vec(message).map_err(std::io::Error::from)?;
    file.write_to_known_channel(&header(channel, time, 0), &text)
}

fn header(channel_id: u16, time: u64, sequence: u64) -> MessageHeader {
    MessageHeader { channel_id, sequence: sequence as u32, log_time: time, publish_time: time }
}
