"""Runs one engine over scenes, methods and step lengths, and appends rows to a CSV as they come.

    python measure.py MODULE FILE [--from JOB] [--core N] [--scenes NAME ...] [--quick]     (columns: see run.py)

Prints `job N: ...` before each job, so that after a crash the caller knows where to go on.
"""

import argparse
import csv
import importlib
import os
import statistics
import time

import numpy as np

import metrics
from scenes import SCENES

STEP_SCENES = {"free": 1000, "slide": 400, "stand0": 1000}  # steps at 1 ms; the cube slides for 407
QUICK_SCENES, QUICK_DTS = ["free", "slide", "stand0"], [2e-3, 1e-3]
BUDGET, FINE_BUDGET = 6.0, 1.0  # CPU seconds; a run that would take longer is left out; with h below 1 ms
TIMING = 0.3  # CPU seconds after which a step is not timed again


def main():
    """See above."""
    arguments = argparse.ArgumentParser()
    arguments.add_argument("module")
    arguments.add_argument("file")
    arguments.add_argument("--from", type=int, default=0, dest="first")
    arguments.add_argument("--core", type=int)
    arguments.add_argument("--scenes", nargs="*", default=list(SCENES))
    arguments.add_argument("--quick", action="store_true")
    arguments = arguments.parse_args()
    if arguments.core is not None:
        os.sched_setaffinity(0, {arguments.core})
    engine = importlib.import_module(arguments.module)
    print(f"version {engine.ENGINE} {engine.VERSION}", flush=True)
    with open(arguments.file, "a", newline="") as file:
        writer = csv.writer(file)
        for number, (view, scene, method, dt) in enumerate(jobs(engine, arguments.scenes, arguments.quick)):
            if number < arguments.first:
                continue
            print(f"job {number}: {view} {scene.name} {engine.ENGINE} {method} dt {dt:g}", flush=True)
            try:
                rows = list((step_rows if view == "step" else precision_rows)(engine, scene, method, dt))
            except Exception as error:  # an engine's own complaint; the next job may do
                print(f"left out: {view} {scene.name} {method} dt {dt:g}: {type(error).__name__}: {error}", flush=True)
                continue
            for metric, error, us in rows:
                figures = [f"{error:.3g}" if metric else "", f"{us * 1e-6 / dt:.3g}", f"{us:.3g}"]
                writer.writerow([view, scene.name, engine.ENGINE, method, f"{dt:g}", metric, *figures])
            file.flush()


def jobs(engine, chosen, quick):
    """(view, scene, method, dt), always in the same order."""
    methods, names = engine.METHODS, getattr(engine, "SCENES", SCENES)
    if quick:
        methods, names = engine.QUICK, QUICK_SCENES
    for method in methods:
        for name in STEP_SCENES:
            if name in names:
                yield "step", SCENES[name], method, 1e-3
    for method in methods:
        for name in (name for name in names if name in chosen):
            for dt in QUICK_DTS if quick else engine.DTS:
                yield "precision", SCENES[name], method, dt


def step_rows(engine, scene, method, dt):
    """Time of a step alone."""
    yield "", None, seconds_per_step(engine.Simulation(scene, method, dt), STEP_SCENES[scene.name], 15) * 1e6


def precision_rows(engine, scene, method, dt):
    """Every metric of a run, with the time of a step over at most its first 2000."""
    simulation, steps = engine.Simulation(scene, method, dt), scene.steps(dt)
    cost = seconds_per_step(simulation, min(steps, 2000), 3 if steps > 100 else 15)
    if cost * steps > (BUDGET if dt >= 1e-3 else FINE_BUDGET):
        print(f"left out: {scene.name} {method} dt {dt:g}: would take {cost * steps:.0f} s", flush=True)
        return
    with np.errstate(all="ignore"):
        found = metrics.measure(scene, simulation.trace(steps, metrics.stride(scene, steps)), dt)
    for metric, error in found.items():
        yield metric, error, cost * 1e6


def seconds_per_step(simulation, steps, repeats):
    """Median time of one step over the scene's first `steps`: CPU time of this thread, or as the engine's file says."""
    times, begun = [], time.thread_time()
    while len(times) < repeats and (time.thread_time() - begun < TIMING or not times):
        simulation.reset()
        if hasattr(simulation, "seconds"):
            times.append(simulation.seconds(steps))
        else:
            start = time.thread_time()
            simulation.run(steps)
            times.append((time.thread_time() - start) / steps)
    return statistics.median(times)


if __name__ == "__main__":
    main()
