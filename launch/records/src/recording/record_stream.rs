//! The raw records of an MCAP file. A separate thread reads, decompresses and checks them ahead of their decoding.

use mcap::McapError;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
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
    batches: Receiver<Result<Batch, McapError>>,
    /// The current batch, and the index of its next record.
    batch: Batch,
    next: usize,
}

/// Several records in one buffer.
#[derive(Default)]
struct Batch {
    bytes: Vec<u8>,
    /// Opcode and end of each record in `bytes`.
    ends: Vec<(u8, usize)>,
    /// Bytes that have been read from the file up to the end of this batch.
    bytes_read: u64,
}

impl RecordStream {
    /// Starts to read a file.
    pub fn new(file: File) -> RecordStream {
        let (to, batches) = sync_channel(MAX_QUEUED_BATCHES);
        std::thread::spawn(move || {
            if let Err(error) = read(file, &to) {
                let _ = to.send(Err(error));
            }
        });
        RecordStream { batches, batch: Batch::default(), next: 0 }
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
fn read(mut file: File, to: &SyncSender<Result<Batch, McapError>>) -> Result<(), McapError> {
    let options = LinearReaderOptions::default()
        .with_record_length_limit(MAX_RECORD_BYTES)
        .with_prevalidate_chunk_crcs(!cfg!(fuzzing)) // a mutated input would never pass the check
        .with_skip_end_magic(true);
    let mut records = LinearReader::new_with_options(options);
    let mut batch = Batch::default();
    let end = loop {
        match records.next_event() {
            Some(Ok(LinearReadEvent::ReadRequest(wanted))) => match file.read(records.insert(wanted)) {
                Ok(count) => {
                    batch.bytes_read += count as u64;
                    records.notify_read(count);
                }
                Err(error) => break Err(error.into()),
            },
            Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                batch.bytes.extend_from_slice(data);
                batch.ends.push((opcode, batch.bytes.len()));
            }
            Some(Err(error)) => break Err(error),
            None => break Ok(()),
        }
        if batch.bytes.len() > BATCH_BYTES {
            let room = (Vec::with_capacity(batch.bytes.capacity()), Vec::with_capacity(batch.ends.capacity()));
            let next = Batch { bytes: room.0, ends: room.1, bytes_read: batch.bytes_read };
            if to.send(Ok(std::mem::replace(&mut batch, next))).is_err() {
                return Ok(());
            }
        }
    };
    let _ = to.send(Ok(batch));
    end
}
