"""Runs a policy of learn_push.py as the controller of a session, in lockstep or in real time.

    biped run stand --controller "python3 run_policy.py push.txt"
    biped plant stand --session lab & python3 run_policy.py push.txt --session lab
    python3 run_policy.py push.txt --compare

Exit codes are those of biped: 0 after the plant's goodbye, 2 for a wrong file, 3 without a plant, 5 if refused, 130 on Ctrl-C or SIGTERM.
"""

import argparse
import signal
import sys

import biped
import numpy as np
from biped.gym import Loop, Push

START = np.array(biped.Scene(Push.built_in).start)
MIRROR = np.array([1.0, -1.0, -1.0, -1.0])  # signs of a right joint's angle seen in a mirror: ankle roll, ankle pitch, knee, hip


def policy(weights):
    """A function from observations, shape (robots, 24), to actions, shape (robots, 8), with 64 weights.

    Angles and rates of a pair of joints have a part that is the same for both legs, seen in a mirror, and a part that is opposite. Each
    part of the action is tanh of a linear function of that part of the observation. So a mirrored robot gets the mirrored action.
    """
    same, opposite = np.asarray(weights, float).reshape(2, 8, 4)

    def act(observations):
        angles, rates = (observations[:, :8] - START) / 0.05, observations[:, 8:16] / 0.5
        left = np.concatenate([angles[:, :4], rates[:, :4]], axis=1)
        right = np.concatenate([angles[:, :3:-1] * MIRROR, rates[:, :3:-1] * MIRROR], axis=1)
        common, difference = np.tanh((left + right) / 2 @ same), np.tanh((left - right) / 2 @ opposite)
        return np.concatenate([common + difference, ((common - difference) * MIRROR)[:, ::-1]], axis=1)

    return act


def load(file):
    """The policy of a file of learn_push.py. ValueError if it is none."""
    try:
        weights = np.loadtxt(file)
    except (OSError, ValueError) as error:
        raise ValueError(f"{file} cannot be read as weights: {error}") from None
    if weights.size != 64 or not np.isfinite(weights).all():
        raise ValueError(f"{file} has {weights.size} numbers: a policy has 64 finite weights, as learn_push.py writes them")
    return policy(weights)


class Controller:
    """The same computations as in the environment, one control period at a time: an action each 20 ms, springs and dampers each millisecond."""

    def __init__(self, scene, policy, offset=0.5):
        self.loop, self.policy, self.offset, self.number = Loop(scene), policy, offset, 0

    def reset(self):
        self.number = 0

    def tick(self, angles):
        if self.number == 0:
            self.loop.begin(angles)
        else:
            self.loop.measure(angles[None])
        if self.number % Push.periods == 0:
            action = self.policy(self.loop.observation().astype(np.float32))
            self.targets = self.loop.start + self.offset * np.clip(action, -1.0, 1.0)
        self.number += 1
        return self.loop.spring(self.targets)[0]


def survived(policy, impulse, seeds, settings=None):
    """Share of the random pushes of this size that the robot survives, one for each seed."""
    task = Push(len(seeds), settings=settings)
    for robot, seed in enumerate(seeds):
        random = np.random.default_rng(seed)
        direction = random.uniform(-np.pi, np.pi)
        task.reset(robot, random, {"push": [impulse * np.cos(direction), impulse * np.sin(direction), 0.0]})
    stands = np.ones(len(seeds), bool)
    for _ in range(task.length):
        _, lost, _ = task.step(policy(task.observation()))
        stands &= ~lost
    return stands.mean()


def springs(observations):
    """The zero action."""
    return np.zeros((len(observations), 8))


def compare(policy, impulses=(5.0, 6.0, 6.5, 7.0, 8.0), seeds=range(1000, 1024)):
    """Prints the share of pushes that the policy survives on seeds that it has not met, and the share for springs and dampers alone."""
    for words, link in [("commands at once", {}), ("commands 2 to 3 ms late", {"link.delay_ms": 2.0, "link.jitter_ms": 1.0})]:
        for impulse in impulses:
            alone, learned = (survived(choice, impulse, seeds, link) for choice in (springs, policy))
            print(f"{words}, push of {impulse} N·s: springs and dampers survive {alone:4.0%}, the policy {learned:4.0%}", flush=True)


def serve(policy, name=None):
    """Answers the readings of the session of this name, or of the one that the environment names, until the plant's goodbye."""
    with biped.attach(name) as session:
        controller = Controller(session.scene, policy)
        for _ in session:
            if session.begins:
                controller.reset()
            session.write(controller.tick(session.angles))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policy", help="a file of learn_push.py")
    parser.add_argument("--session", help="name of a running session; by default the one that the environment names")
    parser.add_argument("--compare", action="store_true", help="simulate pushes instead, with the policy and without it")
    arguments = parser.parse_args()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: sys.exit(130))
    try:
        chosen = load(arguments.policy)
        compare(chosen) if arguments.compare else serve(chosen, arguments.session)
    except (biped.Error, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(getattr(error, "exit_code", 2))
