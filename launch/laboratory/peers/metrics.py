"""What is measured on each scene, from poses alone, so that every engine is judged alike.

A trace has one row per `stride` steps: `x y z qw qx qy qz` of the body; on the biped's scenes the places of both feet,
or (free) the kinetic energy.
"""

from math import cos, radians

import numpy as np

import scenes as s

NEAR_IMPACT = radians(5)  # the wheel's spin is read this far from an impact and carried there by conservation of energy


def stride(scene, steps):
    """Steps between two rows of the trace that `measure` asks for."""
    if scene.name in ("turn", "ball"):
        return steps
    if scene.name == "free":
        return max(steps // 100, 1)
    return 1 if scene.name in ("drop", "rock", "wheel") else steps // 2


def measure(scene, trace, dt):
    """Metric -> error; infinite where the run blew up."""
    if scene.name == "free":
        energy = trace[:, 0]
        found = {"energy": np.abs(energy / energy[0] - 1).max()}
    else:
        found = _MEASURES[scene.name](scene, trace, dt)
    return {name: error if np.isfinite(error) and error < 1e6 else float("inf") for name, error in found.items()}


def _slide(scene, trace, dt):
    way = trace[-1, :2] - trace[0, :2]
    ahead = np.array(scene.velocity[:2]) / np.hypot(*scene.velocity[:2])
    along, across = way @ ahead, way @ np.array([-ahead[1], ahead[0]])
    return {"stop": abs(along / s.STOP - 1), "straight": abs(across) / s.STOP}


def _incline(scene, trace, dt):
    return {"distance": abs((trace[-1, 0] - trace[0, 0]) / s.INCLINE - 1)}


def _creep(scene, trace, dt):
    """Mean speed over the second half; of the feet the faster one."""
    way = (trace[-1] - trace[len(trace) // 2])[: 3 if scene.body else 6].reshape(-1, 3)
    return {"creep_m_per_s": np.linalg.norm(way, axis=1).max() / (scene.duration / 2)}


def _drop(scene, trace, dt):
    up = np.abs(_rotations(trace)[:, 2, :]) @ np.array(scene.body.box) / 2
    gap = trace[:, 2] - up
    deepest = gap.argmin()
    return {"penetration_m": max(0.0, -gap[deepest]), "hop_m": max(0.0, gap[deepest:].max())}


def _rock(scene, trace, dt):
    """How far the block rises on its other edge."""
    tilt = -_pitch(trace)
    top = int(np.clip(tilt.argmax(), 1, len(tilt) - 2))
    a, b, c = tilt[top - 1 : top + 2]
    apex = b - (c - a) ** 2 / (8 * (a - 2 * b + c)) if a + c < 2 * b else b
    return {"apex": abs(apex / s.ROCK_APEX - 1)}


def _wheel(scene, trace, dt):
    """Mean speed between upright instants, and ratio of spins at impacts, over the second half."""
    angle = _pitch(trace)
    if not np.isfinite(angle).all():
        return {"speed": np.inf, "ratio": np.inf}
    first, last = angle[len(angle) // 2], angle[-2]
    upright = [t for t, _ in _crossings(angle, first, last, s.SPOKE_ANGLE / 2)]
    if len(upright) < 2:
        return {"speed": 1.0, "ratio": 1.0}  # it stopped
    start, end = np.interp([upright[0], upright[-1]], np.arange(len(angle)), trace[:, 0])
    speed = (end - start) / ((upright[-1] - upright[0]) * dt)
    begin, finish = -s.SPOKE_ANGLE / 2 + s.WHEEL_SLOPE, s.SPOKE_ANGLE / 2 + s.WHEEL_SLOPE  # angles from gravity
    gain = 2 * s.WHEEL_PULL * (cos(begin) - cos(begin + NEAR_IMPACT))
    loss = 2 * s.WHEEL_PULL * (cos(finish - NEAR_IMPACT) - cos(finish))
    before = [(rate / dt) ** 2 + loss for _, rate in _crossings(angle, first, last, -NEAR_IMPACT)]
    after = [(rate / dt) ** 2 - gain for _, rate in _crossings(angle, first, last, NEAR_IMPACT)]
    count = min(len(before), len(after))
    ratio = np.sqrt(np.mean(after[-count:]) / np.mean(before[-count:]))
    return {"speed": abs(speed / s.WHEEL_SPEED - 1), "ratio": abs(ratio / s.WHEEL_RATIO - 1)}


def _turn(scene, trace, dt):
    """How far it turned, and where it got."""
    rotation, way = _rotations(trace)[-1], trace[-1, :2] - trace[0, :2]
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    return {"yaw": abs(yaw / s.TURN_YAW - 1), "way": np.linalg.norm(way - s.TURN_WAY) / np.linalg.norm(s.TURN_WAY)}


def _ball(scene, trace, dt):
    """Its angle, as a share of that at the start, and where it got, as a share of what it rolls in the quarter of a period."""
    angle, way = _pitch(trace)[-1], trace[-1, 0] - trace[0, 0]
    rolled = scene.body.radius * scene.pitch
    return {"angle": abs((angle - s.BALL_ANGLE) / scene.pitch), "way": abs((way - s.BALL_WAY) / rolled)}


def _crossings(angle, first, last, offset):
    """(time, rate), in steps, at which `angle` passes offset + k spokes between `first` and `last`, by a cubic."""
    found = []
    for k in range(int(np.ceil((first - offset) / s.SPOKE_ANGLE)), int(np.floor((last - offset) / s.SPOKE_ANGLE)) + 1):
        level = offset + k * s.SPOKE_ANGLE
        i = int(np.argmax(angle > level)) - 1
        cubic = np.polynomial.Polynomial.fit([-1, 0, 1, 2], angle[i - 1 : i + 3] - level, 3, domain=[-1, 1])
        at = np.interp(0, angle[i : i + 2] - level, [0, 1])
        for _ in range(3):
            at -= cubic(at) / cubic.deriv()(at)
        found.append((i + at, cubic.deriv()(at)))
    return found


def _rotations(trace):
    w, x, y, z = trace[:, 3:7].T
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]).transpose(2, 0, 1)


def _pitch(trace):
    rotation = _rotations(trace)
    return np.unwrap(np.arctan2(rotation[:, 0, 2], rotation[:, 2, 2]))


_MEASURES = {
    "slide": _slide,
    "slide30": _slide,
    "incline": _incline,
    "stick": _creep,
    "drop": _drop,
    "stand0": _creep,
    "stand10": _creep,
    "rock": _rock,
    "wheel": _wheel,
    "turn": _turn,
    "ball": _ball,
}
