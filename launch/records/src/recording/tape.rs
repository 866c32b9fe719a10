//! A recording that is to be: its file is reserved, but nothing in it is touched before there is something to record, so that a run
//! that is refused costs no recording. Whatever ends the recording does not end the run.

use super::writer::Writer;
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

/// What a recording leaves free, for whatever else is written there, such as the report of the run [bytes].
const LEAVE: u64 = 16_000_000;
/// Room for one more chunk, and the index [bytes].
const NEXT: u64 = 2_000_000;
/// What a walk takes for a control period, after compression: what a run will take is known no better than that [bytes].
const PERIOD: f64 = 950.0;

/// Where a run is recorded.
#[derive(Args, Clone, Default)]
pub struct RecordArgs {
    /// Record the run into this MCAP file, as it goes on
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// End the recording before its file is larger than this, such as 200M or 1.5G; the run goes on
    #[arg(long, value_name = "SIZE", requires = "record", value_parser = size)]
    record_limit: Option<u64>,
}

impl RecordArgs {
    /// The file, if there is to be one.
    pub fn path(&self) -> Option<&Path> {
        self.record.as_deref()
    }

    /// Reserves it.
    ///
    /// # Errors
    /// See [`Tape::reserve`].
    pub fn tape(&self, scene: &Scene) -> Result<Option<Tape>, Failure> {
        self.path().map(|path| Tape::reserve(path, scene, self.record_limit)).transpose()
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
    let good = bytes.filter(|bytes| (2.0 * NEXT as f64..1e18).contains(bytes)).map(|bytes| bytes as u64);
    good.ok_or_else(|| format!("a size such as 200M or 1.5G is needed, of at least {}", megabytes(2 * NEXT)))
}

/// The file of a run.
pub struct Tape {
    path: PathBuf,
    /// Locked for as long as it is open.
    file: File,
    /// Whether it was not there before.
    is_new: bool,
    limit: Option<u64>,
    scene: Scene,
    /// From the first record on.
    writer: Option<Writer>,
}

/// Why a recording ended before its run.
pub struct End {
    /// In a sentence.
    pub words: String,
    /// What that makes of the run: a limit that was asked for is no failure.
    pub exit: Exit,
}

impl Tape {
    /// Reserves the file; a recording of that name will be replaced, anything else is kept. Says so if there is too little room.
    ///
    /// # Errors
    /// If it cannot be written, is no recording, or somebody else is writing it.
    fn reserve(path: &Path, scene: &Scene, limit: Option<u64>) -> Result<Tape, Failure> {
        let refuse = |why: &str| Err(Failure::new(Exit::Usage, format!("{} {why}", path.display())));
        let is_new = !path.exists();
        if path.metadata().is_ok_and(|about| about.file_type().is_fifo()) {
            return refuse("is a pipe, but a recording needs a file: name one");
        }
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path);
        let file = file.map_err(|error| write_failure(path, &error))?;
        let about = file.metadata().map_err(|error| write_failure(path, &error))?;
        let mut begin = vec![];
        if about.is_file() && about.len() > 0 {
            let read = File::open(path).and_then(|file| file.take(MAGIC.len() as u64).read_to_end(&mut begin));
            if read.is_err() || begin != MAGIC {
                return refuse("is there and is no recording, so it is kept: name another file");
            }
        }
        lock_for_writing(&file, || format!("another run is recording into {}: name another file", path.display()))?;
        let tape = Tape { path: path.into(), file, is_new, limit, scene: scene.clone(), writer: None };
        if let Some(free) = tape.free() {
            let (free, all) = (free + about.len(), scene.duration * scene.rate * PERIOD);
            if free < LEAVE + NEXT {
                tape.finish().map_err(|end| Failure::new(Exit::Fault, end.words))?;
                return Err(write_failure(
                    path,
                    &format!("the disk has {} left, and a recording {KEEPS}", megabytes(free)),
                ));
            }
            let (all, room) = (all.min(limit.map_or(f64::INFINITY, |limit| limit as f64)) as u64, free - LEAVE);
            if all > room {
                let (all, free) = (megabytes(all), megabytes(free));
                let words = format!("the run will take some {all}, the disk has {free} left, and a recording {KEEPS}");
                log(format_args!("{}: {words}: it will end before the run, which goes on", path.display()));
            }
        }
        Ok(tape)
    }

    /// Takes the next truth.
    ///
    /// # Errors
    /// If that ends the recording.
    pub fn push(&mut self, truth: &Truth) -> Result<(), End> {
        let has_grown = self.write(truth).map_err(|error| self.failed(&error, truth))?;
        let full = if has_grown { self.full() } else { None };
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

    /// Takes a request that was answered.
    ///
    /// # Errors
    /// As [`Tape::push`].
    pub fn served(&mut self, served: &Served) -> Result<(), End> {
        let written = self.writer().and_then(|writer| writer.served(served));
        written.map_err(|error| self.end(Exit::Unrecorded, &words(&error), &served.stamp))
    }

    fn writer(&mut self) -> McapResult<&mut Writer> {
        match &mut self.writer {
            Some(writer) => Ok(writer),
            none => {
                let _ = self.file.set_len(0); // what is no file has no length
                Ok(none.insert(Writer::begin(self.file.try_clone()?, &self.scene)?))
            }
        }
    }

    fn write(&mut self, truth: &Truth) -> McapResult<bool> {
        self.writer()?.push(truth)
    }

    /// Why there is no room for more.
    fn full(&self) -> Option<(Exit, String)> {
        let length = self.file.metadata().map_or(0, |about| about.len());
        let next = NEXT + length / 1000; // whose index is as long as that
        match (self.limit, self.free()) {
            (Some(limit), _) if length + next > limit => {
                Some((Exit::Ok, format!("--record-limit of {} is reached", megabytes(limit))))
            }
            (_, Some(free)) if free < LEAVE + next => {
                Some((Exit::Unrecorded, format!("the disk has {} left, and a recording {KEEPS}", megabytes(free))))
            }
            _ => None,
        }
    }

    /// Room on the disk, if it is one [bytes].
    fn free(&self) -> Option<u64> {
        let disk = fstatvfs(&self.file).ok().filter(|_| self.file.metadata().is_ok_and(|about| about.is_file()))?;
        Some(disk.blocks_available().saturating_mul(disk.fragment_size()))
    }

    /// Ends the file in order; one that was made for nothing goes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<(), End> {
        let ended = match self.writer.take() {
            Some(writer) => writer.finish(),
            None if self.is_new => std::fs::remove_file(&self.path).map_err(Into::into),
            None => Ok(()),
        };
        ended.map_err(|error| End { words: write_failure(&self.path, &words(&error)).message, exit: Exit::Unrecorded })
    }

    fn failed(&self, error: &McapError, truth: &Truth) -> End {
        self.end(Exit::Unrecorded, &words(error), &truth.stamp)
    }

    fn end(&self, exit: Exit, why: &str, stamp: &Stamp) -> End {
        let time = stamp.sim_ns as f64 * 1e-9;
        End { words: format!("the recording {} ends at {time:.3} s: {why}", self.path.display()), exit }
    }
}

/// What a recording does with the last of a disk.
const KEEPS: &str = "leaves 16 MB";

fn megabytes(bytes: u64) -> String {
    format!("{:.0} MB", bytes as f64 * 1e-6)
}

/// In the words of whatever is behind it, such as a full disk.
fn words(error: &McapError) -> String {
    match error {
        McapError::Io(error) => error.to_string(),
        error => error.to_string(),
    }
}
