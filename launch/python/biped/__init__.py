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
    AbsentError,
    Controller,
    ControllerError,
    ControllerSnapshot,
    EndedError,
    Error,
    InputError,
    NoEffectError,
    Plant,
    PlantBatch,
    PlantSession,
    RecordingError,
    RefusedError,
    Scene,
    SceneError,
    Session,
    SessionError,
    SimulationError,
    Snapshot,
)
from .recording import Recording, read_recording
from .records import PHASES, STATES, empty
from .sweeping import sweep


def attach(name: str | None = None, *, patience: float = 10.0, control: bool = True) -> Session:
    """Joins the session of this name, which ``biped plant SCENE --session NAME`` or ``biped run SCENE --session NAME`` starts.

    Without a name it joins the session that the environment names: that of ``biped run SCENE --controller COMMAND``, or BIPED_SESSION.

        with biped.attach("lab") as session:
            controller = biped.Controller(session.scene)
            session.on_set, session.on_stop = controller.set, controller.stop  # serve `biped set`
            for counts in session:
                if session.begins:
                    controller.reset(time=session.time)
                session.write(controller.tick(counts))

    :param patience: how long to wait for the session, and later for sensors [s]
    :param control: whether to join as its controller. Otherwise this process can only send requests and read the truth.
    :raises AbsentError: no session of that name within that time
    :raises RefusedError: the session has a controller already, or another wire format
    """
    return Session(name, patience=patience, control=control)


__all__ = [
    "PHASES",
    "STATES",
    "AbsentError",
    "Controller",
    "ControllerError",
    "ControllerSnapshot",
    "EndedError",
    "Error",
    "InputError",
    "NoEffectError",
    "Plant",
    "PlantBatch",
    "PlantSession",
    "Recording",
    "RecordingError",
    "RefusedError",
    "Scene",
    "SceneError",
    "Session",
    "SessionError",
    "SimulationError",
    "Snapshot",
    "attach",
    "empty",
    "read_recording",
    "sweep",
]
