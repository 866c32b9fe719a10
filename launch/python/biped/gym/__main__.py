"""``python3 -m biped.gym`` prints the speed of the environments: robots in turn in one process, and robots that step together."""

from __future__ import annotations

import time
from typing import Any

import gymnasium
import numpy as np

from . import TASKS

ROBOTS, STEPS, TURNS = 16, 20, 5


def _seconds(envs: Any) -> float:
    actions = np.zeros(envs.action_space.shape, np.float32)
    begin = time.perf_counter()
    for _ in range(STEPS):
        envs.step(actions)
    return time.perf_counter() - begin


def main() -> None:
    for task, kind in TASKS.items():
        ways = {mode: gymnasium.make_vec(f"biped/{task}-v0", ROBOTS, vectorization_mode=mode) for mode in ["sync", "vector_entry_point"]}
        for envs in ways.values():
            envs.reset(seed=1)
        best = {mode: float("inf") for mode in ways}
        for _ in range(TURNS):
            for mode, envs in ways.items():
                best[mode] = min(best[mode], _seconds(envs))
        periods = kind.periods * ROBOTS * STEPS
        alone, together = (periods / best[mode] for mode in ways)
        print(f"{task:6} {ROBOTS} robots: {alone:8.0f} control periods/s in turn, {together:8.0f} together, {together / alone:.2f} x")


if __name__ == "__main__":
    main()
