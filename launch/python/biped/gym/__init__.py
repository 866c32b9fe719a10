"""Environments of Gymnasium: ``biped/Stand-v0``, ``biped/Push-v0`` and ``biped/Walk-v0``.

    import biped.gym, gymnasium

    env = gymnasium.make("biped/Push-v0")
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

``gymnasium.make("biped.gym:biped/Push-v0")`` imports this module itself. ``gymnasium.make_vec("biped/Push-v0",
num_envs=16)`` makes many robots that step together on all cores.

**Observation**, float32: joint angles from the encoders [rad], their rates by difference through a low-pass filter of 150 Hz [rad/s],
and the last torques [N·m], shape (24,), limits ±π, ±50 and ±40. A controller on the wire knows all of them. ``Walk`` adds the
telemetry of the paper's controller, shape (12,): support (0 left, 1 right), com [m], swing [m], pendulum [m, m/s], landing [m];
docs/WIRE.md, Telemetry. With ``truth=True``, ``info["truth"]`` has data that only the simulation knows.

**Action**, shape (8,), limits ±1:

========  ==========================================================================================  =====================
task      one action                                                                                  holds for
========  ==========================================================================================  =====================
Stand     joint torques, in units of the torque limit (40 N·m)                                        5 ms (200 Hz)
Push      offsets, in units of ``offset`` (0.5 rad), of the angles to which springs and dampers pull  20 ms (50 Hz)
Walk      torques, in units of ``residual`` (5 N·m), in addition to those of the paper's controller   10 ms (100 Hz)
========  ==========================================================================================  =====================

The zero action in Push is the standing controller ``stand.py`` (1000 N·m/rad, 40 N·m·s/rad). In Walk it is the paper's controller.

**Reward**, in each step: 0 for a robot that has fallen, otherwise

- Stand, Push: 1 − 0.5 min(mean((q − q₀)²) / (0.2 rad)², 1) − 0.05 mean((τ / τ_max)²), with the initial joint angles q₀;
- Walk: mean speed of the trunk [m/s] − 0.1 mean(action²).

**End**: terminated when the robot has fallen by the rule of ``biped run``, when the simulation fails, or in Walk when the controller has
no torques; truncated at ``duration`` (5, 3 and 10 s).

**Random**, all from the seed of ``reset``: an impulse of up to ``noise`` (0.2 N·s) on the trunk at time zero; the seed of the plant, which
also draws the faults of a ``[link]`` table; in Push, a push on the trunk for 50 ms between 0.2 and 0.8 s, in any horizontal direction, of
0.5 to 1 times ``impulse`` (8 N·s). ``reset(options={"push": [0, 6, 0], "time": 0.5})`` chooses it.

All environments take ``settings``, changes of the scene: ``gymnasium.make("biped/Push-v0", settings={"link.delay_ms": 2.0})``.
"""

import gymnasium

from .environments import TASKS, Environment, VectorEnvironment
from .loop import Loop
from .tasks import Push, Stand, Task, Walk


def register() -> None:
    """Registers the environments. ``import biped.gym`` does so."""
    for task in TASKS:
        if f"biped/{task}-v0" not in gymnasium.registry:
            gymnasium.register(
                f"biped/{task}-v0",
                entry_point="biped.gym:Environment",
                vector_entry_point="biped.gym:VectorEnvironment",
                kwargs={"task": task},
            )


register()

__all__ = ["TASKS", "Environment", "Loop", "Push", "Stand", "Task", "VectorEnvironment", "Walk", "register"]
