"""Time of MuJoCo's step for each MJCF file: `python3 growth.py FILE ...` prints `us NUMBER` for each.

Newton's method, elliptic cones, Euler, from the keyframe `start`; the least thread time of several runs of 100 steps.
"""

import subprocess
import sys
import time
from pathlib import Path

STEPS, BUDGET, LEAST = 100, 0.1, 5


def main():
    """Runs itself again in the virtual environment that has MuJoCo."""
    if sys.argv[1] == "--inside":
        for file in sys.argv[2:]:
            print(f"us {microseconds(file):.4f}", flush=True)
        return
    import os

    import run

    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    python = run.environment(cache / "biped-peers")
    if python and run.installed(python, "mujoco"):
        subprocess.run([python, __file__, "--inside", *sys.argv[1:]], check=True)


def microseconds(file):
    """Time of one step."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(file)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.opt.cone, model.opt.solver = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_NEWTON
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= int(flags.mjDSBL_SENSOR | flags.mjDSBL_ISLAND | flags.mjDSBL_AUTORESET)
    data = mujoco.MjData(model)
    times = []
    while len(times) < LEAST or sum(times) < BUDGET:
        mujoco.mj_resetDataKeyframe(model, data, 0)
        start = time.thread_time()
        mujoco.mj_step(model, data, STEPS)
        times.append(time.thread_time() - start)
    return 1e6 * min(times) / STEPS


if __name__ == "__main__":
    main()
