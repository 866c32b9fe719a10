"""Runs one engine over scenes, methods and step lengths, and appends a JSON line for each run as it ends.

    python measure.py MODULE SCENES.toml RUNS.jsonl [--from JOB] [--core N] [--quick]

A line has view, scene, engine, method, dt and us_per_step; with view `precision` also `stride` and `trace`, a file beside RUNS.jsonl that
holds the rows of `simulation.py` as 64-bit floats, one row for every `stride` steps.

Prints `job N: ...` before each job, so that after a crash the caller knows the job to continue with.
"""

import argparse
import importlib
import json
import os
import statistics
import time
from pathlib import Path

import numpy as np

import scenes

QUICK_DTS = [2e-3, 1e-3]
BUDGET, FINE_BUDGET = 6.0, 1.0  # CPU seconds; a run that would take longer is left out; with h below 1 ms
TIMING = 0.3  # CPU seconds after which a step is not timed again


def main():
    """See above."""
    arguments = argparse.ArgumentParser()
    arguments.add_argument("module")
    arguments.add_argument("scenes", type=Path)
    arguments.add_argument("runs", type=Path)
    arguments.add_argument("--from", type=int, default=0, dest="first")
    arguments.add_argument("--core", type=int)
    arguments.add_argument("--quick", action="store_true")
    arguments = arguments.parse_args()
    if arguments.core is not None:
        os.sched_setaffinity(0, {arguments.core})
    engine = importlib.import_module(arguments.module)
    print(f"version {engine.ENGINE} {engine.VERSION}", flush=True)
    with arguments.runs.open("a") as file:
        for number, (view, scene, method, dt) in enumerate(jobs(engine, scenes.read(arguments.scenes), arguments.quick)):
            if number < arguments.first:
                continue
            print(f"job {number}: {view} {scene.name} {engine.ENGINE} {method} dt {dt:g}", flush=True)
            run = {"view": view, "scene": scene.name, "engine": engine.ENGINE, "method": method, "dt": dt}
            try:
                if view == "step":
                    simulation = engine.Simulation(scene, method, dt)
                    run["us_per_step"] = 1e6 * seconds_per_step(simulation, scene.timed_steps, 15)
                else:
                    run |= precision(engine, scene, method, dt, arguments.runs.with_name(f"{arguments.runs.stem}-{number}.f64"))
            except Exception as error:  # an engine's own error; the next job may succeed
                print(f"left out: {view} {scene.name} {method} dt {dt:g}: {type(error).__name__}: {error}", flush=True)
                continue
            file.write(json.dumps(run) + "\n")
            file.flush()


def jobs(engine, given, quick):
    """(view, scene, method, dt), always in the same order."""
    methods = engine.QUICK if quick else engine.METHODS
    single = getattr(engine, "SINGLE_BODIES", False)
    able = [scene for scene in given.values() if len(scene.bodies) == 1 or not single]
    for method in methods:
        for scene in able:
            if scene.timed_steps:
                yield "step", scene, method, 1e-3
    for method in methods:
        for scene in able:
            if scene.errors:
                for dt in QUICK_DTS if quick else engine.DTS:
                    yield "precision", scene, method, dt


def precision(engine, scene, method, dt, trace):
    """A run: its trace, and the time of a step over at most its first 2000."""
    simulation, steps, stride = engine.Simulation(scene, method, dt), scene.steps(dt), scene.stride(dt)
    cost = seconds_per_step(simulation, min(steps, 2000), 3 if steps > 100 else 15)
    if cost * steps > (BUDGET if dt >= 1e-3 else FINE_BUDGET):
        raise TimeoutError(f"it would take {cost * steps:.0f} s")
    with np.errstate(all="ignore"):
        np.asarray(simulation.trace(steps, stride), dtype="<f8").tofile(trace)
    return {"us_per_step": 1e6 * cost, "stride": stride, "trace": trace.name}


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
