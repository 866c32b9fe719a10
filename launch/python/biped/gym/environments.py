"""Tasks as environments of Gymnasium: one robot, or many that step together on all cores."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .. import EndedError, InputError
from .checks import count, numbers, seeds
from .tasks import Push, Stand, Task, Walk

TASKS: dict[str, type[Task]] = {"Stand": Stand, "Push": Push, "Walk": Walk}


def _task(name: str, robots: int, options: dict[str, Any]) -> Task:
    if name not in TASKS:
        raise InputError(f"there is no task {name!r}: the tasks are {', '.join(TASKS)}")
    return TASKS[name](robots, **options)


def _spaces(task: Task) -> tuple[Any, Any]:
    bounds = task.bounds().astype(np.float32)
    return gymnasium.spaces.Box(-bounds, bounds), gymnasium.spaces.Box(-1.0, 1.0, task.actions.shape[1:])


class Environment(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """One robot. ``gymnasium.make("biped/Push-v0")`` makes it."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 50}

    def __init__(self, task: str, render_mode: str | None = None, **options: Any) -> None:
        if render_mode not in (None, "rgb_array"):
            raise InputError(f"render_mode is None or 'rgb_array', not {render_mode!r}; `biped view` shows a session in a browser")
        self.task, self.render_mode = _task(task, 1, options), render_mode
        self.observation_space, self.action_space = _spaces(self.task)
        self.metadata = {**self.metadata, "render_fps": round(1 / self.task.interval)}
        self._running = False
        self._picture: Any = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[NDArray[np.float32], dict[str, Any]]:
        super().reset(seed=seed)
        self._running = False  # nor after a refusal
        self.task.reset(0, self.np_random, options)
        self._running = True
        return self.task.observation()[0], self._information()

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        if not self._running:
            raise EndedError("no episode has begun, or it has ended: call reset()")
        rewards, lost, over = self.task.step(numbers("an action", action)[None])
        self._running = not (lost[0] or over[0])
        return self.task.observation()[0], float(rewards[0]), bool(lost[0]), bool(over[0]), self._information()

    def render(self) -> NDArray[np.uint8] | None:
        if self.render_mode is None:
            gymnasium.logger.warn("render_mode is None: make the environment with render_mode='rgb_array'")
            return None
        from .render import Picture

        self._picture = self._picture or Picture(self.task.scene)
        picture: NDArray[np.uint8] = self._picture.draw(self.task.plants[0].truth())
        return picture

    def _information(self) -> dict[str, Any]:
        return {key: {name: rows[0] for name, rows in fields.items()} for key, fields in self.task.information([0]).items()}


class VectorEnvironment(VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """Many robots that step together, with the GIL released. ``gymnasium.make_vec("biped/Push-v0", num_envs=16)`` makes it.

    A robot whose episode ends starts the next one in the same step: ``info["final_obs"]`` has its last observation, and
    ``info["_final_obs"]`` says which rows of it hold.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}

    def __init__(self, task: str, num_envs: int = 1, render_mode: str | None = None, **options: Any) -> None:
        if render_mode is not None:
            raise InputError("a vector environment has no pictures: use gymnasium.make with render_mode='rgb_array'")
        self.num_envs, self.render_mode = count("num_envs", num_envs), None
        self.task = _task(task, self.num_envs, options)
        self.single_observation_space, self.single_action_space = _spaces(self.task)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._randoms = [np.random.default_rng() for _ in range(self.num_envs)]
        self._begun = False

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """A seed s gives robot i the seed s + i, as in ``gymnasium.vector.SyncVectorEnv``."""
        self._begun = False
        for robot, own in enumerate(seeds(seed, self.num_envs)):
            if own is not None:
                self._randoms[robot], _ = gymnasium.utils.seeding.np_random(own)
            self.task.reset(robot, self._randoms[robot], options)
        self._begun = True
        return self.task.observation(), self.task.information(range(self.num_envs))

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        if not self._begun:
            raise EndedError("no episode has begun: call reset()")
        rewards, lost, over = self.task.step(actions)
        ended, information = lost | over, {}
        if ended.any():
            information = {"final_obs": self.task.observation(), "_final_obs": ended}
            for robot in np.flatnonzero(ended):
                self.task.reset(int(robot), self._randoms[robot], {})
        return self.task.observation(), rewards, lost, over, information | self.task.information(range(self.num_envs))
