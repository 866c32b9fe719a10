//! `biped doctor`: whether this machine is fit to run, and what is running; `biped clean`: removes what dead sessions left.

use crate::place::Place;
use crate::realtime;
use messages::port::{REQUIRED_SHM, TRANSPORT};
use messages::session::{REQUIRED_FILES, SHARED_MEMORY, Session, ShmUsage, StaleSession};
use messages::wire::SCHEMA_HASH;
use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};
use nix::sys::statvfs::{FsFlags, statvfs};
use nix::sys::utsname::uname;
use shared::exit::{Exit, Failure};
use shared::output::say;
use std::fmt;
use std::os::unix::fs::MetadataExt;

/// Open files that a role needs, with room to spare.
const HANDLES: u64 = 256;
/// Clocks that are read in nanoseconds and without the kernel's help.
const CLOCKS: [&str; 4] = ["tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"];

/// One line of the doctor's.
#[derive(Debug)]
struct Finding {
    what: &'static str,
    found: String,
    state: State,
}

/// How it is.
#[derive(Debug)]
enum State {
    Ok,
    /// Runs, but could do better in real time if one did this.
    Warning(String),
    /// Something is wrong, until one does this.
    Wrong(String),
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (word, advice) = match &self.state {
            State::Ok => ("ok", ""),
            State::Warning(advice) => ("warning", advice.as_str()),
            State::Wrong(advice) => ("wrong", advice.as_str()),
        };
        writeln!(f, "{word:<8} {:<18} {}", self.what, self.found)?;
        if !advice.is_empty() {
            writeln!(f, "{:<27} → {advice}", "")?;
        }
        Ok(())
    }
}

impl Finding {
    fn ok(what: &'static str, found: impl ToString) -> Finding {
        Finding { what, found: found.to_string(), state: State::Ok }
    }

    /// Well if `good`; else what to do about it.
    fn judged(what: &'static str, found: impl ToString, good: bool, otherwise: impl FnOnce() -> State) -> Finding {
        Finding { what, found: found.to_string(), state: if good { State::Ok } else { otherwise() } }
    }
}

/// Says how the machine is.
///
/// # Errors
/// If something is wrong.
pub fn doctor() -> Result<(), Failure> {
    let all = [program(), kernel(), limits(), memory(), sessions(), remains()];
    let findings: Vec<Finding> = all.into_iter().flatten().collect();
    findings.iter().for_each(say);
    match findings.iter().filter(|finding| matches!(finding.state, State::Wrong(_))).count() {
        0 => Ok(()),
        count => Err(Failure::new(Exit::Fault, format!("{count} of {} findings: something is wrong", findings.len()))),
    }
}

/// Removes what dead sessions of this user left, and says what.
///
/// # Errors
/// If something of it cannot be removed.
pub fn clean() -> Result<(), Failure> {
    let dead = StaleSession::all();
    if dead.is_empty() {
        say("nothing is left of any dead session\n");
    }
    for remains in dead {
        let (name, bytes) = (name_of(&remains), remains.bytes());
        if !remains.remove() {
            say(format_args!("session {name}: somebody has just entered it, so it stays\n"));
            continue;
        }
        say(format_args!("session {name}: removed {} files, {} kB\n", remains.files.len(), bytes >> 10));
        remains.files.iter().for_each(|path| say(format_args!("  {}\n", path.display())));
        if let Some(stays) = remains.files.iter().find(|path| path.symlink_metadata().is_ok()) {
            return Err(Failure::new(Exit::SharedMemory, format!("{} cannot be removed", stays.display())));
        }
    }
    Ok(())
}

fn name_of(remains: &StaleSession) -> String {
    remains.name().unwrap_or_else(|| "without a name".into())
}

fn program() -> Vec<Finding> {
    let version = format!("biped {}, wire schema {SCHEMA_HASH:016x}, {TRANSPORT}", env!("CARGO_PKG_VERSION"));
    vec![Finding::ok("program", version)]
}

fn kernel() -> Vec<Finding> {
    let kernel = uname().map_or(String::new(), |names| {
        format!("{} {}", names.release().to_string_lossy(), names.version().to_string_lossy())
    });
    let preemptive = read("/sys/kernel/realtime") == "1" || kernel.contains("PREEMPT_RT");
    let clock = read("/sys/devices/system/clocksource/clocksource0/current_clocksource");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    vec![
        Finding::judged("kernel", &kernel, preemptive, || {
            State::Warning(
                "a kernel with PREEMPT_RT bounds how late a real-time loop wakes; lockstep needs none".into(),
            )
        }),
        Finding::judged("clock", &clock, CLOCKS.contains(&clock.as_str()), || {
            State::Warning(format!("reading it is slow: boot with clocksource={}", CLOCKS[0]))
        }),
        Finding::judged("processors", cores, cores >= 2, || {
            State::Warning("plant and controller take turns on one: `biped run --in-process` is sooner done".into())
        }),
    ]
}

/// What the system limits; what real time needs is asked for in truth, by a thread that does nothing else.
fn limits() -> Vec<Finding> {
    let limit = |resource| getrlimit(resource).map_or(0, |(soft, _)| soft);
    let text = |value: u64| if value == RLIM_INFINITY { "unlimited".to_string() } else { value.to_string() };
    let (locked, priority, files) =
        (limit(Resource::RLIMIT_MEMLOCK), limit(Resource::RLIMIT_RTPRIO), limit(Resource::RLIMIT_NOFILE));
    let [memory, fifo] = std::thread::spawn(realtime::refusals).join().unwrap_or_default();
    let granted = |what, limit, refusal: Option<String>| {
        let found = format!("{limit}; {}", if refusal.is_none() { "granted when asked" } else { "refused when asked" });
        Finding::judged(what, found, refusal.is_none(), || State::Warning(refusal.unwrap_or_default()))
    };
    vec![
        granted("limit memlock", format!("{} bytes", text(locked)), memory),
        granted("limit rtprio", text(priority), fifo),
        Finding::judged("limit nofile", text(files), files >= HANDLES, || {
            State::Wrong(format!("a session needs {HANDLES} open files: `ulimit -n {HANDLES}`"))
        }),
    ]
}

fn memory() -> Vec<Finding> {
    let what = SHARED_MEMORY;
    let finding = match ShmUsage::now() {
        Err(error) => Finding { what, found: error.to_string(), state: State::Wrong(unusable()) },
        Ok(ShmUsage { size, free, files }) => {
            let mut found =
                format!("{} MB, {} MB free; a session needs {} MB", size >> 20, free >> 20, REQUIRED_SHM >> 20);
            if files < REQUIRED_FILES {
                found += &format!(", and {REQUIRED_FILES} files of which {files} can be made");
            }
            Finding::judged(what, found, free >= REQUIRED_SHM && files >= REQUIRED_FILES, || {
                State::Wrong(format!("remove files there, or {}", Place::here().enlarges()))
            })
        }
    };
    vec![finding]
}

/// What would let this user write to shared memory.
fn unusable() -> String {
    let is_read_only = statvfs(SHARED_MEMORY).is_ok_and(|about| about.flags().contains(FsFlags::ST_RDONLY));
    match std::fs::metadata(SHARED_MEMORY) {
        Err(_) => format!("mount a tmpfs there: `mount -t tmpfs -o mode=1777 tmpfs {SHARED_MEMORY}`"),
        Ok(_) if is_read_only => format!("`mount -o remount,rw {SHARED_MEMORY}`"),
        Ok(about) => {
            let (owner, mode) = (about.uid(), about.mode() & 0o7777);
            format!("it belongs to user {owner}, with the mode {mode:o}: `chmod 1777 {SHARED_MEMORY}`")
        }
    }
}

fn sessions() -> Vec<Finding> {
    let running = Session::running();
    let finding = |session: &Session| {
        let members = session.members();
        let members: Vec<String> = members.iter().map(|number| format!("{} {number}", role_of(*number))).collect();
        Finding::ok("session", format!("{}: {}", session.name(), members.join(", ")))
    };
    match running.is_empty() {
        true => vec![Finding::ok("sessions", "none is running")],
        false => running.iter().map(finding).collect(),
    }
}

fn remains() -> Vec<Finding> {
    let finding = |dead: &StaleSession| {
        let found = format!("{}: {} files, {} kB", name_of(dead), dead.files.len(), dead.bytes() >> 10);
        let advice = "`biped clean` removes it, and so does the next session that begins";
        Finding { what: "dead session", found, state: State::Wrong(advice.into()) }
    };
    let dead = StaleSession::all();
    match dead.is_empty() {
        true => vec![Finding::ok("dead sessions", "nothing is left of any")],
        false => dead.iter().map(finding).collect(),
    }
}

/// What a process does in its session: `plant`, `controller`, `run`, or the name of another program.
fn role_of(number: u32) -> String {
    let line = std::fs::read_to_string(format!("/proc/{number}/cmdline")).unwrap_or_default();
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
