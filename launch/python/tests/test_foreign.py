"""Claims about the controllers in controller/foreign/python: they run with this package alone, and walk.py computes what the controller
in Rust does."""

import contextlib
import importlib
import importlib.util
import io
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
sys.path.insert(0, str(CONTROLLERS))
ROUNDING = 1e-9  # greatest difference of torques of up to 40 N·m that is rounding; 5e-11 was measured [N·m]


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
                    stop = subprocess.run([*request[:4], "--stop"], capture_output=True, text=True)
                    self.assertEqual(stop.returncode, code, stop.stderr)
                    again = subprocess.run(request, capture_output=True, text=True)
                    self.assertEqual(again.returncode, 2)
                    self.assertIn("has no effect before" if scene == "walk" else words, again.stderr)
                    too_fast = subprocess.run([*request[:-3], "9"], capture_output=True, text=True)
                    self.assertEqual(too_fast.returncode, 2)
                finally:
                    controller.terminate()
                    controller.wait()

    def test_walk_takes_other_set_points_within_its_range(self):
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

    def difference(self, settings, begin=0.0, change=None):
        """The greatest difference of torques between walk.py and the controller in Rust, from the same encoder counts [N·m]. Both are
        new at the time `begin`. `change` is a time, and the speed and period that are set then; without both, the walk ends."""
        import walk
        import wire

        scene, telemetry = biped.Scene("walk", settings), wire.Telemetry()
        plant, leader, greatest, changed = biped.Plant(scene), biped.Controller(scene), 0.0, False
        while plant.time < begin:
            plant.step(leader.tick(plant.counts))
        rust, numpy = biped.Controller(scene) if begin else leader, walk.Walk(tomllib.loads(scene.text), scene.rate)
        if begin:
            rust.reset(time=plant.time)
            numpy.begin_at(plant.time)
        while not plant.ended:
            if change and not changed and plant.time >= change[0]:
                _, speed, period = change
                if speed is None and period is None:
                    rust.stop()
                    numpy.stop()
                else:
                    rust.set(speed=speed, period=period)
                    numpy.set(speed, period)
                changed = True
            torques = rust.tick(plant.counts)
            greatest = max(greatest, abs(torques - numpy.tick(plant.counts.tolist(), telemetry)).max())
            plant.step(torques)
        self.assertFalse(plant.fallen, settings)
        return greatest

    def test_walk_gives_the_torques_of_the_controller_in_rust(self):
        push = {"plant.push_impulse": [4.0, 0.0, 0.0], "plant.push_time": 3.0}
        with tempfile.TemporaryDirectory() as folder:
            robot = Path(folder, "long-legs.toml")
            robot.write_text(program.run("export", "toml").replace("at = [0.0, 0.0, -0.2]", "at = [0.0, 0.0, -0.24]"))
            for name, settings, more in [
                ("all phases", {"duration": 6, "controller.stop_time": 4.0}, {}),
                ("another speed", {"duration": 5}, {"change": (3.0, 0.1, None)}),
                ("another period", {"duration": 5}, {"change": (3.0, 0.3, 0.8)}),
                ("a stop on request", {"duration": 6}, {"change": (4.1, None, None)}),
                ("restarted within a step", {"duration": 4}, {"begin": 2.7}),
                ("restarted during the stop", {"duration": 8, "controller.stop_time": 4.0}, {"begin": 4.3}),
                ("restarted after the stop", {"duration": 8, "controller.stop_time": 4.0}, {"begin": 6.0}),
                ("long steps", {"duration": 8, "controller.speed": 0.6, "controller.period": 0.8}, {}),
                ("a push from behind", {"duration": 5, **push}, {}),
                ("another robot that is pushed", {"duration": 5, "robot": str(robot), **push}, {}),
                ("tiles of ±3 mm", {"duration": 5, "plant.ground.random.height": 0.003, "plant.ground.random.seed": 2}, {}),
            ]:
                greatest = self.difference(settings, **more)
                self.assertLess(greatest, ROUNDING, name)

    def test_walk_refuses_what_it_does_not_have(self):
        for setting, words in [
            ("controller.rate_limit=8", "a QP with bounds"),
            ("controller.torque_bound=30", "a QP with bounds"),
            ("bodies.left thigh.joint.axis=[-1, 0, 0]", "roll, three times pitch, three times pitch, roll"),
            ("controller.com_height=0.5", "no posture has its centre of gravity 0.5 m high"),
        ]:
            with tempfile.TemporaryDirectory() as out:
                controller = f"{sys.executable} {CONTROLLERS / 'walk.py'}"
                command = [program.BIPED, "run", "walk", "--quiet", "--set", setting, "--controller", controller, "--out", out]
                ended = subprocess.run(command, capture_output=True, text=True)
                self.assertNotEqual(ended.returncode, 0)
                self.assertIn(words, ended.stderr)
                self.assertNotIn("Traceback", ended.stderr)

    def test_walk_refuses_straight_legs_in_the_words_of_the_controller_in_rust(self):
        import walk
        import wire

        scene, straight = biped.Scene("walk"), [0] * 8
        reason = "the legs are straight, or an encoder reading is wrong"
        with self.assertRaisesRegex(biped.ControllerError, reason):
            biped.Controller(scene).tick(straight)
        printed = io.StringIO()
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(printed):
            walk.Walk(tomllib.loads(scene.text), scene.rate).tick(straight, wire.Telemetry())
        self.assertIn(reason, printed.getvalue())

    def test_they_end_by_ctrl_c_and_sigterm_without_a_traceback(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with program.plant("stand", "--set", "duration=1000") as (name, process):
                process.stdout.close()
                command = [sys.executable, CONTROLLERS / "stand.py", "--session", name]
                default = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731, a job of a shell would ignore it
                controller = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=default)
                with biped.attach(name, control=False) as session:
                    truth = None
                    while truth is None or truth.stamp.sim_ns == 0:  # the plant waits for the first command
                        truth = session.truth(timeout=1.0)
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
