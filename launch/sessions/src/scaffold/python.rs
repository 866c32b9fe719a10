//! A new controller and a new plant in Python.

use super::template::{NewFile, Template, shell_word};
use crate::export::mjcf;
use controller::foreign;
use messages::load::built_in;
use shared::exit::Failure;
use std::path::Path;

/// Python packages that the modules of a controller need. tests/common/languages.rs has the same list.
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

/// A controller.
pub fn controller(folder: &Path, from: Template) -> Result<Vec<NewFile>, Failure> {
    let (code, class, scene, more) = from.parts();
    let program = shell_word(&folder.join("controller.py"));
    let code = code.replace(&format!("controller/foreign/python/{scene}.py"), &program);
    let texts = [
        ("controller.py", code),
        ("requirements.txt", REQUIREMENTS.into()),
        ("README.md", controller_readme(&program, scene, folder)),
        ("test_controller.py", controller_test(class)),
        ("scene.json", serde_json::to_string_pretty(&built_in(scene)?).unwrap_or_default() + "\n"),
    ];
    Ok(texts.into_iter().chain(copies(&foreign::PYTHON)).chain(copies(more)).collect())
}

fn copies(files: &[foreign::File]) -> impl Iterator<Item = NewFile> {
    files.iter().map(|(name, text)| (*name, text.to_string()))
}

fn controller_readme(program: &str, scene: &str, folder: &Path) -> String {
    let [requirements, test] = ["requirements.txt", "test_controller.py"].map(|file| shell_word(&folder.join(file)));
    format!(
        "# A controller for biped\n\n\
         pip install -r {requirements}                       # once\n\
         biped run {scene} --controller \"python3 {program}\"   # started by biped\n\
         biped plant {scene} --session lab & python3 {program} --session lab   # started by hand, for example in a debugger\n\
         biped conform --controller \"python3 {program}\"       # checks it against the rules of the wire\n\
         python3 {test}\n"
    )
}

fn controller_test(class: &str) -> String {
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

/// MuJoCo as the plant.
pub fn plant(folder: &Path) -> Result<Vec<NewFile>, Failure> {
    let program = shell_word(&folder.join("plant.py"));
    let scene = built_in("walk")?;
    let texts = [
        ("plant.py", plant::foreign::MUJOCO_PLANT.replace("plant/foreign/mujoco/plant.py", &program)),
        ("link.py", plant::foreign::MUJOCO_LINK.into()),
        ("requirements.txt", "numpy\nmujoco\n".into()),
        ("README.md", plant_readme(&program, folder)),
        ("test_plant.py", PLANT_TEST.into()),
        ("scene.json", serde_json::to_string_pretty(&scene).unwrap_or_default() + "\n"),
        ("robot.xml", mjcf(&scene)?),
    ];
    Ok(texts.into())
}

fn plant_readme(program: &str, folder: &Path) -> String {
    let [requirements, test] = ["requirements.txt", "test_plant.py"].map(|file| shell_word(&folder.join(file)));
    format!(
        "# MuJoCo as the plant for biped\n\n\
         pip install CLONE -r {requirements}           # once; CLONE is a clone of biped, whose Python package this is\n\
         biped run walk --plant \"python3 {program}\"       # the robot of `biped export mjcf`, walked by the controller of biped\n\
         biped conform --plant \"python3 {program}\"        # checks it against the rules of the wire\n\
         python3 {test}                           # reads scene.json and robot.xml, which are for this test only\n"
    )
}

const PLANT_TEST: &str = r#""""The plant starts at the scene's posture and moves: python3 test_plant.py"""

import json
import math
import unittest
from pathlib import Path

from plant import Plant

HERE = Path(__file__).parent


class Motion(unittest.TestCase):
    def test_the_robot_starts_at_the_posture_of_the_scene_and_moves_without_torques(self):
        scene = json.loads((HERE / "scene.json").read_text())
        plant = Plant(scene, (HERE / "robot.xml").read_text())
        count = math.tau / 2 ** scene["plant"]["encoder_bits"]
        before = plant.counts()
        for counts, angle in zip(before, scene["initial"]["joints"]):
            self.assertAlmostEqual(counts * count, angle, delta=count)
        for _ in range(50):
            plant.advance([0.0] * 8)
        self.assertNotEqual(plant.counts(), before)


if __name__ == "__main__":
    unittest.main()
"#;
