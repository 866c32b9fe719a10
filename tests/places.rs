//! Claims about other surroundings than a machine of one's own, made of namespaces: what `biped doctor` sees of a /dev/shm that
//! nobody can use, what grants real time where a capability cannot, and a session over the walls of two containers.
//!
//! Where no namespaces may be made, they say so and claim nothing.

#![expect(clippy::expect_used, reason = "a test may panic")]

use std::process::{Command, Output};

/// Exit code, what was printed, and what was said to be wrong, of a shell's script in namespaces of its own, as their root.
fn within(namespaces: &[&str], script: &str) -> Option<(Option<i32>, String, String)> {
    let unshare = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--mount"]).args(namespaces).args(["sh", "-c", script]);
        command.env("BIPED", env!("CARGO_BIN_EXE_biped")).output().expect("unshare")
    };
    if !unshare("mount -t tmpfs tmpfs /dev/shm").status.success() {
        println!("no namespaces may be made here: nothing was tried");
        return None;
    }
    let Output { status, stdout, stderr } = unshare(script);
    let [told, errors] = [stdout, stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    println!("{script}\n{told}{errors}");
    Some((status.code(), told, errors))
}

/// The doctor's line that begins with a word and its finding, and the advice below.
fn finding(told: &str, what: &str) -> (String, String) {
    let mut lines = told.lines().skip_while(|line| line.split_whitespace().nth(1) != Some(what));
    let line = lines.next().unwrap_or_default().to_string();
    (line, lines.next().unwrap_or_default().trim().to_string())
}

#[test]
fn shared_memory_that_cannot_be_used_is_told_with_what_would_mend_it() {
    for (options, found, advice) in [
        ("ro", "cannot be written to: Read-only file system", "mount -o remount,rw /dev/shm"),
        ("size=10m", "10 MB free; a session needs 17 MB", "size=1"),
        ("nr_inodes=9", "64 files, of which 8 can be created", "remove files there"),
    ] {
        let place = format!("mount -t tmpfs -o {options} tmpfs /dev/shm");
        let Some((code, told, _)) = within(&[], &format!("{place}; $BIPED doctor")) else { return };
        let (line, mends) = finding(&told, "/dev/shm");
        assert_eq!(code, Some(4), "{told}");
        assert!(line.starts_with("wrong") && line.contains(found), "{line}");
        assert!(mends.contains(advice) || mends.contains("--shm-size"), "{mends}");
        let run = format!("{place}; $BIPED run stand --quiet --set duration=0.1");
        let (code, _, errors) = within(&[], &run).expect("namespaces");
        assert_eq!((code, errors.lines().count()), (Some(6), 1), "{errors}");
        assert!(errors.contains("/dev/shm") && !errors.contains("InternalError"), "{errors}");
    }
    let (code, told, _) = within(&[], "mount -t tmpfs tmpfs /dev/shm; $BIPED doctor").expect("namespaces");
    assert_eq!(code, Some(0), "{told}");
    assert!(finding(&told, "/dev/shm").0.starts_with("ok"), "{told}");
}

/// As one of another user, to whom alone it is open; here it is open to nobody, and root without the right to pass over that.
#[test]
fn shared_memory_of_another_user_is_told() {
    let enter = "mount -t tmpfs -o mode=555 tmpfs /dev/shm; exec setpriv --bounding-set=-dac_override $BIPED doctor";
    let Some((code, told, errors)) = within(&[], enter) else { return };
    let (line, mends) = finding(&told, "/dev/shm");
    assert_eq!(code, Some(4), "{told}{errors}");
    assert!(line.starts_with("wrong") && line.contains("cannot be written to: Permission denied"), "{line}");
    assert!(mends.contains("chmod 1777 /dev/shm") && mends.contains("has mode 555"), "{mends}");
}

/// A program whose file has a capability beyond the bounding set, or of a user whom the machine does not know, does not start or gains nothing.
#[test]
fn no_capability_is_advised_where_none_can_be_given() {
    let script = "exec setpriv --bounding-set=-sys_nice,-ipc_lock $BIPED doctor";
    let Some((_, told, errors)) = within(&[], script) else { return };
    let (line, mends) = finding(&told, "limit");
    assert!(line.contains("memlock") && told.contains("rtprio"), "{told}{errors}");
    assert!(!told.contains("setcap"), "{told}");
    if told.contains("refused on request") {
        assert!(!mends.is_empty(), "{told}");
    }
}

#[test]
fn a_session_spans_two_containers_that_share_memory_and_not_processes() {
    let walk = "walk --session places --set duration=1";
    let script = format!(
        "mount -t tmpfs tmpfs /dev/shm; $BIPED plant {walk} & unshare --pid --fork --mount-proc $BIPED controller {walk} && wait $!"
    );
    let Some((code, told, errors)) = within(&[], &script) else { return };
    assert_eq!(code, Some(0), "{told}{errors}");
}
