//! The contract between plant and controller, and nothing else.
//!
//! | what | where |
//! |---|---|
//! | messages, schema hash | [`wire`] |
//! | the same for C, Python and people | [`describe`] |
//! | robots as data, Table 1 of the paper | [`robot`] |
//! | scenes: TOML in, checked values out | [`scene`], [`load`] |
//! | what may be asked of a running session | [`ask`] |
//! | files that somebody names | [`file`] |
//! | the link between two processes | [`port`], [`session`], [`clock`] |
//! | sine, cosine, and what they turn | [`turn`] |
//! | how a program learns where it takes part | [`invitation`] |
//! | words for people | [`tell`] |
//! | whether the processor is one that this was built for | `processor` |

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
