//! Helpers to write an MCAP file: chunks, channels, messages.

use super::chunk_sink::ChunkSink;
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, McapResult, WriteOptions};
use std::collections::BTreeMap;
use std::fs::File;

/// Length of a chunk before compression at which it is flushed [bytes].
pub const CHUNK_BYTES: usize = 1 << 20;

/// An MCAP file that is being written.
pub type McapWriter = mcap::Writer<NoSeek<ChunkSink>>;

/// Starts an MCAP file in an empty file. Each flush ends a chunk.
pub fn create(file: File) -> McapResult<McapWriter> {
    let options =
        WriteOptions::new().compression(if cfg!(fuzzing) { None } else { Some(Compression::Lz4) }).library("biped");
    options.chunk_size(None).disable_seeking(true).create(NoSeek::new(ChunkSink::new(file)))
}

/// Adds a channel of JSON messages with the schema of `M`.
pub fn json_channel<M: schemars::JsonSchema>(file: &mut McapWriter, topic: &str, name: &str) -> McapResult<u16> {
    // Foxglove does not resolve references between schemas.
    let settings = schemars::generate::SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let schema = settings.into_generator().into_root_schema_for::<M>();
    let schema = file.add_schema(name, "jsonschema", schema.as_value().to_string().as_bytes())?;
    file.add_channel(schema, topic, "json", &BTreeMap::new())
}

/// Writes a message to a JSON channel.
pub fn json_message(file: &mut McapWriter, channel: u16, time: u64, message: &impl serde::Serialize) -> McapResult<()> {
    let text = serde_json::to_vec(message).map_err(std::io::Error::from)?;
    file.write_to_known_channel(&header(channel, time, 0), &text)
}

/// The header of a message.
pub fn header(channel_id: u16, time: u64, sequence: u64) -> MessageHeader {
    MessageHeader { channel_id, sequence: sequence as u32, log_time: time, publish_time: time }
}
