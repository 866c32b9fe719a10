//! The protocol of a share: another user sends one line of JSON, and the owner's process answers with lines.

use crate::exit::{Exit, Failure};
use messages::session::SharedSession;
use messages::wire::SCHEMA_HASH;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Longest line in either direction [bytes]. A push has 120, the longest sentence about a scene 1000.
const LONGEST_LINE: usize = 4096;
/// Longest wait for a line. The owner's process waits up to 2 s for plant or controller.
const LINE_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval at which a waiting process checks whether it has to stop.
const STOP_POLL: Duration = Duration::from_millis(100);

/// A request of another user. Bodies are given by name or number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
#[expect(missing_docs, reason = "the arguments of the commands, whose help explains them")]
pub enum SharedRequest {
    /// The lines of `biped top`.
    Top,
    Pause,
    Resume,
    Rearm,
    Step {
        periods: u64,
    },
    Reset {
        seed: Option<u64>,
    },
    Set {
        period: Option<f64>,
        speed: Option<f64>,
    },
    Stop,
    Push {
        /// The base by default.
        body: Option<String>,
        impulse: [f64; 3],
        duration: f64,
    },
}

/// The line of the other user.
#[derive(Serialize, Deserialize)]
struct Line {
    schema: u64,
    wanted: Value,
}

/// The answer of the owner's process: an exit code, and the text to print.
#[derive(Debug, Serialize, Deserialize)]
struct Answer {
    exit: u8,
    text: String,
}

/// Sends a request. [`read_answer`] reads its answer.
///
/// # Errors
/// If the session is not shared with this user.
pub fn send(shared: &SharedSession, request: &SharedRequest) -> Result<UnixStream, Failure> {
    let mut stream = shared.connect()?;
    let line = serde_json::to_value(request).map(|wanted| Line { schema: SCHEMA_HASH, wanted });
    write_line(&mut stream, &line.map_err(|error| broken(shared, &error))?).map_err(|error| broken(shared, &error))?;
    Ok(stream)
}

/// The text of the next answer; `None` at the end of the session.
///
/// # Errors
/// The refusal of the owner's process, or no answer.
pub fn read_answer(
    shared: &SharedSession,
    stream: &mut UnixStream,
    stop: &AtomicBool,
) -> Result<Option<String>, Failure> {
    let Some(line) = read_line(stream, stop).map_err(|reason| broken(shared, &reason))? else { return Ok(None) };
    let Answer { exit, text } = serde_json::from_str(&line).map_err(|error| broken(shared, &error))?;
    match Exit::of_child(Some(exit.into())) {
        Exit::Ok => Ok(Some(text)),
        exit => Err(Failure::new(exit, text)),
    }
}

fn broken(shared: &SharedSession, reason: &impl std::fmt::Display) -> Failure {
    Failure::new(Exit::PeerMissing, format!("the share of session {} does not answer: {reason}", shared.name()))
}

/// Reads the request of another user.
///
/// # Errors
/// If this version cannot read it.
pub fn receive(stream: &mut UnixStream, stop: &AtomicBool) -> Result<SharedRequest, Failure> {
    let unreadable =
        |reason: &dyn std::fmt::Display| Failure::new(Exit::Usage, format!("the request cannot be read: {reason}"));
    let line = read_line(stream, stop).map_err(|reason| unreadable(&reason))?;
    let line = line.ok_or_else(|| unreadable(&"it is empty"))?;
    let Line { schema, wanted } = serde_json::from_str(&line).map_err(|error| unreadable(&error))?;
    if schema != SCHEMA_HASH {
        let words = format!(
            "the owner's program has wire schema {SCHEMA_HASH:016x}, but this one has {schema:016x}: use the same version"
        );
        return Err(Failure::new(Exit::Incompatible, words));
    }
    serde_json::from_value(wanted).map_err(|error| unreadable(&error))
}

/// Sends the answer to another user.
///
/// # Errors
/// If the user has gone, or does not read.
pub fn answer(stream: &mut UnixStream, result: Result<String, Failure>) -> std::io::Result<()> {
    let (exit, text) = result.map_or_else(|failure| (failure.exit, failure.message), |text| (Exit::Ok, text));
    write_line(stream, &Answer { exit: exit as u8, text })
}

fn write_line(stream: &mut UnixStream, value: &impl Serialize) -> std::io::Result<()> {
    let mut line = serde_json::to_vec(value)?;
    line.push(b'\n');
    stream.set_write_timeout(Some(STOP_POLL))?; // a line fits into the buffer of a socket
    stream.write_all(&line)
}

/// Reads a line; `None` if the other side has closed the connection.
fn read_line(stream: &mut UnixStream, stop: &AtomicBool) -> Result<Option<String>, String> {
    let (mut line, mut byte, start) = (vec![], [0], Instant::now());
    stream.set_read_timeout(Some(STOP_POLL)).map_err(|error| error.to_string())?;
    while !stop.load(Relaxed) {
        match stream.read(&mut byte) {
            Ok(0) => return Ok(None),
            Ok(_) if byte == *b"\n" => return String::from_utf8(line).map(Some).map_err(|_| "it is not text".into()),
            Ok(_) => line.extend(byte),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => (),
            Err(error) if error.kind() == ErrorKind::ConnectionReset => return Ok(None),
            Err(error) => return Err(error.to_string()),
        }
        if line.len() > LONGEST_LINE || start.elapsed() > LINE_TIMEOUT {
            return Err(format!("no line of at most {LONGEST_LINE} bytes within {} s", LINE_TIMEOUT.as_secs()));
        }
    }
    Ok(None)
}
