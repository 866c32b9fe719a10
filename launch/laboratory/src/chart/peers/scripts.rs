//! The scripts that run other simulators. This program holds them, and copies them to where they run.

use shared::exit::{Exit, Failure};
use shared::output::{create_folder, write_atomically};
use std::path::{Path, PathBuf};

/// Where a script is put, and its text.
macro_rules! script {
    ($name:literal) => {
        ($name, include_str!(concat!("../../../peers/", $name)))
    };
}

/// All scripts. cargo would leave a folder with a `Cargo.toml` out of a package, so that file has another name there.
pub const SCRIPTS: [(&str, &str); 16] = [
    script!("README.md"),
    script!("dart_scenes.py"),
    script!("drake_scenes.py"),
    script!("growth.py"),
    script!("measure.py"),
    script!("mujoco_scenes.py"),
    script!("pinocchio_scenes.py"),
    script!("pybullet_scenes.py"),
    script!("rapier_scenes.py"),
    script!("run.py"),
    script!("scenes.py"),
    script!("siconos_scenes.py"),
    script!("simulation.py"),
    ("rapier/Cargo.toml", include_str!("../../../peers/rapier/manifest.toml")),
    script!("rapier/Cargo.lock"),
    script!("rapier/src/main.rs"),
];

/// The Python packages that `run.py` installs, as a requirements.txt.
pub fn requirements() -> String {
    let run = SCRIPTS.iter().find(|(name, _)| *name == "run.py").map_or("", |(_, text)| text);
    let pinned = run.split('"').filter(|word| word.contains("==") && !word.contains(char::is_whitespace));
    pinned.map(|package| format!("{package}\n")).collect()
}

/// Copies all scripts into a folder of that name within `folder`. Returns the path of the script `name`.
///
/// # Errors
/// A file that cannot be written.
pub fn copy(folder: &Path, name: &str) -> Result<PathBuf, Failure> {
    let folder = folder.join("scripts");
    create_folder(&folder.join("rapier/src"))?;
    for (file, text) in SCRIPTS {
        write_atomically(&folder.join(file), text)
            .map_err(|error| Failure::new(Exit::Fault, format!("--peers: {}: {error}", folder.join(file).display())))?;
    }
    Ok(folder.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_requirements_are_the_packages_that_the_script_installs() {
        let listed = requirements();
        assert!(listed.contains("mujoco-core==4.0.0\n") && listed.contains("numpy=="), "{listed}");
        assert!(listed.lines().all(|line| line.split("==").count() == 2), "{listed}");
    }

    #[test]
    fn every_script_is_copied() {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("peers");
        let names = std::fs::read_dir(source).expect("the scripts").map(|file| file.expect("a file").file_name());
        let names: Vec<_> = names.map(|name| name.to_string_lossy().into_owned()).collect();
        let folder = std::env::temp_dir().join(format!("biped-scripts-{}", std::process::id()));
        let program = copy(&folder, "run.py").expect("a folder that can be written");
        assert!(program.is_file());
        for name in &names {
            assert!(folder.join("scripts").join(name).exists(), "{name} is not in SCRIPTS");
        }
        std::fs::remove_dir_all(folder).expect("our own folder");
    }
}
