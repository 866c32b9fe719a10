//! `biped doctor` checks this machine and lists the running sessions. `biped clean` removes the files of dead sessions.

use crate::host_environment::HostEnvironment;
use crate::realtime;
use crate::resource_limits::MIN_OPEN_FILES;
use messages::port::{REQUIRED_SHM, TRANSPORT};
use messages::session::{REQUIRED_FILES, SHARED_MEMORY, Session, ShmUsage, StaleSession};
use messages::wire::SCHEMA_HASH;
use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};
use nix::sys::statvfs::{FsFlags, statvfs};
use nix::sys::utsname::uname;
use shared::exit::{Exit, Failure};
use shared::output::print_text;
use shared::thread;
use std::fmt;
use std::os::unix::fs::MetadataExt;

/// Clock sources that take nanoseconds to read, because no system call is needed.
const FAST_CLOCKS: [&str; 4] = ["tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"];

/// The result of one check.
#[derive(Debug)]
struct CheckResult {
    item: &'static str,
    found: String,
    level: Level,
}

/// The severity of a result, with advice.
#[derive(Debug)]
enum Level {
    Ok,
    /// Runs work, but real-time runs would be better with this advice.
    Warning(String),
    /// Runs fail until the user follows this advice.
    Wrong(String),
}

impl fmt::Display for CheckResult {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (word, advice) = match &self.level {
            Level::Ok => ("ok", ""),
            Level::Warning(advice) => ("warning", advice.as_str()),
            Level::Wrong(advice) => ("wrong", advice.as_str()),
        };
        writeln!(f, "{word:<8} {:<18} {}", self.item, self.found)?;
        if !advice.is_empty() {
            writeln!(f, "{:<27} → {advice}", "")?;
        }
        Ok(())
    }
}

impl CheckResult {
    fn ok(item: &'static str, found: impl ToString) -> CheckResult {
        CheckResult { item, found: found.to_string(), level: Level::Ok }
    }

    /// Ok if `good`, otherwise the given level.
    fn checked(item: &'static str, found: impl ToString, good: bool, otherwise: impl FnOnce() -> Level) -> CheckResult {
        CheckResult { item, found: found.to_string(), level: if good { Level::Ok } else { otherwise() } }
    }
}

/// Runs all checks and prints their results.
///
/// # Errors
/// If a result is wrong.
pub fn doctor() -> Result<(), Failure> {
    let all = [program(), kernel(), limits(), memory(), sessions(), dead_sessions()];
    let results: Vec<CheckResult> = all.into_iter().flatten().collect();
    results.iter().for_each(print_text);
    match results.iter().filter(|result| matches!(result.level, Level::Wrong(_))).count() {
        0 => Ok(()),
        count => Err(Failure::new(Exit::Fault, format!("{count} of {} checks failed", results.len()))),
    }
}

/// Removes the files of this user's dead sessions, and lists them.
///
/// # Errors
/// If a file cannot be removed.
pub fn clean() -> Result<(), Failure> {
    let dead = StaleSession::all();
    if dead.is_empty() {
        print_text("no dead session has left files\n");
    }
    for remains in dead {
        let (name, bytes) = (name_of(&remains), remains.bytes());
        if !remains.remove() {
            print_text(format_args!("session {name}: kept, because a process has just joined it\n"));
            continue;
        }
        print_text(format_args!("session {name}: removed {} files, {} kB\n", remains.files.len(), bytes >> 10));
        remains.files.iter().for_each(|path| print_text(format_args!("  {}\n", path.display())));
        if let Some(kept) = remains.files.iter().find(|path| path.symlink_metadata().is_ok()) {
            return Err(Failure::new(Exit::SharedMemory, format!("{} cannot be removed", kept.display())));
        }
    }
    Ok(())
}

fn name_of(remains: &StaleSession) -> String {
    remains.name().unwrap_or_else(|| "without a name".into())
}

fn program() -> Vec<CheckResult> {
    let version = format!("biped {}, wire schema {SCHEMA_HASH:016x}, {TRANSPORT}", env!("CARGO_PKG_VERSION"));
    vec![CheckResult::ok("program", version)]
}

fn kernel() -> Vec<CheckResult> {
    let kernel = uname().map_or(String::new(), |names| {
        format!("{} {}", names.release().to_string_lossy(), names.version().to_string_lossy())
    });
    let preemptive = read("/sys/kernel/realtime") == "1" || kernel.contains("PREEMPT_RT");
    let clock = read("/sys/devices/system/clocksource/clocksource0/current_clocksource");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    vec![
        CheckResult::checked("kernel", &kernel, preemptive, || {
            Level::Warning(
                "a kernel with PREEMPT_RT bounds how late a real-time loop wakes; lockstep needs none".into(),
            )
        }),
        CheckResult::checked("clock", &clock, FAST_CLOCKS.contains(&clock.as_str()), || {
            Level::Warning(format!("reading it is slow: boot with clocksource={}", FAST_CLOCKS[0]))
        }),
        CheckResult::checked("processors", cores, cores >= 2, || {
            Level::Warning("plant and controller share one processor: `biped run --in-process` is faster".into())
        }),
    ]
}

/// The limits of the system. Real-time privileges are tested by requesting them in a thread of their own.
fn limits() -> Vec<CheckResult> {
    let limit = |resource| getrlimit(resource).map_or(0, |(soft, _)| soft);
    let text = |value: u64| if value == RLIM_INFINITY { "unlimited".to_string() } else { value.to_string() };
    let (locked, priority, files) =
        (limit(Resource::RLIMIT_MEMLOCK), limit(Resource::RLIMIT_RTPRIO), limit(Resource::RLIMIT_NOFILE));
    let [memory, fifo] =
        thread::start(realtime::missing_privileges).ok().and_then(|asking| asking.join().ok()).unwrap_or_default();
    let granted = |item, limit, remedy: Option<String>| {
        let found = format!("{limit}; {}", if remedy.is_none() { "granted on request" } else { "refused on request" });
        CheckResult::checked(item, found, remedy.is_none(), || Level::Warning(remedy.unwrap_or_default()))
    };
    vec![
        granted("limit memlock", format!("{} bytes", text(locked)), memory),
        granted("limit rtprio", text(priority), fifo),
        CheckResult::checked("limit nofile", text(files), files >= MIN_OPEN_FILES, || {
            Level::Wrong(format!("a session needs {MIN_OPEN_FILES} open files: `ulimit -n {MIN_OPEN_FILES}`"))
        }),
    ]
}

fn memory() -> Vec<CheckResult> {
    let item = SHARED_MEMORY;
    let result = match ShmUsage::now() {
        Err(error) => CheckResult { item, found: error.to_string(), level: Level::Wrong(access_advice()) },
        Ok(ShmUsage { size, free, files }) => {
            let mut found =
                format!("{} MB, {} MB free; a session needs {} MB", size >> 20, free >> 20, REQUIRED_SHM >> 20);
            if files < REQUIRED_FILES {
                found += &format!(", and {REQUIRED_FILES} files, of which {files} can be created");
            }
            CheckResult::checked(item, found, free >= REQUIRED_SHM && files >= REQUIRED_FILES, || {
                Level::Wrong(format!("remove files there, or {}", HostEnvironment::detect().how_to_enlarge_shm()))
            })
        }
    };
    vec![result]
}

/// Advice: how to make shared memory writable for this user.
fn access_advice() -> String {
    let is_read_only = statvfs(SHARED_MEMORY).is_ok_and(|about| about.flags().contains(FsFlags::ST_RDONLY));
    match std::fs::metadata(SHARED_MEMORY) {
        Err(_) => format!("mount a tmpfs there: `mount -t tmpfs -o mode=1777 tmpfs {SHARED_MEMORY}`"),
        Ok(_) if is_read_only => format!("`mount -o remount,rw {SHARED_MEMORY}`"),
        Ok(about) => {
            let (owner, mode) = (about.uid(), about.mode() & 0o7777);
            format!("it belongs to user {owner} and has mode {mode:o}: `chmod 1777 {SHARED_MEMORY}`")
        }
    }
}

fn sessions() -> Vec<CheckResult> {
    let running = Session::running();
    let result = |session: &Session| {
        let members = session.members();
        let members: Vec<String> = members.iter().map(|pid| format!("{} {pid}", role_of(*pid))).collect();
        CheckResult::ok("session", format!("{}: {}", session.name(), members.join(", ")))
    };
    match running.is_empty() {
        true => vec![CheckResult::ok("sessions", "none is running")],
        false => running.iter().map(result).collect(),
    }
}

fn dead_sessions() -> Vec<CheckResult> {
    let result = |dead: &StaleSession| {
        let found = format!("{}: {} files, {} kB", name_of(dead), dead.files.len(), dead.bytes() >> 10);
        let advice = "`biped clean` or the start of the next session removes it";
        CheckResult { item: "dead session", found, level: Level::Wrong(advice.into()) }
    };
    let dead = StaleSession::all();
    match dead.is_empty() {
        true => vec![CheckResult::ok("dead sessions", "none has left files")],
        false => dead.iter().map(result).collect(),
    }
}

/// The role of a process in its session: `plant`, `controller`, `run`, or the name of a foreign program.
fn role_of(pid: u32) -> String {
    let line = std::fs::read_to_string(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    let mut words = line.split('\0');
    let program = words.next().and_then(|path| path.rsplit('/').next()).unwrap_or("?");
    match (program, words.next()) {
        ("biped", Some(role)) if !role.is_empty() => role.into(),
        ("biped", _) => "run".into(),
        _ => program.into(),
    }
}

fn read(path: &str) -> String {
    std::fs::read_to_string(path).map_or_else(|_| "unknown".into(), |text| text.trim().into())
}
