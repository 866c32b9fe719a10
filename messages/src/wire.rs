//! The wire format: the messages that plant and controller exchange.
//!
//! | what | where |
//! |---|---|
//! | every message, magic number, schema hash | `wire/declaration.rs` |
//! | the macro that lays a message out and describes it | `wire/layout.rs` |
//! | enumerations behind the numbers in messages, with their names | `wire/names.rs` |
//! | encoder counts as angles | `wire/encoders.rs` |
//! | stamp: sealing and checking a message | `wire/stamped.rs` |
//! | counters of the plant as a sentence | `wire/tally.rs` |
//! | FNV-1a | `wire/hash.rs` |

mod declaration;
mod encoders;
mod hash;
mod layout;
mod names;
mod stamped;
mod tally;

pub use declaration::{
    CONTACTS, Command, Encoders, JOINTS, LAYOUT, MAGIC, Reply, Request, SCHEMA, SCHEMA_HASH, Sensors, Served, Stamp,
    Tally, Telemetry, Torques, Truth,
};
pub use hash::{FNV_START, fnv1a};
pub use layout::{Field, Message};
pub use names::{PHASES, Phase, PlantState, REFUSALS, REQUESTS, Refusal, RequestKind, STATES, VERDICTS, Verdict};
pub use stamped::Stamped;
