//! Claims about other environments, which namespaces imitate: `biped doctor` with an unusable /dev/shm, remedies where no capability can be
//! granted, a session across two containers, and a program without the repository in which it was built.
//!
//! On a host that does not allow namespaces, these tests print that and check nothing.

#![expect(clippy::expect_used, reason = "a test may panic")]

use std::process::{Command, Output};

/// Runs a shell script as root of new namespaces. Returns exit code, standard output and standard error; `None` without namespaces.
fn within(namespaces: &[&str], script: &str) -> Option<(Option<i32>, String, String)> {
    let unshare = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--mount"]).args(namespaces).args(["sh", "-c", script]);
        command.env("BIPED", env!("CARGO_BIN_EXE_biped")).output().expect("unshare")
    };
    if !unshare("mount -t tmpfs tmpfs /dev/shm").status.success() {
        println!("this host does not allow namespaces: nothing was tested");
        return None;
    }
    let Output { status, stdout, stderr } = unshare(script);
    let [printed, errors] = [stdout, stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    println!("{script}\n{printed}{errors}");
    Some((status.code(), printed, errors))
}

/// The line of `biped doctor` about an item, and the advice below it.
fn check_result(printed: &str, what: &str) -> (String, String) {
    let mut lines = printed.lines().skip_while(|line| line.split_whitespace().nth(1) != Some(what));
    let line = lines.next().unwrap_or_default().to_string();
    (line, lines.next().unwrap_or_default().trim().to_string())
}

#[test]
fn unusable_shared_memory_is_reported_with_a_remedy() {
    for (options, found, advice) in [
        ("ro", "cannot be written to: Read-only file system", "mount -o remount,rw /dev/shm"),
        ("size=10m", "10 MB free; a session needs 17 MB", "size=1"),
        ("nr_inodes=9", "64 files, of which 8 can be created", "remove files there"),
    ] {
        let mount = format!("mount -t tmpfs -o {options} tmpfs /dev/shm");
        let Some((code, printed, _)) = within(&[], &format!("{mount}; $BIPED doctor")) else { return };
        let (line, advice_line) = check_result(&printed, "/dev/shm");
        assert_eq!(code, Some(4), "{printed}");
        assert!(line.starts_with("wrong") && line.contains(found), "{line}");
        assert!(advice_line.contains(advice) || advice_line.contains("--shm-size"), "{advice_line}");
        let run = format!("{mount}; $BIPED run stand --quiet --set duration=0.1");
        let (code, _, errors) = within(&[], &run).expect("namespaces");
        assert_eq!((code, errors.lines().count()), (Some(6), 1), "{errors}");
        assert!(errors.contains("/dev/shm") && !errors.contains("InternalError"), "{errors}");
    }
    let (code, printed, _) = within(&[], "mount -t tmpfs tmpfs /dev/shm; $BIPED doctor").expect("namespaces");
    assert_eq!(code, Some(0), "{printed}");
    assert!(check_result(&printed, "/dev/shm").0.starts_with("ok"), "{printed}");
}

/// Imitates a /dev/shm of another user: nobody has write permission, and root lacks the capability to override permissions.
#[test]
fn shared_memory_of_another_user_is_reported_with_a_remedy() {
    let enter = "mount -t tmpfs -o mode=555 tmpfs /dev/shm; exec setpriv --bounding-set=-dac_override $BIPED doctor";
    let Some((code, printed, errors)) = within(&[], enter) else { return };
    let (line, advice_line) = check_result(&printed, "/dev/shm");
    assert_eq!(code, Some(4), "{printed}{errors}");
    assert!(line.starts_with("wrong") && line.contains("cannot be written to: Permission denied"), "{line}");
    assert!(advice_line.contains("chmod 1777 /dev/shm") && advice_line.contains("has mode 555"), "{advice_line}");
}

/// A program file with a capability outside the bounding set does not start. In another user namespace, a capability has no effect.
#[test]
fn setcap_is_not_advised_where_no_capability_can_be_granted() {
    let script = "exec setpriv --bounding-set=-sys_nice,-ipc_lock $BIPED doctor";
    let Some((_, printed, errors)) = within(&[], script) else { return };
    let (line, advice_line) = check_result(&printed, "limit");
    assert!(line.contains("memlock") && printed.contains("rtprio"), "{printed}{errors}");
    assert!(!printed.contains("setcap"), "{printed}");
    if printed.contains("refused on request") {
        assert!(!advice_line.is_empty(), "{printed}");
    }
}

#[test]
fn a_session_spans_two_containers_that_share_only_memory() {
    let walk = "walk --session places --set duration=1";
    let script = format!(
        "mount -t tmpfs tmpfs /dev/shm; $BIPED plant {walk} & unshare --pid --fork --mount-proc $BIPED controller {walk} && wait $!"
    );
    let Some((code, printed, errors)) = within(&[], &script) else { return };
    assert_eq!(code, Some(0), "{printed}{errors}");
}

/// Hides the repository, in which the program was built, under an empty folder.
#[test]
fn the_program_needs_nothing_of_the_repository() {
    let hide =
        format!("cp $BIPED biped; mount -t tmpfs tmpfs {0} && test -z \"$(ls {0})\"", env!("CARGO_MANIFEST_DIR"));
    let commands = [
        "run walk --quiet --set duration=1 --record walk.mcap",
        "replay walk.mcap",
        "new controller mine",
        "new plant plant",
        "new peers peers",
        "chart --scenes slide --quick --quiet",
    ];
    let commands: String = commands.iter().map(|command| format!(" && ./biped {command} >printed")).collect();
    let script = format!(
        "mount -t tmpfs tmpfs /dev/shm; mkdir /dev/shm/own; cd /dev/shm/own; {hide}{commands}; code=$?; ls; exit $code"
    );
    let Some((code, printed, errors)) = within(&[], &script) else { return };
    assert_eq!(code, Some(0), "{printed}{errors}");
}
