"""Claims about the learned policy and the tuned gains: they beat their start, and the policy on the wire is that of the environment."""

import contextlib
import importlib.util
import io
import os
import re
import shlex
import subprocess
import sys
import unittest
from pathlib import Path

for module in ["gymnasium", "cma"]:
    if importlib.util.find_spec(module) is None:
        raise unittest.SkipTest(f"needs {module}: pip install 'biped[gym]' cma")

EXAMPLES = Path(__file__).parents[1] / "examples"
sys.path.insert(0, str(EXAMPLES))

import biped
import gymnasium
import learn_push
import numpy as np
import program
import run_policy
import tune_gains

FAST = {"plant.law": "Sweep(5)"}
FILE = EXAMPLES / "push.txt"
COMMAND = shlex.join([sys.executable, str(EXAMPLES / "run_policy.py"), str(FILE)])
PUSH = {"plant.push_impulse": "[4.0, 3.0, 0.0]", "plant.push_time": 0.3, "duration": 1.0}
LINK = {"link.delay_ms": 2.0, "link.jitter_ms": 1.0}


def arguments(*settings):
    return [part for pairs in settings for key, value in pairs.items() for part in ("--set", f"{key}={value}")]


class Policies(unittest.TestCase):
    def setUp(self):
        self.policy = run_policy.load(FILE)

    def test_the_policy_survives_more_pushes_than_springs_and_dampers_on_other_seeds(self):
        seeds = range(5000, 5032)
        alone, learned = (run_policy.survived(choice, 7.0, seeds, FAST | LINK) for choice in (run_policy.springs, self.policy))
        self.assertGreater(learned, alone + 0.1)

    def test_a_control_period_at_a_time_gives_the_bits_of_the_environment(self):
        env = gymnasium.make("biped.gym:biped/Push-v0", duration=1.0, noise=0.0, settings=FAST)
        observation, _ = env.reset(seed=1, options={"push": [4.0, 3.0, 0.0], "time": 0.3})
        over = False
        while not over:
            observation, _, lost, truncated, _ = env.step(self.policy(observation[None])[0])
            over = lost or truncated
        plant = biped.Plant(biped.Scene("stand", FAST, "duration=1"))
        controller = run_policy.Controller(plant.scene, self.policy)
        while not plant.ended:
            if round(plant.time * 1000) == 300:
                plant.push([4.0, 3.0, 0.0])
            plant.step(controller.tick(plant.angles))
        self.assertEqual(env.unwrapped.task.plants[0].hash, plant.hash)

    def test_a_process_on_the_wire_gives_the_same_bits_with_delay_and_jitter(self):
        plant = biped.Plant(biped.Scene("stand", PUSH, LINK))
        controller = run_policy.Controller(plant.scene, self.policy)
        while not plant.ended:
            plant.step(controller.tick(plant.angles))
        report = program.run("run", "stand", *arguments(PUSH, LINK), "--controller", COMMAND)
        self.assertIn(f"{plant.hash:016x}", report)
        self.assertNotIn("FELL", report)

    def test_it_stands_in_real_time_with_delay_and_jitter(self):
        # at a tenth of the speed, so that a busy machine does not decide
        report = program.run("run", "stand", *arguments(PUSH, LINK), "--realtime", "--speed", "0.1", "--controller", COMMAND)
        self.assertNotIn("FELL", report)

    def test_it_attaches_by_name_and_ends_with_a_sentence_and_the_exit_codes_of_a_controller(self):
        def ended(*arguments, **environment):
            command = [sys.executable, str(EXAMPLES / "run_policy.py"), *arguments]
            return subprocess.run(command, capture_output=True, text=True, env=os.environ | environment, timeout=120)

        with program.plant("stand", "--set", "duration=0.5") as (name, process):
            self.assertEqual((ended(str(FILE), "--session", name).returncode, process.wait(30)), (0, 0))
        for arguments, environment, code, words in [
            ([str(FILE)], {}, 2, "BIPED_SESSION is not set"),
            ([str(FILE)], {"BIPED_SESSION": "no-such", "BIPED_PATIENCE": "0.1"}, 3, "no session `no-such` is running"),
            (["no-such.txt"], {}, 2, "no-such.txt cannot be read as weights"),
            ([str(EXAMPLES / "learn_push.py")], {}, 2, "cannot be read as weights"),
            (["/dev/null"], {}, 2, "has 0 numbers: a policy has 64 finite weights"),
        ]:
            result = ended(*arguments, **environment)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertRegex(result.stderr, f"(?m)^error: .*{re.escape(words)}.*\n\\Z")
            self.assertNotIn("Traceback", result.stderr)

    def test_it_conforms(self):
        self.assertIn("0 broken", program.run("conform", "stand", "--controller", COMMAND))


class Learning(unittest.TestCase):
    def test_a_few_generations_raise_the_return_for_pushes_in_other_directions(self):
        with contextlib.redirect_stdout(io.StringIO()):
            weights = learn_push.learn(6, impulses=np.full(4, 6.5), seconds=2.0)
        before, after = learn_push.returns([np.zeros(64), weights], seed=50, impulses=np.full(16, 6.5), seconds=2.0)
        self.assertGreater(after, before + 0.02)


class Gains(unittest.TestCase):
    def test_tuning_makes_weak_springs_survive_greater_pushes(self):
        weak = np.concatenate([np.log(np.repeat([40.0, 2.0], 4)), np.zeros(4)])
        impulses = np.array([3.0, 5.0, 6.0])
        tuned = tune_gains.tune(4, start=weak, impulses=impulses)
        before, after = tune_gains.upright([weak, tuned], impulses, FAST).mean(axis=2).min(axis=1)
        self.assertGreater(after, before + 0.05)


if __name__ == "__main__":
    unittest.main()
