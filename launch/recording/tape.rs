//! A recording that is to be: its file is reserved, but nothing in it is touched before there is something to record, so that a run
//! that is refused costs no recording.

use super::Writer;
use crate::exit::{Exit, Failure};
use crate::output::unwritten;
use messages::scene::Scene;
use messages::wire::Truth;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

/// The file of a run.
pub enum Tape {
    /// As it was found.
    Reserved {
        path: PathBuf,
        file: File,
        /// Whether it was not there before.
        is_new: bool,
        scene: Box<Scene>,
    },
    /// With a record at least.
    Begun(Box<Writer>),
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
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let words = format!("another run is recording into {}: name another file", path.display());
            return Err(Failure::new(Exit::Usage, words));
        }
        Ok(Tape::Reserved { path: path.into(), file, is_new, scene: Box::new(scene.clone()) })
    }

    /// Takes the next truth.
    ///
    /// # Errors
    /// If the file cannot be written, as on a full disk.
    pub fn push(&mut self, truth: &Truth) -> Result<(), Failure> {
        if let Tape::Reserved { path, file, scene, .. } = self {
            let file = file.try_clone().map_err(|error| unwritten(path, &error))?;
            let _ = file.set_len(0); // what is no file, such as a pipe, has no length
            *self = Tape::Begun(Box::new(Writer::begin(path, file, scene)?));
        }
        match self {
            Tape::Begun(writer) => writer.push(truth),
            Tape::Reserved { .. } => Ok(()),
        }
    }

    /// Ends the file in order; one that was made for nothing goes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<(), Failure> {
        match self {
            Tape::Begun(writer) => writer.finish(),
            Tape::Reserved { path, is_new: true, .. } => {
                std::fs::remove_file(&path).map_err(|error| unwritten(&path, &error))
            }
            Tape::Reserved { .. } => Ok(()),
        }
    }
}
