"""The twelve comparison scenes: bodies, initial states and exact answers, the same for every engine.

World frame: x forward (downhill), y left, z up; the ground is the plane z = 0 and a slope is a tilt of gravity. Nothing
is in flight or in the ground at the start, except the foot that drops. Units are SI. The biped is `biped8.xml` or
`biped8.urdf`: Table 1 of Fujimoto & Kawamura (1995), joints from hip to foot, left leg first.
"""

from dataclasses import dataclass
from functools import cached_property
from math import atan, cos, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np

import motion

HERE = Path(__file__).parent
BIPED_MJCF = HERE / "biped8.xml"
BIPED_URDF = HERE / "biped8.urdf"
JOINTS = [f"{side}_{joint}" for side in "lr" for joint in ("hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")]
FEET = ["l_foot", "r_foot"]
SOLE = [(x, y, -0.05) for x in (0.1, -0.1) for y in (0.05, -0.05)]  # corners of a sole in its foot's frame
G = 9.81


@dataclass(frozen=True)
class Body:
    """A free body with its centre of mass at its origin: a box, point tips, or balls about them."""

    mass: float
    inertia: tuple  # principal moments about the centre of mass
    box: tuple = ()  # side lengths
    tips: tuple = ()  # points that may touch; spheres of radius TIP in engines that know no points
    radius: float = 0.0  # of balls about the tips

    @property
    def points(self):
        """Points of the body, or middles of its balls, that may touch the ground."""
        return list(self.tips) or [tuple(s * a / 2 for s, a in zip(signs, self.box)) for signs in CORNERS]

    def urdf(self):
        """The body as a one-link URDF."""
        sphere = '<collision><origin xyz="{} {} {}"/><geometry><sphere radius="%r"/></geometry></collision>'
        sphere %= self.radius or TIP
        collisions = "".join(sphere.format(*tip) for tip in self.tips)
        if self.box:
            size = "{} {} {}".format(*self.box)
            collisions = f'<collision><geometry><box size="{size}"/></geometry></collision>'
        xx, yy, zz = self.inertia
        moments = f'ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" ixy="0" ixz="0" iyz="0"'
        inertial = f'<inertial><mass value="{self.mass!r}"/><inertia {moments}/></inertial>'
        return f'<robot name="body"><link name="body">{inertial}{collisions}</link></robot>'


CORNERS = [(x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
TIP = 1e-5  # small enough that rolling over it moves the answers by less than 1e-5


@dataclass(frozen=True)
class Scene:
    """One scene; `body` None means the biped."""

    name: str
    duration: float
    body: Body | None = None
    position: tuple = (0.0, 0.0, 0.0)  # of the body's origin
    pitch: float = 0.0  # about y, of the body
    velocity: tuple = (0.0, 0.0, 0.0)  # of the body's origin, in W
    spin: tuple = (0.0, 0.0, 0.0)  # angular velocity, in W
    friction: float = 0.5
    slope: float = 0.0
    gravity: float = G
    contact: bool = True
    joints: tuple = (0.0,) * 8
    rates: tuple = (0.0,) * 8
    stiffness: float = 0.0  # torque = stiffness (joints at start - q) - damping qd
    damping: float = 0.0

    @cached_property
    def gravity_vector(self):
        """Gravity in W: a slope, downhill along x."""
        return self.gravity * np.array([sin(self.slope), 0.0, -cos(self.slope)])

    @property
    def urdf(self):
        """The body, or the biped, as a URDF."""
        return self.body.urdf() if self.body else BIPED_URDF.read_text()

    @property
    def quaternion(self):
        """Attitude of the body, w first."""
        return (cos(self.pitch / 2), 0.0, sin(self.pitch / 2), 0.0)

    def steps(self, dt):
        """Number of steps of the whole scene."""
        return round(self.duration / dt)


def _box(mass, sides):
    a, b, c = (side**2 for side in sides)
    return Body(mass, tuple(mass / 12 * sum for sum in (b + c, a + c, a + b)), box=tuple(sides))


CUBE = _box(1.0, (0.1, 0.1, 0.1))
FOOT = _box(1.0, (0.2, 0.1, 0.05))
BLOCK = _box(1.0, (0.1, 0.1, 0.4))
SPOKE, SPOKES, SPOKE_ANGLE = 0.3, 8, pi / 4
_EIGHTHS = [SPOKE_ANGLE * (i + 0.5) for i in range(SPOKES)]
WHEEL = Body(10.0, (0.1,) * 3, tips=tuple((SPOKE * sin(a), y, SPOKE * cos(a)) for a in _EIGHTHS for y in (0.1, -0.1)))
PUCK = Body(1.0, (0.005, 0.005, 0.01), tips=((0.1, 0, 0), (-0.05, 0.0075**0.5, 0), (-0.05, -(0.0075**0.5), 0)))
BALL = Body(1.0, (0.002,) * 3, tips=((0, 0, 0.04),), radius=0.1)

# Rocking block: Housner's ratio of spins at the impact, and how far it then rises on its other edge.
TIPPING = atan(0.1 / 0.4)
ROCK_RATIO = 1 - 1.5 * sin(TIPPING) ** 2
ROCK_APEX = TIPPING - np.arccos(cos(TIPPING) + ROCK_RATIO**2 * (cos(TIPPING / 2) - cos(TIPPING)))

# Rimless wheel: ratio of spins at the impact, spins before and after it on the limit cycle, and mean speed.
WHEEL_SLOPE = radians(8)
_RHO2 = WHEEL.inertia[1] / (WHEEL.mass * SPOKE**2)
WHEEL_RATIO = (_RHO2 + cos(SPOKE_ANGLE)) / (1 + _RHO2)
WHEEL_PULL = G / (SPOKE * (1 + _RHO2))  # d(spin^2 / 2) = WHEEL_PULL d(-cos(angle from gravity))
_BEFORE = sqrt(4 * WHEEL_PULL * sin(SPOKE_ANGLE / 2) * sin(WHEEL_SLOPE) / (1 - WHEEL_RATIO**2))
WHEEL_SPIN = WHEEL_RATIO * _BEFORE
_HALVES = np.linspace(-1, 1, 20001)[1::2] * SPOKE_ANGLE / 2 + WHEEL_SLOPE  # midpoints of the swing, from gravity
_RATES = np.sqrt(WHEEL_SPIN**2 + 2 * WHEEL_PULL * (cos(WHEEL_SLOPE - SPOKE_ANGLE / 2) - np.cos(_HALVES)))
_PERIOD = SPOKE_ANGLE * np.mean(1 / _RATES)
WHEEL_SPEED = 2 * SPOKE * sin(SPOKE_ANGLE / 2) / _PERIOD  # .784571 m/s

_HIP = 0.2 * cos(0.2) * 2 + 0.25  # trunk above the soles with the knees bent by .4
_STAND = dict(position=(0, 0, _HIP), joints=(-0.2, 0.4, -0.2, 0.0) * 2, stiffness=400.0, damping=3.0, duration=10.0)
_WHEEL_TOP = SPOKE * cos(SPOKE_ANGLE / 2)
_WHEEL_ARM = (-SPOKE * sin(SPOKE_ANGLE / 2), _WHEEL_TOP)  # from the front tip to the axle

SCENES = {
    scene.name: scene
    for scene in [
        Scene("free", 5.0, position=(0, 0, 0.65), spin=(0.6, -0.8, 1.0), gravity=0.0, contact=False,
              rates=(0.8, -0.9, 1.0, -1.1, 1.2, -1.3, 1.4, -1.5)),
        Scene("slide", 1.0, CUBE, (0, 0, 0.05), velocity=(2, 0, 0)),
        Scene("slide30", 1.0, CUBE, (0, 0, 0.05), velocity=(2 * cos(pi / 6), 2 * sin(pi / 6), 0)),
        Scene("incline", 2.0, CUBE, (0, 0, 0.05), slope=radians(20), friction=0.3),
        Scene("stick", 5.0, CUBE, (0, 0, 0.05), slope=radians(26)),
        Scene("drop", 0.5, FOOT, (0, 0, 0.125)),
        Scene("stand0", **_STAND),
        Scene("stand10", **_STAND, slope=radians(10)),
        Scene("rock", 1.0, BLOCK, pitch=TIPPING / 2,
              position=(0, 0, 0.05 * sin(TIPPING / 2) + 0.2 * cos(TIPPING / 2))),
        Scene("wheel", 4.0, WHEEL, (0, 0, _WHEEL_TOP), slope=WHEEL_SLOPE, friction=1.0, spin=(0, WHEEL_SPIN, 0),
              velocity=(WHEEL_SPIN * _WHEEL_ARM[1], 0, -WHEEL_SPIN * _WHEEL_ARM[0])),
        Scene("turn", 0.5, PUCK, velocity=(2, 0, 0), spin=(0, 0, 1), friction=0.2),
        Scene("ball", 1.75, BALL, (0.04 * sin(1.2), 0, 0.1 - 0.04 * cos(1.2)), pitch=-1.2),
    ]
}  # fmt: skip

STOP = 2.0**2 / (2 * 0.5 * G)  # v^2 / (2 mu g) = .407747 m
INCLINE = G * (sin(radians(20)) - 0.3 * cos(radians(20))) * 2.0**2 / 2  # 1.179404 m
*TURN_WAY, TURN_YAW = motion.puck(SCENES["turn"], G)  # .754942 m, .431227 rad
BALL_WAY, BALL_ANGLE = motion.ball(SCENES["ball"], G)  # at its lowest place all but -.070268 rad
