"""Claims about a plant of one's own in a session. Here it is the plant of this package, so the bits are known."""

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

FIELDS = ["base_position", "base_orientation", "base_velocity", "angle", "rate", "torque", "contact_force", "hash"]


def serve(goes_on_after_the_end):
    """The program that `biped run --plant` starts."""
    with biped.PlantSession() as session:
        plant, truth = biped.Plant(session.scene), biped.empty("Truth")
        torques = ()
        while torques is not None or goes_on_after_the_end:
            ours = plant.truth()
            for name in FIELDS:
                truth[name] = ours[name]
            torques = session.exchange(plant.counts, truth)
            if torques is not None:
                plant.step(torques)


class PlantSessions(unittest.TestCase):
    def command(self, what):
        return f"{sys.executable} {Path(__file__).absolute()} {what}"

    def test_a_plant_of_ones_own_is_walked_with_the_bits_of_one_process(self):
        plant = biped.Plant(biped.Scene("walk", {"duration": 1.5}))
        controller = biped.Controller(plant.scene)
        while not plant.ended:
            plant.step(controller.tick(plant.counts))
        with tempfile.TemporaryDirectory() as out:
            program.run("run", "walk", "--quiet", "--set", "duration=1.5", "--plant", self.command("serve"), "--out", out)
            summary = json.loads(Path(out, "summary.json").read_text())
        self.assertEqual(summary["trajectory_hash"], f"{plant.hash:016x}")
        self.assertEqual((summary["fell"], summary["duration_s"]), (False, 1.5))

    def test_it_obeys_the_rules_of_the_wire(self):
        printed = program.run("conform", "--plant", self.command("serve"))
        self.assertRegex(printed, "3[0-9] rules kept")

    def test_a_call_without_a_session_or_after_the_end_is_refused(self):
        without = {key: value for key, value in os.environ.items() if not key.startswith("BIPED_")}
        ended = subprocess.run(self.command("serve").split(), capture_output=True, text=True, env=without)
        self.assertRegex(ended.stderr, "error: BIPED_SESSION is not set: .*--plant COMMAND")
        with tempfile.TemporaryDirectory() as out:
            run = [program.BIPED, "run", "stand", "--quiet", "--set", "duration=0.01", "--out", out, "--plant", self.command("on")]
            ended = subprocess.run(run, capture_output=True, text=True)
        self.assertEqual(ended.returncode, 2)
        self.assertIn("the run has ended: its last exchange returned no torques", ended.stderr)


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))
    try:
        serve(sys.argv[1] == "on")
    except biped.Error as error:
        codes = {biped.AbsentError: 3, biped.RefusedError: 5}
        print(f"error: {error}", file=sys.stderr)
        sys.exit(codes.get(type(error), 2))


if __name__ == "__main__":
    if sys.argv[1:] in (["serve"], ["on"]):
        main()
    else:
        unittest.main()
