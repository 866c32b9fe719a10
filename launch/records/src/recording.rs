//! Recordings: a run as an MCAP file that Foxglove, Lichtblick and PlotJuggler open directly.
//!
//! | topic | message | rate |
//! |---|---|---|
//! | `/sensors` | `biped.Sensors` | each control period |
//! | `/command`, `/telemetry` | `biped.Command` without telemetry, `biped.Telemetry` | each accepted command |
//! | `/truth` | `biped.Truth` without the fields of the other topics | each control period |
//! | `/served` | `biped.Served` | each answered request |
//! | `/events` | `foxglove.Log` | each event |
//! | `/tf`, `/robot`, `/forces` | `foxglove.FrameTransforms`, `foxglove.SceneUpdate` | 50 Hz, once, 50 Hz |
//!
//! The metadata record `biped` contains the scene and, as `begun`, the UTC time of the first record. No message contains
//! a calendar time. Therefore two recordings of the same run have equal states, and `biped info` prints the same hash
//! for both. Messages are Protocol Buffers ([`protobuf`]); Foxglove's own messages are JSON. Log times are simulated
//! times. A reset of the simulation does not reset them: they keep increasing.

mod chunk_sink;
pub mod convert;
mod events;
mod foxglove_scene;
pub mod info;
mod mcap_file;
mod protobuf;
mod reader;
mod record_stream;
mod recorder;
mod reindex;
pub mod replay;
mod topic;
mod writer;

pub use reader::{Payload, RecordingReader};
pub use recorder::{McapRecorder, RecordArgs, RecordingEnd};
