//! `biped convert --mcap`: copies a recording, complete or truncated, into a complete MCAP file with index.

use super::mcap_file::{CHUNK_BYTES, McapWriter, create};
use super::reader::RecordingReader;
use super::record_stream::{RecordStream, parse_record};
use mcap::records::Record;
use mcap::{MAGIC, McapError, McapResult};
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::{AtomicFile, create_failure, log, print_text, refuse_overwriting_input, write_failure};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Copies the recording.
///
/// # Errors
/// See [`RecordingReader::open`]. Also if the new file cannot be written.
pub fn run(from: &Path, to: &Path, stop: &AtomicBool) -> Result<(), Failure> {
    refuse_overwriting_input(from, to)?;
    RecordingReader::open(from)?; // refuses a file that is not a recording of this program
    let file = messages::file::open(from)
        .map_err(|error| Failure::new(Exit::Usage, format!("{}: cannot be opened: {error}", from.display())))?;
    let mut records = RecordStream::new(file)?;
    let draft = AtomicFile::create(to, MAGIC).map_err(|error| create_failure(to, &error))?;
    let mut file =
        draft.file.try_clone().map_err(McapError::from).and_then(create).map_err(|e| write_failure(to, &e))?;
    let (mut unflushed_bytes, mut truncated_by) = (0, Some("the file has no index".to_string()));
    while let Some(record) = records.next() {
        check_interrupt(stop)?;
        let copied = record.and_then(|(opcode, data)| {
            unflushed_bytes += data.len();
            parse_record(opcode, data)
        });
        match copied.and_then(|record| copy(&mut file, &record)) {
            Ok(None) => (),
            Ok(Some(is_complete)) => {
                truncated_by = truncated_by.filter(|_| !is_complete);
                break;
            }
            Err(error) => {
                truncated_by = Some(error.to_string());
                break;
            }
        }
        if unflushed_bytes > CHUNK_BYTES {
            file.flush().map_err(|error| write_failure(to, &error))?;
            unflushed_bytes = 0;
        }
    }
    let summary = file.finish().map_err(|error| write_failure(to, &error))?;
    draft.commit().map_err(|error| write_failure(to, &error))?;
    let count = summary.stats.map_or(0, |stats| stats.message_count);
    print_text(format_args!("{}: {count} messages, with index\n", to.display()));
    if let Some(why) = truncated_by {
        log(format_args!("{} is cut short: {why}; {} contains everything before that", from.display(), to.display()));
    }
    Ok(())
}

/// Copies a record. Returns `Some` at the footer of the old file: true if that file has an index.
fn copy(file: &mut McapWriter, record: &Record) -> McapResult<Option<bool>> {
    match record {
        Record::Metadata(metadata) => file.write_metadata(metadata)?,
        Record::Schema { header, data } => {
            file.add_schema_with_id(header.id, &header.name, &header.encoding, data)?;
        }
        Record::Channel(channel) => {
            let mcap::records::Channel { id, schema_id, topic, message_encoding, metadata } = channel;
            file.add_channel_with_id(*id, *schema_id, topic, message_encoding, metadata)?;
        }
        Record::Message { header, data } => file.write_to_known_channel(header, data)?,
        Record::Footer(footer) => return Ok(Some(footer.summary_start > 0)),
        _ => (), // chunks and index of the old file
    }
    Ok(None)
}
