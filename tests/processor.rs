//! Claim: on a processor without an instruction set that the program was built for, it exits with a message instead of a crash.

#![cfg(target_arch = "x86_64")]

use std::process::{Command, Output};

/// Exit code and standard error of the program on a processor that qemu emulates; `None` without qemu.
fn on(processor: &str) -> Option<(Option<i32>, String)> {
    let mut command = Command::new("qemu-x86_64");
    let Ok(Output { status, stderr, .. }) =
        command.args(["-cpu", processor, env!("CARGO_BIN_EXE_biped"), "list"]).output()
    else {
        println!("qemu-x86_64 is missing (apt-get install qemu-user): nothing was tested");
        return None;
    };
    let own = |line: &&str| !line.contains("qemu-x86_64: warning"); // it warns of features that it cannot emulate
    Some((status.code(), String::from_utf8_lossy(&stderr).lines().filter(own).collect::<Vec<_>>().join("\n")))
}

#[test]
fn a_missing_processor_instruction_is_named() {
    // the oldest x86-64 processor, and one of 2008
    for processor in ["qemu64", "Nehalem"] {
        let Some((code, printed)) = on(processor) else { return };
        if cfg!(target_feature = "avx") {
            assert_eq!((code, printed.lines().count()), (Some(4), 1), "{processor}: {printed}");
            assert!(
                printed.contains("this program was built for processors with ") && printed.contains("cargo build"),
                "{printed}"
            );
        } else {
            println!("{processor}: {code:?} {printed}"); // the program was built for a processor as old as this one
        }
    }
}
