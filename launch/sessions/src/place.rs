//! Where this runs, and what grants real time and room there: on the machine itself a capability of the program, or a limit of its
//! user; in a container what it is started with.

use nix::sys::statvfs::{FsFlags, statvfs};
use nix::unistd::{User, getuid};
use rustix::thread::{CapabilitySet, capability_is_in_bounding_set, no_new_privs};
use std::path::{Path, PathBuf};

/// What the system may refuse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Right {
    /// To lock memory.
    Memory,
    /// SCHED_FIFO at a priority.
    Fifo(u8),
}

/// Who runs the container.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Engine {
    Docker,
    Podman,
    Kubernetes,
    Nspawn,
    Lxc,
    Other,
}

/// Where this process runs.
#[derive(Clone, Debug)]
pub struct Place {
    engine: Option<Engine>,
    program: PathBuf,
    user: String,
    /// Capabilities of those rights that a file can give: within the bounding set, and of a user who is known to the machine.
    giveable: CapabilitySet,
}

impl Place {
    /// Here.
    pub fn here() -> Place {
        let program = std::env::current_exe().unwrap_or_else(|_| "biped".into());
        let is_ignored = no_new_privs().unwrap_or(false) || is_nosuid(&program) || !is_first_namespace();
        let mut giveable = CapabilitySet::empty();
        for capability in [CapabilitySet::SYS_NICE, CapabilitySet::IPC_LOCK] {
            giveable.set(capability, !is_ignored && capability_is_in_bounding_set(capability).unwrap_or(false));
        }
        let user = User::from_uid(getuid()).ok().flatten().map_or("*".into(), |user| user.name);
        Place { engine: Engine::here(), program, user, giveable }
    }

    /// What would grant a right here.
    pub fn grants(&self, right: Right) -> String {
        let (limit, flag, most, capability) = match right {
            Right::Memory => ("memlock", 'l', "unlimited".to_string(), CapabilitySet::IPC_LOCK),
            Right::Fifo(priority) => ("rtprio", 'r', priority.to_string(), CapabilitySet::SYS_NICE),
        };
        let number = if right == Right::Memory { "-1" } else { &most };
        match self.engine {
            Some(Engine::Docker) => format!("`docker run --ulimit {limit}={number}`, as this runs in a container"),
            Some(Engine::Podman) => format!("`podman run --ulimit {limit}={number}`, as this runs in a container"),
            Some(Engine::Kubernetes) => {
                let name = if right == Right::Memory { "IPC_LOCK" } else { "SYS_NICE" };
                format!(
                    "`securityContext: {{runAsUser: 0, capabilities: {{add: [{name}]}}}}` of the container in its pod"
                )
            }
            Some(Engine::Nspawn) => {
                let value = if right == Right::Memory { "infinity" } else { &most };
                format!("`systemd-nspawn --rlimit={}={value}`, as this runs in a container", limit.to_uppercase())
            }
            Some(Engine::Lxc) => format!("`lxc.prlimit.{limit} = {most}` in the configuration of this container"),
            Some(Engine::Other) => format!("a limit {limit} of {most} where this container is started"),
            None => {
                let limits = format!(
                    "`{} - {limit} {most}` in /etc/security/limits.conf, a new login and `ulimit -{flag} {most}`",
                    self.user
                );
                // A program whose file has a capability beyond the bounding set does not start.
                match self.giveable.contains(capability) {
                    true => format!("`sudo setcap {}+ep {}`; or {limits}", self.names(), self.program.display()),
                    false => limits,
                }
            }
        }
    }

    /// What would make /dev/shm larger.
    pub fn enlarges(&self) -> String {
        match self.engine {
            Some(Engine::Docker) => "`docker run --shm-size=1g`".into(),
            Some(Engine::Podman) => "`podman run --shm-size=1g`".into(),
            Some(Engine::Kubernetes) => "an `emptyDir: {medium: Memory}` mounted there in its pod".into(),
            Some(Engine::Nspawn) => "`systemd-nspawn --tmpfs=/dev/shm:size=1G`".into(),
            Some(Engine::Lxc | Engine::Other) => "a larger tmpfs where this container is started".into(),
            None => "`mount -o remount,size=1G /dev/shm`".into(),
        }
    }

    /// The capabilities that can be given, as setcap has them.
    fn names(&self) -> String {
        let names = [(CapabilitySet::SYS_NICE, "cap_sys_nice"), (CapabilitySet::IPC_LOCK, "cap_ipc_lock")];
        let given = names.iter().filter(|(capability, _)| self.giveable.contains(*capability)).map(|(_, name)| *name);
        given.collect::<Vec<_>>().join(",")
    }
}

impl Engine {
    /// The marks that engines leave.
    fn here() -> Option<Engine> {
        let says = std::env::var("container").unwrap_or_default();
        let groups = std::fs::read_to_string("/proc/1/cgroup").unwrap_or_default();
        let is = |mark: &str| Path::new(mark).exists();
        match &*says {
            _ if std::env::var_os("KUBERNETES_SERVICE_HOST").is_some() => Some(Engine::Kubernetes),
            "podman" => Some(Engine::Podman),
            "systemd-nspawn" => Some(Engine::Nspawn),
            "lxc" => Some(Engine::Lxc),
            _ if is("/run/.containerenv") => Some(Engine::Podman),
            _ if is("/.dockerenv") => Some(Engine::Docker),
            _ => Engine::of(&groups).or((!says.is_empty()).then_some(Engine::Other)),
        }
    }

    /// By the control groups of the first process: the older version of them names the container.
    fn of(groups: &str) -> Option<Engine> {
        let marks = [
            ("kubepods", Engine::Kubernetes),
            ("docker", Engine::Docker),
            ("libpod", Engine::Podman),
            ("lxc", Engine::Lxc),
            ("containerd", Engine::Other),
        ];
        marks.into_iter().find(|(mark, _)| groups.contains(mark)).map(|(_, engine)| engine)
    }
}

/// Whether capabilities of files count for nothing where a program lies.
fn is_nosuid(program: &Path) -> bool {
    statvfs(program).is_ok_and(|about| about.flags().contains(FsFlags::ST_NOSUID))
}

/// Whether users here are those of the machine: capabilities of others neither schedule nor lock.
fn is_first_namespace() -> bool {
    let map = std::fs::read_to_string("/proc/self/uid_map").unwrap_or_default();
    let numbers: Vec<_> = map.split_whitespace().collect();
    numbers.is_empty() || numbers == ["0", "0", "4294967295"]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(engine: Option<Engine>, giveable: CapabilitySet) -> Place {
        Place { engine, program: "/opt/biped".into(), user: "ann".into(), giveable }
    }

    #[test]
    fn a_program_gets_no_capability_that_keeps_it_from_starting() {
        let (nice, lock) = (CapabilitySet::SYS_NICE, CapabilitySet::IPC_LOCK);
        let grants = |giveable, right| place(None, giveable).grants(right);
        let both = grants(nice | lock, Right::Fifo(80));
        assert!(both.contains("`sudo setcap cap_sys_nice,cap_ipc_lock+ep /opt/biped`"), "{both}");
        let one = grants(lock, Right::Memory);
        assert!(one.contains("`sudo setcap cap_ipc_lock+ep /opt/biped`"), "{one}");
        for refused in [grants(lock, Right::Fifo(80)), grants(CapabilitySet::empty(), Right::Fifo(80))] {
            assert_eq!(refused, "`ann - rtprio 80` in /etc/security/limits.conf, a new login and `ulimit -r 80`");
        }
    }

    #[test]
    fn a_container_is_told_how_it_has_to_be_started() {
        let all = CapabilitySet::SYS_NICE | CapabilitySet::IPC_LOCK;
        for (engine, words) in [
            (Engine::Docker, ["docker run --ulimit memlock=-1", "docker run --ulimit rtprio=80"]),
            (Engine::Podman, ["podman run --ulimit memlock=-1", "podman run --ulimit rtprio=80"]),
            (Engine::Kubernetes, ["add: [IPC_LOCK]", "add: [SYS_NICE]"]),
            (Engine::Nspawn, ["--rlimit=MEMLOCK=infinity", "--rlimit=RTPRIO=80"]),
            (Engine::Lxc, ["lxc.prlimit.memlock = unlimited", "lxc.prlimit.rtprio = 80"]),
            (Engine::Other, ["memlock of unlimited", "rtprio of 80"]),
        ] {
            for (right, word) in [Right::Memory, Right::Fifo(80)].into_iter().zip(words) {
                let told = place(Some(engine), all).grants(right);
                assert!(told.contains(word) && !told.contains("setcap"), "{engine:?}: {told}");
            }
        }
    }

    #[test]
    fn control_groups_name_the_engine() {
        assert_eq!(Engine::of("0::/\n"), None);
        assert_eq!(Engine::of("1:name=systemd:/user.slice\n"), None);
        assert_eq!(Engine::of("5:cpu:/docker/9f3e\n0::/\n"), Some(Engine::Docker));
        assert_eq!(Engine::of("5:cpu:/kubepods/besteffort/pod1/9f3e\n"), Some(Engine::Kubernetes));
        assert_eq!(Engine::of("0::/machine.slice/libpod-9f3e.scope\n"), Some(Engine::Podman));
    }
}
