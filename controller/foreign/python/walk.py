"""Walks: the controller of Fujimoto & Kawamura (1995), section 3, a second time, in NumPy. Letters and equation numbers are
the paper's.

    biped run walk --controller "python3 controller/foreign/python/walk.py"

robot.py: kinematics (25)-(27), rate QP (28), (29). gait.py: (30)-(43). Here: servo (23), (24), and the tick.
"""

from math import exp, tau

import numpy as np

import session
from gait import AIRBORNE, WALK, Gait, right_supports
from robot import Chain, Constants, level, mirror, resolve

RATE_LIMIT = 12.0  # greatest joint rate that is asked for [rad/s]


class Servo:
    """Sliding mode on each joint's rate with a disturbance observer: τ = τ_ff − J_n sat(κσ) + d̂, σ = q̇ − q̇_ref."""

    def __init__(self, scene, nominal_inertia, h, time):
        self.J_n, self.h, self.reach = nominal_inertia, h, 60.0 / time**2
        self.kappa, self.relay = scene["switch_rate"], scene["switching"] == "relay"
        self.forget = exp(-scene["observer_bandwidth"] * h)
        self.disturbance, self.effort, self.rate = np.zeros(8), np.zeros(8), None

    def observe(self, rate):
        """What the effort of the last period did not explain."""
        if self.rate is not None:
            unexplained = self.effort - self.J_n * (rate - self.rate) / self.h
            self.disturbance = self.disturbance * self.forget + unexplained * (1.0 - self.forget)
        self.rate = rate

    def drive(self, rate, reference, feed_forward, limit):
        sigma = rate - reference
        switch = self.reach * np.sign(sigma) if self.relay else np.clip(self.kappa * sigma, -self.reach, self.reach)
        torque = np.clip(feed_forward + self.disturbance - self.J_n * switch, -limit, limit)  # (24)
        self.effort = torque - feed_forward  # after the limit, or the observer winds up
        return torque, sigma

    def exchange(self):
        """To the other support order; the new swing leg forgets what it held against the ground."""
        self.disturbance, self.effort, self.rate = mirror(self.disturbance), mirror(self.effort), mirror(self.rate)
        self.disturbance[4:] = 0.0


class Walk:
    def __init__(self, scene, rate):
        self.plant, self.scene, self.h = scene["plant"], scene["controller"], 1.0 / rate
        if "rate_limit" in self.scene or "torque_bound" in self.scene:
            session.fail(2, "controller.rate_limit and torque_bound need a QP with bounds, which walk.py has not")
        self.chain = Chain(scene["bodies"])
        self.constants = Constants(self.chain, self.scene["com_height"], self.plant)
        self.servo = Servo(self.scene, self.constants.nominal_inertia, self.h, self.chain.time)
        self.count = tau / 2 ** self.plant["encoder_bits"]  # [rad]
        self.share = 1.0 - exp(-tau * self.scene["rate_filter_hz"] * self.h)
        self.angle, self.rate, self.gait, self.right, self.readings = None, np.zeros(8), None, False, 0

    def ordered(self, q):
        """Wire order to support order and back."""
        return mirror(q) if self.right else q

    def new_gait(self, task):
        return Gait(self.scene, self.chain, self.constants, self.h, task)

    def take_over(self):
        """In the first two ticks: on which foot the robot stands, and whether it is already stepping."""
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
            self.servo = Servo(self.scene, self.constants.nominal_inertia, self.h, self.chain.time)
        else:
            self.right = before

    def tick(self, counts, telemetry):
        angle = np.array(counts, dtype=float) * self.count
        if self.angle is not None:
            self.rate = self.rate + self.share * ((angle - self.angle) / self.h - self.rate)
        self.angle, self.readings = angle, self.readings + 1
        if self.readings <= 2:
            self.take_over()
        task = self.chain.task(self.ordered(angle))  # (25)-(27)
        self.gait = self.gait or self.new_gait(task)
        if self.gait.exchange_due():
            self.gait.exchange(task)
            self.servo.exchange()
            self.right = not self.right
            task = self.chain.task(self.ordered(angle))
        plan = self.gait.plan(task)  # (30)-(43)
        rate = self.ordered(self.rate)
        self.servo.observe(rate)
        feed_forward = self.feed_forward(task, plan)
        reference = resolve(task.jacobian, plan.xdot, level(task.swing_pitch / self.chain.time))  # (28), (29)
        fastest = RATE_LIMIT / self.chain.time
        reference = np.clip(reference, -fastest, fastest)
        torque, sigma = self.servo.drive(rate, reference, feed_forward, self.limits(plan))  # (24)
        self.tell(telemetry, task, sigma)
        return self.ordered(torque)

    def feed_forward(self, task, plan):
        """τ = M (g J_c3ᵀ + a_1 J_c1ᵀ + a_2 J_c2ᵀ), shared between the feet by load. With both feet down the swing
        foot's ankle does not roll, and the stance foot's carries only what the loads leave over."""
        if not self.scene["feed_forward"]:
            return np.zeros(8)
        M, g, (a_1, a_2) = self.chain.total, self.plant["gravity"], plan.acceleration
        stance = M * (np.array([a_1, a_2, g]) @ task.jacobian[:3])
        if plan.load >= 1.0:
            return stance
        other = self.chain.task(mirror(self.ordered(self.angle)))  # seen from it, axis 2 points the other way
        swing = mirror(M * (np.array([a_1, -a_2, g]) @ other.jacobian[:3]))
        shared = plan.load * stance + (1.0 - plan.load) * swing
        shared[0] = -M * g * (plan.zmp - (1.0 - plan.load) * self.chain.width)
        shared[7] = 0.0
        return shared

    def limits(self, plan):
        """The drives' limits, and at the ankles what leaves the soles flat on the ground [N·m]."""
        gait, roll_limit, pitch_limit = self.gait, self.constants.ankle_roll, self.constants.ankle_pitch
        stepping = gait.phase == WALK and gait.steps > 0
        stance = plan.load * (0.15 + 0.85 * min(1.0, gait.since / (0.04 * self.chain.time)) if stepping else 1.0)
        if plan.load < 1.0:
            swing = (1.0 - plan.load, 1.0 - plan.load)
        else:
            light = 0.3 if plan.time_left is not None and plan.time_left < 0.02 * self.chain.time else 1.0
            swing = (0.46 * light, 0.31 * light)
        limit = np.full(8, self.plant["torque_limit"])
        ankles = [roll_limit * stance, pitch_limit * stance, pitch_limit * swing[1], roll_limit * swing[0]]
        limit[[0, 1, 6, 7]] = np.minimum(limit[[0, 1, 6, 7]], ankles)
        return limit

    def tell(self, telemetry, task, sigma):
        gait, (sagittal, lateral) = self.gait, self.gait.com
        telemetry.phase, telemetry.support, telemetry.steps = gait.phase, int(self.right), gait.steps
        telemetry.com[:], telemetry.swing[:] = task.x[0:3], task.x[3:6]
        telemetry.pendulum[:] = sagittal.x, sagittal.v, lateral.x, lateral.v
        telemetry.energy[:], telemetry.energy_ref[:] = gait.energies(), gait.references()
        telemetry.landing, telemetry.surface[:] = gait.landing, self.ordered(sigma)


if __name__ == "__main__":
    session.serve(Walk)
