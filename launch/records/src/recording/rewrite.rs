//! `biped convert --mcap`: a recording as a whole MCAP file with its index, whatever cut it short.

use super::file::{CHUNK, Mcap, create};
use super::reader::Reader;
use super::records::Records;
use mcap::records::Record;
use mcap::{MAGIC, McapError, McapResult};
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::{AtomicFile, log, print_text, refuse_overwriting_input, write_failure};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Rewrites it.
///
/// # Errors
/// See [`Reader::open`]; or if the new file cannot be written.
pub fn run(from: &Path, to: &Path, stop: &AtomicBool) -> Result<(), Failure> {
    refuse_overwriting_input(from, to)?;
    Reader::open(from)?; // refuses what is not ours
    let mut records = messages::file::open(from)
        .map(Records::of)
        .map_err(|error| Failure::new(Exit::Usage, format!("{}: cannot be opened: {error}", from.display())))?;
    let draft = AtomicFile::create(to, MAGIC).map_err(|error| write_failure(to, &error))?;
    let mut file =
        draft.file.try_clone().map_err(McapError::from).and_then(create).map_err(|e| write_failure(to, &e))?;
    let (mut waiting, mut cut) = (0, Some("it was not ended in order".to_string()));
    while let Some(record) = records.next() {
        check_interrupt(stop)?;
        let copied = record.and_then(|(opcode, data)| {
            waiting += data.len();
            mcap::parse_record(opcode, data)
        });
        match copied.and_then(|record| copy(&mut file, &record)) {
            Ok(None) => (),
            Ok(Some(in_order)) => {
                cut = cut.filter(|_| !in_order);
                break;
            }
            Err(error) => {
                cut = Some(error.to_string());
                break;
            }
        }
        if waiting > CHUNK {
            file.flush().map_err(|error| write_failure(to, &error))?;
            waiting = 0;
        }
    }
    let summary = file.finish().map_err(|error| write_failure(to, &error))?;
    draft.commit().map_err(|error| write_failure(to, &error))?;
    let count = summary.stats.map_or(0, |stats| stats.message_count);
    print_text(format_args!("{}: {count} messages, with their index\n", to.display()));
    if let Some(why) = cut {
        log(format_args!("{} is cut short: {why}; {} has all before that", from.display(), to.display()));
    }
    Ok(())
}

/// Copies a record; at the end of the old file, whether that was ended in order.
fn copy(file: &mut Mcap, record: &Record) -> McapResult<Option<bool>> {
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
        _ => (), // of the old file
    }
    Ok(None)
}
