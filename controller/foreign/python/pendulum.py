"""The pendulums of the centre of gravity, their energies and orbits, (31)-(42), and minimum-jerk motions."""

from dataclasses import dataclass
from math import cosh, exp, log, sinh, sqrt


def clip(value, limit):
    return max(-limit, min(limit, value))


@dataclass
class MinimumJerkState:
    """Position, velocity and acceleration along one axis: the state of a minimum-jerk motion [m, m/s, m/s²]."""

    x: float
    v: float = 0.0
    a: float = 0.0

    def advance_toward(self, target, t, h):
        """The state after one period h of the quintic that comes to rest at the target in the time t."""
        d, v, a = target - self.x, self.v, self.a
        jerk = 60 * d / t**3 - 36 * v / t**2 - 9 * a / t
        snap = -360 * d / t**4 + 192 * v / t**3 + 36 * a / t**2
        crackle = 720 * d / t**5 - 360 * v / t**4 - 60 * a / t**3
        return MinimumJerkState(
            self.x + h * (v + h * (a / 2 + h * (jerk / 6 + h * (snap / 24 + h * crackle / 120)))),
            v + h * (a + h * (jerk / 2 + h * (snap / 6 + h * crackle / 24))),
            a + h * (jerk + h * (snap / 2 + h * crackle / 6)),
        )

    def propagated(self, omega, u, t):
        """The state of the pendulum ẍ = ω²x + u after a time t. (31), (32), (34)"""
        sh, ch, rest = sinh(omega * t), cosh(omega * t), -u / omega**2
        x = rest + (self.x - rest) * ch + self.v / omega * sh
        return MinimumJerkState(x, (self.x - rest) * omega * sh + self.v * ch, omega**2 * x + u)

    def energy(self, omega):
        return 0.5 * self.v**2 - 0.5 * (omega * self.x) ** 2  # (33)

    def time_to(self, width, omega, longest):
        """Time until the free motion reaches `width`, from a quadratic equation in e^(ωt)."""
        a, b = 0.5 * (self.x + self.v / omega), 0.5 * (self.x - self.v / omega)
        if a <= 1e-5:
            return longest
        root = sqrt(max(0.0, width**2 - 4 * a * b))
        return max(0.0, min(longest, log((width + root) / (2 * a)) / omega))


def virtual_input(gain, missing, v, fading, limit):
    """u that adds the missing energy, with v/(v² + v_0²) in place of the 1/v of (39), which is singular at rest."""
    return clip(gain * missing * v / (v * v + fading**2), limit)


def lateral_energy(omega, width, period):
    """E_2 of the orbit of this period with feet `width` apart."""
    e = exp(0.5 * omega * period)
    return -((omega * width) ** 2) * e / (2 * (1 + e) ** 2)  # (40)


def turning_point(omega, width, period):
    """Turning point of that orbit."""
    return 0.5 * width / cosh(0.25 * omega * period)
