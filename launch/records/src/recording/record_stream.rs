//! The records of a file: a thread of their own reads, decompresses and checks them, while those before are made sense of.

use mcap::McapError;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::fs::File;
use std::io::Read;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// No record or chunk of ours is longer, nor of those who rewrote them; a damaged length asks for more [bytes].
const LONGEST: usize = 1 << 24;
/// What goes over at once; it stays in a cache [bytes].
const BATCH: usize = 1 << 18;
/// Batches that may wait.
const AHEAD: usize = 4;

/// RecordStream in their order.
pub(super) struct RecordStream {
    batches: Receiver<Result<Batch, McapError>>,
    batch: Batch,
    next: usize,
}

/// Some of them, end to end.
#[derive(Default)]
struct Batch {
    bytes: Vec<u8>,
    /// Of each its opcode, and where it ends.
    ends: Vec<(u8, usize)>,
    /// Bytes of the file up to here.
    read: u64,
}

impl RecordStream {
    /// Begins to read.
    pub fn of(file: File) -> RecordStream {
        let (to, batches) = sync_channel(AHEAD);
        std::thread::spawn(move || {
            if let Err(error) = read(file, &to) {
                let _ = to.send(Err(error));
            }
        });
        RecordStream { batches, batch: Batch::default(), next: 0 }
    }

    /// The next record, opcode and content; none at the end.
    ///
    /// # Errors
    /// If the file is damaged, or ends before its end.
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

    /// Bytes of the file that the records so far are from.
    pub fn read(&self) -> u64 {
        self.batch.read
    }
}

/// Reads to the end, or as long as somebody listens.
fn read(mut file: File, to: &SyncSender<Result<Batch, McapError>>) -> Result<(), McapError> {
    let options = LinearReaderOptions::default()
        .with_record_length_limit(LONGEST)
        .with_prevalidate_chunk_crcs(!cfg!(fuzzing)) // which no mutation of a fuzzer's would get through
        .with_skip_end_magic(true);
    let mut records = LinearReader::new_with_options(options);
    let mut batch = Batch::default();
    let end = loop {
        match records.next_event() {
            Some(Ok(LinearReadEvent::ReadRequest(wanted))) => match file.read(records.insert(wanted)) {
                Ok(count) => {
                    batch.read += count as u64;
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
        if batch.bytes.len() > BATCH {
            let room = (Vec::with_capacity(batch.bytes.capacity()), Vec::with_capacity(batch.ends.capacity()));
            let next = Batch { bytes: room.0, ends: room.1, read: batch.read };
            if to.send(Ok(std::mem::replace(&mut batch, next))).is_err() {
                return Ok(());
            }
        }
    };
    let _ = to.send(Ok(batch));
    end
}
