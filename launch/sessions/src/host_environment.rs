//! The environment of this process (host or container), and the settings that grant real-time privileges and shared memory there. On the
//! host, a setting is a capability of the program file or a limit of the user. In a container, it is an option of the start command.

use nix::sys::statvfs::{FsFlags, statvfs};
use nix::unistd::{User, getuid};
use rustix::thread::{CapabilitySet, capability_is_in_bounding_set, no_new_privs};
use std::path::{Path, PathBuf};

/// A privilege that the system may refuse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Privilege {
    /// To lock memory.
    LockMemory,
    /// To run under SCHED_FIFO at a priority.
    Fifo(u8),
}

/// The program that runs the container.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ContainerEngine {
    Docker,
    Podman,
    Kubernetes,
    Nspawn,
    Lxc,
    Other,
}

/// The environment of this process.
#[derive(Clone, Debug)]
pub struct HostEnvironment {
    container: Option<ContainerEngine>,
    program: PathBuf,
    user: String,
    /// Capabilities that `setcap` can give to the program file. They lie within the bounding set of the process, and its user is one of
    /// the host.
    grantable: CapabilitySet,
}

impl HostEnvironment {
    /// Detects the environment of this process.
    pub fn detect() -> HostEnvironment {
        let program = std::env::current_exe().unwrap_or_else(|_| "biped".into());
        let is_ignored = no_new_privs().unwrap_or(false) || is_nosuid(&program) || !is_first_namespace();
        let mut grantable = CapabilitySet::empty();
        for capability in [CapabilitySet::SYS_NICE, CapabilitySet::IPC_LOCK] {
            grantable.set(capability, !is_ignored && capability_is_in_bounding_set(capability).unwrap_or(false));
        }
        let user = User::from_uid(getuid()).ok().flatten().map_or("*".into(), |user| user.name);
        HostEnvironment { container: ContainerEngine::detect(), program, user, grantable }
    }

    /// The setting that would grant a privilege.
    pub fn how_to_grant(&self, privilege: Privilege) -> String {
        let (limit, flag, most, capability) = match privilege {
            Privilege::LockMemory => ("memlock", 'l', "unlimited".to_string(), CapabilitySet::IPC_LOCK),
            Privilege::Fifo(priority) => ("rtprio", 'r', priority.to_string(), CapabilitySet::SYS_NICE),
        };
        let number = if privilege == Privilege::LockMemory { "-1" } else { &most };
        match self.container {
            Some(ContainerEngine::Docker) => {
                format!("`docker run --ulimit {limit}={number}`, as this runs in a container")
            }
            Some(ContainerEngine::Podman) => {
                format!("`podman run --ulimit {limit}={number}`, as this runs in a container")
            }
            Some(ContainerEngine::Kubernetes) => {
                let name = if privilege == Privilege::LockMemory { "IPC_LOCK" } else { "SYS_NICE" };
                format!(
                    "`securityContext: {{runAsUser: 0, capabilities: {{add: [{name}]}}}}` of the container in its pod"
                )
            }
            Some(ContainerEngine::Nspawn) => {
                let value = if privilege == Privilege::LockMemory { "infinity" } else { &most };
                format!("`systemd-nspawn --rlimit={}={value}`, as this runs in a container", limit.to_uppercase())
            }
            Some(ContainerEngine::Lxc) => {
                format!("`lxc.prlimit.{limit} = {most}` in the configuration of this container")
            }
            Some(ContainerEngine::Other) => format!("a limit {limit} of {most} where this container is started"),
            None => {
                let limits = format!(
                    "`{} - {limit} {most}` in /etc/security/limits.conf, a new login and `ulimit -{flag} {most}`",
                    self.user
                );
                // A program file with a capability outside the bounding set cannot be started.
                match self.grantable.contains(capability) {
                    true => format!("`sudo setcap {}+ep {}`; or {limits}", self.setcap_names(), self.program.display()),
                    false => limits,
                }
            }
        }
    }

    /// The setting that would enlarge /dev/shm.
    pub fn how_to_enlarge_shm(&self) -> String {
        match self.container {
            Some(ContainerEngine::Docker) => "`docker run --shm-size=1g`".into(),
            Some(ContainerEngine::Podman) => "`podman run --shm-size=1g`".into(),
            Some(ContainerEngine::Kubernetes) => "an `emptyDir: {medium: Memory}` mounted there in its pod".into(),
            Some(ContainerEngine::Nspawn) => "`systemd-nspawn --tmpfs=/dev/shm:size=1G`".into(),
            Some(ContainerEngine::Lxc | ContainerEngine::Other) => {
                "a larger tmpfs where this container is started".into()
            }
            None => "`mount -o remount,size=1G /dev/shm`".into(),
        }
    }

    /// The grantable capabilities, as `setcap` names them.
    fn setcap_names(&self) -> String {
        let names = [(CapabilitySet::SYS_NICE, "cap_sys_nice"), (CapabilitySet::IPC_LOCK, "cap_ipc_lock")];
        let given = names.iter().filter(|(capability, _)| self.grantable.contains(*capability)).map(|(_, name)| *name);
        given.collect::<Vec<_>>().join(",")
    }
}

impl ContainerEngine {
    /// Detects the container engine by the environment variables and files that it sets. `None`: no container.
    fn detect() -> Option<ContainerEngine> {
        let variable = std::env::var("container").unwrap_or_default();
        let cgroups = std::fs::read_to_string("/proc/1/cgroup").unwrap_or_default();
        let exists = |path: &str| Path::new(path).exists();
        match &*variable {
            _ if std::env::var_os("KUBERNETES_SERVICE_HOST").is_some() => Some(ContainerEngine::Kubernetes),
            "podman" => Some(ContainerEngine::Podman),
            "systemd-nspawn" => Some(ContainerEngine::Nspawn),
            "lxc" => Some(ContainerEngine::Lxc),
            _ if exists("/run/.containerenv") => Some(ContainerEngine::Podman),
            _ if exists("/.dockerenv") => Some(ContainerEngine::Docker),
            _ => ContainerEngine::from_cgroups(&cgroups).or((!variable.is_empty()).then_some(ContainerEngine::Other)),
        }
    }

    /// Detects the container engine by the control groups of process 1. Only version 1 of control groups names the container.
    fn from_cgroups(cgroups: &str) -> Option<ContainerEngine> {
        let marks = [
            ("kubepods", ContainerEngine::Kubernetes),
            ("docker", ContainerEngine::Docker),
            ("libpod", ContainerEngine::Podman),
            ("lxc", ContainerEngine::Lxc),
            ("containerd", ContainerEngine::Other),
        ];
        marks.into_iter().find(|(mark, _)| cgroups.contains(mark)).map(|(_, engine)| engine)
    }
}

/// Whether the file system of a program ignores capabilities of files.
fn is_nosuid(program: &Path) -> bool {
    statvfs(program).is_ok_and(|about| about.flags().contains(FsFlags::ST_NOSUID))
}

/// Whether this process is in the user namespace of the host. Capabilities in other namespaces grant neither privilege.
fn is_first_namespace() -> bool {
    let map = std::fs::read_to_string("/proc/self/uid_map").unwrap_or_default();
    let numbers: Vec<_> = map.split_whitespace().collect();
    numbers.is_empty() || numbers == ["0", "0", "4294967295"]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn environment(container: Option<ContainerEngine>, grantable: CapabilitySet) -> HostEnvironment {
        HostEnvironment { container, program: "/opt/biped".into(), user: "ann".into(), grantable }
    }

    #[test]
    fn only_grantable_capabilities_are_suggested() {
        let (nice, lock) = (CapabilitySet::SYS_NICE, CapabilitySet::IPC_LOCK);
        let advice = |grantable, privilege| environment(None, grantable).how_to_grant(privilege);
        let both = advice(nice | lock, Privilege::Fifo(80));
        assert!(both.contains("`sudo setcap cap_sys_nice,cap_ipc_lock+ep /opt/biped`"), "{both}");
        let one = advice(lock, Privilege::LockMemory);
        assert!(one.contains("`sudo setcap cap_ipc_lock+ep /opt/biped`"), "{one}");
        for refused in [advice(lock, Privilege::Fifo(80)), advice(CapabilitySet::empty(), Privilege::Fifo(80))] {
            assert_eq!(refused, "`ann - rtprio 80` in /etc/security/limits.conf, a new login and `ulimit -r 80`");
        }
    }

    #[test]
    fn inside_a_container_the_advice_is_an_option_of_its_engine() {
        let all = CapabilitySet::SYS_NICE | CapabilitySet::IPC_LOCK;
        for (engine, words) in [
            (ContainerEngine::Docker, ["docker run --ulimit memlock=-1", "docker run --ulimit rtprio=80"]),
            (ContainerEngine::Podman, ["podman run --ulimit memlock=-1", "podman run --ulimit rtprio=80"]),
            (ContainerEngine::Kubernetes, ["add: [IPC_LOCK]", "add: [SYS_NICE]"]),
            (ContainerEngine::Nspawn, ["--rlimit=MEMLOCK=infinity", "--rlimit=RTPRIO=80"]),
            (ContainerEngine::Lxc, ["lxc.prlimit.memlock = unlimited", "lxc.prlimit.rtprio = 80"]),
            (ContainerEngine::Other, ["memlock of unlimited", "rtprio of 80"]),
        ] {
            for (privilege, word) in [Privilege::LockMemory, Privilege::Fifo(80)].into_iter().zip(words) {
                let advice = environment(Some(engine), all).how_to_grant(privilege);
                assert!(advice.contains(word) && !advice.contains("setcap"), "{engine:?}: {advice}");
            }
        }
    }

    #[test]
    fn control_groups_of_version_1_name_the_container_engine() {
        assert_eq!(ContainerEngine::from_cgroups("0::/\n"), None);
        assert_eq!(ContainerEngine::from_cgroups("1:name=systemd:/user.slice\n"), None);
        assert_eq!(ContainerEngine::from_cgroups("5:cpu:/docker/9f3e\n0::/\n"), Some(ContainerEngine::Docker));
        assert_eq!(
            ContainerEngine::from_cgroups("5:cpu:/kubepods/besteffort/pod1/9f3e\n"),
            Some(ContainerEngine::Kubernetes)
        );
        assert_eq!(
            ContainerEngine::from_cgroups("0::/machine.slice/libpod-9f3e.scope\n"),
            Some(ContainerEngine::Podman)
        );
    }
}
