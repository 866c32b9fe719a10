"""Plant and walking controller of an eight-axis biped robot, after Fujimoto and Kawamura (1995).

    import biped

    scene = biped.Scene("walk", "duration=3")
    plant, controller = biped.Plant(scene), biped.Controller(scene)
    while not plant.ended:
        plant.step(controller.tick(plant.counts))
    print(plant.time, plant.truth().base_position)

Arrays have eight entries in the order of the joints: left ankle roll, ankle pitch, knee, hip, right hip, knee, ankle pitch, ankle roll.
Units are SI. The arrays that an object returns are views of memory that it reuses: copy what you want to keep.
"""

from ._biped import (
    Controller,
    ControllerError,
    ControllerSnapshot,
    EndedError,
    Error,
    InputError,
    Plant,
    PlantBatch,
    Scene,
    SceneError,
    SimulationError,
    Snapshot,
)
from .records import PHASES, STATES
from .sweeping import sweep

__all__ = [
    "PHASES",
    "STATES",
    "Controller",
    "ControllerError",
    "ControllerSnapshot",
    "EndedError",
    "Error",
    "InputError",
    "Plant",
    "PlantBatch",
    "Scene",
    "SceneError",
    "SimulationError",
    "Snapshot",
    "sweep",
]
