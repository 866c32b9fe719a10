//! Claim: a program that is moved to a processor without what it was built for says so, and does not die of it.

#![cfg(target_arch = "x86_64")]

use std::process::{Command, Output};

/// Exit code and what was said to be wrong, of the program on a processor that qemu makes believe; nothing without qemu.
fn on(processor: &str) -> Option<(Option<i32>, String)> {
    let mut command = Command::new("qemu-x86_64");
    let Ok(Output { status, stderr, .. }) =
        command.args(["-cpu", processor, env!("CARGO_BIN_EXE_biped"), "list"]).output()
    else {
        println!("there is no qemu-x86_64 here (apt-get install qemu-user): nothing was tried");
        return None;
    };
    let own = |line: &&str| !line.contains("qemu-x86_64: warning"); // what it cannot emulate
    Some((status.code(), String::from_utf8_lossy(&stderr).lines().filter(own).collect::<Vec<_>>().join("\n")))
}

#[test]
fn a_processor_that_lacks_an_instruction_is_told_which() {
    // the oldest there is, and one of 2008
    for processor in ["qemu64", "Nehalem"] {
        let Some((code, words)) = on(processor) else { return };
        if cfg!(target_feature = "avx") {
            assert_eq!((code, words.lines().count()), (Some(4), 1), "{processor}: {words}");
            assert!(
                words.contains("this program was built for processors with ") && words.contains("cargo build"),
                "{words}"
            );
        } else {
            println!("{processor}: {code:?} {words}"); // built for one that may be as old
        }
    }
}
