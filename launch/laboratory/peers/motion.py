"""Where two bodies get whose equations have no closed solution: by the classical method of fourth order, to rounding."""

import numpy as np

STEPS = 2000


def integrated(rate, state, time):
    """The state after a time."""
    h = time / STEPS
    for _ in range(STEPS):
        first = rate(state)
        second = rate(state + h / 2 * first)
        third = rate(state + h / 2 * second)
        state = state + h / 6 * (first + 2 * (second + third) + rate(state + h * third))
    return state


def puck(scene, gravity):
    """x, y and yaw at the end of a body on legs that share its weight; friction opposes the velocity of each."""
    legs = np.array([complex(x, y) for x, y, _ in scene.body.tips])
    share, gyration = scene.friction * gravity / len(legs), scene.body.inertia[2] / scene.body.mass

    def rate(state):
        x, y, yaw, vx, vy, spin = state
        arms = legs * np.exp(1j * yaw)
        velocities = complex(vx, vy) + 1j * spin * arms
        frictions = -share * velocities / abs(velocities)
        force, moment = frictions.sum(), (arms.conj() * frictions).imag.sum()
        return np.array([vx, vy, spin, force.real, force.imag, moment / gyration])

    return integrated(rate, np.array([0.0, 0.0, 0.0, *scene.velocity[:2], scene.spin[2]]), scene.duration)[:3]


def ball(scene, gravity):
    """x and angle at the end of a loaded ball that rolls without slipping, let go at its pitch; x of the centre of mass."""
    radius, offset, gyration = scene.body.radius, scene.body.tips[0][2], scene.body.inertia[1] / scene.body.mass

    def rate(state):
        angle, spin = state
        arm = radius**2 + offset**2 - 2 * radius * offset * np.cos(angle)
        return np.array([spin, -offset * np.sin(angle) * (radius * spin**2 + gravity) / (gyration + arm)])

    angle = integrated(rate, np.array([scene.pitch, 0.0]), scene.duration)[0]
    return radius * (angle - scene.pitch) - offset * (np.sin(angle) - np.sin(scene.pitch)), angle
