"""A standing controller: a spring and a damper hold every joint at its initial angle.

    biped run stand --controller "python3 controller/foreign/python/stand.py"
"""

from math import exp, tau

import session

STIFFNESS = 1000.0  # [N·m/rad]
DAMPING = 40.0  # [N·m·s/rad]
CUT_OFF = 150.0  # of the low-pass filter of the rates [Hz]


class Stand:
    def __init__(self, scene, rate):
        self.target = scene["initial"]["joints"]
        self.count = tau / 2 ** scene["plant"]["encoder_bits"]  # [rad]
        self.limit = scene["plant"]["torque_limit"]
        self.rate, self.share = rate, 1.0 - exp(-tau * CUT_OFF / rate)
        self.angle, self.speed = None, [0.0] * len(self.target)

    def tick(self, counts, telemetry):
        angle = [self.count * count for count in counts]
        before = self.angle or angle
        difference = [(q - p) * self.rate for q, p in zip(angle, before)]
        self.speed = [v + self.share * (d - v) for v, d in zip(self.speed, difference)]
        self.angle = angle
        torque = [STIFFNESS * (w - q) - DAMPING * v for w, q, v in zip(self.target, angle, self.speed)]
        return [max(-self.limit, min(self.limit, t)) for t in torque]


if __name__ == "__main__":
    session.serve(Stand)
