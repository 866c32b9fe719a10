"""The pendulums of the centre of gravity, their energies and orbits, (31)-(42), and minimum-jerk motions. The energy of an orbit
stabilises the lateral pendulum. The placement of the foot stabilises the sagittal pendulum."""

from dataclasses import dataclass
from math import cosh, exp, expm1, log, sinh, sqrt, tanh

# for the robot of Table 1; scaled for another robot, see Chain
SHORTEST = 0.03  # shortest horizon of a correction by the ankle [s]
FARTHEST = 0.25  # largest distance of a landing foot from the supporting foot [m]
DEVIATION = 0.015, 0.04  # deviations of ξ_1 between which the limits of a pushed robot widen [m]
# these are not scaled
CAPTURE_GAIN = 3.0  # shift of the zero-moment point per distance of ξ from the slowest orbit; below 1 the robot would not return
SLOWEST, QUICKEST = 1.2, 0.8  # period of the allowed orbits, over the period of the gait
DECAYING = 0.3, 0.8  # range of ζ in widths W_2
ANKLE_SHARE = 0.7  # g: share of a sagittal deviation that the ankle corrects
SWING_ACCELERATION = 12.0, 18.0  # largest of the swing foot, near the ground and clear of it [m/s²]
SPARE = 1.25  # acceleration that the foot may always have, over that of the steady gait
MINIMUM_JERK_PEAK = 5.7735  # largest acceleration of a minimum-jerk motion, over d/t²: 10/√3


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


class LateralOrbit:
    """The orbit of the gait's period. E = −ω² ξ ζ/2 with ξ = x + v/ω, which diverges, and ζ = x − v/ω, which decays."""

    def __init__(self, scene, omega, width):
        self.gain, self.omega, self.width, T = scene["energy_gain"], omega, width, scene["period"]
        self.inner = turning_point(omega, width, T)
        self.slowest = turning_point(omega, width, SLOWEST * T) ** 2  # ξ ζ
        self.quickest = lateral_energy(omega, width, QUICKEST * T)

    def input(self, lateral, missing, fading, most_zmp, captures):
        """u_2: the energy rule, and the ankle where that rule alone would act too late. A robot that is pushed out of the slowest orbit
        returns to it at once."""
        w, most = self.omega, most_zmp * self.omega**2
        u_2 = virtual_input(self.gain, missing, lateral.v, fading, most)  # (39)
        if not captures:
            return u_2
        least, greatest = (share * self.width for share in DECAYING)
        xi, zeta = lateral.x + lateral.v / w, max(least, min(greatest, lateral.x - lateral.v / w))
        return clip(u_2 + CAPTURE_GAIN * max(0.0, self.slowest / zeta - xi) * w * w, most)


class FootPlacement:
    """x_t1 = x_e + W_1/2 + K (v_e − v_ref) with the predicted touchdown (x_e, v_e), K = k coth(ωT/2)/ω, and until then the ankle's
    zero-moment point p = d + g (ξ_e − ξ_ref)/(e^(ωt) − 1) with ξ = x + v/ω. With g = 1 it alone would remove a deviation before
    touchdown. d is the lean: x is relative to it."""

    def __init__(self, scene, chain, constants, zmp_range):
        self.omega, self.gamma, self.lean, self.T = constants.omega[0], constants.gamma, constants.lean, scene["period"]
        self.zmp_range, self.farthest, self.shortest = zmp_range, FARTHEST * chain.length, SHORTEST * chain.time
        self.deviation = [distance * chain.length for distance in DEVIATION]
        quarter = 0.25 * self.omega * self.T
        self.K = scene["foot_placement_gain"] / (self.omega * tanh(2 * quarter))
        self.touchdown_speed = self.omega * (0.5 / tanh(quarter) - self.gamma / sinh(quarter))  # v_ref over W_1

    def place(self, com, foot, W_1, left):
        """x_t1, p and the present deviation of ξ. The prediction depends on x_t1 through γ ẍ_t; the equation is linear in x_t1 and is
        solved for it."""
        w, gamma, v_ref = self.omega, self.gamma, self.touchdown_speed * W_1
        com = MinimumJerkState(com.x - self.lean, com.v)  # about the steady gait's zero-moment point
        # change of x_e and of v_e per metre of foot motion
        per_x, per_v = gamma * cosh(0.5 * w * left), gamma * w * sinh(0.5 * w * left)

        def touchdown(zmp):
            """x_e, v_e, and the distance of the foot to its landing position, for this zero-moment point."""
            e = com.propagated(w, -w * w * zmp, left)
            x_e, v_e = e.x - gamma * sinh(w * left) * foot.v / w, e.v - gamma * cosh(w * left) * foot.v
            distance = (x_e + 0.5 * W_1 + self.K * (v_e - v_ref) - foot.x) / (1 - per_x - self.K * per_v)
            return x_e + per_x * distance, v_e + per_v * distance, distance

        x_e, v_e, _ = touchdown(0.0)
        deviation = x_e - 0.5 * W_1 + (v_e - v_ref) / w  # ξ_e − ξ_ref
        low, high = self.zmp_range
        zmp = max(low, min(high, self.lean + ANKLE_SHARE * deviation / expm1(w * max(left, self.shortest))))
        return clip(foot.x + touchdown(zmp - self.lean)[2], self.farthest), zmp, deviation * exp(-w * left)

    def urgency(self, deviation):
        """Share to which limits widen, so that a pushed robot may do more than a robot on its orbit: from 0 to 1, without a kink."""
        low, high = self.deviation
        r = max(0.0, min(1.0, (abs(deviation) - low) / (high - low)))
        return r * r * (3 - 2 * r)

    def within_reach(self, target, foot, W_1, clearance, left):
        """The target, or the position nearest to it that the foot reaches in the time left."""
        steady = SPARE * MINIMUM_JERK_PEAK * 2 * abs(W_1) / (0.5 * self.T) ** 2  # each step moves the foot by 2 W_1
        near_ground, in_the_air = (max(most, steady) for most in SWING_ACCELERATION)
        reach = (near_ground + (in_the_air - near_ground) * clearance) / MINIMUM_JERK_PEAK * left**2
        coasting = foot.x + 0.5 * foot.v * left
        return coasting + clip(target - coasting, reach)
