//! Tools for other languages: a Python with packages, and compilers.
//!
//! The Python packages are installed once, into a virtual environment in the target folder.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]
#![allow(dead_code, reason = "each test file uses a part of this")]

use super::common::fresh_path;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The packages that controllers without the package `biped`, and comparisons, need.
const PACKAGES: [&str; 10] = [
    "iceoryx2==0.10.0",
    "numpy",
    "xxhash==4.1.0",
    "mujoco==4.0.0",
    "pin==4.1.0",
    "mcap==1.6.0",
    "mcap-protobuf-support==0.6.0",
    "foxglove-schemas-protobuf==0.4.0",
    "jsonschema==4.26.0",
    "pandas",
];

/// The packages that build the Python package `biped` and run its tests, and MuJoCo for the plant. Only NumPy is a dependency of `biped`.
const BESIDE_PACKAGE: [&str; 9] = [
    "maturin>=1.9.4,<2",
    "numpy",
    "pandas",
    "gymnasium",
    "cma",
    "matplotlib", // cma warns without it
    "distributed",
    "pillow",
    "mujoco==4.0.0",
];

/// The Python interpreter of an environment with the package `biped` of this repository, and without the wheel of iceoryx2.
pub fn python_with_package() -> &'static PathBuf {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let python = python_with("python-package", &BESIDE_PACKAGE);
        // With the maturin of the environment, so that pip does not download another one.
        pip_install(&python, &["--no-build-isolation", "--no-deps", "--force-reinstall", env!("CARGO_MANIFEST_DIR")]);
        python
    })
}

/// The Python interpreter of an environment with these packages.
pub fn python() -> &'static PathBuf {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| python_with("python", &PACKAGES))
}

/// The Python interpreter of an environment of this name in the target folder, with these packages.
pub fn python_with(name: &str, packages: &[&str]) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let (python, marker) = (folder.join("bin/python3"), folder.join(packages.join(" ")));
    // only one test program installs at a time
    let lock = File::create(folder.with_extension("lock")).expect("a file of ours");
    lock.lock().expect("a lock");
    if !marker.exists() {
        let venv = Command::new("python3").args(["-m", "venv"]).arg(&folder).output().expect("Python 3");
        assert!(venv.status.success(), "{}", String::from_utf8_lossy(&venv.stderr));
        pip_install(&python, packages);
        std::fs::write(marker, "").expect("a file of ours");
    }
    python
}

/// Installs packages. The programs of the environment are on the path, for those that are built.
pub fn pip_install(python: &Path, arguments: &[&str]) {
    let programs = python.parent().expect("a folder").to_path_buf();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(programs).chain(std::env::split_paths(&others))).expect("a path");
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    let pip = Command::new(python).args(pip).args(arguments).env("PATH", path).output().expect("pip");
    assert!(pip.status.success(), "{}", String::from_utf8_lossy(&pip.stderr));
}

/// The folder of the C library, as cargo builds it for tests.
pub fn libraries() -> PathBuf {
    let folder = Path::new(env!("CARGO_BIN_EXE_biped")).parent().expect("a folder").join("deps");
    assert!(folder.join("libbiped_c.so").exists(), "no libbiped_c.so in {}", folder.display());
    folder
}

/// Compiles a source file of this repository. Returns the path of the program.
pub fn compile(compiler: &str, standard: &str, source: &str) -> PathBuf {
    let (program, libraries) = (fresh_path("native"), libraries());
    let output = Command::new(compiler)
        .args([standard, "-O2", "-Wall", "-Wextra", "-Werror", source, "-o"])
        .arg(&program)
        .args(["-Icontroller/foreign/c", "-Imessages/include", "-L"])
        .arg(&libraries)
        // the program finds the library there, independently of LD_LIBRARY_PATH
        .args(["-lbiped_c", "-lm", &format!("-Wl,--disable-new-dtags,-rpath,{}", libraries.display())])
        .output()
        .unwrap_or_else(|error| panic!("there is no compiler `{compiler}` ({error}): install g++, which brings both"));
    assert!(output.status.success(), "{source}: {}", String::from_utf8_lossy(&output.stderr));
    program
}
