//! `biped new`: a controller, scene or robot of one's own to begin from. All files come out of this program.

use crate::export::toml;
use clap::{Args, Subcommand, ValueEnum};
use controller::foreign;
use messages::load::load;
use shared::exit::{Exit, Failure};
use shared::list::SCENES;
use shared::output::{print_text, write_atomically, write_failure};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Kind of file or folder to make.
#[derive(Subcommand)]
pub enum NewArgs {
    /// Make a folder with a controller in Python that runs at once
    Controller(ControllerArgs),
    /// Make a file with a scene to edit
    Scene(FileArgs),
    /// Make a file with a robot to edit
    Robot(FileArgs),
}

/// Arguments of `biped new controller`.
#[derive(Args)]
pub struct ControllerArgs {
    /// Folder to make
    folder: PathBuf,
    /// Controller to begin from
    #[arg(long, value_enum, default_value = "stand")]
    from: Template,
    /// In Python, which is the default and so far the only language: docs/WIRE.md shows C, C++ and Rust
    #[arg(long)]
    python: bool,
}

/// Arguments of `biped new scene` and `biped new robot`.
#[derive(Args)]
pub struct FileArgs {
    /// File to make; without an extension, .toml is added
    file: PathBuf,
    /// Built-in scene (see `biped list`) or path of a TOML file to begin from
    #[arg(long, default_value = "walk")]
    from: String,
}

/// A controller to begin from.
#[derive(Clone, Copy, ValueEnum)]
enum Template {
    /// A spring and a damper in each joint
    Stand,
    /// The paper's controller in NumPy
    Walk,
}

/// Python packages that these modules need. tests/common/languages.rs has the same list.
const REQUIREMENTS: &str = "iceoryx2==0.10.0\nnumpy\nxxhash\n";

impl Template {
    /// The controller, the class in it, the scene that it is for, whose name its file has too, and further modules.
    fn parts(self) -> (&'static str, &'static str, &'static str, &'static [foreign::File]) {
        match self {
            Template::Stand => (foreign::PYTHON_STAND.1, "Stand", "stand", &[]),
            Template::Walk => (foreign::PYTHON_WALK.1, "Walk", "walk", &foreign::PYTHON_GAIT),
        }
    }
}

/// Makes it.
///
/// # Errors
/// Something that is there already, a scene that is refused, or a place that cannot be written.
pub fn run(args: &NewArgs) -> Result<(), Failure> {
    match args {
        NewArgs::Controller(args) => controller(args),
        NewArgs::Scene(args) => {
            let scene = load(&args.from, &[], SCENES)?;
            let path = file(&args.file, &messages::load::text(&scene))?;
            print_text(format!(
                "{0}: run it by `biped run {0}`; `biped list --keys` explains every key\n",
                path.display()
            ));
            Ok(())
        }
        NewArgs::Robot(args) => {
            let scene = load(&args.from, &[], SCENES)?;
            let path = file(&args.file, &toml::text(&scene))?;
            print_text(format!("{0}: walk it by `biped run walk --robot {0}`\n", path.display()));
            Ok(())
        }
    }
}

fn controller(args: &ControllerArgs) -> Result<(), Failure> {
    let folder = &args.folder;
    fs::create_dir(folder).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => there(folder),
        _ => write_failure(folder, &error),
    })?;
    let (code, class, scene, more) = args.from.parts();
    let program = folder.join("controller.py").display().to_string();
    let code = code.replace(&format!("controller/foreign/python/{scene}.py"), &program);
    let texts = [
        ("controller.py", code),
        ("requirements.txt", REQUIREMENTS.into()),
        ("README.md", readme(&program, scene, folder)),
        ("test_controller.py", test(class)),
        ("scene.json", serde_json::to_string_pretty(&load(scene, &[], SCENES)?).unwrap_or_default() + "\n"),
    ];
    let copies = foreign::PYTHON.iter().chain(more).map(|(name, text)| (*name, text.to_string()));
    for (name, text) in texts.into_iter().chain(copies) {
        write_atomically(&folder.join(name), &text).map_err(|error| write_failure(folder, &error))?;
    }
    print_text(format!("{}: README.md says how to run it\n", folder.display()));
    Ok(())
}

fn readme(program: &str, scene: &str, folder: &Path) -> String {
    let folder = folder.display();
    format!(
        "# A controller for biped\n\n\
         pip install -r {folder}/requirements.txt                       # once\n\
         biped run {scene} --controller \"python3 {program}\"   # started by biped\n\
         biped plant {scene} --session lab & python3 {program} --session lab   # started by hand, for example in a debugger\n\
         biped conform --controller \"python3 {program}\"       # checks it against the rules of the wire\n\
         python3 {folder}/test_controller.py\n"
    )
}

fn test(class: &str) -> String {
    format!(
        r#""""The controller gives eight finite torques within the limit: python3 test_controller.py"""

import json
import math
import unittest
from pathlib import Path

import wire
from controller import {class}


class Torques(unittest.TestCase):
    def test_eight_finite_torques_within_the_limit(self):
        scene = json.loads(Path(__file__).with_name("scene.json").read_text())
        controller = {class}(scene, scene["rate"])
        count = math.tau / 2 ** scene["plant"]["encoder_bits"]
        counts = [round(angle / count) for angle in scene["initial"]["joints"]]
        torques = controller.tick(counts, wire.Telemetry())
        self.assertEqual(len(torques), 8)
        self.assertTrue(all(abs(torque) <= scene["plant"]["torque_limit"] for torque in torques), torques)


if __name__ == "__main__":
    unittest.main()
"#
    )
}

/// Writes a new file, and gives its name.
fn file(path: &Path, text: &str) -> Result<PathBuf, Failure> {
    let path = if path.extension().is_none() { path.with_extension("toml") } else { path.into() };
    if path.exists() {
        return Err(there(&path));
    }
    write_atomically(&path, text).map_err(|error| write_failure(&path, &error))?;
    Ok(path)
}

fn there(path: &Path) -> Failure {
    Failure::new(Exit::Usage, format!("{} is there already: choose another name, or remove it", path.display()))
}
