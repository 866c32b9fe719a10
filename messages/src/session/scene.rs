//! What is simulated in a session, for those who come to look on.

use super::{SHARED_MEMORY, Session, private_file};
use crate::port::PortError;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Of a scene as TOML [bytes]: the longest that is built in has six thousand.
const LONGEST_SCENE: u64 = 1 << 24;

impl Session {
    /// Says what the scene is, as TOML. It goes with the rest of the session.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is no room for it.
    pub fn publish_scene(&self, text: &str) -> Result<(), PortError> {
        // a draft of one's own: launcher and plant say it at the same time
        let (draft, path) = (self.file(&format!("draft_{}", std::process::id())), self.file("scene"));
        let write = || {
            let mut file = private_file::open(&draft, File::options().write(true).create(true).truncate(true))?;
            file.write_all(text.as_bytes())?;
            std::fs::rename(&draft, &path)
        };
        write().map_err(|error| PortError::SharedMemory(format!("{} cannot be written: {error}", path.display())))
    }

    /// What the scene is, if somebody has said so.
    pub fn scene(&self) -> Option<String> {
        private_file::read(&self.file("scene"), LONGEST_SCENE).ok()
    }

    fn file(&self, name: &str) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + name)
    }
}
