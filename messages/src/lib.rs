//! What plant and controller share: the messages between them, and the scene that both read.
//!
//! | what | where |
//! |---|---|
//! | messages, schema hash | [`wire`] |
//! | the wire format for C, Python and as a table | [`describe`] |
//! | robots as data, Table 1 of the paper | [`robot`] |
//! | scenes as data; loading and checking them | [`scene`], [`load`] |
//! | requests to a running session | [`action`] |
//! | connection between the processes | [`port`] |
//! | sessions: names, members and files in shared memory | [`session`] |
//! | monotonic clock, timeouts | [`clock`] |
//! | environment variables of a process in a session | [`peer_environment`] |
//! | files that the user names | [`file`] |
//! | sine, cosine, rotations | [`rotation`] |
//! | lines on standard error | [`log()`] |
//! | check of the processor's features | `processor` |

pub mod action;
pub mod clock;
pub mod describe;
mod error;
pub mod file;
mod law;
pub mod load;
mod log;
pub mod peer_environment;
pub mod port;
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod processor;
pub mod robot;
pub mod rotation;
pub mod scene;
pub mod session;
pub mod wire;

pub use log::{log, printable};
