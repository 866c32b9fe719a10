//! Files that somebody names: opened without waiting for anybody, and read no further than a text may reach.

use nix::fcntl::OFlag;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use std::fs::{File, FileType, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::time::{Duration, Instant};

/// No scene, robot, contact problem or table is longer [bytes].
const LONGEST: u64 = 64 << 20;
/// What comes through a pipe has come by then.
const PATIENCE: Duration = Duration::from_secs(10);

/// Opens a file; what may have no end, such as a pipe or a device, is none.
///
/// # Errors
/// As the system has them, or that.
pub fn open(path: &Path) -> io::Result<File> {
    match at_once(path)? {
        (file, kind) if kind.is_file() => Ok(file),
        (_, kind) => Err(io::Error::other(format!("this is no file but a {}", name(kind)))),
    }
}

/// The text of a file, or of a pipe such as `<(command)` or standard input.
///
/// # Errors
/// As the system has them; or if it is a device or a folder, longer than 64 MiB, or nothing comes through the pipe.
pub fn text(path: &Path) -> io::Result<String> {
    let mut bytes = vec![];
    match at_once(path)? {
        (file, kind) if kind.is_file() => {
            file.take(LONGEST + 1).read_to_end(&mut bytes)?;
        }
        (mut pipe, kind) if kind.is_fifo() => drain(&mut pipe, &mut bytes)?,
        (_, kind) => return Err(io::Error::other(format!("this is no file but a {}", name(kind)))),
    }
    if bytes.len() as u64 > LONGEST {
        return Err(io::Error::other(format!("it is longer than {} MiB, which no such text is", LONGEST >> 20)));
    }
    String::from_utf8(bytes).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is no text in UTF-8"))
}

/// Without waiting for a pipe's other end.
fn at_once(path: &Path) -> io::Result<(File, FileType)> {
    let file = OpenOptions::new().read(true).custom_flags(OFlag::O_NONBLOCK.bits()).open(path)?;
    let kind = file.metadata()?.file_type();
    Ok((file, kind))
}

/// All that comes through a pipe.
fn drain(pipe: &mut File, bytes: &mut Vec<u8>) -> io::Result<()> {
    let begun = Instant::now();
    let late = || io::Error::other(format!("this is a pipe whose end has not come within {} s", PATIENCE.as_secs()));
    let mut some = [0; 1 << 16];
    loop {
        match pipe.read(&mut some) {
            Ok(0) if bytes.is_empty() => return Err(io::Error::other("this is a pipe, and nothing came through it")),
            Ok(0) => return Ok(()),
            Ok(count) => bytes.extend_from_slice(&some[..count]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let left = PATIENCE.checked_sub(begun.elapsed()).ok_or_else(late)?;
                let left = PollTimeout::try_from(left).unwrap_or(PollTimeout::ZERO);
                let _ = poll(&mut [PollFd::new(pipe.as_fd(), PollFlags::POLLIN)], left); // what it is, reading tells
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => (),
            Err(error) => return Err(error),
        }
        if bytes.len() as u64 > LONGEST {
            return Ok(());
        }
        if begun.elapsed() > PATIENCE {
            return Err(late());
        }
    }
}

fn name(kind: FileType) -> &'static str {
    match kind {
        kind if kind.is_dir() => "folder",
        kind if kind.is_fifo() => "pipe",
        kind if kind.is_socket() => "socket",
        _ => "device",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nix::sys::stat::Mode;
    use std::io::Write;

    #[test]
    fn what_has_no_end_is_refused_and_what_has_one_is_read() {
        let refused = |path: &Path, word: &str| {
            let error = text(path).expect_err("it must be refused").to_string();
            assert!(error.contains(word), "{}: {error}", path.display());
        };
        refused(Path::new("/dev/zero"), "device");
        refused(Path::new("/"), "folder");
        let path = std::env::temp_dir().join(format!("biped-pipe-{}", std::process::id()));
        nix::unistd::mkfifo(&path, Mode::S_IRWXU).expect("a pipe");
        refused(&path, "nothing came");
        assert!(open(&path).is_err_and(|error| error.to_string().contains("pipe")));
        // endless: somebody writes and never stops
        let mut endless = OpenOptions::new().read(true).write(true).open(&path).expect("both ends");
        let writing = std::thread::spawn(move || while endless.write_all(&[b'#'; 1 << 16]).is_ok() {});
        refused(&path, "64 MiB");
        std::fs::remove_file(&path).expect("our own file");
        drop(writing); // it ends with this process
        let (reader, mut writer) = io::pipe().expect("a pipe");
        writer.write_all(b"duration = 1.0").expect("room in it");
        drop(writer);
        let number = std::os::fd::AsRawFd::as_raw_fd(&reader);
        assert_eq!(text(Path::new(&format!("/proc/self/fd/{number}"))).expect("a text"), "duration = 1.0");
        let long = File::create(&path).expect("a file");
        long.set_len(LONGEST + 1).expect("a sparse file");
        refused(&path, "64 MiB");
        std::fs::remove_file(&path).expect("our own file");
    }
}
