//! The file of a recording. What MCAP writes gathers in memory and comes into the file a whole chunk at a time, its length known.
//! Behind the last chunk stands the end of a file without index, which the next one overwrites: so every reader opens the file, whatever
//! stops the run. Also amid a chunk: first the new end is written, where it will stand, then all of the chunk that lies behind the
//! old end, and then what replaces that.

use mcap::MAGIC;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;

/// The end of a file without index: a record that ends the data, a footer that names no summary, and the magic bytes.
const TAIL: [u8; 50] = {
    const DATA_END: (u8, u8) = (0x0f, 4); // opcode and length; the check sum is 0: none
    const FOOTER: (u8, u8) = (0x02, 20);
    let mut tail = [0; 50];
    (tail[0], tail[1], tail[13], tail[14]) = (DATA_END.0, DATA_END.1, FOOTER.0, FOOTER.1);
    let mut place = 0;
    while place < MAGIC.len() {
        tail[42 + place] = MAGIC[place];
        place += 1;
    }
    tail
};

/// Gathers until it is flushed.
pub(super) struct ChunkSink {
    file: File,
    gathered: Vec<u8>,
    /// Of the file, without its tail [bytes].
    length: u64,
    /// Nothing comes behind what could not be written.
    has_failed: bool,
}

impl ChunkSink {
    /// Into an empty file.
    pub fn new(file: File) -> ChunkSink {
        ChunkSink { file, gathered: vec![], length: 0, has_failed: false }
    }
}

impl ChunkSink {
    fn commit(&self) -> io::Result<()> {
        let (over, behind) = self.gathered.split_at(self.gathered.len().min(TAIL.len()));
        if !self.gathered.ends_with(MAGIC) {
            // the end of the whole brings its own
            self.file.write_all_at(&TAIL, self.length + self.gathered.len() as u64)?;
        }
        self.file.write_all_at(behind, self.length + over.len() as u64)?;
        self.file.write_all_at(over, self.length)
    }
}

impl Write for ChunkSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.gathered.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    /// Whole, or not at all.
    fn flush(&mut self) -> io::Result<()> {
        if self.has_failed {
            return Err(io::Error::other("an earlier part could not be written"));
        }
        let length = self.gathered.len() as u64;
        let written = self.commit();
        self.gathered.clear();
        match &written {
            Ok(()) => self.length += length,
            Err(_) => {
                self.has_failed = true;
                let tail = if self.length > 0 { &TAIL[..] } else { &[] };
                let _ = self.file.set_len(self.length); // which makes room for the tail
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
    fn a_file_is_whole_after_each_chunk_and_after_one_that_does_not_fit() {
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
            // as a kill amid the next chunk leaves it: all of it that lies behind the end, and the end of that
            let amid = [&bytes[..], &[7; 99], &TAIL].concat();
            let records = mcap::read::LinearReader::new(&amid).unwrap().map_while(Result::ok);
            assert_eq!(
                records.filter(|record| matches!(record, Record::Message { .. } | Record::Footer(_))).count(),
                1
            );
        }
        let before = std::fs::read(&path).unwrap();
        // a descriptor that cannot be written stands for a full disk
        let mut sink =
            ChunkSink { file: File::open(&path).unwrap(), gathered: vec![1; 9], length: 20, has_failed: false };
        assert!(sink.flush().is_err() && sink.write(&[2]).is_ok() && sink.flush().is_err());
        assert!(std::fs::read(&path).unwrap() == before);
        std::fs::remove_file(path).unwrap();
    }
}
