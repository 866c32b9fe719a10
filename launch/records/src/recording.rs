//! Recordings: a run as an MCAP file, which Foxglove, Lichtblick and PlotJuggler open as it is.
//!
//! | topic | message | when |
//! |---|---|---|
//! | `/sensors` | `biped.Sensors` | each control period |
//! | `/command`, `/telemetry` | `biped.Command` without its telemetry, `biped.Telemetry` | when a new one has been accepted |
//! | `/truth` | `biped.Truth` without what the others have | each control period |
//! | `/events` | `foxglove.Log` | when something happens |
//! | `/tf`, `/robot`, `/forces` | `foxglove.FrameTransforms`, `foxglove.SceneUpdate` | 50 Hz, once, 50 Hz |
//!
//! The metadata record `biped` has the scene and `begun`, when by the calendar (UTC) the first record came; nothing else knows a calendar,
//! so the states of two recordings of one run are equal, and so is the hash that `biped info` prints of them. Messages are Protocol Buffers ([`protobuf`]), those of Foxglove JSON. All times are
//! simulated times; after a reset the clock of the file goes on.

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
