"""Claims about the controllers in controller/foreign/python: they run with this package alone."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import program

ROOT = Path(__file__).parents[3]
CONTROLLERS = ROOT / "controller" / "foreign" / "python"


class Foreign(unittest.TestCase):
    def test_they_stand_and_walk_without_the_wheel_of_iceoryx2(self):
        self.assertIsNone(importlib.util.find_spec("iceoryx2"), "this environment must not have it")
        for scene, duration in [("stand", 1), ("walk", 3)]:
            with tempfile.TemporaryDirectory() as out:
                controller = f"{sys.executable} {CONTROLLERS / scene}.py"
                program.run("run", scene, "--quiet", "--set", f"duration={duration}", "--controller", controller, "--out", out)
                summary = json.loads(Path(out, "summary.json").read_text())
                self.assertEqual((summary["fell"], summary["duration_s"]), (False, duration))
                if scene == "walk":
                    self.assertGreater(summary["distance_m"], 0.1)

    def test_they_obey_the_rules_of_the_wire(self):
        program.run("conform", "--controller", f"{sys.executable} {CONTROLLERS / 'stand.py'}")

    def test_without_a_session_they_say_how_to_start_them(self):
        ended = subprocess.run([sys.executable, CONTROLLERS / "stand.py"], capture_output=True, text=True)
        self.assertEqual(ended.returncode, 2)
        self.assertRegex(ended.stderr, "error: start this program by: biped run SCENE")
        absent = os.environ | {"BIPED_SESSION": "no-such", "BIPED_PATIENCE": "0.1"}
        ended = subprocess.run([sys.executable, CONTROLLERS / "stand.py"], capture_output=True, text=True, env=absent)
        self.assertEqual(ended.returncode, 3)
        self.assertRegex(ended.stderr, "error: no session `no-such` is running")


if __name__ == "__main__":
    unittest.main()
