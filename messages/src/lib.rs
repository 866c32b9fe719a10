//! The contract between plant and controller, and nothing else.
//!
//! Everything that both processes must agree on is here: the messages with their layout, check sum and schema hash; scenes and robots as data,
//! read from TOML and URDF and checked; sessions, which are sets of files in shared memory; and ports, the ends of the topics of a session. The
//! crate computes nothing about the robot. A foreign program needs no Rust: [`describe`] prints the same messages for C and Python.
//!
//! A scene is plain data. What a text leaves out has its default, and a wrong key gets a sentence that says where and what would be right:
//!
//! ```
//! use messages::{load, scene::Method};
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

pub mod ask;
pub mod clock;
pub mod describe;
pub mod file;
pub mod invitation;
mod law;
pub mod load;
pub mod port;
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod processor;
pub mod robot;
pub mod scene;
pub mod session;
mod tell;
pub mod turn;
pub mod wire;

pub use tell::{printable, tell};
