//! What a session publishes beside its topics, as files that go with it: its scene, and what a peer has to know to take part.

use super::{SHARED_MEMORY, Session, private_file};
use crate::port::PortError;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Greatest size of such a file [bytes]: the longest built-in scene takes six thousand.
const LONGEST: u64 = 1 << 24;

impl Session {
    /// Publishes the scene, as TOML.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is no room for it.
    pub fn publish_scene(&self, text: &str) -> Result<(), PortError> {
        self.write("scene", text)
    }

    /// Publishes the environment of peers, as JSON.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is no room for it.
    pub(crate) fn publish_environment(&self, text: &str) -> Result<(), PortError> {
        self.write("environment", text)
    }

    /// The scene as TOML, if it has been published.
    pub fn scene(&self) -> Option<String> {
        private_file::read(&self.file("scene"), LONGEST).ok()
    }

    /// The environment of peers as JSON, if it has been published.
    pub fn environment(&self) -> Option<String> {
        private_file::read(&self.file("environment"), LONGEST).ok()
    }

    fn write(&self, name: &str, text: &str) -> Result<(), PortError> {
        // a draft of one's own: launcher and plant publish at the same time
        let (draft, path) = (self.file(&format!("draft_{}", std::process::id())), self.file(name));
        let write = || {
            let mut file = private_file::open(&draft, File::options().write(true).create(true).truncate(true))?;
            file.write_all(text.as_bytes())?;
            std::fs::rename(&draft, &path)
        };
        write().map_err(|error| PortError::SharedMemory(format!("{} cannot be written: {error}", path.display())))
    }

    fn file(&self, name: &str) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + name)
    }
}
