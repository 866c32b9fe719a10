"""What the centre of gravity and the swing foot are to do next: phases, pendulums, energies, foot placement, (30)-(43).

    stand → sway → lift → walk (exchange, exchange, …) → land → rest
"""

from dataclasses import dataclass
from math import ceil, copysign, cosh, exp, log, sinh, sqrt, tanh

import numpy as np


def clip(value, limit):
    return max(-limit, min(limit, value))


@dataclass
class Travel:
    """Position, velocity and acceleration along one axis [m, m/s, m/s²]."""

    x: float
    v: float = 0.0
    a: float = 0.0

    def toward(self, target, t, h):
        """One period h along the quintic that comes to rest at the target in the time t."""
        d, v, a = target - self.x, self.v, self.a
        jerk = 60 * d / t**3 - 36 * v / t**2 - 9 * a / t
        snap = -360 * d / t**4 + 192 * v / t**3 + 36 * a / t**2
        crackle = 720 * d / t**5 - 360 * v / t**4 - 60 * a / t**3
        return Travel(
            self.x + h * (v + h * (a / 2 + h * (jerk / 6 + h * (snap / 24 + h * crackle / 120)))),
            v + h * (a + h * (jerk / 2 + h * (snap / 6 + h * crackle / 24))),
            a + h * (jerk + h * (snap / 2 + h * crackle / 6)),
        )

    def after(self, omega, u, t):
        """The pendulum ẍ = ω²x + u a time t later. (31), (32), (34)"""
        sh, ch, rest = sinh(omega * t), cosh(omega * t), -u / omega**2
        x = rest + (self.x - rest) * ch + self.v / omega * sh
        return Travel(x, (self.x - rest) * omega * sh + self.v * ch, omega**2 * x + u)

    def energy(self, omega):
        return 0.5 * self.v**2 - 0.5 * (omega * self.x) ** 2  # (33)

    def time_to(self, width, omega, longest):
        """Time until the free motion reaches `width`: a quadratic in e^(ωt)."""
        a, b = 0.5 * (self.x + self.v / omega), 0.5 * (self.x - self.v / omega)
        if a <= 1e-5:
            return longest
        root = sqrt(max(0.0, width**2 - 4 * a * b))
        return max(0.0, min(longest, log((width + root) / (2 * a)) / omega))


def virtual_input(gain, missing, v, fading, limit):
    """u that adds the missing energy; v/(v² + v_0²) for the 1/v of (39), singular at rest."""
    return clip(gain * missing * v / (v * v + fading**2), limit)


STAND, SWAY, LIFT, WALK, LAND, REST = range(6)  # as wire.PHASE
# for the robot of Table 1; another's go with its size, see Chain
DURATION = {STAND: 0.5, SWAY: 0.8, LIFT: 0.3, LAND: 0.5}  # [s]
FREEZE = 0.012  # so long before landing the target stays as it is [s]
AIRBORNE = 1e-3  # a foot this far above the other swings [m]


def right_supports(from_left, moving, airborne):
    """Whether the right foot carries, seen from the left: the left one is in the air, or, amid an exchange, the centre of
    gravity is nearer to the right one."""
    x = from_left.x
    return x[5] < 0 if abs(x[5]) > airborne else moving and x[1] > 0.5 * x[4]


@dataclass
class Plan:
    """What the lower levels are to do in this period."""

    xdot: np.ndarray  # of (30)
    acceleration: tuple  # of the centre of gravity along axes 1 and 2 [m/s²]
    load: float  # share of the weight on the supporting foot
    zmp: float  # along axis 2 [m]
    time_left: float | None = None  # until the next exchange [s]


class Gait:
    def __init__(self, scene, chain, constants, h, task):
        self.scene, self.h, self.omega, self.width = scene, h, constants.omega, chain.width
        T = self.T = scene["period"]
        self.L, self.t = chain.length, chain.time
        self.duration = {phase: time * self.t for phase, time in DURATION.items()}
        self.freeze, self.airborne, self.fading = FREEZE * self.t, AIRBORNE * self.L, 0.03 * self.L / self.t
        self.gamma = 0.3 * constants.gamma_0 if T <= 0.8 * self.t else 0.0
        inner = 0.5 * self.width / cosh(0.25 * self.omega[1] * T)  # turning point of the orbit of (40)
        self.release = scene.get("release_x2") or inner
        self.reach = 0.5 * self.width - inner  # h_d of (43)
        self.phase, self.since, self.time, self.steps = STAND, 0.0, 0.0, 0
        x_1, x_2, self.height, self.landing = task.x[:4].tolist()
        self.com, self.foot = [Travel(x_1), Travel(x_2)], Travel(self.landing)
        self.W_1, self.trim = 0.0, 0.0

    def resume(self, task, speed):
        """Goes on amid a step, from the task and its rates: the gait has no clock, and its state can be measured. False if the
        robot is standing."""
        x, v = task.x.tolist(), speed.tolist()
        lateral = Travel(x[1], v[1])
        exchanging = abs(v[1]) > 0.05 * self.L / self.t and self.f_h(lateral)[0] < 2 * self.airborne
        if x[5] <= self.airborne and not exchanging:
            return False
        self.phase, self.steps, self.W_1 = WALK, 1, 0.5 * self.scene["speed"] * self.T
        self.since = max(0.0, 0.5 * self.T - self.time_left(lateral))
        self.com, self.foot = [Travel(x[0], v[0]), lateral], Travel(x[3], v[3])
        return True

    def stopping(self):
        return self.time >= self.scene.get("stop_time", float("inf"))

    def exchange_due(self):
        lateral = self.com[1]
        return self.phase == WALK and lateral.x >= 0.5 * self.width and lateral.v > 0 and self.since >= 0.1 * self.t

    def exchange(self, task):
        """Hands the plan over to the other support; `task` is measured before, in the old support frame."""
        t_1, t_3 = task.x[[3, 5]].tolist()
        self.trim = clip(self.trim + 0.3 * (t_1 - self.landing), 0.02 * self.L)
        sagittal, lateral = self.com
        x = self.width - lateral.x  # up to a period late: along the orbit to the other foot
        v = -sqrt(max(0.0, lateral.v**2 - self.omega[1] ** 2 * (lateral.x**2 - x**2)))
        self.com = [Travel(sagittal.x - t_1, sagittal.v, sagittal.a), Travel(x, v, -lateral.a)]
        self.height -= t_3
        self.foot, self.landing = Travel(-t_1), -t_1
        self.steps, self.since = self.steps + 1, 0.0
        if self.stopping() and self.W_1 == 0.0:
            self.phase = LAND
            return
        wanted = 0.0 if self.stopping() else 0.5 * self.scene["speed"] * self.T
        self.W_1 += clip(wanted - self.W_1, 0.015 * self.L)

    def plan(self, task):
        self.change_phase()
        if self.phase in (STAND, REST):
            plan = self.hold(task)
        elif self.phase == SWAY:
            plan = self.shift(task, (0.0, self.release))
        elif self.phase == LIFT:
            plan = self.rise(task)
        elif self.phase == WALK:
            plan = self.walk(task)
        else:
            plan = self.shift(task, (0.5 * task.x[3], 0.5 * task.x[4]))
        self.since += self.h
        self.time += self.h
        return plan

    def change_phase(self):
        if self.since < self.duration.get(self.phase, float("inf")):
            return
        if self.phase == STAND and (self.scene["gait"] != "walk" or self.stopping()):
            return
        self.phase, self.since = self.phase + 1, 0.0
        self.com = [Travel(axis.x) for axis in self.com]

    def zmp(self):
        return self.com[1].x - self.com[1].a / self.omega[1] ** 2  # (32)

    def hold(self, task):
        """Both feet down."""
        return self.follow(task, 0.0, 0.0, 0.0, max(0.0, min(1.0, 1.0 - self.zmp() / self.width)))

    def shift(self, task, target):
        """Both feet down, the centre of gravity on its way."""
        left = self.duration[self.phase] - self.since
        move = lambda axis, to: axis.toward(to, left, self.h) if left > self.freeze else Travel(axis.x)
        self.com = [move(axis, to) for axis, to in zip(self.com, target)]
        return self.hold(task)

    def rise(self, task):
        """The weight leaves the swing foot, then the foot leaves the ground."""
        height, _ = self.f_h(self.com[1])
        r = min(1.0, self.since / self.duration[LIFT])
        load = 1.0 - self.com[1].x / self.width * max(0.0, 1.0 - self.since / (0.1 * self.t))
        rate = 30 * r * r * (1 - r) ** 2 / self.duration[LIFT]
        return self.follow(task, height * r**3 * (10 - 15 * r + 6 * r * r), 0.0, height * rate, load)

    def walk(self, task):
        """One period of stepping: both axes are pendulums."""
        for axis, measured in zip(self.com, task.x.tolist()):
            axis.x += self.scene["com_feedback"] * self.h * (measured - axis.x)
        energy, reference = self.energies(), self.references()
        sagittal, lateral = self.com
        u_2 = virtual_input(self.scene["energy_gain"], reference[1] - energy[1], lateral.v, self.fading, 0.6)  # (39)
        left = self.time_left(lateral)
        lateral = lateral.after(self.omega[1], u_2, self.h)  # (32)
        if self.scene["sagittal"] == "energy":  # the paper's: x_t1 = 2 x_c1, and (42)
            self.landing = 2 * sagittal.after(self.omega[0], 0.0, left).x
            self.foot = Travel(2 * sagittal.x, 2 * sagittal.v, 2 * sagittal.a)
            missing, gain = reference[0] - energy[0], self.scene["sagittal_energy_gain"]
            u_1 = virtual_input(gain, missing, sagittal.v, self.fading, 0.5)
            if abs(sagittal.v) < 0.02 * self.L / self.t:
                u_1 = copysign(0.5, self.W_1) * (self.W_1 != 0.0)  # leave the rest point
        else:
            self.place_foot(sagittal, left)
            u_1 = self.gamma * self.foot.a
        self.com = [sagittal.after(self.omega[0], u_1, self.h), lateral]  # (31)
        height, rate = self.f_h(lateral)  # (43)
        plan = self.follow(task, height, self.foot.v, rate, 1.0)
        plan.time_left = left
        return plan

    def f_h(self, lateral):
        """Height of the swing foot (43) and its rate: a parabola in x_2, highest at the turning point."""
        r = max(0.0, -(lateral.x - 0.5 * self.width) / self.reach)
        h_max = self.scene["swing_height"]
        return h_max * min(r, 1.3) ** 2, -2 * h_max * r * lateral.v / self.reach if r < 1.3 else 0.0

    def time_left(self, lateral):
        """Until the exchange, in whole periods: it comes with the first one that finds x_2 beyond W_2/2."""
        left = lateral.time_to(0.5 * self.width, self.omega[1], self.T)
        return max(1.0, ceil(left / self.h)) * self.h

    def place_foot(self, sagittal, left):
        """x_t1 = x_e + W_1/2 + K (v_e − v_ref) with the predicted touchdown (x_e, v_e), K = k coth(ωT/2)/ω. The
        prediction holds the foot's own effect γ ẍ_t, in which x_t1 occurs; it is solved for."""
        if left <= self.freeze:
            self.foot = Travel(self.foot.x + self.h * self.foot.v, self.foot.v)
            return
        w, g, foot, quarter = self.omega[0], self.gamma, self.foot, 0.25 * self.omega[0] * self.T
        free = sagittal.after(w, 0.0, left)
        x_e = free.x - g * sinh(w * left) * foot.v / w
        v_e = free.v - g * cosh(w * left) * foot.v
        K = self.scene["foot_placement_gain"] / (w * tanh(2 * quarter))
        v_ref = w * (0.5 / tanh(quarter) - g / sinh(quarter)) * self.W_1
        per_metre = g * cosh(0.5 * w * left) + K * g * w * sinh(0.5 * w * left)
        self.landing = (x_e + 0.5 * self.W_1 + K * (v_e - v_ref) - per_metre * foot.x) / (1.0 - per_metre)
        self.foot = foot.toward(self.landing - self.trim, left, self.h)

    def follow(self, task, lift, foot_rate, lift_rate, load):
        """(30): task rates that make the measured task follow the plan."""
        low = self.scene["com_height"] - self.height
        climb = clip(2.0 * low, 0.1 * self.L) / self.t
        self.height += self.h * climb
        sagittal, lateral = self.com
        command = np.array([sagittal.x, lateral.x, self.height, self.foot.x, self.width, lift, 0.0])
        rate = np.array([sagittal.v, lateral.v, climb, foot_rate, 0.0, lift_rate, 0.0])
        c, t = self.scene["com_gain"], self.scene["swing_gain"]
        xdot = np.array([c, c, c, t, t, t, c]) * (command - task.x) + rate  # (30)
        if self.phase not in (WALK, LIFT):
            xdot[3:6] = 0.0  # a foot on the ground stays where it is
        return Plan(xdot, (sagittal.a, lateral.a), load, self.zmp())

    def energies(self):
        return [axis.energy(omega) for axis, omega in zip(self.com, self.omega)]

    def references(self):
        e_1, e_2 = (exp(0.5 * omega * self.T) for omega in self.omega)
        return [
            (self.omega[0] * self.W_1) ** 2 * e_1 / (2 * (1 - e_1) ** 2),  # (42)
            -((self.omega[1] * self.width) ** 2) * e_2 / (2 * (1 + e_2) ** 2),  # (40)
        ]
