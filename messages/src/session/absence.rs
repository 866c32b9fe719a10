//! Why a process cannot join the session of a name.

use super::Session;
use super::private_file::{self, user_name};
use crate::error::Absence;
use std::fs::File;

impl Session {
    /// Why this session is not running.
    pub fn absence(&self) -> Absence {
        if private_file::open(&self.lock_file(), File::options().read(true)).is_ok() {
            return Absence::Killed;
        }
        let foreign = |user| Absence::Foreign { owner: user_name(user), shared: self.share_folder(user).exists() };
        self.other_owners().next().map_or(Absence::Unknown, foreign)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_whose_processes_were_killed_is_told_from_one_that_never_was() {
        let session = Session::unique();
        assert_eq!(session.absence(), Absence::Unknown);
        std::fs::write(session.lock_file(), session.name()).expect("shared memory");
        assert_eq!(session.absence(), Absence::Killed);
        assert!(session.require_running().expect_err("killed").to_string().contains("its processes were killed"));
        session.remove_files();
        assert_eq!(session.absence(), Absence::Unknown);
    }
}
