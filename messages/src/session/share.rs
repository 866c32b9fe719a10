//! A share: a socket through which the members of a group reach the session of another user.
//!
//! Shared memory stays private, because iceoryx2 0.10 fixes its permissions when it is compiled. The socket is in a folder that only its
//! owner and the group can enter. The system checks that, so both sides only check whom they talk to.

use super::private_file::{remove, user_name};
use super::{SHARED_MEMORY, Session};
use crate::error::{Absence, PortError};
use nix::unistd::{Gid, Group, Uid, User, getgrouplist, getuid};
use rustix::net::sockopt::socket_peercred;
use std::ffi::CString;
use std::fs::{DirBuilder, Metadata, Permissions, set_permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, PermissionsExt, chown};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

/// End of the name of the folder.
const FOLDER: &str = "share";
/// Name of the socket in it.
const SOCKET: &str = "desk";
/// Write permission of group and others.
const WRITTEN_BY_OTHERS: u32 = 0o022;

/// The owner's end of a share. Dropping it removes it.
#[derive(Debug)]
pub struct ShareListener {
    listener: UnixListener,
    group: Gid,
    _folder: ShareFolder,
}

/// The folder of a share, which is removed when dropped.
#[derive(Debug)]
struct ShareFolder(PathBuf);

impl Drop for ShareFolder {
    fn drop(&mut self) {
        remove(&self.0);
    }
}

/// A group by its name or number.
///
/// # Errors
/// [`PortError::Share`] if there is no such group.
pub fn group(name: &str) -> Result<Gid, PortError> {
    let named = Group::from_name(name).ok().flatten().map(|group| group.gid);
    let number = || name.parse().ok().map(Gid::from_raw);
    named
        .or_else(number)
        .ok_or_else(|| PortError::Share(format!("there is no group `{name}`: `getent group` lists them")))
}

/// Name of a group, or the number if the group has no name.
fn group_name(number: u32) -> String {
    let group = Group::from_gid(Gid::from_raw(number)).ok().flatten();
    group.map_or_else(|| number.to_string(), |group| group.name)
}

impl ShareListener {
    /// Opens the share of a session of this user. Only the leader or the plant of the session may do so.
    ///
    /// # Errors
    /// [`PortError::Share`] if this user may not give files to the group, [`PortError::SharedMemory`].
    pub fn open(session: &Session, group: Gid) -> Result<ShareListener, PortError> {
        let path = session.share_folder(getuid().as_raw());
        let failed = |error: io::Error| PortError::SharedMemory(format!("{} cannot be made: {error}", path.display()));
        let give = |path: &Path| {
            chown(path, None, Some(group.as_raw())).map_err(|error| match error.kind() {
                ErrorKind::PermissionDenied => PortError::Share(format!(
                    "user {} cannot share with group {}, because only a member of a group can",
                    user_name(getuid().as_raw()),
                    group_name(group.as_raw())
                )),
                _ => failed(error),
            })
        };
        remove(&path); // a process that was killed left it
        DirBuilder::new().mode(0o700).create(&path).map_err(failed)?;
        let folder = ShareFolder(path.clone());
        let socket = path.join(SOCKET);
        let listener = UnixListener::bind(&socket).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        give(&socket)?;
        set_permissions(&socket, Permissions::from_mode(0o660)).map_err(failed)?;
        // Until here only this user could enter the folder.
        give(&path)?;
        set_permissions(&path, Permissions::from_mode(0o750)).map_err(failed)?;
        Ok(ShareListener { listener, group, _folder: folder })
    }

    /// The next connection of the owner or of a member of the group, with the number of its user. `None` if nobody waits.
    pub fn accept(&self) -> Option<(UnixStream, u32)> {
        let (stream, _) = self.listener.accept().ok()?;
        let peer = socket_peercred(&stream).ok()?;
        let (user, group) = (peer.uid.as_raw(), peer.gid.as_raw());
        let is_trusted = user == 0 || user == getuid().as_raw() || group == self.group.as_raw();
        (is_trusted || self.lists(user)).then_some((stream, user))
    }

    /// Whether the system's list of groups has this user in the group.
    fn lists(&self, user: u32) -> bool {
        let Some(user) = User::from_uid(Uid::from_raw(user)).ok().flatten() else { return false };
        let groups = CString::new(user.name).ok().and_then(|name| getgrouplist(&name, user.gid).ok());
        groups.is_some_and(|groups| groups.contains(&self.group))
    }
}

/// The session of another user, seen through its share.
#[derive(Clone, Debug)]
pub struct SharedSession {
    session: Session,
    owner: u32,
}

impl SharedSession {
    /// The session `NAME` of `OWNER`.
    ///
    /// # Errors
    /// [`PortError::Share`] if there is no such user, [`PortError::SessionName`].
    pub fn of(owner: &str, name: &str) -> Result<SharedSession, PortError> {
        let named = User::from_name(owner).ok().flatten().map(|user| user.uid.as_raw());
        let user = named.or_else(|| owner.parse().ok());
        let owner = user.ok_or_else(|| PortError::Share(format!("there is no user `{owner}`")))?;
        Ok(SharedSession { session: Session::named(name)?, owner })
    }

    /// The sessions of this name that other users have.
    pub fn of_others(session: &Session) -> Vec<SharedSession> {
        session.other_owners().map(|owner| SharedSession { session: session.clone(), owner }).collect()
    }

    /// The session, if it is this user's own.
    pub fn own(&self) -> Option<&Session> {
        (self.owner == getuid().as_raw()).then_some(&self.session)
    }

    /// Owner and name, as `--session` takes them.
    pub fn name(&self) -> String {
        format!("{}/{}", user_name(self.owner), self.session.name())
    }

    /// Connects with the owner's process.
    ///
    /// # Errors
    /// [`PortError::Share`] if the session is not shared, or not with this user.
    pub fn connect(&self) -> Result<UnixStream, PortError> {
        let (name, user) = (self.session.name(), user_name(self.owner));
        let folder = self.session.share_folder(self.owner);
        let not_shared = || match self.session.other_owners().any(|other| other == self.owner) {
            true => PortError::Share(format!("session `{name}` belongs to {user}; ask them for --share GROUP")),
            false => PortError::NoSession { session: name.into(), why: Absence::Unknown },
        };
        let is_theirs = |found: &Metadata| found.uid() == self.owner;
        let found = folder.symlink_metadata().map_err(|_| not_shared())?;
        if !(found.is_dir() && is_theirs(&found) && found.mode() & WRITTEN_BY_OTHERS == 0) {
            return Err(not_shared());
        }
        let failed = |error: io::Error| match error.kind() {
            ErrorKind::PermissionDenied => PortError::Share(format!(
                "session `{name}` belongs to {user}, who shares it with group {}; {} is not a member",
                group_name(found.gid()),
                user_name(getuid().as_raw())
            )),
            ErrorKind::ConnectionRefused => PortError::Share(format!(
                "session `{name}` of {user} has ended: its processes were killed; ask them to start it again with --share {}",
                group_name(found.gid())
            )),
            _ => not_shared(),
        };
        let socket = folder.join(SOCKET);
        let file = socket.symlink_metadata().map_err(failed)?;
        let stream = UnixStream::connect(&socket).map_err(failed)?;
        let server = socket_peercred(&stream).map_err(|_| not_shared())?;
        let is_good = file.file_type().is_socket() && is_theirs(&file) && server.uid.as_raw() == self.owner;
        if is_good { Ok(stream) } else { Err(not_shared()) }
    }
}

impl Session {
    /// Folder of the share of a user's session of this name.
    pub(super) fn share_folder(&self, user: u32) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix_of(user) + FOLDER)
    }
}
