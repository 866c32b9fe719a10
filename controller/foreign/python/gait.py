"""The motion of the centre of gravity and of the swing foot: phases, energies, foot placement, (30)-(43).

    stand → sway → lift → walk (exchange, exchange, …) → land → rest

In walk, both axes are pendulums whose states follow the measured centre of gravity. The energy rule keeps the lateral pendulum on
its orbit, which sets the time of the steps. The landing position of the foot and the ankle stabilise the sagittal pendulum. If the
robot is pushed forward or backward, limits widen. A foot that meets a higher place stays there until the exchange.
"""

from dataclasses import dataclass
from math import ceil, copysign, exp, sqrt, tau

import numpy as np

import wire
from corrections import Corrections
from robot import INERTIA_MARGIN
from pendulum import FootPlacement, LateralOrbit, MinimumJerkState, clip, lateral_energy, virtual_input

STAND, SWAY, LIFT, WALK, LAND, REST = range(len(wire.PHASE))
# for the robot of Table 1; scaled for another robot, see Chain
DURATION = {STAND: 0.5, SWAY: 0.8, LIFT: 0.3, LAND: 0.5}  # [s]
FREEZE = 0.012  # last part of a step, in which the landing position is fixed [s]
AIRBORNE = 1e-3  # a foot that is higher than this above the other one is in the air [m]
# these are not scaled
ZMP_SHARE = 0.85, 0.9  # share of the sole's half-depth and half-width within which the plan keeps the zero-moment point
INPUT_LIMIT = 0.5  # of u_1 under the paper's rule [m/s²]
RETURN = 0.5, 0.3  # rate at which ξ returns to the middle between the feet in land and rest, along and across, over ω
TOUCHDOWN = 0.01  # time in which a foot that has landed takes its load [s]
FIRST_SUPPORT = 0.65  # share of the weight on the new supporting foot immediately after an exchange, as the servos assume it
RESTING_POLE = 0.4  # pole of the observers in rest, over that of the walk
CLEAR = 0.3  # height, as a share of the largest one, above which the full acceleration is allowed
TOUCH = 0.5  # load at which a foot has touched the ground, over the weight: it carries more than the supporting foot


def right_supports(from_left, moving, airborne):
    """Whether the right foot supports the robot: the left one is in the air, or, during an exchange, the centre of gravity is
    nearer to the right one."""
    x = from_left.x
    return x[5] < 0 if abs(x[5]) > airborne else moving and x[1] > 0.5 * x[4]


def observer(pole, h):
    """Gains of position and rate with which errors decay as e^(−pt)."""
    kept = exp(-pole * h)
    return 1 - kept**2, (1 - kept) ** 2 / h


@dataclass
class Plan:
    """Reference for the lower levels in one control period."""

    xdot: np.ndarray  # of (30)
    acceleration: tuple  # of the centre of gravity along axes 1 and 2 [m/s²]
    load: float  # share of the weight on the supporting foot
    support: float  # the same share as the servos assume it
    zmp: tuple  # zero-moment point along axes 1 and 2 [m]


class Gait:
    def __init__(self, scene, chain, constants, h, task, time):
        self.h, self.omega, self.width = h, constants.omega, chain.width
        self.chain, self.constants = chain, constants
        self.L, self.t = chain.length, chain.time
        self.duration = {phase: time * self.t for phase, time in DURATION.items()}
        self.freeze, self.airborne, self.fading = FREEZE * self.t, AIRBORNE * self.L, 0.01 * self.L / self.t
        self.gamma = constants.gamma
        self.zmp_range = (ZMP_SHARE * chain.sole_half[:2]).tolist()
        # observers of the pendulums: errors decay as e^(−pt); with p = 0 they correct nothing
        self.observer, self.resting_observer = (observer(share * scene["com_feedback"], h) for share in (1.0, RESTING_POLE))
        self.is_disabled = self.observer[0] == 0.0
        # delay of a joint rate after its reference: 1/κ of the boundary layer, less the delays of the measured rates. Without this
        # lead the observer would hold the plan back
        sensitivity = self.omega[1] / (self.omega[1] + scene["observer_bandwidth"])
        sooner = 0.0 if scene.get("nominal_inertia") == "diagonal" else (1 - 1 / INERTIA_MARGIN) * sensitivity
        late = (1 - sooner) / scene["switch_rate"] - 1 / (tau * scene["rate_filter_hz"]) - 1.5 * h
        self.servo_lag = 0.0 if scene["switching"] == "relay" else max(0.0, late)
        self.phase, self.since, self.time, self.steps = STAND, 0.0, time, 0  # time is simulated time
        self.resumed = False  # whether the controller started within the step under way
        self.set_points(scene)
        x_1, x_2, self.height, self.landing = task.x[:4].tolist()
        self.com, self.foot = [MinimumJerkState(x_1), MinimumJerkState(x_2)], MinimumJerkState(self.landing)
        self.W_1, self.corrections = 0.0, Corrections(chain)
        self.ground = 0.0  # height at which the swing foot has met a higher place in this step
        self.urgency = 0.0  # share to which limits are widened, because ξ_1 deviates from the steady gait

    def set_points(self, scene):
        """Takes period and speed from the scene's controller. The step under way keeps its period, unless the controller took over in it."""
        self.scene = scene
        if self.resumed:
            self.W_1 = 0.5 * scene["speed"] * scene["period"]
        self.plan_with(self.T if self.phase == WALK and not self.resumed else scene["period"])

    def plan_with(self, period):
        """Takes a period [s], and what follows from it."""
        self.T, scene = period, self.scene | {"period": period}
        self.orbit = LateralOrbit(scene, self.omega[1], self.width)
        self.release = scene.get("release_x2", self.orbit.inner)
        self.reach = 0.5 * self.width - self.orbit.inner  # h_d of (43)
        most, lean = self.zmp_range[0], self.constants.lean
        zmp_range = (lean, lean) if self.is_disabled else (-most, most)
        self.placement = FootPlacement(scene, self.chain, self.constants, zmp_range)

    def resume(self, task, speed):
        """Starts in the middle of a step, from the task and its rates: the gait has no clock, so its state can be measured. Returns
        False if the robot is standing."""
        x, v = task.x.tolist(), speed.tolist()
        lateral = MinimumJerkState(x[1], v[1])
        airborne = x[5] > self.airborne
        moving = [abs(v[k]) > 0.05 * self.L / self.t for k in (0, 1)]
        exchanging = moving[1] and self.f_h(lateral)[0] < 2 * self.airborne
        landed = self.stopping() and not airborne
        if not airborne and not exchanging and not (landed and moving[0]):
            return False
        self.phase, self.steps, self.W_1 = LAND if landed else WALK, 1, 0.5 * self.scene["speed"] * self.T
        self.since = max(0.0, 0.5 * self.T - self.time_left(lateral))
        self.com, self.foot = [MinimumJerkState(x[0], v[0]), lateral], MinimumJerkState(x[3], v[3])
        self.resumed = True
        return True

    def stopping(self):
        return self.time >= self.scene.get("stop_time", float("inf"))

    def exchange_due(self):
        """Whether x_2 has passed W_2/2 and moves on, and the following orbit is not quicker than the quickest one allowed."""
        lateral = self.com[1]
        if self.phase != WALK or lateral.x < 0.5 * self.width or lateral.v <= 0 or self.since < 0.1 * self.t:
            return False
        return MinimumJerkState(self.width - lateral.x, lateral.v).energy(self.omega[1]) >= self.orbit.quickest

    def errors(self, landed):
        """Errors of the step that has just landed. The corrections learn from them."""
        errors = {"landing": landed - self.landing}
        if self.steps > 0 and not self.is_disabled:
            errors |= {"step": self.W_1 - landed, "time": 0.5 * self.T - self.since}
        return errors

    def exchange(self, task):
        """Transforms the plan to the other supporting foot. `task` is the task before the exchange, in the old support frame."""
        t_1, t_3 = task.x[[3, 5]].tolist()
        self.corrections.learn(self.errors(t_1))
        sagittal, lateral = self.com
        x = self.width - lateral.x  # the exchange is up to a period late: same orbit, as far short of W_2/2
        v = -sqrt(max(0.0, lateral.v**2 - self.omega[1] ** 2 * (lateral.x**2 - x**2)))
        self.com = [MinimumJerkState(sagittal.x - t_1, sagittal.v, sagittal.a), MinimumJerkState(x, v, -lateral.a)]
        self.height -= t_3
        self.ground = 0.0
        self.foot, self.landing = MinimumJerkState(-t_1), -t_1
        self.steps, self.since, self.resumed = self.steps + 1, 0.0, False
        if self.stopping():
            self.phase, self.urgency = LAND, 0.0
            return
        self.lead_set_points()

    def lead_set_points(self):
        """Leads length and period of the steps toward the set-points, by the same share of what is missing. So no step is faster than
        both the old and the new speed."""
        period = self.scene["period"]
        missing = 0.5 * self.scene["speed"] * period - self.W_1
        change = clip(missing, (0.015 if period == self.T else 0.03) * self.L)
        self.W_1 += change
        if period != self.T:
            self.plan_with(period if change == missing else self.T + change / missing * (period - self.T))

    def plan(self, task, load):
        """The reference of one control period. `load` is that of the swing foot, over the weight."""
        self.change_phase()
        if self.phase == STAND:
            plan = self.hold(task)
        elif self.phase == SWAY:
            plan = self.move_com(task, (self.constants.lean, self.release))
        elif self.phase == LIFT:
            plan = self.lift_foot(task)
        elif self.phase == WALK:
            plan = self.walk(task, load)
        else:
            plan = self.balance(task)
        self.since, self.time = self.since + self.h, self.time + self.h
        return plan

    def change_phase(self):
        if self.since < self.duration.get(self.phase, float("inf")):
            return
        if self.phase == STAND and (self.scene["gait"] != "walk" or self.stopping()):
            return
        self.phase, self.since = self.phase + 1, 0.0
        if self.phase == REST:
            return
        self.com = [MinimumJerkState(axis.x) for axis in self.com]

    def zmp(self):
        """Zero-moment point of the plan."""
        sagittal, lateral = self.com
        p_1 = sagittal.x - (sagittal.a - self.gamma * self.foot.a) / self.omega[0] ** 2  # (31)
        return p_1, lateral.x - lateral.a / self.omega[1] ** 2  # (32)

    def hold(self, task):
        """Both feet are on the ground."""
        return self.reference(task, 0.0, 0.0, max(0.0, min(1.0, 1.0 - self.zmp()[1] / self.width)))

    def move_com(self, task, target):
        """Both feet are on the ground; the centre of gravity moves to the target."""
        left = self.duration[self.phase] - self.since
        move = lambda axis, to: axis.advance_toward(to, left, self.h) if left > self.freeze else MinimumJerkState(axis.x)
        self.com = [move(axis, to) for axis, to in zip(self.com, target)]
        return self.hold(task)

    def lift_foot(self, task):
        """The weight leaves the swing foot; meanwhile the foot rises along a minimum-jerk path."""
        height, _ = self.f_h(self.com[1])
        r = min(1.0, self.since / self.duration[LIFT])
        load = 1.0 - self.com[1].x / self.width * max(0.0, 1.0 - self.since / (0.1 * self.t))
        rate = 30 * r * r * (1 - r) ** 2 / self.duration[LIFT]
        return self.reference(task, height * r**3 * (10 - 15 * r + 6 * r * r), height * rate, max(0.0, min(1.0, load)))

    def walk(self, task, load):
        """One control period of walk: both axes are pendulums."""
        self.observe(task)
        sagittal, lateral = self.com
        left, missing = self.time_left(lateral), self.references()[1] - self.energies()[1]
        u_2 = self.orbit.input(lateral, missing, self.fading, self.zmp_range[1], not self.is_disabled)
        if self.scene["sagittal"] == "energy":
            u_1 = self.mirror_foot(left)
        else:
            zmp = self.place_foot(left)
            u_1 = self.gamma * self.foot.a - self.omega[0] ** 2 * zmp
        self.com = [sagittal.propagated(self.omega[0], u_1, self.h), lateral.propagated(self.omega[1], u_2, self.h)]  # (31), (32)
        height, rate = self.f_h(self.com[1])  # (43)
        higher = 1.0 + self.urgency
        return self.reference(task, *self.above_ground(task, load, height * higher, rate * higher), 1.0)

    def balance(self, task):
        """The end of a stop, on both feet where they are: ξ = x + v/ω returns to the middle between them. Across, the zero-moment point
        sets the loads of the feet; along, the ankles move it away from the mean of the soles' centres, weighted by the loads."""
        self.observe(task)
        foot, (along, across) = task.x[3].item(), self.zmp_range
        p_2 = min(max(self.led(1, 0.5 * self.width), -across), self.width + across)
        load = max(0.0, min(1.0, 1.0 - p_2 / self.width))
        centre = (1.0 - load) * foot
        p_1 = min(max(self.led(0, 0.5 * foot), centre - along), centre + along)
        self.com = [axis.propagated(w, -(w**2) * p, self.h) for axis, w, p in zip(self.com, self.omega, (p_1, p_2))]
        return self.reference(task, 0.0, 0.0, load)

    def led(self, k, middle):
        """Zero-moment point along an axis that leads ξ to the middle."""
        return middle + (1.0 + RETURN[k]) * (self.com[k].x + self.com[k].v / self.omega[k] - middle)

    def observe(self, task):
        """Corrects the plan by the measured centre of gravity. Under the paper's sagittal rule axis 1 is not corrected: the mirrored
        foot is still moving when it lands, and the jump of the measured speed would make the robot fall."""
        l_x, l_v = self.resting_observer if self.phase == REST else self.observer
        for k in (1,) if self.scene["sagittal"] == "energy" else (0, 1):
            error = task.x[k].item() - self.com[k].x
            self.com[k].x += l_x * error
            self.com[k].v += l_v * error

    def mirror_foot(self, left):
        """The paper's sagittal rule: x_t1 = 2 x_c1, and u_1 by (42)."""
        sagittal = self.com[0]
        self.landing = 2 * sagittal.propagated(self.omega[0], 0.0, left).x
        self.foot = MinimumJerkState(2 * sagittal.x, 2 * sagittal.v, 2 * sagittal.a)
        if abs(sagittal.v) < 0.02 * self.L / self.t:
            return copysign(INPUT_LIMIT, self.W_1) * (self.W_1 != 0.0)  # start from rest
        missing = self.references()[0] - self.energies()[0]
        return virtual_input(self.scene["sagittal_energy_gain"], missing, sagittal.v, self.fading, INPUT_LIMIT)

    def f_h(self, lateral):
        """Height of the swing foot (43) and its rate: a parabola in x_2, highest at the turning point."""
        r = max(0.0, -(lateral.x - 0.5 * self.width) / self.reach)
        h_max = self.scene["swing_height"]
        return h_max * min(r, 1.3) ** 2, -2 * h_max * r * lateral.v / self.reach if r < 1.3 else 0.0

    def time_left(self, lateral):
        """Time until the exchange, rounded up to whole periods. It takes place in the first period with x_2 beyond W_2/2."""
        left = lateral.time_to(0.5 * self.width, self.omega[1], self.T)
        return max(1.0, ceil(left / self.h)) * self.h

    def place_foot(self, left):
        """Moves the swing foot by one period toward its landing position. Returns the zero-moment point for the ankle."""
        foot, W_1 = self.foot, self.W_1 + self.corrections.step
        if left <= self.freeze:
            self.foot = MinimumJerkState(foot.x + self.h * foot.v, foot.v)
            return self.constants.lean
        self.landing, zmp, deviation = self.placement.place(self.com[0], foot, W_1, left)
        self.urgency = 0.0 if self.is_disabled else self.placement.urgency(deviation)
        clearance = min(1.0, self.f_h(self.com[1])[0] / (CLEAR * self.scene["swing_height"]))
        target = self.placement.within_reach(self.landing - self.corrections.landing, foot, W_1, clearance, left)
        self.foot = foot.advance_toward(target, left, self.h)
        return zmp

    def above_ground(self, task, load, height, rate):
        """Height of the swing foot and its rate: those of (43), which knows only level ground, or the height at which the foot has met
        a higher place. That is where it carries more than the supporting foot, and the kinematics say that it is in the air."""
        x_t3 = task.x[5].item()
        descends = self.com[1].v > 0 and self.scene["sagittal"] != "energy"  # under the paper's sagittal rule the foot always follows (43)
        if descends and load > TOUCH and x_t3 > self.airborne:
            self.ground = self.ground or x_t3
        return (self.ground, 0.0) if height < self.ground else (height, rate)

    def reference(self, task, lift, lift_rate, load):
        """Task rates (30) that make the measured task follow the plan; in walk and after it, they lead it by the delay of the servos."""
        low = self.scene["com_height"] - self.height
        climb = clip(2.0 * low, 0.1 * self.L) / self.t
        self.height += self.h * climb
        sagittal, lateral = self.com
        command = np.array([sagittal.x, lateral.x, self.height, self.foot.x, self.width, lift, 0.0])
        v_1, v_2, v_t = (axis.v + self.servo_lag * axis.a * (self.phase >= WALK) for axis in (sagittal, lateral, self.foot))
        rate = np.array([v_1, v_2, climb, v_t, 0.0, lift_rate, 0.0])
        c, t = self.scene["com_gain"], self.scene["swing_gain"]
        xdot = np.array([c, c, c, t, t, t, c]) * (command - task.x) + rate  # (30)
        if self.phase not in (WALK, LIFT):
            xdot[3:6] = 0.0  # a foot on the ground must not move
        support = load if self.phase > WALK else self.loaded(FIRST_SUPPORT, TOUCHDOWN)
        return Plan(xdot, (sagittal.a, lateral.a), load, support, self.zmp())

    def loaded(self, first, time):
        """Share of the weight on a new supporting foot: it rises from `first` to 1 within the time after an exchange."""
        return first + (1.0 - first) * min(1.0, self.since / (time * self.t)) if self.phase == WALK and self.steps > 0 else 1.0

    def energies(self):
        rest = self.constants.lean, 0.0
        return [MinimumJerkState(axis.x - x, axis.v).energy(omega) for axis, x, omega in zip(self.com, rest, self.omega)]

    def unit_energy(self):
        """E_1 by (42) for a step of 1 m."""
        e = exp(0.5 * self.omega[0] * self.T)
        return self.omega[0] ** 2 * e / (2 * (1 - e) ** 2)

    def references(self):
        return [
            self.unit_energy() * self.W_1**2,  # (42)
            lateral_energy(self.omega[1], self.width, self.T + 2 * self.corrections.time),  # (40)
        ]
