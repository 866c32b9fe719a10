//! What is simulated in a session, for those who come to look on.

use super::{SHARED_MEMORY, Session};
use crate::port::PortError;
use std::path::{Path, PathBuf};

impl Session {
    /// Says what the scene is, as TOML. It goes with the rest of the session.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is no room for it.
    pub fn tell_scene(&self, text: &str) -> Result<(), PortError> {
        // a draft of one's own: launcher and plant say it at the same time
        let (draft, path) = (self.file(&format!("draft_{}", std::process::id())), self.file("scene"));
        let written = std::fs::write(&draft, text).and_then(|()| std::fs::rename(&draft, &path));
        written.map_err(|error| PortError::SharedMemory(format!("{} cannot be written: {error}", path.display())))
    }

    /// What the scene is, if somebody has said so.
    pub fn scene(&self) -> Option<String> {
        crate::file::text(&self.file("scene")).ok()
    }

    fn file(&self, name: &str) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + name)
    }
}
