//! A sink that keeps the file valid at all times. It buffers the output of the MCAP writer and appends one complete
//! chunk per flush. After the last chunk it writes the tail of an MCAP file without index, which the next chunk
//! overwrites. Therefore every reader can open the file, even after the run was killed.
//!
//! This also holds while a chunk is being written. The order of writes is: the new tail at its final position, the part
//! of the chunk that lies beyond the old tail, and finally the part that replaces the old tail.

use mcap::MAGIC;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;

/// Tail of an MCAP file without index: a DataEnd record, a Footer record without summary, and the magic bytes.
const TAIL: [u8; 50] = {
    const DATA_END: (u8, u8) = (0x0f, 4); // opcode and length; the CRC 0 means that there is none
    const FOOTER: (u8, u8) = (0x02, 20);
    let mut tail = [0; 50];
    (tail[0], tail[1], tail[13], tail[14]) = (DATA_END.0, DATA_END.1, FOOTER.0, FOOTER.1);
    let mut index = 0;
    while index < MAGIC.len() {
        tail[42 + index] = MAGIC[index];
        index += 1;
    }
    tail
};

/// Buffers output until it is flushed.
pub(super) struct ChunkSink {
    file: File,
    buffer: Vec<u8>,
    /// Length of the file without its tail [bytes].
    length: u64,
    /// A write has failed. Later chunks are refused, because they would follow an incomplete one.
    has_failed: bool,
}

impl ChunkSink {
    /// A sink for an empty file.
    pub fn new(file: File) -> ChunkSink {
        ChunkSink { file, buffer: vec![], length: 0, has_failed: false }
    }
}

impl ChunkSink {
    fn commit(&self) -> io::Result<()> {
        let (over_tail, beyond_tail) = self.buffer.split_at(self.buffer.len().min(TAIL.len()));
        if !self.buffer.ends_with(MAGIC) {
            // The final chunk contains the tail.
            self.file.write_all_at(&TAIL, self.length + self.buffer.len() as u64)?;
        }
        self.file.write_all_at(beyond_tail, self.length + over_tail.len() as u64)?;
        self.file.write_all_at(over_tail, self.length)
    }
}

impl Write for ChunkSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.buffer.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    /// Appends the buffer to the file completely, or restores the file.
    fn flush(&mut self) -> io::Result<()> {
        if self.has_failed {
            return Err(io::Error::other("an earlier chunk could not be written"));
        }
        let length = self.buffer.len() as u64;
        let written = self.commit();
        self.buffer.clear();
        match &written {
            Ok(()) => self.length += length,
            Err(_) => {
                self.has_failed = true;
                let tail = if self.length > 0 { &TAIL[..] } else { &[] };
                let _ = self.file.set_len(self.length); // frees space for the tail on a full disk
                let _ = self.file.write_all_at(tail, self.length);
            }
        }
        written
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::records::{DataEnd, Footer, Record};
    use mcap::write::NoSeek;

    #[test]
    fn the_file_is_valid_after_each_chunk_and_after_a_failed_one() {
        let path = std::env::temp_dir().join(format!("biped-sink-{}", std::process::id()));
        let file = File::options().read(true).write(true).create_new(true).open(&path).unwrap();
        let options = mcap::WriteOptions::new().chunk_size(None).disable_seeking(true);
        let mut writer = options.create(NoSeek::new(ChunkSink::new(file.try_clone().unwrap()))).unwrap();
        let channel = writer.add_channel(0, "/a", "json", &Default::default()).unwrap();
        for sequence in 0..3 {
            let header = mcap::records::MessageHeader { channel_id: channel, sequence, log_time: 0, publish_time: 0 };
            writer.write_to_known_channel(&header, b"{}").unwrap();
            writer.flush().unwrap();
            let bytes = std::fs::read(&path).unwrap();
            let messages = mcap::MessageStream::new(&bytes).unwrap().map(|message| message.unwrap().sequence);
            assert!(messages.eq(0..=sequence));
            let ends: Vec<_> = mcap::read::LinearReader::new(&bytes).unwrap().map(Result::unwrap).collect();
            let [.., Record::DataEnd(DataEnd { data_section_crc: 0 }), Record::Footer(footer)] = &ends[..] else {
                panic!("{ends:?}")
            };
            assert_eq!(*footer, Footer { summary_start: 0, summary_offset_start: 0, summary_crc: 0 });
            // The state after a kill during the next chunk: its part beyond the old tail, and the new tail.
            let interrupted = [&bytes[..], &[7; 99], &TAIL].concat();
            let records = mcap::read::LinearReader::new(&interrupted).unwrap().map_while(Result::ok);
            assert_eq!(
                records.filter(|record| matches!(record, Record::Message { .. } | Record::Footer(_))).count(),
                1
            );
        }
        let before = std::fs::read(&path).unwrap();
        // A read-only descriptor simulates a full disk.
        let mut sink =
            ChunkSink { file: File::open(&path).unwrap(), buffer: vec![1; 9], length: 20, has_failed: false };
        assert!(sink.flush().is_err() && sink.write(&[2]).is_ok() && sink.flush().is_err());
        assert!(std::fs::read(&path).unwrap() == before);
        std::fs::remove_file(path).unwrap();
    }
}
