//! Recordings: the messages of each topic, as bytes that NumPy takes as arrays.

use crate::error::RecordingError;
use crate::scene::Scene;
use bytemuck::bytes_of;
use messages::wire::Truth;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use records::recording::{Payload, RecordingReader};
use shared::exit::Failure;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Messages of one topic: log times [ns], and the messages one after another.
type Topic = (Vec<u64>, Vec<u8>);
/// The same as Python objects.
type TopicBytes<'py> = (Bound<'py, PyBytes>, Bound<'py, PyBytes>);

/// Reads a recording: scene, times [ns] and messages of each topic, when it began, and why it is cut short, if it is.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "a plain tuple for Python")]
pub fn read_recording<'py>(
    py: Python<'py>,
    path: PathBuf,
) -> PyResult<(Scene, BTreeMap<&'static str, TopicBytes<'py>>, String, Option<String>)> {
    let read = || {
        let mut reader = RecordingReader::open(&path)?;
        let topics = topics(&mut reader);
        let (scene, begun) = (reader.scene().clone(), reader.metadata("begun").to_string());
        Ok((scene, topics, begun, reader.truncated_by))
    };
    let (scene, topics, begun, truncated_by) = py.detach(read).map_err(failed)?;
    let topics = topics.into_iter().map(|(name, topic)| (name, bytes(py, &topic))).collect();
    Ok((Scene { name: path.display().to_string(), scene }, topics, begun, truncated_by))
}

/// Reads a recording as one topic: times [ns], and the truth of each control period, completed from the other topics.
#[pyfunction]
pub fn read_table<'py>(py: Python<'py>, path: PathBuf) -> PyResult<TopicBytes<'py>> {
    let read = || {
        let (mut reader, mut truth, mut table) = (RecordingReader::open(&path)?, Truth::default(), Topic::default());
        while let Some(time) = reader.next_truth(&mut truth) {
            table.0.push(time);
            table.1.extend_from_slice(bytes_of(&truth));
        }
        Ok(table)
    };
    Ok(bytes(py, &py.detach(read).map_err(failed)?))
}

fn failed(failure: Failure) -> PyErr {
    RecordingError::new_err(failure.message)
}

fn bytes<'py>(py: Python<'py>, (times, messages): &Topic) -> TopicBytes<'py> {
    (PyBytes::new(py, bytemuck::cast_slice(times)), PyBytes::new(py, messages))
}

/// The messages of each topic.
fn topics(reader: &mut RecordingReader) -> BTreeMap<&'static str, Topic> {
    let mut topics = BTreeMap::<_, Topic>::new();
    while let Some(message) = reader.next_message() {
        let (name, bytes) = match &message.payload {
            Payload::Sensors(sensors) => ("sensors", bytes_of(sensors)),
            Payload::Command(command) => ("command", bytes_of(command)),
            Payload::Telemetry(telemetry) => ("telemetry", bytes_of(telemetry)),
            Payload::Truth(truth) => ("truth", bytes_of(&**truth)),
            Payload::Served(served) => ("served", bytes_of(&**served)),
            Payload::Other => continue,
        };
        let (times, messages) = topics.entry(name).or_default();
        times.push(message.time);
        messages.extend_from_slice(bytes);
    }
    topics
}
