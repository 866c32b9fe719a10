"""The comparison scenes as `biped chart --peers` writes them into `scenes.toml`, read for the engines' files.

World frame W: x forward (downhill), y left, z up. The ground is the plane z = 0; a slope is a tilt of gravity. Units are SI. The program
has resolved each scene: every default is written out, the origin of the base is its centre of mass, and joint axes point along
positive axes.
"""

import tomllib
from dataclasses import dataclass
from math import cos, radians, sin
from pathlib import Path

import numpy as np

TIP = 1e-5  # radius of the sphere that stands for a contact point [m]; rolling over it moves the answers by less than 1e-5


@dataclass(frozen=True)
class Joint:
    """A hinge, with its state at the start."""

    name: str
    parent: int  # index of a body
    anchor: list  # in the parent's frame
    axis: list
    stiffness: float  # torque = stiffness (rest - angle) - damping rate
    damping: float
    rest: float
    angle: float
    rate: float


@dataclass(frozen=True)
class Body:
    """A rigid body; its frame sits in its joint."""

    name: str
    mass: float
    com: list
    inertia: list  # principal moments about the centre of mass
    points: list  # that may touch the ground; of a ball its centre
    radius: float  # of balls about the points; 0: they are points
    box: list  # side lengths, about the centre of mass, if the points are its corners; otherwise empty
    joint: Joint | None

    def urdf(self, bodies):
        """Its link and joint."""
        xx, yy, zz = self.inertia
        moments = f'ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" ixy="0" ixz="0" iyz="0"'
        text = f'<link name="{self.name}"><inertial><origin xyz="{_numbers(self.com)}"/><mass value="{self.mass!r}"/>'
        text += f"<inertia {moments}/></inertial>"
        collision = '<collision><origin xyz="{}"/><geometry>{}</geometry></collision>'
        if self.box:
            text += collision.format(_numbers(self.com), f'<box size="{_numbers(self.box)}"/>')
        else:
            ball = f'<sphere radius="{self.radius or TIP!r}"/>'
            text += "".join(collision.format(_numbers(point), ball) for point in self.points)
        text += "</link>"
        if joint := self.joint:
            text += f'<joint name="{joint.name}" type="revolute"><parent link="{bodies[joint.parent].name}"/>'
            text += f'<child link="{self.name}"/><origin xyz="{_numbers(joint.anchor)}"/><axis xyz="{_numbers(joint.axis)}"/>'
            text += '<limit lower="-100" upper="100" effort="1e9" velocity="1e9"/></joint>'
        return text


@dataclass(frozen=True)
class Scene:
    """One scene."""

    name: str
    duration: float
    bodies: list  # parents before children; the first is the base
    position: list  # of the base's origin
    quaternion: tuple  # attitude of the base, w first
    velocity: list  # of the base's origin, in W
    spin: list  # angular velocity of the base, in W
    friction: float
    gravity_vector: np.ndarray  # in W
    contact: bool  # False: weightless, in flight
    samples: int  # rows of a trace after the first; 0: one for each step
    timed_steps: int  # at 1 ms, whose time is the cost of a step; 0: not timed for itself
    errors: bool  # whether its errors are measured

    @property
    def joints(self):
        """All joints."""
        return [body.joint for body in self.bodies if body.joint]

    @property
    def touching(self):
        """Bodies that may touch the ground, whose poses make a row of a trace."""
        return [body for body in self.bodies if body.points]

    @property
    def urdf(self):
        """The robot as URDF."""
        return f'<robot name="robot">{"".join(body.urdf(self.bodies) for body in self.bodies)}</robot>'

    def steps(self, dt):
        """Number of steps of the whole scene."""
        return round(self.duration / dt)

    def stride(self, dt):
        """Steps between two rows of a trace."""
        return max(self.steps(dt) // self.samples, 1) if self.samples else 1


def read(file):
    """The scenes of a `scenes.toml`, by name."""
    scenes = tomllib.loads(Path(file).read_text())["scenes"]
    return {scene["name"]: _scene(scene, **scene["scene"]) for scene in scenes}


def _scene(given, plant, initial, bodies, duration, **_):
    slope = radians(plant["incline_deg"])
    return Scene(
        name=given["name"],
        duration=duration,
        bodies=_tree(bodies, initial),
        position=initial["position"],
        quaternion=_quaternion(*map(radians, initial["orientation_deg"])),
        velocity=initial["velocity"],
        spin=initial["angular_velocity"],
        friction=plant["friction"],
        gravity_vector=plant["gravity"] * np.array([sin(slope), 0.0, -cos(slope)]),
        contact=plant["gravity"] != 0.0,
        **{key: given[key] for key in ("samples", "timed_steps", "errors")},
    )


def _tree(bodies, initial):
    """Bodies in depth-first order, with the states of their joints, which `initial` has in the order of the file."""
    order, carried = [], [body["name"] for body in bodies if "joint" in body]
    states = {name: [initial[key][i] if initial[key] else 0.0 for key in ("joints", "joint_rates")] for i, name in enumerate(carried)}

    def add(body, parent):
        joint = body.get("joint")
        hinge = joint and Joint(
            body["name"].replace(" ", "_") + "_joint",
            parent,
            joint["at"],
            joint["axis"],
            *(joint[key] for key in ("stiffness", "damping", "rest")),
            *states[body["name"]],
        )
        index = len(order)
        order.append(_body(body, hinge))
        for child in bodies:
            if child.get("joint", {}).get("parent") == body["name"]:
                add(child, index)

    add(next(body for body in bodies if "joint" not in body), None)
    return order


def _body(given, joint):
    points, spheres = given.get("contacts", []), given.get("spheres", [])
    corners = [np.abs(np.subtract(point, given["com"])) - np.divide(given["size"], 2) for point in points]
    return Body(
        name=given["name"].replace(" ", "_"),
        mass=given["mass"],
        com=given["com"],
        inertia=given["inertia"],
        points=points + [ball["at"] for ball in spheres],
        radius=spheres[0]["radius"] if spheres else 0.0,
        box=given["size"] if points and np.abs(corners).max() < 1e-12 else [],
        joint=joint,
    )


def _quaternion(roll, pitch, yaw):
    """Attitude after yaw, then pitch, then roll, w first."""
    (a, b), (c, d), (e, f) = ((cos(angle / 2), sin(angle / 2)) for angle in (roll, pitch, yaw))
    return (a * c * e + b * d * f, b * c * e - a * d * f, a * d * e + b * c * f, a * c * f - b * d * e)


def _numbers(values):
    return " ".join(map(repr, values))
