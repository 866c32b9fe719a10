//! A recording that is to be: its file is reserved, but nothing in it is touched before there is something to record, so that a run
//! that is refused costs no recording.

use super::Writer;
use crate::exit::Failure;
use crate::output::{alone, unwritten};
use messages::scene::Scene;
use messages::wire::Truth;
use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};

/// The file of a run.
pub struct Tape {
    path: PathBuf,
    /// Locked for as long as it is open.
    file: File,
    /// Whether it was not there before.
    is_new: bool,
    scene: Scene,
    /// From the first record on.
    writer: Option<Writer>,
}

impl Tape {
    /// Reserves the file; one of that name will be replaced.
    ///
    /// # Errors
    /// If it cannot be written, or somebody else is writing it.
    pub fn reserve(path: &Path, scene: &Scene) -> Result<Tape, Failure> {
        let is_new = !path.exists();
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path);
        let file = file.map_err(|error| unwritten(path, &error))?;
        alone(&file, || format!("another run is recording into {}: name another file", path.display()))?;
        Ok(Tape { path: path.into(), file, is_new, scene: scene.clone(), writer: None })
    }

    /// Takes the next truth.
    ///
    /// # Errors
    /// If the file cannot be written, as on a full disk.
    pub fn push(&mut self, truth: &Truth) -> Result<(), Failure> {
        let writer = match &mut self.writer {
            Some(writer) => writer,
            none => {
                let _ = self.file.set_len(0); // what is no file, such as a pipe, has no length
                let file = self.file.try_clone().map_err(|error| unwritten(&self.path, &error))?;
                none.insert(Writer::begin(&self.path, file, &self.scene)?)
            }
        };
        writer.push(truth)
    }

    /// Ends the file in order; one that was made for nothing goes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<(), Failure> {
        match self.writer {
            Some(writer) => writer.finish(),
            None if self.is_new => std::fs::remove_file(&self.path).map_err(|error| unwritten(&self.path, &error)),
            None => Ok(()),
        }
    }
}
