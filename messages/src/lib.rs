//! Parts that plant and controller share: the messages between them, and the scene that both read.
//!
//! A scene is plain data. Keys that a text omits have default values. The error for a wrong key names its place and the valid keys:
//!
//! ```
//! use biped_messages::{load, scene::Method};
//!
//! let scene = load::parse("duration = 2.0\nplant = { friction = 0.3 }", "my scene")?;
//! assert_eq!((scene.plant.friction, scene.plant.method), (0.3, Method::MidpointContact));
//! assert_eq!(scene.bodies.len(), 9); // the robot of the paper's Table 1
//! assert_eq!(load::parse(&load::text(&scene), "written and read back")?, scene);
//!
//! let error = load::parse("plant = { fricton = 0.3 }", "my scene").unwrap_err().to_string();
//! assert!(error.starts_with("my scene: ") && error.contains("unknown field `fricton`"));
//! # Ok::<(), load::SceneError>(())
//! ```
//!
//! Everything that both processes must agree on is here: the messages with their layout, check sum and schema hash; scenes and robots as data,
//! read from TOML and URDF and checked; sessions, which are sets of files in shared memory; and ports, the ends of the topics of a session. The
//! crate computes nothing about the robot. A foreign program needs no Rust: [`describe`] prints the same messages for C and Python.
//!
//! | what | where |
//! |---|---|
//! | messages, schema hash | [`wire`] |
//! | the wire format for C, Python and as a table | [`describe`] |
//! | robots as data, Table 1 of the paper | [`robot`] |
//! | scenes as data; loading and checking them | [`scene`], [`load`] |
//! | requests to a running session | [`action`] |
//! | connection between the processes | [`port`] |
//! | a controller of your own: as a program, in a session | [`controller_program`], [`controller_session`] |
//! | sessions: names, members and files in shared memory | [`session`] |
//! | monotonic clock, timeouts | [`clock`] |
//! | environment variables of a process in a session | [`peer_environment`] |
//! | files that the user names | [`file`] |
//! | sine, cosine, rotations | [`rotation`] |
//! | lines on standard error | [`log()`] |
//! | check of the processor's features | `processor` |

#![cfg_attr(not(test), deny(clippy::disallowed_methods))] // the same bits everywhere: clippy.toml

pub mod action;
pub mod clock;
pub mod controller_program;
pub mod controller_session;
pub mod describe;
mod error;
pub mod exit;
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

pub use log::{legible, log, printable, rounded_down, rounded_up};
