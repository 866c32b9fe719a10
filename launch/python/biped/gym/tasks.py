"""The tasks of the environments, for any number of robots that step together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Controller, ControllerError, EndedError, InputError, Plant, PlantBatch, Scene, SimulationError
from .checks import mapping, number, numbers
from .loop import Array, Loop

#: Fields of ``Plant.truth()`` that ``truth=True`` puts into ``info["truth"]``.
TRUTH = ["base_position", "base_orientation", "base_velocity", "base_spin", "angle", "rate", "torque", "contact_force"]


class Task:
    """Some robots with equal scenes. A subclass defines the effect of an action and the reward.

    :param duration: length of an episode [s], a multiple of the period of the actions
    :param settings: changes of the scene, such as ``{"plant.friction": 0.4}``
    :param noise: largest random impulse on the trunk at time zero, in each horizontal direction [N·s]
    :param truth: whether ``info["truth"]`` has data that only the simulation knows
    """

    #: Built-in scene, and control periods for which an action holds.
    built_in, periods = "stand", 5
    #: Names that ``options`` of ``reset`` may have.
    options: Sequence[str] = ()

    def __init__(
        self, robots: int, *, duration: float = 5.0, settings: Mapping[str, Any] | None = None, noise: float = 0.2, truth: bool = False
    ) -> None:
        settings = mapping("settings", settings, '{"plant.friction": 0.4}')
        self.scene = Scene(self.built_in, {**settings, "duration": duration})
        self.interval, self.truth, self.noise = self.periods / self.scene.rate, truth, number("noise", noise, "N·s")
        self.length = round(duration / self.interval)
        if self.length < 1 or abs(self.length * self.interval - duration) > 1e-9:
            raise InputError(f"a duration of {duration} s is not a multiple of the {self.interval} s for which an action holds")
        self.plants = [Plant(self.scene) for _ in range(robots)]
        self.batch = PlantBatch(self.plants)
        self.loop = Loop(self.scene, robots)
        self.steps = np.zeros(robots, int)
        self.actions = np.zeros((robots, self.loop.start.size))

    def reset(self, robot: int, random: np.random.Generator, options: Mapping[str, Any] | None) -> None:
        """Starts an episode of one robot. All random numbers come from ``random``."""
        for name in mapping("options", options, '{"time": 0.5}' if "time" in self.options else "{}"):
            if name not in self.options:
                raise InputError(f"{name!r} is no option of this environment: it has {list(self.options) or 'none'}")
        plant = self.plants[robot]
        plant.reset(seed=int(random.integers(1, 2**32)))
        plant.push([*random.uniform(-self.noise, self.noise, 2), 0.0], duration=0.001)
        self.loop.begin(plant.angles, robot)
        self.steps[robot] = 0

    def step(self, actions: Any) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
        """One action of each robot, shape (robots, 8): rewards, and which robots have fallen or have reached the end."""
        actions = numbers("an action", actions)
        if actions.shape != self.actions.shape:
            (robots, joints), shape = self.actions.shape, actions.shape[1:] if len(self.plants) == 1 else actions.shape
            raise InputError(f"an action has the shape ({joints},), {robots} of them ({robots}, {joints}): this one has {shape}")
        self.actions = np.clip(actions, -1.0, 1.0)
        failed = False
        for period in range(self.periods):
            self.disturb(period)
            torques = self.torques()
            try:
                self.batch.step(torques)
            except SimulationError:  # all other plants have stepped
                failed = True
            self.loop.measure(self.batch.angles)
        self.steps += 1
        lost = np.array([(failed and _failed(plant)) or plant.fallen for plant in self.plants]) | self.given_up()
        return self.rewards() * ~lost, lost, self.steps >= self.length

    def disturb(self, period: int) -> None:
        """Disturbs the robots in this period of the action."""

    def torques(self) -> Array:
        """The torques of the next control period [N·m]."""
        raise NotImplementedError

    def rewards(self) -> Array:
        """The reward of each robot that still stands."""
        raise NotImplementedError

    def given_up(self) -> NDArray[np.bool_]:
        """The robots whose controller has no torques any more."""
        return np.zeros(len(self.plants), bool)

    def observation(self) -> NDArray[np.float32]:
        """The observation, which contains only data that a controller on the wire knows."""
        return self.loop.observation().astype(np.float32)

    def bounds(self) -> Array:
        """Largest magnitude of each number of the observation."""
        return self.loop.bounds()

    def information(self, robots: Sequence[int]) -> dict[str, Any]:
        """``info`` of some robots: with ``truth``, the fields ``TRUTH``, one row a robot."""
        if not self.truth:
            return {}
        records = [self.plants[robot].truth() for robot in robots]
        return {"truth": {name: np.array([record[name] for record in records]) for name in TRUTH}}

    def quiet(self) -> Array:
        """1 − 0.5 mean((q − q₀)²) / (0.2 rad)² − 0.05 mean((τ / τ_max)²), with the initial joint angles q₀."""
        loop = self.loop
        posture: Array = ((loop.angles - loop.start) ** 2).mean(axis=1) / 0.2**2
        effort: Array = ((loop.torques / loop.limit) ** 2).mean(axis=1)
        return 1.0 - 0.5 * np.minimum(posture, 1.0) - 0.05 * effort


def _failed(plant: Plant) -> bool:
    """Whether the simulation of this plant has failed: then even a step of no period is refused."""
    try:
        plant.step(periods=0)
    except SimulationError:
        return True
    except EndedError:
        pass
    return False


class Stand(Task):
    """Actions are torques, rewards those of :meth:`quiet`."""

    def torques(self) -> Array:
        return self.loop.drive(self.actions * self.loop.limit)

    def rewards(self) -> Array:
        return self.quiet()


class Push(Task):
    """Actions are offsets of the targets of springs and dampers, rewards those of :meth:`quiet`; there is a push at a random time.

    :param impulse: largest impulse of the push [N·s]
    :param offset: largest offset of a joint [rad]
    """

    periods = 20
    options = ("push", "time")

    def __init__(self, robots: int, *, duration: float = 3.0, impulse: float = 8.0, offset: float = 0.5, **others: Any) -> None:
        super().__init__(robots, duration=duration, **others)
        self.impulse, self.offset = number("impulse", impulse, "N·s"), number("offset", offset, "rad")
        self.at, self.pushes = np.zeros(robots, int), np.zeros((robots, 3))

    def reset(self, robot: int, random: np.random.Generator, options: Mapping[str, Any] | None) -> None:
        super().reset(robot, random, options)
        options = options or {}
        size, direction, time = self.impulse * random.uniform(0.5, 1.0), random.uniform(-np.pi, np.pi), random.uniform(0.2, 0.8)
        push = numbers("the option 'push'", options.get("push", [size * np.cos(direction), size * np.sin(direction), 0.0]))
        if push.shape != (3,):
            raise InputError(f"the option 'push' is an impulse with the shape (3,) [N·s]: this one has the shape {push.shape}")
        self.pushes[robot] = push
        if "time" in options:
            time = number("the option 'time'", options["time"], "s", self.scene.duration)
        self.at[robot] = round(time * self.scene.rate)

    def disturb(self, period: int) -> None:
        for robot in np.flatnonzero(self.steps * self.periods + period == self.at):
            self.plants[robot].push(self.pushes[robot])

    def torques(self) -> Array:
        return self.loop.spring(self.loop.start + self.offset * self.actions)

    def rewards(self) -> Array:
        return self.quiet()


class Walk(Task):
    """Actions are torques in addition to those of the paper's controller, rewards are for progress.

    :param residual: largest additional torque [N·m]
    """

    built_in, periods = "walk", 10

    def __init__(self, robots: int, *, duration: float = 10.0, residual: float = 5.0, **others: Any) -> None:
        super().__init__(robots, duration=duration, **others)
        self.residual = number("residual", residual, "N·m")
        self.controllers = [Controller(self.scene) for _ in range(robots)]
        self.lost, self.places = np.zeros(robots, bool), np.zeros(robots)

    def reset(self, robot: int, random: np.random.Generator, options: Mapping[str, Any] | None) -> None:
        super().reset(robot, random, options)
        self.controllers[robot].reset()
        self.lost[robot], self.places[robot] = False, self._place(robot)

    def torques(self) -> Array:
        torques = self.residual * self.actions
        for robot, (controller, plant) in enumerate(zip(self.controllers, self.plants)):
            if not self.lost[robot]:
                try:
                    torques[robot] += controller.tick(plant.counts)
                except ControllerError:  # no torques for this posture
                    self.lost[robot] = True
        return self.loop.drive(torques)

    def rewards(self) -> Array:
        before, self.places = self.places, np.array([self._place(robot) for robot in range(len(self.plants))])
        effort: Array = (self.actions**2).mean(axis=1)
        return (self.places - before) / self.interval - 0.1 * effort

    def given_up(self) -> NDArray[np.bool_]:
        return self.lost

    def observation(self) -> NDArray[np.float32]:
        gaits = [controller.telemetry() for controller in self.controllers]
        rows = [[gait.support, *gait.com, *gait.swing, *gait.pendulum, gait.landing] for gait in gaits]
        return np.concatenate([super().observation(), np.clip(rows, -GAIT, GAIT).astype(np.float32)], axis=1)

    def bounds(self) -> Array:
        return np.concatenate([super().bounds(), np.full(12, GAIT)])

    def _place(self, robot: int) -> float:
        return float(self.plants[robot].truth().base_position[0])


#: Limit of the telemetry in the observation [m, m/s].
GAIT = 10.0
