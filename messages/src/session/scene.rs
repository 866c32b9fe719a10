//! Files that a session stores for the processes that join it: its scene, the environment of peers, and files to map into memory.

use super::{SHARED_MEMORY, Session, private_file};
use crate::error::PortError;
use nix::fcntl::{FallocateFlags, fallocate};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Largest size of such a file [bytes]. The longest built-in scene has 6000.
const LONGEST: u64 = 1 << 24;

impl Session {
    /// Stores the scene as TOML. The file is removed with the other files of the session.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if the file cannot be written.
    pub fn publish_scene(&self, text: &str) -> Result<(), PortError> {
        self.write("scene", text)
    }

    /// Stores the environment of peers as JSON.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if the file cannot be written.
    pub(crate) fn publish_environment(&self, text: &str) -> Result<(), PortError> {
        self.write("environment", text)
    }

    /// The scene as TOML, if it has been stored.
    pub fn scene(&self) -> Option<String> {
        private_file::read(&self.file("scene"), LONGEST).ok()
    }

    /// The environment of peers as JSON, if it has been stored.
    pub fn environment(&self) -> Option<String> {
        private_file::read(&self.file("environment"), LONGEST).ok()
    }

    fn write(&self, name: &str, text: &str) -> Result<(), PortError> {
        // Launcher and plant store it at the same time, so each first writes a separate draft.
        let (draft, path) = (self.file(&format!("draft_{}", std::process::id())), self.file(name));
        let write = || {
            let mut file = private_file::open(&draft, File::options().write(true).create(true).truncate(true))?;
            file.write_all(text.as_bytes())?;
            std::fs::rename(&draft, &path)
        };
        write().map_err(|error| PortError::SharedMemory(format!("{} cannot be written: {error}", path.display())))
    }

    /// A file of the session that can be mapped into memory. Its memory is reserved, and holds zeros if the file is new.
    pub(crate) fn reserved_file(&self, name: &str, bytes: usize) -> io::Result<File> {
        let options = &mut File::options();
        let file = private_file::open(&self.file(name), options.read(true).write(true).create(true).truncate(false))?;
        fallocate(&file, FallocateFlags::empty(), 0, bytes as i64)?;
        Ok(file)
    }

    fn file(&self, name: &str) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + name)
    }
}
