//! The topics of a recording that have messages of the wire.

use super::protobuf::Codec;
use messages::wire::{LAYOUT, Message};

/// Name of the metadata record.
pub const METADATA: &str = "biped";

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
    pub fn message(self) -> &'static Message {
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
    pub fn without(self) -> &'static [&'static str] {
        match self {
            Topic::Sensors => &["last"],
            Topic::Command => &["telemetry"],
            Topic::Telemetry | Topic::Served => &[],
            Topic::Truth => &["telemetry", "command", "asked", "encoders"],
        }
    }

    /// How its messages are coded.
    pub fn codec(self) -> Codec {
        Codec::new(self.message(), self.without())
    }
}
