"""Claims about the controllers in controller/foreign/python: they run with this package alone."""

import importlib
import importlib.util
import json
import os
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import biped
import program

tomllib = importlib.import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")

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

    def test_walk_serves_requests_and_stand_refuses_them(self):
        for scene, code, words in [("walk", 0, "set at t"), ("stand", 2, "this program does not serve the request")]:
            with program.plant(scene, "--set", "duration=1000") as (name, _):
                controller = subprocess.Popen([sys.executable, CONTROLLERS / f"{scene}.py", "--session", name])
                try:
                    request = [program.BIPED, "set", "--session", name, "--speed", "0.1", "--period", "0.5"]
                    for _ in range(100):
                        ended = subprocess.run(request, capture_output=True, text=True)
                        if ended.returncode != 3:  # until the controller is there
                            break
                    self.assertEqual(ended.returncode, code, ended.stderr)
                    self.assertIn(words, ended.stdout + ended.stderr)
                    too_fast = subprocess.run([*request[:-3], "9"], capture_output=True, text=True)
                    self.assertEqual(too_fast.returncode, 2)
                finally:
                    controller.terminate()
                    controller.wait()

    def test_walk_takes_other_set_points_within_its_range(self):
        sys.path.insert(0, str(CONTROLLERS))
        import walk
        import wire

        scene, telemetry = tomllib.loads(biped.Scene("walk").text), wire.Telemetry()
        plant, controller = biped.Plant(biped.Scene("walk", "duration=8")), walk.Walk(scene, scene["rate"])
        speeds = []
        for speed, period in [(0.2, None), (0.1, 0.5)]:
            controller.set(speed, period)
            before = plant.truth().base_position[0]
            for _ in range(4000):
                plant.step(controller.tick(plant.counts.tolist(), telemetry))
            speeds.append((plant.truth().base_position[0] - before) / 4)
        self.assertFalse(plant.fallen)
        self.assertAlmostEqual(speeds[1], 0.1, delta=0.03)
        for speed, period in [(9.0, None), (None, 0.1), (None, 3.0), (0.6, 1.0), (float("nan"), None)]:
            with self.assertRaises(ValueError):
                controller.set(speed, period)

    def test_they_end_by_ctrl_c_and_sigterm_without_a_traceback(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with program.plant("stand", "--set", "duration=1000") as (name, process):
                process.stdout.close()
                command = [sys.executable, CONTROLLERS / "stand.py", "--session", name]
                default = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731, a job of a shell would ignore it
                controller = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=default)
                with biped.attach(name, control=False) as session:
                    while session.truth(timeout=1.0) is None:
                        pass  # until it controls
                controller.send_signal(number)
                self.assertEqual((controller.communicate(timeout=30)[1], controller.returncode), ("", 130))

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
