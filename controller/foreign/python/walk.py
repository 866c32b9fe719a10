"""The walking controller of Fujimoto & Kawamura (1995), section 3, in NumPy: an independent second implementation. Symbols and
equation numbers are those of the paper. From the same encoder counts it computes the torques of the controller in Rust, up to rounding.
Only the relay and a plan without feedback amplify that rounding.

    biped run walk --controller "python3 controller/foreign/python/walk.py"

robot.py: kinematics (25)-(27), rate QP (28), (29). pendulum.py, corrections.py, gait.py: (30)-(43). Here: servo (23), (24), load of
the swing foot, ankles, and the tick.

It lacks the QP with bounds, and refuses the settings that need it.
"""

from math import ceil, exp, floor, inf, log10, tau

import session  # first, because it reports missing packages
import numpy as np

from gait import AIRBORNE, Gait, right_supports
from robot import Chain, Constants, level, mirror, resolve

# for the robot of Table 1; scaled for another robot, see Chain
RATE_LIMIT = 12.0  # largest joint rate reference [rad/s]
RELAY, SATURATION = 60.0, 180.0  # acceleration toward the sliding surface, by relay or boundary layer [rad/s²]
PERIODS, LONGEST_STEP = (0.3, 2.0), 0.25  # accepted in a scene and by request: period of two steps [s], step [m]
LOAD_FILTER = 100.0  # rate of the low-pass filter of the swing foot's load [1/s]; a foot that lands takes its load in 10 to 20 ms
LOADING = 0.04  # time in which the weight moves to the new supporting foot after an exchange [s]
# these are not scaled
FIRST_LOAD = 0.15  # share of the weight on the new supporting foot immediately after an exchange
SWING_SHARE = 0.31, 0.8  # pitch and roll torque limit of the swing foot's ankle, over that of a supporting foot at rest
PUSHED_SWING_SHARE = 0.8, 0.8  # the same after a strong push forward or backward: with less, the foot would turn in the quick step
ANKLES = (1, 0), (0, 1)  # joint, and axis along which it moves the zero-moment point: pitch forward, roll sideways


def inward(bound, direction):
    """A bound with three digits, rounded by floor or ceil so that it is itself accepted."""
    unit = floor(log10(bound)) - 2
    digits = bound * 10.0**-unit
    is_near = abs(digits - round(digits)) <= 1e-12 * digits  # rounding of the bound itself
    return f"{float(f'{round(digits) if is_near else direction(digits)}e{unit}'):g}"


class Servo:
    """Sliding mode on each joint's rate with a disturbance observer: τ = τ_ff − J sat(κσ) + d̂, σ = q̇ − q̇_ref. With the share s of the
    weight on the supporting foot J = s⁴ J_n + (1 − s)⁴ J'_n, J'_n that of the other foot; the paper's numbers J_n stay as they are."""

    def __init__(self, scene, nominal_inertia, h, time):
        self.J_n, self.h = nominal_inertia, h
        swap = np.array([mirror(unit) for unit in np.eye(8)])
        self.J_other = None if scene.get("nominal_inertia") == "diagonal" else swap @ self.J_n @ swap
        self.kappa, self.relay = scene["switch_rate"], scene["switching"] == "relay"
        self.reach = (RELAY if self.relay else SATURATION) / time**2
        self.forget = exp(-scene["observer_bandwidth"] * h)
        self.disturbance, self.effort, self.rate = np.zeros(8), np.zeros(8), None

    def observe(self, rate):
        """Returns the acceleration, and updates the disturbance: the part of it that the effort of the last period does not explain."""
        acceleration = np.zeros(8) if self.rate is None else (rate - self.rate) / self.h
        unexplained = self.effort - self.J_n @ acceleration
        self.disturbance = self.disturbance * self.forget + unexplained * (1.0 - self.forget)
        self.rate = rate
        return acceleration

    def drive(self, rate, reference, feed_forward, limits, support):
        J = self.J_n if self.J_other is None else support**4 * self.J_n + (1.0 - support) ** 4 * self.J_other
        sigma = rate - reference
        switch = self.reach * np.sign(sigma) if self.relay else np.clip(self.kappa * sigma, -self.reach, self.reach)
        torque = np.clip(feed_forward + self.disturbance - J @ switch, *limits)  # (24)
        self.effort = torque - feed_forward  # after the limit: otherwise the observer would wind up
        return torque, sigma

    def exchange(self):
        """Transforms the state to the other support order, with zero disturbance for the new swing leg."""
        self.disturbance, self.effort, self.rate = mirror(self.disturbance), mirror(self.effort), mirror(self.rate)
        self.disturbance[4:] = 0.0


class Load:
    """Load of the swing foot over the weight, by the power of joint rates v that raise the foot by 1 m/s and leave the rest of the task
    as it is: F = −vᵀ(τ − (M + J_r 1) q̈). Neither gravity nor the ground under the other foot does work. M is that in the middle of a
    step."""

    def __init__(self, inertia, weight, h, time):
        self.inertia, self.weight, self.share = inertia, weight, 1.0 - exp(-LOAD_FILTER / time * h)
        self.torque, self.value = np.zeros(8), 0.0

    def estimate(self, rise, acceleration):
        """Updates the load by the acceleration that the torque of the last period has caused. `rise` is v."""
        force = rise @ (self.inertia @ acceleration - self.torque)
        self.value += self.share * (force / self.weight - self.value)

    def exchange(self):
        """Transforms the state to the other support order. The two feet carry the weight together."""
        self.torque, self.value = mirror(self.torque), 1.0 - self.value


class Walk:
    def __init__(self, scene, rate):
        self.plant, self.scene, self.h = scene["plant"], scene["controller"], 1.0 / rate
        if "rate_limit" in self.scene or "torque_bound" in self.scene:
            session.fail(2, "controller.rate_limit and torque_bound need a QP with bounds, which walk.py does not have")
        self.chain = Chain(scene["bodies"])
        if self.scene["gait"] == "walk" and (reason := self.refusal(self.scene)):
            session.fail(2, reason)
        self.constants = Constants(self.chain, self.scene, self.plant)
        self.servo, self.load = self.new_servo(), self.new_load()
        self.count = tau / 2 ** self.plant["encoder_bits"]  # [rad]
        self.share = 1.0 - exp(-tau * self.scene["rate_filter_hz"] * self.h)
        self.angle, self.rate, self.gait, self.right, self.readings = None, np.zeros(8), None, False, 0
        self.begin = 0.0

    def begin_at(self, time):
        """Sets the simulated time of the first reading [s], which a controller that takes over needs for the stop time."""
        self.begin = time

    def ordered(self, q):
        """Converts wire order to support order, and back."""
        return mirror(q) if self.right else q

    def new_gait(self, task):
        return Gait(self.scene, self.chain, self.constants, self.h, task, self.time())

    def new_servo(self):
        return Servo(self.scene, self.constants.nominal_inertia, self.h, self.chain.time)

    def new_load(self):
        return Load(self.constants.inertia, self.chain.total * self.plant["gravity"], self.h, self.chain.time)

    def detect_initial_state(self):
        """In the first two periods: determines the supporting foot, and whether the robot is already stepping."""
        from_left = self.chain.task(self.angle)
        if self.readings == 1:
            self.right = bool(right_supports(from_left, False, AIRBORNE * self.chain.length))
            return
        before, self.right = self.right, bool(right_supports(from_left, True, AIRBORNE * self.chain.length))
        rate = self.rate / self.share  # without the filter's delay
        task = self.chain.task(self.ordered(self.angle))
        gait = self.new_gait(task)
        if gait.resume(task, task.jacobian @ self.ordered(rate)):  # (27)
            self.gait, self.rate = gait, rate
            self.servo, self.load = self.new_servo(), self.new_load()
        else:
            self.right = before

    def refusal(self, scene):
        """Why a gait is refused, if it is: its period is out of range, or a step is longer than the foot reaches."""
        period, speed, more = scene["period"], scene["speed"], 1 + 1e-9  # rounding of set-points that are scaled to another robot
        shortest, longest = (period * self.chain.time for period in PERIODS)
        most = LONGEST_STEP * self.chain.length
        if shortest / more <= period <= longest * more and abs(0.5 * period * speed) <= most * more:
            return None
        return (
            f"controller.period = {period:g} s and controller.speed = {speed:g} m/s are out of range: the period must be "
            f"{inward(shortest, ceil)} to {inward(longest, floor)} s, and a step, half a period times the speed, at most "
            f"{inward(most, floor)} m"
        )

    def set(self, speed, period):
        """Changes walking speed [m/s] and period of two steps [s]; None leaves them. ValueError if they are out of range, NoEffect if the
        robot only stands or its walk ends already."""
        changes = {"speed": speed, "period": period}
        scene = self.scene | {key: value for key, value in changes.items() if value is not None}
        if scene["gait"] != "walk" or self.time() >= scene.get("stop_time", inf):
            raise session.NoEffect("the robot stands or stops")
        if reason := self.refusal(scene):
            raise ValueError(reason)
        self.scene = scene
        if self.gait:
            self.gait.set_points(scene)

    def stop(self):
        """Ends the walk: the robot stops at the end of the step under way."""
        self.scene = self.scene | {"stop_time": min(self.time(), self.scene.get("stop_time", inf))}
        if self.gait:
            self.gait.scene = self.scene

    def time(self):
        """Simulated time of the next reading [s]."""
        return self.gait.time if self.gait else self.begin

    def tick(self, counts, telemetry):
        angle = np.array(counts, dtype=float) * self.count
        if self.angle is not None:
            self.rate = self.rate + self.share * ((angle - self.angle) / self.h - self.rate)
        self.angle, self.readings = angle, self.readings + 1
        if self.readings <= 2:
            self.detect_initial_state()
        task = self.chain.task(self.ordered(angle))  # (25)-(27)
        self.gait = self.gait or self.new_gait(task)
        if self.gait.exchange_due():
            self.gait.exchange(task)
            self.servo.exchange()
            self.load.exchange()
            self.right = not self.right
            task = self.chain.task(self.ordered(angle))
        rate = self.ordered(self.rate)
        self.load.estimate(task.inverse[:, 5], self.servo.observe(rate))
        plan = self.gait.plan(task, self.load.value)  # (30)-(43)
        feed_forward = self.feed_forward(task, plan)
        reference = resolve(task, plan.xdot, level(task.swing_pitch / self.chain.time))  # (28), (29)
        fastest = RATE_LIMIT / self.chain.time
        reference = np.clip(reference, -fastest, fastest)
        torque, sigma = self.servo.drive(rate, reference, feed_forward, self.limits(task, plan), plan.support)  # (24)
        self.load.torque = torque
        self.fill_telemetry(telemetry, task, sigma)
        return self.ordered(torque)

    def feed_forward(self, task, plan):
        """τ = M (g J_c3ᵀ + a_1 J_c1ᵀ + a_2 J_c2ᵀ), shared between the feet by the load. If one foot carries the whole
        weight, its ankle gets the torque of the planned zero-moment point. Otherwise the roll torque of the swing foot's ankle is
        zero, and that of the supporting foot's ankle is the remainder of the balance."""
        if not self.scene["feed_forward"]:
            return np.zeros(8)
        M, g, (a_1, a_2) = self.chain.total, self.plant["gravity"], plan.acceleration
        stance = M * (np.array([a_1, a_2, g]) @ task.jacobian[:3])
        if plan.load >= 1.0:
            for joint, axis in ANKLES:
                stance[joint] = self.ankle_torque(task, joint, axis, plan.zmp[axis], plan.acceleration[axis])
            return stance
        other = self.chain.task(mirror(self.ordered(self.angle)))  # axis 2 of its support frame points the opposite way
        swing = mirror(M * (np.array([a_1, -a_2, g]) @ other.jacobian[:3]))
        shared = plan.load * stance + (1.0 - plan.load) * swing
        shared[0] = -M * g * (plan.zmp[1] - (1.0 - plan.load) * self.chain.width)
        shared[7] = 0.0
        return shared

    def ankle_torque(self, task, joint, axis, p, a):
        """Torque at an ankle joint for the zero-moment point p and the acceleration a: the torque for a point mass, whose zero-moment
        point is x − a x_3/g, and a second term that moves that point to p. The pitch axis rolls with the ankle."""
        g, x, lift, lever = self.plant["gravity"], task.x[axis], task.jacobian[2, joint], task.jacobian[axis, joint]
        level = 1.0 if axis == 1 else task.roll_cosine
        return self.chain.total * (g * lift + a * lever + np.copysign(level, lever) * (g * (x - p) - a * task.x[2]))

    def limits(self, task, plan):
        """Torque limits: those of the drives and, at the ankles, those that keep the soles flat on the ground [N·m]. A foot that
        carries the whole weight tips when the zero-moment point reaches its edge, with a = ω² (x − p), (31), (32). A foot that
        shares the load, and the swing foot, get a share of the torque at rest. A drive that accelerates needs its own torque J_r q̈
        in addition. After a push forward or backward, the new supporting foot counts as loaded at once, its a is the planned one, and
        the ankle of the swing foot gets more torque."""
        gait, constants, ends = self.gait, self.constants, np.array([-1.0, 1.0])
        loaded = gait.loaded(FIRST_LOAD, LOADING)
        loaded += (1.0 - loaded) * gait.urgency
        limits = np.outer(ends, np.full(8, self.plant["torque_limit"]))
        xddot = np.array([*plan.acceleration, 0.0, gait.foot.a, 0.0, 0.0, 0.0])
        inertia = self.plant["drive_inertia"] if self.scene["feed_forward"] else 0.0
        drives = inertia * (task.inverse @ xddot)
        for joint, axis in ANKLES:
            at_rest = constants.ankle_limit[axis] * ends
            if plan.load < 1.0:
                stance, swing = plan.load * at_rest, (1.0 - plan.load) * at_rest
            else:
                p = loaded * constants.sole_edge[axis] * ends
                a = constants.omega[axis] ** 2 * (task.x[axis] - p)
                a += (gait.urgency, 0.0)[axis] * (plan.acceleration[axis] - a)
                share = SWING_SHARE[axis] + (PUSHED_SWING_SHARE[axis] - SWING_SHARE[axis]) * gait.urgency
                stance, swing = np.sort(self.ankle_torque(task, joint, axis, p, a)), share * at_rest
            limits[:, joint], limits[:, 7 - joint] = stance + drives[joint], swing + drives[7 - joint]
        return limits.clip(-self.plant["torque_limit"], self.plant["torque_limit"])

    def fill_telemetry(self, telemetry, task, sigma):
        gait, (sagittal, lateral) = self.gait, self.gait.com
        telemetry.phase, telemetry.support, telemetry.steps = gait.phase, int(self.right), gait.steps
        telemetry.com[:], telemetry.swing[:] = task.x[0:3], task.x[3:6]
        telemetry.pendulum[:] = sagittal.x, sagittal.v, lateral.x, lateral.v
        telemetry.energy[:], telemetry.energy_ref[:] = gait.energies(), gait.references()
        telemetry.landing, telemetry.surface[:] = gait.landing, self.ordered(sigma)


if __name__ == "__main__":
    session.serve(Walk)
