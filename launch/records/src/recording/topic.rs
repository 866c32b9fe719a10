//! The topics of a recording that contain wire messages.

use super::protobuf::Codec;
use messages::wire::{LAYOUT, Message};

/// Name of the metadata record.
pub const METADATA: &str = "biped";

/// A topic that contains wire messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordingTopic {
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

impl RecordingTopic {
    /// All topics.
    pub const ALL: [RecordingTopic; 5] = [
        RecordingTopic::Sensors,
        RecordingTopic::Command,
        RecordingTopic::Telemetry,
        RecordingTopic::Truth,
        RecordingTopic::Served,
    ];

    /// Name of the topic.
    pub fn name(self) -> &'static str {
        match self {
            RecordingTopic::Sensors => "/sensors",
            RecordingTopic::Command => "/command",
            RecordingTopic::Telemetry => "/telemetry",
            RecordingTopic::Truth => "/truth",
            RecordingTopic::Served => "/served",
        }
    }

    /// Message type.
    pub fn message(self) -> &'static Message {
        let name = match self {
            RecordingTopic::Sensors => "Sensors",
            RecordingTopic::Command => "Command",
            RecordingTopic::Telemetry => "Telemetry",
            RecordingTopic::Truth => "Truth",
            RecordingTopic::Served => "Served",
        };
        LAYOUT.iter().find(|message| message.name == name).unwrap_or(&LAYOUT[0])
    }

    /// Fields that are omitted, because another topic contains them.
    pub fn omitted(self) -> &'static [&'static str] {
        match self {
            RecordingTopic::Sensors => &["last"],
            RecordingTopic::Command => &["telemetry"],
            RecordingTopic::Telemetry | RecordingTopic::Served => &[],
            RecordingTopic::Truth => &["telemetry", "command", "asked", "encoders"],
        }
    }

    /// The codec of its messages.
    pub fn codec(self) -> Codec {
        Codec::new(self.message(), self.omitted())
    }
}
