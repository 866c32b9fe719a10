"""The computations of every control period, the same in an environment and in a process on the wire: rates, springs and dampers, observation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Scene

Array = NDArray[np.float64]

#: Limits of the observation: angles [rad] and rates [rad/s]. Torques have the limit of the scene.
ANGLE, RATE = np.pi, 50.0


class Loop:
    """The control periods of some robots of one scene. All arrays have the shape (robots, 8).

    At the first reading of a run call ``begin(angles)``, and at all others ``measure(angles)``. Then call ``spring(targets)`` or
    ``drive(torques)`` for the torques. So :class:`biped/Push-v0 <biped.gym.Push>` and a process on the wire compute the same bits.

    :param stiffness: of the springs [N·m/rad], a number or shape (8,)
    :param damping: of the dampers [N·m·s/rad], a number or shape (8,)
    :param cut_off: of the low-pass filter of the rates [Hz]
    """

    def __init__(self, scene: Scene, robots: int = 1, *, stiffness: Any = 1000.0, damping: Any = 40.0, cut_off: float = 150.0) -> None:
        self.start: Array = np.array(scene.start)
        self.limit = scene.torque_limit
        self.stiffness, self.damping = np.asarray(stiffness, float), np.asarray(damping, float)
        self._rate, self._share = scene.rate, 1.0 - np.exp(-2.0 * np.pi * cut_off / scene.rate)
        self.angles, self.rates, self.torques = (np.zeros((robots, self.start.size)) for _ in range(3))

    def begin(self, angles: Array, robots: Any = slice(None)) -> None:
        """The first reading of a run [rad], of all robots or of some."""
        self.angles[robots], self.rates[robots], self.torques[robots] = angles, 0.0, 0.0

    def measure(self, angles: Array) -> None:
        """The next reading [rad]."""
        self.rates += self._share * ((angles - self.angles) * self._rate - self.rates)
        self.angles[:] = angles

    def drive(self, torques: Array) -> Array:
        """These torques within the limit of the drives [N·m]."""
        self.torques = np.clip(torques, -self.limit, self.limit)
        return self.torques

    def spring(self, targets: Array) -> Array:
        """The torques of a spring and a damper at each joint, which pull it to its target [rad]."""
        return self.drive(self.stiffness * (targets - self.angles) - self.damping * self.rates)

    def observation(self) -> Array:
        """Angles [rad], filtered rates [rad/s] and last torques [N·m], shape (robots, 24). A controller on the wire knows all of them."""
        angles, rates = np.clip(self.angles, -ANGLE, ANGLE), np.clip(self.rates, -RATE, RATE)
        return np.concatenate([angles, rates, self.torques], axis=1)

    def bounds(self) -> Array:
        """Largest magnitude of each number of the observation, shape (24,)."""
        return np.repeat([ANGLE, RATE, self.limit], self.start.size)
