"""Kinematics of the robot from its supporting foot, the rate QP, and the constants ω, γ, J_n: (25)-(29).

Support frame S: origin at the centre of the supporting sole, axis 1 forward, axis 2 toward the swing foot, axis 3 up.
Joints s in support order, from the supporting foot to the swing foot.
Task x = [x_c1 x_c2 x_c3 x_t1 x_t2 x_t3 x_g]: centre of gravity, swing sole, pitch of the trunk. (26)
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, sin, sqrt

import numpy as np

import session

FLIP = np.array([1.0, -1.0, 1.0])  # axis 2 of S is the negative y axis while the left foot supports
PITCH_SUM = np.array([0.0, 1, 1, 1, 1, 1, 1, 0])  # s: 1 for each joint whose angle is part of the swing foot's pitch
OUTWARD = (3, 4, 3), (2, 3, 2), (1, 2, 1), (0, 1, 0), (5, 4, 4), (6, 5, 5), (7, 6, 6), (8, 7, 7)  # bodies and joint, from the trunk
AXES = "roll, three times pitch, three times pitch, roll"
CROUCH = np.array([0.0, 0.4943, -1.5177, 1.0234, -1.0234, 1.5177, -0.4943, 0.0])  # initial guess for postures [rad]
UPRIGHT = 4.475 / 14  # height of Table 1's centre of gravity at zero angles [m]


def mirror(q):
    """Converts wire order to support order of the right foot, and back."""
    s = -q[::-1]
    s[[0, -1]] *= -1.0  # rolls: reversed and mirrored
    return s


def cross(a, b):
    """a × b of the rows."""
    (a0, a1, a2), (b0, b1, b2) = a.T, b.T
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]).T


def roll(angle):
    return np.array([[1, 0, 0], [0, cos(angle), -sin(angle)], [0, sin(angle), cos(angle)]])


def pitch(angle):
    return np.array([[cos(angle), 0, sin(angle)], [0, 1, 0], [-sin(angle), 0, cos(angle)]])


@dataclass
class Task:
    """x of (26), J_aco of (27), the pitch of the swing foot [rad], and the cosine of the supporting ankle's roll."""

    x: np.ndarray
    jacobian: np.ndarray
    swing_pitch: float
    roll_cosine: float

    @cached_property
    def inverse(self):
        """J⁺ = C⁻¹Jᵀ(J C⁻¹Jᵀ)⁻¹: the cheapest joint rates for one unit of each task rate."""
        weighted = C_INVERSE @ self.jacobian.T
        try:
            return weighted @ np.linalg.inv(self.jacobian @ weighted)
        except np.linalg.LinAlgError:
            session.fail(4, "the task Jacobian is singular: the legs are straight, or an encoder reading is wrong")


class Chain:
    """The robot from its left foot, link 0, to its right foot, link 8; origin at the left sole's centre, at zero angles."""

    def __init__(self, bodies):
        if not is_biped(bodies):
            session.fail(2, f"the robot has to be nine bodies from the left foot to the right foot, joined by {AXES}")
        origin = np.zeros((9, 3))
        joint = np.zeros((8, 3))
        for child, parent, j in OUTWARD:
            joint[j] = origin[child] = origin[parent] + bodies[child]["joint"]["at"]
        left, right = (origin[k] + np.mean(bodies[k]["contacts"], axis=0) for k in (0, 8))
        self.mass = np.array([body["mass"] for body in bodies])
        self.total = self.mass.sum()
        self.com = np.array([origin[k] + body["com"] for k, body in enumerate(bodies)]) - left
        self.moments = np.array([moments(body) for body in bodies])
        self.joint = joint - left
        self.sole = right - left
        self.width = abs(self.sole[1])  # W_2
        # dynamic similarity: ratios of lengths and of times to those of Table 1
        self.length = self.mass @ self.com[:, 2] / self.total / UPRIGHT
        self.time = sqrt(self.length)
        self.sole_half = np.abs(origin[0] + bodies[0]["contacts"] - left).max(axis=0)
        # vectors from each joint outward to the next one and to the centre of mass, and the mass outside the joint
        self.step = np.diff(self.joint, axis=0)
        self.arm = self.com[1:] - self.joint
        self.outer_mass = self.mass[:0:-1].cumsum()[::-1]

    def forward_kinematics(self, s):
        """Positions of joints, centres of mass and swing sole, and directions of the axes. The frame rolls with s_0 about joint 0;
        in it the six middle joints rotate about y."""
        phi = np.zeros(8)
        phi[1:7] = np.cumsum(s[1:7])  # pitch of link j + 1; the last link has the pitch of the preceding one
        phi[7] = phi[6]
        c, sn = np.cos(phi), np.sin(phi)
        turn = lambda v, c, sn: np.stack([c * v[:, 0] + sn * v[:, 2], v[:, 1], c * v[:, 2] - sn * v[:, 0]], axis=1)
        joint = np.zeros((8, 3))
        joint[1:] = np.cumsum(turn(self.step, c[:7], sn[:7]), axis=0)
        last = roll(s[7])
        arm = self.arm.copy()
        arm[7] = last @ arm[7]
        com = joint + turn(arm, c, sn)
        sole = joint[7] + turn((last @ (self.sole - self.joint[7]))[None], c[7:], sn[7:])[0]
        axis = np.zeros((8, 3))
        axis[0, 0] = 1.0
        axis[1:7, 1] = 1.0
        axis[7] = [c[7], 0.0, -sn[7]]
        return joint, com, sole, axis

    def task(self, s):
        joint, com, sole, axis = self.forward_kinematics(s)
        tilt = roll(s[0])
        moment = (self.mass[1:, None] * com)[::-1].cumsum(axis=0)[::-1]  # of all links outside each joint
        to_s = lambda v: (v @ tilt.T) * FLIP
        whole = moment[0] + self.mass[0] * (tilt.T @ (self.com[0] - self.joint[0]))
        jacobian = np.zeros((7, 8))
        jacobian[0:3] = to_s(cross(axis, moment - self.outer_mass[:, None] * joint) / self.total).T
        jacobian[3:6] = to_s(cross(axis, sole - joint)).T
        jacobian[6, 1:4] = 1.0
        foot = self.joint[0] * FLIP
        trunk = s[1:4].sum()
        x = np.concatenate([foot + to_s(whole / self.total), foot + to_s(sole), [trunk]])
        return Task(x, jacobian, trunk + s[4:7].sum(), cos(s[0]))


def is_biped(bodies):
    """Whether the bodies are those of the paper's Figure 4, from the left foot to the right one."""
    if len(bodies) != 9 or [bodies[k]["name"] for k in (0, 4, 8)] != ["left foot", "trunk", "right foot"]:
        return False
    for child, parent, j in OUTWARD:
        joint, axis = bodies[child].get("joint"), np.eye(3)[0 if j in (0, 7) else 1]
        if not joint or joint["parent"] != bodies[parent]["name"]:
            return False
        turns = np.array(joint["axis"]) / np.linalg.norm(joint["axis"]) * (-1 if child < parent else 1)  # of the outer link in the chain
        if np.abs(turns - axis).max() > 1e-9:
            return False
    return True


def moments(body):
    """Principal moments of inertia [kg·m²]: as given, or of a uniform box."""
    a, b, c = np.square(body["size"])
    return body.get("inertia") or body["mass"] / 12.0 * np.array([b + c, a + c, a + b])


# The rate QP, (28), (29)

LEVEL_WEIGHT, LEVEL_GAIN = 100.0, 40.0
# C = I + w s sᵀ, inverted by Sherman and Morrison
C_INVERSE = np.eye(8) - np.outer(PITCH_SUM, PITCH_SUM) * LEVEL_WEIGHT / (1.0 + LEVEL_WEIGHT * PITCH_SUM @ PITCH_SUM)


def resolve(task, xdot, c_0):
    """Minimises ½ q̇ᵀC q̇ − c_0ᵀq̇ subject to J q̇ = ẋ, in closed form."""
    free = C_INVERSE @ c_0
    return free + task.inverse @ (xdot - task.jacobian @ free)


def level(swing_pitch):
    """c_0: the remaining degree of freedom levels the swing foot."""
    return -LEVEL_WEIGHT * LEVEL_GAIN * swing_pitch * PITCH_SUM


INERTIA_MARGIN = 1.5  # J_n over the inertia matrix
SOLE_SHARE = 0.95  # share of the sole's half-depth and half-width to which the zero-moment point may come
KNEE, KNEE_SHARE = 2, 0.72  # knee of the supporting leg, and the share of its torque limit that the weight may need
LARGEST_LEAN, LEANS = 0.7, 70  # greatest lean over the sole's half-depth, and number of leans that are tried


class Constants:
    """ω_1, ω_2, γ, M, J_n and the limits of the ankles, from the full inverse dynamics at rest in the posture of the middle of a step."""

    def __init__(self, chain, scene, plant):
        self.lean, s = leaning(chain, scene, plant)
        joint, com, _, axis = chain.forward_kinematics(s)
        tilt = roll(s[0])
        joint, com, axis = (v @ tilt.T for v in (joint, com, axis))
        com += chain.joint[0]
        joint += chain.joint[0]
        turn = [tilt @ pitch(s[1 : i + 1].sum()) for i in range(7)] + [tilt @ pitch(s[1:7].sum()) @ roll(s[7])]
        weight = chain.total * plant["gravity"]
        inertia = plant["drive_inertia"] * np.eye(8)
        couple = np.zeros((3, 8))  # moment about the sole's centre per joint acceleration
        for i in range(8):
            outward = np.arange(8) <= i  # the joints that move link i + 1
            angular = (axis * outward[:, None]).T
            linear = (cross(axis, com[i] - joint) * outward[:, None]).T
            tensor = turn[i] @ np.diag(chain.moments[i + 1]) @ turn[i].T
            inertia += chain.mass[i + 1] * linear.T @ linear + angular.T @ tensor @ angular
            couple += chain.mass[i + 1] * cross(com[i][None], linear.T).T + tensor @ angular
        task = chain.task(s)

        def zmp_shift(k):  # along and across [m] per acceleration [m/s²] of task component k
            moment = couple @ task.inverse[:, k]
            return -moment[1] / weight, -moment[0] / weight

        self.omega = sqrt(-1.0 / zmp_shift(0)[0]), sqrt(-1.0 / zmp_shift(1)[1])
        self.gamma = zmp_shift(3)[0] * self.omega[0] ** 2
        self.inertia = inertia  # M + J_r 1 with the supporting foot fixed
        if scene.get("nominal_inertia") == "diagonal":  # a number for each joint, as in the paper
            self.nominal_inertia = np.diag(2.0 / np.diag(np.linalg.inv(inertia)))
        else:
            self.nominal_inertia = INERTIA_MARGIN * inertia
        self.sole_edge = SOLE_SHARE * chain.sole_half[:2]
        self.ankle_limit = weight * self.sole_edge  # along and across: pitch and roll [N·m]


def leaning(chain, scene, plant):
    """The least distance of the zero-moment point before the sole's centre with which the weight asks no more of the knee than its share
    [m], and the posture of the middle of a step. The paper's sagittal rule has no such distance."""
    most = 0.0 if scene["sagittal"] == "energy" else LARGEST_LEAN * chain.sole_half[0]
    target = np.array([0.0, 0.4 * chain.width, scene["com_height"], 0.0, chain.width, 0.02 * chain.length, 0.0])
    found = None
    for lean in most * np.arange(LEANS + 1) / LEANS:
        s = posture(chain, target + lean * np.eye(7)[0])
        if s is None:
            break
        found = lean, s
        if abs(chain.total * plant["gravity"] * chain.task(s).jacobian[2, KNEE]) <= KNEE_SHARE * plant["torque_limit"]:
            break
    if found is None:
        session.fail(4, f"no posture has its centre of gravity {target[2]} m high")
    return found


def posture(chain, target):
    """Joint angles at which the task is `target`, by Newton's method; None if there are none."""
    s = CROUCH.copy()
    for _ in range(50):
        task = chain.task(s)
        miss = target - task.x
        if np.abs(miss).max() < 1e-12 and abs(task.swing_pitch) < 1e-9:
            return s
        s += resolve(task, miss, level(task.swing_pitch / LEVEL_GAIN))
    return None
