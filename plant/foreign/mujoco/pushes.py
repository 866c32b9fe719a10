"""`biped study pushes` with MuJoCo as the plant: the greatest impulse [N·s] up to which the walking robot survives every smaller one,
least and mean over the phases of a period. It uses all processors.

    python3 -m pip install . mujoco   # in a clone of biped: its Python package; before Python 3.11 also tomli
    python3 plant/foreign/mujoco/pushes.py --biped target/release/biped --soft --set plant.friction=0.2
"""

import argparse
import copy
import multiprocessing
import subprocess
import sys
from math import cos, radians, sqrt

import biped
import link
import mujoco
import numpy as np
from plant import Plant

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

BEGIN, AFTER = 4.5, 6.0  # first phase; time after the push for which the robot must not fall [s]
GROWTH, GREATEST, DURATION = 0.5, 12.0, 0.05  # step and limit of the impulse [N·s], duration of a push [s]
TRUNK, COM, TILT = 0.6, 0.5, cos(radians(45.0))  # a fall, as `biped run` defines it: parts of the first heights, and tilt
HALF = sqrt(0.5)
DIRECTIONS = {"forward": (1, 0, 0), "backward": (-1, 0, 0), "left": (0, 1, 0), "right": (0, -1, 0)}
DIRECTIONS |= {"front": (HALF, HALF, 0), "rear": (-HALF, -HALF, 0)}


class Walk:
    """MuJoCo's robot and the controller of biped, in one process."""

    def __init__(self, program, settings, soft):
        scene = biped.Scene("walk", *settings)
        self.scene = tomllib.loads(scene.text)
        changes = [part for setting in settings for part in ("--set", setting)]
        mjcf = subprocess.run([program, "export", "mjcf", "walk", *changes], stdout=subprocess.PIPE, text=True, check=True).stdout
        self.plant, self.controller = Plant(self.scene, mjcf, soft), biped.Controller(scene)
        self.data = self.plant.data
        self.start = self.posture()

    def posture(self):
        """Heights of the trunk and of the centre of mass [m], and the cosine of the trunk's tilt."""
        base = self.plant.base
        return self.data.xipos[base, 2], self.data.subtree_com[base, 2], self.data.xmat[base, 8]

    def place(self):
        """Position of the centre of mass in the direction of the walk [m]."""
        return float(self.data.subtree_com[self.plant.base, 0])

    def until(self, time):
        """Walks until a time [s]. Returns whether the robot is still up."""
        while self.data.time < time - 0.5 * self.plant.period:
            try:
                self.plant.advance(self.controller.tick(self.plant.counts()))
            except (biped.ControllerError, SystemExit):
                return False
            if np.any(np.less(self.posture(), (TRUNK * self.start[0], COM * self.start[1], TILT))):
                return False
        return True


def begin(program, settings, soft, shares):
    """Walks through all phases, and keeps the state at each. Every process does so once."""
    global walk, states
    walk, states = Walk(program, settings, soft), {}
    for share in shares:
        walk.until(BEGIN + share * walk.scene["controller"]["period"])
        states[share] = copy.copy(walk.data), walk.controller.snapshot()


def survived(case):
    """The impulse up to which the robot does not fall."""
    direction, share = case
    data, snapshot = states[share]
    for k in range(round(GREATEST / GROWTH)):
        mujoco.mj_copyData(walk.data, walk.plant.model, data)
        walk.controller.restore(snapshot)
        walk.plant.push((k + 1) * GROWTH * np.array(DIRECTIONS[direction]), walk.data.time, DURATION)
        if not walk.until(walk.data.time + AFTER):
            return k * GROWTH
    return GREATEST


def main():
    parser = argparse.ArgumentParser(description="Pushes the robot that walks in MuJoCo.")
    parser.add_argument("--biped", default="biped", metavar="PROGRAM", help="the program, which exports the robot")
    parser.add_argument("--soft", action="store_true", help="MuJoCo's own contacts, as of plant.py --soft")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="replace a value of the scene; repeatable")
    parser.add_argument("--phases", type=int, default=12, help="number of phases of a period; 12 by default")
    parser.add_argument("--offset", type=float, default=0.0, help="shift of all phases, as a share of the interval of two")
    asked = parser.parse_args()
    if asked.phases < 1 or not 0.0 <= asked.offset < 1.0:
        parser.error("--phases must be 1 or more, and --offset at least 0 and less than 1")
    shares = [(k + asked.offset) / asked.phases for k in range(asked.phases)]
    arguments = asked.biped, asked.set, asked.soft
    alone = Walk(*arguments)
    first = alone.place()
    if not alone.until(14.0):
        link.fail(1, f"the robot falls without a push, after {alone.data.time:.3f} s")
    print(f"unpushed: {alone.place() - first:.3f} m in 14 s\n", flush=True)
    print("| direction | least | mean | by phase |\n|---|---|---|---|")
    with multiprocessing.Pool(initializer=begin, initargs=(*arguments, shares)) as pool:
        for direction in DIRECTIONS:
            impulses = pool.map(survived, [(direction, share) for share in shares], chunksize=1)
            least, mean = min(impulses), sum(impulses) / len(impulses)
            print(f"| {direction} | {least:.1f} | {mean:.2f} | {' '.join(f'{impulse:.1f}' for impulse in impulses)} |", flush=True)


if __name__ == "__main__":
    try:
        main()
    except biped.Error as error:
        link.fail(error.exit_code, error)
    except FileNotFoundError as error:
        link.fail(2, f"there is no program {error.filename}: name it by --biped, such as --biped target/release/biped")
    except subprocess.CalledProcessError as error:
        link.fail(error.returncode, "biped could not export the robot")
    except KeyboardInterrupt:
        sys.exit(130)
