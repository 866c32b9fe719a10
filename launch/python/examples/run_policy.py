"""Runs a policy of learn_push.py as the controller of a session, in lockstep or in real time.

    biped run stand --controller "python3 run_policy.py push.txt"
    python run_policy.py push.txt --compare
"""

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
    """The policy of a file of learn_push.py."""
    return policy(np.loadtxt(file))


class Controller:
    """A control period at a time, what the environment does: an action each 20 ms, springs and dampers each millisecond."""

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
    """Prints what the policy survives on seeds that it has not met, and what springs and dampers alone survive."""
    for words, link in [("commands at once", {}), ("commands 2 to 3 ms late", {"link.delay_ms": 2.0, "link.jitter_ms": 1.0})]:
        for impulse in impulses:
            alone, learned = (survived(choice, impulse, seeds, link) for choice in (springs, policy))
            print(f"{words}, push of {impulse} N·s: springs and dampers survive {alone:4.0%}, the policy {learned:4.0%}", flush=True)


def serve(policy):
    """Answers the readings of the session until the plant's goodbye."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))
    try:
        with biped.attach() as session:
            controller = Controller(session.scene, policy)
            for _ in session:
                if session.begins:
                    controller.reset()
                session.write(controller.tick(session.angles))
    except biped.Error as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    (compare if "--compare" in sys.argv else serve)(load(sys.argv[1]))
