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

mod drawing;
mod events;
pub mod info;
mod protobuf;
mod reader;
mod records;
pub mod replay;
mod rewrite;
mod sink;
pub mod table;
mod tape;
mod writer;

pub use reader::{Content, Reader};
pub use tape::{End, RecordArgs, Tape};
use writer::Writer;

use messages::wire::{LAYOUT, Message};

/// Name of the metadata record.
const METADATA: &str = "biped";

/// A topic that has a message of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// `/sensors`.
    Sensors,
    /// `/command`.
    Command,
    /// `/telemetry`.
    Telemetry,
    /// `/truth`.
    Truth,
    /// `/served`.
    Served,
}

impl Topic {
    /// All of them.
    pub const ALL: [Topic; 5] = [Topic::Sensors, Topic::Command, Topic::Telemetry, Topic::Truth, Topic::Served];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Topic::Sensors => "/sensors",
            Topic::Command => "/command",
            Topic::Telemetry => "/telemetry",
            Topic::Truth => "/truth",
            Topic::Served => "/served",
        }
    }

    /// Its message.
    fn message(self) -> &'static Message {
        let name = match self {
            Topic::Sensors => "Sensors",
            Topic::Command => "Command",
            Topic::Telemetry => "Telemetry",
            Topic::Truth => "Truth",
            Topic::Served => "Served",
        };
        LAYOUT.iter().find(|message| message.name == name).unwrap_or(&LAYOUT[0])
    }

    /// Fields that other topics have.
    fn without(self) -> &'static [&'static str] {
        match self {
            Topic::Sensors => &["last"],
            Topic::Command => &["telemetry"],
            Topic::Telemetry | Topic::Served => &[],
            Topic::Truth => &["telemetry", "command", "asked", "encoders"],
        }
    }

    /// How its messages are coded.
    fn codec(self) -> protobuf::Codec {
        protobuf::Codec::new(self.message(), self.without())
    }
}
