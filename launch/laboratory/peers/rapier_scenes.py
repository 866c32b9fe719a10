"""rapier3d-f64, by the program in `rapier/`: articulations in reduced coordinates, servos as joint motors.

Time is CPU time of the thread over the scene's first steps, taken in that program.
"""

import json
import os
import subprocess
from pathlib import Path
from xml.etree import ElementTree

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
        links = _biped(scene) if scene.body is None else [_body(scene)]
        feet = [i for i, link in enumerate(links) if link.pop("name", "") in s.FEET]
        watch = [0] if scene.body else feet if scene.contact else []
        keys = ("friction", "contact", "stiffness", "damping")
        problem = {key: getattr(scene, key) for key in keys}
        problem |= {"gravity": list(scene.gravity_vector), "tip": (scene.body and scene.body.radius) or s.TIP}
        self.problem = json.dumps(problem | {"links": links, "watch": watch})
        self.places = slice(None) if len(watch) < 2 else [0, 1, 2, 7, 8, 9]

    def reset(self):
        """Nothing: every run begins at the start."""

    def seconds(self, steps):
        """CPU time of a step."""
        return float(self._run("time", steps, 1))

    def trace(self, steps, stride):
        """Rows as `metrics` wants them."""
        rows = np.array([line.split() for line in self._run("trace", steps, stride).splitlines()], dtype=float)
        return rows[:, self.places]

    def _run(self, mode, steps, stride):
        command = [PROGRAM, mode, repr(self.dt), str(steps), str(stride)]
        result = subprocess.run(command, input=self.problem, capture_output=True, text=True)
        if result.returncode:
            raise RuntimeError(result.stderr.strip().splitlines()[-1] if result.stderr else f"exit {result.returncode}")
        return result.stdout


def _link(mass, inertia, position, quaternion, velocity, spin, **more):
    own = dict(mass=mass, inertia=inertia, position=position, quaternion=quaternion, velocity=velocity, spin=spin)
    return dict(com=(0, 0, 0), joint=None, box_at=(0, 0, 0), box_size=None, tips=()) | own | more


def _body(scene):
    body, (x, y, z) = scene.body, scene.position
    if body.tips and not body.radius:
        z += s.TIP  # a sphere with its middle in the plane would be pushed down
    state = ((x, y, z), scene.quaternion, scene.velocity, scene.spin)
    return _link(body.mass, body.inertia, *state, box_size=body.box or None, tips=body.tips)


def _biped(scene):
    """Links with their poses and velocities, from the joint angles and rates."""
    urdf = ElementTree.parse(s.BIPED_URDF)
    joints = {joint.find("child").get("link"): joint for joint in urdf.iter("joint")}
    names = [link.get("name") for link in urdf.iter("link")]
    motion = {names[0]: (np.eye(3), np.array(scene.position), np.array(scene.velocity), np.array(scene.spin))}
    links = []
    for link in urdf.iter("link"):
        name, inertial, collision = link.get("name"), link.find("inertial"), link.find("collision")
        com = _numbers(inertial.find("origin").get("xyz"))
        more = {"name": name, "com": com.tolist()}
        if name in joints:
            joint = joints[name]
            parent = joint.find("parent").get("link")
            anchor, axis = _numbers(joint.find("origin").get("xyz")), _numbers(joint.find("axis").get("xyz"))
            i = s.JOINTS.index(joint.get("name"))
            turn, place, velocity, spin = motion[parent]
            arm = turn @ anchor
            rotated = turn @ _rotation(axis, scene.joints[i])
            motion[name] = (
                rotated,
                place + arm,
                velocity + np.cross(spin, arm),
                spin + turn @ axis * scene.rates[i],
            )
            hinge = {"parent": names.index(parent), "anchor": anchor.tolist(), "axis": axis.tolist()}
            more["joint"] = hinge | {"angle": scene.joints[i], "rate": scene.rates[i]}
        turn, place, velocity, spin = motion[name]
        if collision is not None:
            more["box_at"] = _numbers(collision.find("origin").get("xyz")).tolist()
            more["box_size"] = _numbers(collision.find("geometry/box").get("size")).tolist()
        inertia = [float(inertial.find("inertia").get(key)) for key in ("ixx", "iyy", "izz")]
        velocity = velocity + np.cross(spin, turn @ com)
        state = (place.tolist(), _quaternion(turn), velocity.tolist(), spin.tolist())
        links.append(_link(float(inertial.find("mass").get("value")), inertia, *state, **more))
    return links


def _numbers(text):
    """A vector as URDF writes it."""
    return np.array(text.split(), dtype=float)


def _rotation(axis, angle):
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _quaternion(turn):
    """Of a turn by less than half, w first."""
    w = np.sqrt(1 + np.trace(turn)) / 2
    axis = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    return [w, *(part / (4 * w) for part in axis)]
