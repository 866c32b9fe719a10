"""Speed of the package compared with the same work in Rust, alternately: python3 -m biped.benchmark [PROGRAM]

PROGRAM is the path of the program `biped`. With it, the loop over shared memory is measured too. Only ratios are of use on a busy machine.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import biped
from biped._biped import rust_loop

ROUNDS = 7  # the best of them counts
PLANTS, PERIODS = 64, 200  # of a batch


def in_turns(*subjects: Callable[[], float]) -> list[float]:
    """The least time of each subject [s]."""
    times = [[subject() for subject in subjects] for _ in range(ROUNDS)]
    return [min(column) for column in zip(*times)]


def timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def single() -> None:
    """One plant: eight torques in and an observation out in each period."""
    scene = biped.Scene("walk")
    plant, controller = biped.Plant(scene), biped.Controller(scene)
    torques = np.zeros((round(scene.duration * scene.rate), 8))
    for row in torques:
        row[:] = controller.tick(plant.counts)
        plant.step(row)
    walked = plant.hash

    def given() -> None:
        step = plant.step
        for row in torques:
            step(row)

    def closed() -> None:
        while not plant.ended:
            plant.step(controller.tick(plant.counts))

    def here(loop: Callable[[], None]) -> float:
        plant.reset()
        controller.reset()
        spent = timed(loop)
        assert plant.hash == walked, "the loops do not compute the same"
        return spent

    rows = [("given torques", given, torques), ("with the controller", closed, None)]
    for name, loop, given_torques in rows:
        python, rust = in_turns(lambda: here(loop), lambda: rust_loop(scene, given_torques)[1])
        print(f"{name}: Python {len(torques) / python:,.0f} periods/s, Rust {len(torques) / rust:,.0f}, ratio {rust / python:.2f}")


def batch() -> None:
    """Many plants, one period a call: on all cores and on one, and in a loop over the plants."""

    def run(way: str) -> float:
        command = [sys.executable, "-m", "biped.benchmark", way]
        return float(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)

    every, one, loop = in_turns(lambda: run("every core"), lambda: run("one core"), lambda: run("loop"))
    print(
        f"{PLANTS} plants: {PLANTS * PERIODS / every:,.0f} periods/s on {os.cpu_count()} cores, {one / every:.2f} times one core, "
        f"{loop / every:.2f} times a loop over the plants"
    )


def seconds(way: str) -> float:
    """Time of the batch in this process [s]: "every core", "one core", or a "loop" instead."""
    if way != "every core":
        os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])  # before the first step, which starts a thread for each further core
    plants = [biped.Plant(biped.Scene("walk")) for _ in range(PLANTS)]
    together, torques = biped.PlantBatch(plants), np.zeros((PLANTS, 8))

    def periods() -> None:
        for _ in range(PERIODS):
            if way != "loop":
                together.step(torques)
                continue
            for plant, row in zip(plants, torques):
                plant.step(row)

    def fresh() -> float:
        for plant in plants:
            plant.reset()
        return timed(periods)

    return min(fresh() for _ in range(3))


def wire(program: str) -> None:
    """The controller in a process of its own, in lockstep: the one of this module, and that of the program."""

    def run(*controller: str) -> float:
        with tempfile.TemporaryDirectory() as out:
            subprocess.run([program, "run", "walk", "--quiet", "--out", out, *controller], check=True, stdout=subprocess.DEVNULL)
            summary = json.loads(Path(out, "summary.json").read_text())
            return float(summary["loop_s"]) / (summary["duration_s"] * biped.Scene("walk").rate)

    answering = f"{sys.executable} -m biped.benchmark answer"
    python, rust = in_turns(lambda: run("--controller", answering), run)
    print(f"over shared memory: Python {1 / python:,.0f} periods/s, Rust {1 / rust:,.0f}, ratio {rust / python:.2f}")


def answer() -> None:
    """The controller of a session as a loop in Python."""
    with biped.attach() as session:
        controller = biped.Controller(session.scene)
        for counts in session:
            session.write(controller.tick(counts))


if __name__ == "__main__":
    if sys.argv[1:] == ["answer"]:
        answer()
    elif sys.argv[1:2] in (["every core"], ["one core"], ["loop"]):
        print(seconds(sys.argv[1]))
    else:
        single()
        batch()
        for path in sys.argv[1:2]:
            wire(path)
