"""rapier3d-f64, by the program in `rapier/`: articulations in reduced coordinates, servos as joint motors.

Time is CPU time of the thread over the scene's first steps, taken in that program.
"""

import json
import os
import subprocess
from pathlib import Path

import numpy as np

import scenes as s

ENGINE = "rapier3d-f64"
VERSION = "0.36.0"  # as in rapier/Cargo.toml
DTS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4]
METHODS = ["default"]
PROGRAM = Path(os.environ["RAPIER_SCENES"])  # built by run.py


class Simulation:
    """One scene."""

    def __init__(self, scene, method, dt):
        self.dt = dt
        self.problem = json.dumps({
            "friction": scene.friction,
            "contact": scene.contact,
            "gravity": list(scene.gravity_vector),
            "links": _links(scene),
            "watch": [i for i, body in enumerate(scene.bodies) if body.points and scene.contact],
        })

    def reset(self):
        """Does nothing: every run starts at the beginning."""

    def seconds(self, steps):
        """CPU time of a step."""
        return float(self._run("time", steps, 1))

    def trace(self, steps, stride):
        """Rows as simulation.py has them."""
        return np.array([line.split() for line in self._run("trace", steps, stride).splitlines()], dtype=float)

    def _run(self, mode, steps, stride):
        command = [PROGRAM, mode, repr(self.dt), str(steps), str(stride)]
        result = subprocess.run(command, input=self.problem, capture_output=True, text=True)
        if result.returncode:
            raise RuntimeError(result.stderr.strip().splitlines()[-1] if result.stderr else f"exit {result.returncode}")
        return result.stdout


def _links(scene):
    """Bodies with their poses and velocities, from the joint angles and rates."""
    x, y, z = scene.position
    if not scene.bodies[0].box and len(scene.bodies) == 1 and not scene.bodies[0].radius:
        z += s.TIP  # a sphere whose centre lies in the plane would be pushed down
    w, *turn = scene.quaternion
    base = (_attitude(w, np.array(turn)), np.array((x, y, z)), np.array(scene.velocity), np.array(scene.spin))
    motion, links = [], []
    for body in scene.bodies:
        joint = body.joint
        if joint:
            turn, place, velocity, spin = motion[joint.parent]
            axis, arm = np.array(joint.axis), turn @ np.array(joint.anchor)
            turned = turn @ _rotation(axis, joint.angle)
            motion.append((turned, place + arm, velocity + np.cross(spin, arm), spin + turn @ axis * joint.rate))
        else:
            motion.append(base)
        turn, place, velocity, spin = motion[-1]
        links.append({
            "mass": body.mass,
            "com": body.com,
            "inertia": body.inertia,
            "position": place.tolist(),
            "quaternion": _quaternion(turn) if joint else scene.quaternion,
            "velocity": (velocity + np.cross(spin, turn @ np.array(body.com))).tolist(),
            "spin": spin.tolist(),
            "joint": joint and vars(joint),
            "box_size": body.box or None,
            "tips": [] if body.box else body.points,
            "tip": body.radius or s.TIP,
        })
    return links


def _attitude(w, axis):
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def _rotation(axis, angle):
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _quaternion(turn):
    """Quaternion of a rotation by less than half a turn, w first."""
    w = np.sqrt(1 + np.trace(turn)) / 2
    axis = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    return [w, *(part / (4 * w) for part in axis)]
