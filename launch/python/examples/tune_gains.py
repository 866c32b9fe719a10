"""Tunes springs, dampers and posture of a standing robot by CMA-ES, for the greatest push that it survives.

    pip install 'biped[gym]' cma && python tune_gains.py [GENERATIONS]
"""

import sys

import biped
import cma
import numpy as np
from biped.gym import Loop

DIRECTIONS = {"forward": np.array([1, 0, 0]), "backward": np.array([-1, 0, 0]), "left": np.array([0, 1, 0])}
# Logarithms of stiffness and damping of ankle roll, ankle pitch, knee and hip; their angles from the initial ones [0.25 rad]
START = np.concatenate([np.log(np.repeat([1000.0, 40.0], 4)), np.zeros(4)])
FAST = {"plant.law": "Sweep(5)"}  # a few sweeps of Gauss-Seidel over the contacts: for the search, not for the result


def upright(candidates, impulses, settings, seconds=2.4):
    """Share of the time for which a robot stands, for each candidate, direction and impulse: shape (candidates, 3, impulses)."""
    scene = biped.Scene("stand", {**settings, "duration": seconds})
    rows, directions, sizes = np.indices((len(candidates), len(DIRECTIONS), len(impulses))).reshape(3, -1)
    batch = biped.PlantBatch([biped.Plant(scene) for _ in rows])
    left = np.array(candidates)[rows].reshape(-1, 3, 4)
    stiffness, damping, angles = np.concatenate([left, left[:, :, ::-1]], axis=2).swapaxes(0, 1)  # the right leg like the left
    loop = Loop(scene, len(rows), stiffness=np.exp(stiffness), damping=np.exp(damping))
    targets = loop.start + 0.25 * angles * np.repeat([1.0, -1.0, 1.0], [4, 3, 1])
    loop.begin(batch.angles)
    stands = np.zeros(len(rows))
    for part in range(24):
        for plant, direction, size in zip(batch.plants, directions, sizes) if part == 4 else []:
            plant.push(impulses[size] * list(DIRECTIONS.values())[direction])
        for _ in range(round(seconds * scene.rate / 24)):
            batch.step(loop.spring(targets))
            loop.measure(batch.angles)
        stands += [not plant.fallen for plant in batch.plants]
    return (stands / 24).reshape(len(candidates), len(DIRECTIONS), -1)


def greatest(candidate):
    """The greatest push up to which the robot always stands in each direction, in steps of 0.1 N·s, by the scene's own law [N·s]."""
    stands = upright([candidate], np.arange(20, 101) * 0.1, {})[0] == 1.0
    return {name: round(1.9 + 0.1 * int(np.cumprod(row).sum()), 1) for name, row in zip(DIRECTIONS, stands)}


def tune(generations, seed=1, start=START, impulses=np.arange(5.5, 7.5, 0.25)):
    """The candidate that does best in its worst direction."""
    search = cma.CMAEvolutionStrategy(start, 0.3, {"seed": seed, "popsize": 8, "verbose": -9})
    for _ in range(generations):
        candidates = search.ask()
        search.tell(candidates, list(-upright(candidates, impulses, FAST).mean(axis=2).min(axis=1)))
    return search.result.xbest


if __name__ == "__main__":
    best = tune(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
    for name, candidate in [("stand.py", START), ("tuned", best)]:
        print(f"{name}: stiffness and damping {np.exp(candidate[:8]).round()}, angles {(candidate[8:] / 4).round(2)} rad")
        print(f"{name}: greatest push {greatest(candidate)} N·s", flush=True)
