//! Whether the processor has the instructions that this was built for: `.cargo/config.toml`.

use crate::exit::{Exit, Failure};
use std::fs::File;
use std::io::Read;

/// What is used of x86-64-v3.
const NEEDED: [&str; 4] = ["avx2", "bmi1", "bmi2", "fma"];
/// Room for what the system says of the first processor.
const FIRST: u64 = 8192;

/// Says what is missing before an instruction does that does not exist.
///
/// # Errors
/// If something is missing.
pub fn check() -> Result<(), Failure> {
    let mut said = String::new();
    let mut read = || File::open("/proc/cpuinfo")?.take(FIRST).read_to_string(&mut said);
    if !cfg!(target_feature = "avx2") || read().is_err() {
        return Ok(());
    }
    match missing(&said).as_slice() {
        [] => Ok(()),
        missing => Err(Failure::new(
            Exit::Fault,
            format!(
                "this was built for processors with {}, which this one has not; build it by RUSTFLAGS=\"-C target-cpu=x86-64\" \
                 cargo build --release, the results are the same to the bit",
                missing.join(", ")
            ),
        )),
    }
}

/// What the first processor lacks; nothing if that is not said.
fn missing(cpuinfo: &str) -> Vec<&'static str> {
    let flags = cpuinfo.lines().find(|line| line.starts_with("flags"));
    let has = |flag: &str| flags.is_none_or(|flags| flags.split_whitespace().any(|known| known == flag));
    NEEDED.into_iter().filter(|flag| !has(flag)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_processor_is_told_what_it_lacks() {
        assert_eq!(missing("processor : 0\nflags\t\t: fpu sse2 avx bmi1\n"), ["avx2", "bmi2", "fma"]);
        assert_eq!(missing("flags\t\t: fma bmi2 avx2 bmi1"), [""; 0]);
        assert_eq!(missing("Features : asimd"), [""; 0]);
    }
}
