//! Records a run into a file. The file is locked before the run starts, but an existing recording is overwritten only when
//! the first record arrives. Therefore a run that fails to start destroys nothing. A recording that ends early does not
//! end the run.

use super::writer::RecordingWriter;
use clap::Args;
use mcap::{MAGIC, McapError, McapResult};
use messages::scene::Scene;
use messages::wire::{Served, Stamp, Truth};
use nix::sys::statvfs::fstatvfs;
use shared::exit::{Exit, Failure};
use shared::output::{lock_for_writing, log, write_failure};
use std::fs::{File, OpenOptions};
use std::io::Read;
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

/// Disk space that a recording leaves free for other files, such as the report of the run [bytes].
const RESERVED_BYTES: u64 = 16_000_000;
/// Space for one more chunk and the index [bytes].
const NEXT_CHUNK_BYTES: u64 = 2_000_000;
/// Compressed size of a control period of a walk [bytes], measured: the estimate of the size of a recording.
const BYTES_PER_PERIOD: f64 = 950.0;
/// Length of a recording divided by the length of its index [-].
const LENGTH_PER_INDEX: u64 = 1000;

/// Options of a recording.
#[derive(Args, Clone, Default)]
pub struct RecordArgs {
    /// Record the run into this MCAP file
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// End the recording before its file exceeds this size, for example 200M or 1.5G; the run goes on
    #[arg(long, value_name = "SIZE", requires = "record", value_parser = size)]
    record_limit: Option<u64>,
}

impl RecordArgs {
    /// The file, if the run is to be recorded.
    pub fn path(&self) -> Option<&Path> {
        self.record.as_deref()
    }

    /// Reserves the file.
    ///
    /// # Errors
    /// See [`McapRecorder::reserve`].
    pub fn recorder(&self, scene: &Scene) -> Result<Option<McapRecorder>, Failure> {
        self.path().map(|path| McapRecorder::reserve(path, scene, self.record_limit)).transpose()
    }
}

fn size(text: &str) -> Result<u64, String> {
    let (number, unit) = text.split_at(text.trim_end_matches(char::is_alphabetic).len());
    let unit = match unit.to_uppercase().as_str() {
        "" | "B" => Some(1.0),
        "K" | "KB" => Some(1e3),
        "M" | "MB" => Some(1e6),
        "G" | "GB" => Some(1e9),
        "T" | "TB" => Some(1e12),
        _ => None,
    };
    let bytes = unit.and_then(|unit| Some(number.parse::<f64>().ok()? * unit));
    let good = bytes.filter(|bytes| (2.0 * NEXT_CHUNK_BYTES as f64..1e18).contains(bytes)).map(|bytes| bytes as u64);
    good.ok_or_else(|| {
        format!("a size such as 200M or 1.5G is needed, of at least {}", megabytes(2 * NEXT_CHUNK_BYTES))
    })
}

/// Records a run into an MCAP file.
pub struct McapRecorder {
    path: PathBuf,
    /// Locked while it is open.
    file: File,
    /// The file did not exist before.
    is_new: bool,
    /// Limit of the file size [bytes].
    limit: Option<u64>,
    scene: Scene,
    /// Created with the first record.
    writer: Option<RecordingWriter>,
}

/// The reason why a recording ended before its run.
pub struct RecordingEnd {
    /// One sentence.
    pub message: String,
    /// Exit code of the run. A limit that the user has set is no failure.
    pub exit: Exit,
}

impl McapRecorder {
    /// Reserves the file. An existing recording will be replaced, but any other existing file is an error. Prints a warning
    /// if the disk is too full for the whole run.
    ///
    /// # Errors
    /// If the file cannot be written, is not a recording, or is in use by another run.
    fn reserve(path: &Path, scene: &Scene, limit: Option<u64>) -> Result<McapRecorder, Failure> {
        let refuse = |why: &str| Err(Failure::new(Exit::Usage, format!("{} {why}", path.display())));
        let is_new = !path.exists();
        if path.metadata().is_ok_and(|metadata| metadata.file_type().is_fifo()) {
            return refuse("is a pipe, but a recording needs a regular file: name another file");
        }
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path);
        let file = file.map_err(|error| write_failure(path, &error))?;
        let metadata = file.metadata().map_err(|error| write_failure(path, &error))?;
        let mut first_bytes = vec![];
        if metadata.is_file() && metadata.len() > 0 {
            let read = File::open(path).and_then(|file| file.take(MAGIC.len() as u64).read_to_end(&mut first_bytes));
            if read.is_err() || first_bytes != MAGIC {
                return refuse("exists and is not a recording, so it is not overwritten: name another file");
            }
        }
        lock_for_writing(&file, || format!("another run is recording into {}: name another file", path.display()))?;
        let recorder = McapRecorder { path: path.into(), file, is_new, limit, scene: scene.clone(), writer: None };
        if let Some(free) = recorder.free() {
            let (free, expected) = (free + metadata.len(), scene.duration * scene.rate * BYTES_PER_PERIOD);
            if free < RESERVED_BYTES + NEXT_CHUNK_BYTES {
                recorder.finish().map_err(|end| Failure::new(Exit::Fault, end.message))?;
                return Err(write_failure(
                    path,
                    &format!("the disk has {} left, and a recording {LEAVES_FREE}", megabytes(free)),
                ));
            }
            let (expected, room) =
                (expected.min(limit.map_or(f64::INFINITY, |limit| limit as f64)) as u64, free - RESERVED_BYTES);
            if expected > room {
                let (expected, free) = (megabytes(expected), megabytes(free));
                let estimate = format!(
                    "the run will take some {expected}, the disk has {free} left, and a recording {LEAVES_FREE}"
                );
                log(format_args!(
                    "{}: {estimate}: the recording will end before the run, which continues",
                    path.display()
                ));
            }
        }
        Ok(recorder)
    }

    /// Records the next truth.
    ///
    /// # Errors
    /// If the recording ends here.
    pub fn push(&mut self, truth: &Truth) -> Result<(), RecordingEnd> {
        let has_flushed = self.write(truth).map_err(|error| self.failed(&error, truth))?;
        let full = if has_flushed { self.is_full() } else { None };
        match (full, self.writer.take()) {
            (Some((exit, why)), Some(writer)) => {
                writer.finish().map_err(|error| self.failed(&error, truth))?;
                Err(self.end(exit, &why, &truth.stamp))
            }
            (_, writer) => {
                self.writer = writer;
                Ok(())
            }
        }
    }

    /// Records an answered request.
    ///
    /// # Errors
    /// As [`McapRecorder::push`].
    pub fn served(&mut self, served: &Served) -> Result<(), RecordingEnd> {
        let written = self.writer().and_then(|writer| writer.served(served));
        written.map_err(|error| self.end(Exit::Unrecorded, &describe(&error), &served.stamp))
    }

    fn writer(&mut self) -> McapResult<&mut RecordingWriter> {
        match &mut self.writer {
            Some(writer) => Ok(writer),
            none => {
                let _ = self.file.set_len(0); // fails for a device, which has no length
                Ok(none.insert(RecordingWriter::begin(self.file.try_clone()?, &self.scene)?))
            }
        }
    }

    fn write(&mut self, truth: &Truth) -> McapResult<bool> {
        self.writer()?.push(truth)
    }

    /// The reason why the file cannot take another chunk, if there is one.
    fn is_full(&self) -> Option<(Exit, String)> {
        let length = self.file.metadata().map_or(0, |metadata| metadata.len());
        let next = NEXT_CHUNK_BYTES + length / LENGTH_PER_INDEX;
        match (self.limit, self.free()) {
            (Some(limit), _) if length + next > limit => {
                Some((Exit::Ok, format!("--record-limit of {} is reached", megabytes(limit))))
            }
            (_, Some(free)) if free < RESERVED_BYTES + next => Some((
                Exit::Unrecorded,
                format!("the disk has {} left, and a recording {LEAVES_FREE}", megabytes(free)),
            )),
            _ => None,
        }
    }

    /// Free space on the disk [bytes]. `None` if the file is a device.
    fn free(&self) -> Option<u64> {
        let disk =
            fstatvfs(&self.file).ok().filter(|_| self.file.metadata().is_ok_and(|metadata| metadata.is_file()))?;
        Some(disk.blocks_available().saturating_mul(disk.fragment_size()))
    }

    /// Completes the file, or removes it if it is new and nothing was recorded.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<(), RecordingEnd> {
        let ended = match self.writer.take() {
            Some(writer) => writer.finish(),
            None if self.is_new => std::fs::remove_file(&self.path).map_err(Into::into),
            None => Ok(()),
        };
        ended.map_err(|error| RecordingEnd {
            message: write_failure(&self.path, &describe(&error)).message,
            exit: Exit::Unrecorded,
        })
    }

    fn failed(&self, error: &McapError, truth: &Truth) -> RecordingEnd {
        self.end(Exit::Unrecorded, &describe(error), &truth.stamp)
    }

    fn end(&self, exit: Exit, why: &str, stamp: &Stamp) -> RecordingEnd {
        let time = stamp.time();
        RecordingEnd { message: format!("the recording {} ends at {time:.3} s: {why}", self.path.display()), exit }
    }
}

/// States [`RESERVED_BYTES`] in messages.
const LEAVES_FREE: &str = "leaves 16 MB free";

fn megabytes(bytes: u64) -> String {
    format!("{:.0} MB", bytes as f64 * 1e-6)
}

/// The message of the underlying error, for example of a full disk.
fn describe(error: &McapError) -> String {
    match error {
        McapError::Io(error) => error.to_string(),
        error => error.to_string(),
    }
}
