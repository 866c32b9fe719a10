"""Learns to stand under pushes: CMA-ES over the 64 weights of a policy that treats left and right alike. An evolution strategy, not a
policy gradient; docs/LEARNING.md says why.

    pip install 'biped[gym]' cma
    python learn_push.py [GENERATIONS] [FILE]

It writes the weights to FILE (push.txt), and prints the share of pushes survived, with the policy and without it.
"""

import sys

import cma
import numpy as np
import run_policy
from biped.gym import Push

# To learn, not to judge: a few sweeps of Gauss-Seidel over the contacts. With delayed commands, it learns what a slow link allows.
FAST = {"plant.law": "Sweep(5)", "link.delay_ms": 2.0, "link.jitter_ms": 1.0}
IMPULSES = np.repeat([4.0, 6.0, 6.5, 7.5], 3)  # [N·s]


def returns(candidates, seed, impulses=IMPULSES, seconds=2.4):
    """Mean return of each candidate in the environment biped/Push-v0, for pushes of these impulses in random directions."""
    task = Push(len(candidates) * len(impulses), duration=seconds, settings=FAST)
    directions = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(impulses))
    for robot in range(len(task.plants)):
        push = robot % len(impulses)
        impulse = impulses[push] * np.array([np.cos(directions[push]), np.sin(directions[push]), 0.0])
        task.reset(robot, np.random.default_rng([seed, push]), {"push": impulse, "time": 0.2})
    policies = [run_policy.policy(candidate) for candidate in candidates]
    total, stands = np.zeros(len(task.plants)), np.ones(len(task.plants), bool)
    for _ in range(task.length):
        observations = task.observation().reshape(len(candidates), len(impulses), -1)
        rewards, lost, _ = task.step(np.concatenate([policy(rows) for policy, rows in zip(policies, observations)]))
        stands &= ~lost
        total += rewards * stands
    return total.reshape(len(candidates), -1).mean(axis=1) / task.length


def learn(generations, seed=1, **options):
    """The weights at the center of the search after some generations. The first center is zero: springs and dampers alone."""
    search = cma.CMAEvolutionStrategy(np.zeros(64), 0.01, {"seed": seed, "popsize": 12, "verbose": -9})
    for generation in range(generations):
        candidates = search.ask()
        scores = returns(candidates, seed + generation, **options)
        search.tell(candidates, list(-scores))
        print(f"generation {generation + 1:3}: mean return {scores.mean():.3f}, best {scores.max():.3f}", flush=True)
    return search.result.xfavorite


if __name__ == "__main__":
    weights = learn(int(sys.argv[1]) if len(sys.argv) > 1 else 50)
    file = sys.argv[2] if len(sys.argv) > 2 else "push.txt"
    np.savetxt(file, weights.reshape(16, 4))
    run_policy.compare(run_policy.load(file))
