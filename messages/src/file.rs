//! Files that the user names. Opening one never blocks, and reading one has a limit.

use nix::fcntl::OFlag;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use std::fs::{File, FileType, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::time::{Duration, Instant};

/// Largest size of a text: a scene, robot, contact problem or table [bytes].
const MAX_SIZE: u64 = 64 << 20;
/// Longest time to read from a pipe.
const PIPE_TIMEOUT: Duration = Duration::from_secs(10);

/// Opens a regular file.
///
/// # Errors
/// An error of the operating system, or a path that is a pipe, a device or a folder.
pub fn open(path: &Path) -> io::Result<File> {
    match open_without_blocking(path)? {
        (file, kind) if kind.is_file() => Ok(file),
        (_, kind) => Err(not_a_file(kind)),
    }
}

/// The text of a file, or of a pipe such as `<(command)` or standard input.
///
/// # Errors
/// An error of the operating system; a device, a folder or an empty pipe; or a text that is longer than 64 MiB or is not UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    let mut bytes = vec![];
    match open_without_blocking(path)? {
        (file, kind) if kind.is_file() => {
            file.take(MAX_SIZE + 1).read_to_end(&mut bytes)?;
        }
        (mut pipe, kind) if kind.is_fifo() => drain(&mut pipe, &mut bytes)?,
        (_, kind) => return Err(not_a_file(kind)),
    }
    if bytes.len() as u64 > MAX_SIZE {
        return Err(io::Error::other(format!("it is longer than {} MiB, the limit for such a text", MAX_SIZE >> 20)));
    }
    String::from_utf8(bytes).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is not text in UTF-8"))
}

/// Opens a file without waiting for the other end of a pipe.
fn open_without_blocking(path: &Path) -> io::Result<(File, FileType)> {
    let file = OpenOptions::new().read(true).custom_flags(OFlag::O_NONBLOCK.bits()).open(path)?;
    let kind = file.metadata()?.file_type();
    Ok((file, kind))
}

/// Reads a pipe to its end, or to more than [`MAX_SIZE`] bytes.
fn drain(pipe: &mut File, bytes: &mut Vec<u8>) -> io::Result<()> {
    let start = Instant::now();
    let late = || io::Error::other(format!("this is a pipe that has not ended within {} s", PIPE_TIMEOUT.as_secs()));
    let mut some = [0; 1 << 16];
    loop {
        match pipe.read(&mut some) {
            Ok(0) if bytes.is_empty() => return Err(io::Error::other("this is a pipe without any data")),
            Ok(0) => return Ok(()),
            Ok(count) => bytes.extend_from_slice(&some[..count]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let left = PIPE_TIMEOUT.checked_sub(start.elapsed()).ok_or_else(late)?;
                let left = PollTimeout::try_from(left).unwrap_or(PollTimeout::ZERO);
                let _ = poll(&mut [PollFd::new(pipe.as_fd(), PollFlags::POLLIN)], left); // the next read shows the result
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => (),
            Err(error) => return Err(error),
        }
        if bytes.len() as u64 > MAX_SIZE {
            return Ok(());
        }
        if start.elapsed() > PIPE_TIMEOUT {
            return Err(late());
        }
    }
}

fn not_a_file(kind: FileType) -> io::Error {
    io::Error::other(format!("this is not a file but a {}", name(kind)))
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
    fn endless_input_is_refused_and_finite_input_is_read() {
        let refused = |path: &Path, word: &str| {
            let error = text(path).expect_err("it must be refused").to_string();
            assert!(error.contains(word), "{}: {error}", path.display());
        };
        refused(Path::new("/dev/zero"), "device");
        refused(Path::new("/"), "folder");
        let path = std::env::temp_dir().join(format!("biped-pipe-{}", std::process::id()));
        nix::unistd::mkfifo(&path, Mode::S_IRWXU).expect("a pipe");
        refused(&path, "without any data");
        assert!(open(&path).is_err_and(|error| error.to_string().contains("pipe")));
        // a writer that never stops
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
        long.set_len(MAX_SIZE + 1).expect("a sparse file");
        refused(&path, "64 MiB");
        std::fs::remove_file(&path).expect("our own file");
    }
}
