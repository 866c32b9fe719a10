//! The raw records of an MCAP file. A separate thread reads, decompresses and checks them ahead of their decoding.

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};
use shared::exit::Failure;
use shared::thread;
use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Limit of the length of a record or chunk [bytes]. Neither this program nor MCAP tools write longer ones, so a greater
/// length shows that the file is damaged.
const MAX_RECORD_BYTES: usize = 1 << 24;
/// Length of a batch that is sent between the threads [bytes]. It fits into the processor's cache.
const BATCH_BYTES: usize = 1 << 18;
/// Number of batches that the reading thread may be ahead.
const MAX_QUEUED_BATCHES: usize = 4;

/// The records of a file, in order.
pub(super) struct RecordStream {
    batches: Receiver<Result<RecordBatch, McapError>>,
    /// The current batch, and the index of its next record.
    batch: RecordBatch,
    next: usize,
}

/// Several records in one buffer.
#[derive(Default)]
struct RecordBatch {
    bytes: Vec<u8>,
    /// Opcode and end of each record in `bytes`.
    ends: Vec<(u8, usize)>,
    /// Bytes that have been read from the file up to the end of this batch.
    bytes_read: u64,
}

impl RecordBatch {
    fn push(&mut self, opcode: u8, data: &[u8]) {
        self.bytes.extend_from_slice(data);
        self.ends.push((opcode, self.bytes.len()));
    }
}

impl RecordStream {
    /// Starts to read a file.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn new(file: File) -> Result<RecordStream, Failure> {
        let (to, batches) = sync_channel(MAX_QUEUED_BATCHES);
        thread::start(move || {
            if let Err(error) = read(file, &to) {
                let _ = to.send(Err(error));
            }
        })?;
        Ok(RecordStream { batches, batch: RecordBatch::default(), next: 0 })
    }

    /// Opcode and content of the next record. `None` at the end.
    ///
    /// # Errors
    /// If the file is damaged or truncated.
    pub fn next(&mut self) -> Option<Result<(u8, &[u8]), McapError>> {
        while self.next == self.batch.ends.len() {
            match self.batches.recv().ok()? {
                Ok(batch) => (self.batch, self.next) = (batch, 0),
                Err(error) => return Some(Err(error)),
            }
        }
        let begin = self.next.checked_sub(1).map_or(0, |before| self.batch.ends[before].1);
        let (opcode, end) = self.batch.ends[self.next];
        self.next += 1;
        Some(Ok((opcode, &self.batch.bytes[begin..end])))
    }

    /// Bytes of the file that have been read up to the current batch.
    pub fn bytes_read(&self) -> u64 {
        self.batch.bytes_read
    }
}

/// Reads until the end of the file, or until the receiver is dropped.
fn read(mut file: File, to: &SyncSender<Result<RecordBatch, McapError>>) -> Result<(), McapError> {
    let mut records = LinearReader::new_with_options(options().with_emit_chunks(true));
    let mut batch = RecordBatch::default();
    let end = loop {
        match records.next_event() {
            Some(Ok(LinearReadEvent::ReadRequest(wanted))) => match file.read(records.insert(wanted)) {
                Ok(count) => {
                    batch.bytes_read += count as u64;
                    records.notify_read(count);
                }
                Err(error) => break Err(error.into()),
            },
            Some(Ok(LinearReadEvent::Record { opcode: op::CHUNK, data })) => {
                if let Err(error) = unpack(data, &mut batch) {
                    break Err(error);
                }
            }
            Some(Ok(LinearReadEvent::Record { opcode, data })) => batch.push(opcode, data),
            Some(Err(error)) => break Err(error),
            None => break Ok(()),
        }
        if batch.bytes.len() > BATCH_BYTES {
            let room = (Vec::with_capacity(batch.bytes.capacity()), Vec::with_capacity(batch.ends.capacity()));
            let next = RecordBatch { bytes: room.0, ends: room.1, bytes_read: batch.bytes_read };
            if to.send(Ok(std::mem::replace(&mut batch, next))).is_err() {
                return Ok(());
            }
        }
    };
    let _ = to.send(Ok(batch));
    end
}

/// Parses a record of a type that this program writes. Other types, such as attachments, are not parsed: mcap 0.26 panics on an attachment
/// that is too short.
pub(super) fn parse_record(opcode: u8, data: &[u8]) -> McapResult<Record<'_>> {
    match opcode {
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA | op::FOOTER => mcap::parse_record(opcode, data),
        _ => Ok(Record::Unknown { opcode, data: Cow::Borrowed(data) }),
    }
}

fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_record_length_limit(MAX_RECORD_BYTES)
        .with_prevalidate_chunk_crcs(!cfg!(fuzzing)) // a mutated input would never pass the check
        .with_skip_end_magic(true)
}

/// Adds the records of a chunk to a batch, as many as are valid.
fn unpack(chunk: &[u8], batch: &mut RecordBatch) -> McapResult<()> {
    let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, chunk)? else { return Ok(()) };
    if header.compression.is_empty() {
        check_lengths(&data)?;
    }
    let mut records = LinearReader::new_with_options(options().with_skip_start_magic(true));
    let file = [&[op::CHUNK][..], &(chunk.len() as u64).to_le_bytes(), chunk].concat();
    let mut rest = &file[..];
    while let Some(event) = records.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (some, left) = rest.split_at(wanted.min(rest.len()));
                records.insert(some.len()).copy_from_slice(some);
                records.notify_read(some.len());
                rest = left;
            }
            LinearReadEvent::Record { opcode, data } => batch.push(opcode, data),
        }
    }
    Ok(())
}

/// Checks that the records of an uncompressed chunk fill it exactly. mcap 0.26 subtracts their lengths from that of the chunk without a
/// check: the result wraps, or panics where overflow is checked.
fn check_lengths(mut chunk: &[u8]) -> McapResult<()> {
    while !chunk.is_empty() {
        let after = chunk
            .split_first_chunk::<9>()
            .and_then(|([_, length @ ..], rest)| rest.get(usize::try_from(u64::from_le_bytes(*length)).ok()?..));
        chunk = after.ok_or(McapError::UnexpectedEoc)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Seek, SeekFrom, Write};

    /// A file with these bytes.
    fn file(bytes: &[u8]) -> File {
        let path = std::env::temp_dir().join(format!("biped-records-{:?}", std::thread::current().id()));
        let mut file = File::options().read(true).write(true).create(true).truncate(true).open(&path).expect("a file");
        std::fs::remove_file(path).expect("it is there");
        file.write_all(bytes).and_then(|()| file.seek(SeekFrom::Start(0))).expect("room");
        file
    }

    fn record(opcode: u8, data: &[u8]) -> Vec<u8> {
        [&[opcode][..], &(data.len() as u64).to_le_bytes(), data].concat()
    }

    /// A file with one uncompressed chunk, of two records of 3 bytes; the second states another length.
    fn recording(stated: u64) -> Vec<u8> {
        let mut records = [record(op::METADATA, &[1; 3]), record(op::METADATA, &[2; 3])].concat();
        records[13..21].copy_from_slice(&stated.to_le_bytes());
        let header = [&[0; 16][..], &(records.len() as u64).to_le_bytes(), &[0; 4], &0u32.to_le_bytes()].concat();
        let chunk = [&header[..], &(records.len() as u64).to_le_bytes(), &records].concat();
        [mcap::MAGIC, &record(op::CHUNK, &chunk), &record(op::DATA_END, &[0; 4])].concat()
    }

    /// Length of each record, and whether the stream ended without an error.
    fn lengths(bytes: &[u8]) -> (Vec<usize>, bool) {
        let (mut records, mut lengths) = (RecordStream::new(file(bytes)).expect("a thread"), vec![]);
        loop {
            match records.next() {
                Some(Ok((_, data))) => lengths.push(data.len()),
                Some(Err(_)) => return (lengths, false),
                None => return (lengths, true),
            }
        }
    }

    #[test]
    fn records_of_a_chunk_are_read_and_a_length_beyond_the_chunk_is_an_error() {
        assert_eq!(lengths(&recording(3)), (vec![3, 3, 4], true));
        for wrong in [2, 4, 5, 1 << 20, u64::MAX, u64::MAX - 9] {
            assert_eq!(lengths(&recording(wrong)), (vec![], false), "{wrong}");
        }
    }

    #[test]
    fn an_attachment_that_is_too_short_is_not_parsed() {
        for length in 0..64 {
            assert!(matches!(parse_record(op::ATTACHMENT, &vec![0; length]), Ok(Record::Unknown { .. })));
        }
    }
}
