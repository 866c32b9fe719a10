from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

class Error(Exception):
    """Base of all exceptions of this package."""

    exit_code: int  # of a controller that ends for this reason

class SceneError(Error):
    """A scene is unknown or invalid. The message names the key and the values that are allowed."""

class InputError(Error):
    """An argument has the wrong shape or type, is not finite, or is out of range."""

class EndedError(Error):
    """The run has ended: there is no further control period."""

class SimulationError(Error):
    """The simulation has diverged, or a contact problem could not be solved."""

class ControllerError(Error):
    """The controller does not fit the robot, or has no torques for its posture."""

class NoEffectError(ControllerError):
    """Set-points for a robot that only stands, or whose walk ends already."""

class RecordingError(Error):
    """A file is not a recording of this program, or has another wire format."""

class SessionError(Error):
    """A session fails: shared memory, a call of another thread or process, or a closed session."""

class AbsentError(SessionError):
    """No session of that name is running, or its other side does not answer."""

class RefusedError(SessionError):
    """The session refuses: it has another contract or a controller already, or a request cannot be done."""

def layout() -> list[tuple[str, int, list[tuple[str, str, int, str]]]]:
    """The layout of every message: name, size [bytes], and fields with name, type, offset [bytes] and meaning."""

def names() -> tuple[list[str], list[str]]:
    """Names of the phases of the gait, and of the states of the plant."""

def rust_loop(scene: Scene, torques: NDArray[np.float64] | None = None) -> tuple[int, float, int]:
    """Runs a scene without Python, with the torques of the rows of an array, shape (periods, 8) [N·m], or those of its controller: (control
    periods, time [s], hash of all states). It is the reference for the speed of a loop in Python."""

def read_recording(path: str) -> tuple[Scene, dict[str, tuple[bytes, bytes]], str, str | None]:
    """Reads a recording: scene, times [ns] and messages of each topic, when it began, and why it is cut short, if it is."""

def read_table(path: str) -> tuple[bytes, bytes]:
    """Reads a recording as one topic: times [ns], and the truth of each control period, completed from the other topics."""

@final
class Scene:
    """A scene: robot, ground, controller settings and duration. It cannot be changed.

    ``Scene("walk")`` is a built-in scene, ``Scene("my.toml")`` a file. Settings change values:
    ``Scene("walk", "plant.friction=0.3")`` or ``Scene("walk", {"plant.friction": 0.3, "robot": "my.urdf"})``.
    """

    def __init__(self, name: str | PathLike[str], *settings: str | Mapping[str, Any]) -> None: ...
    @staticmethod
    def parse(text: str, name: str = "scene") -> Scene:
        """A scene from its TOML text. Errors call it by ``name``."""

    @staticmethod
    def built_in() -> list[str]:
        """Names of the built-in scenes."""

    @property
    def name(self) -> str: ...
    @property
    def text(self) -> str:
        """The scene as TOML, with every default written out."""

    @property
    def dt(self) -> float:
        """Length of an integration step [s]."""

    @property
    def rate(self) -> float:
        """Control periods per second [Hz]."""

    @property
    def duration(self) -> float:
        """Length of a run [s]."""

    @property
    def torque_limit(self) -> float:
        """Largest torque of a drive [N·m]."""

    @property
    def radians_per_count(self) -> float:
        """Angle of one encoder count [rad]."""

    @property
    def joints(self) -> list[str]:
        """Names of the joints, in the order of all arrays."""

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies."""

    @property
    def start(self) -> list[float]:
        """Joint angles at time zero [rad]."""

    @property
    def mass(self) -> float:
        """Mass of the robot, with its payload [kg]."""

    @property
    def has_controller(self) -> bool:
        """Whether the scene has settings for the walking controller."""

@final
class Snapshot:
    """The state of a plant, from :meth:`Plant.snapshot`. It cannot be changed. It can be copied, pickled and sent to another process."""

    @staticmethod
    def from_bytes(scene: Scene, data: bytes) -> Snapshot:
        """The snapshot of a plant of this scene, from :meth:`to_bytes`.

        :raises InputError: of another scene, from another version, or damaged
        """

    def to_bytes(self) -> bytes:
        """The state as bytes, with the version of this package and a hash of the scene."""

@final
class Plant:
    """Robot, ground and drives of a scene, one control period at a time.

    It has the command pipeline of ``biped run``: a ``[link]`` table of the scene delays and loses commands, and torques beyond four
    times the limit are refused. The same torques give the same bits as in ``biped run``.

    A plant serves one thread at a time. Different plants run in parallel, because a step releases the GIL.
    """

    def __init__(self, scene: Scene) -> None: ...
    def reset(self, *, seed: int | None = None) -> NDArray[np.int64]:
        """Starts again from time zero, with another seed of all random numbers if one is given. Returns :attr:`counts`."""

    def step(self, torques: ArrayLike | None = None, periods: int = 1) -> NDArray[np.int64]:
        """Simulates control periods with these torques, shape (8,) [N·m]. Returns :attr:`counts`.

        Without torques the plant gets no command: it holds the last ones for 10 ms, then damps the joints. Stops at the end of the run.

        :raises InputError: wrong shape, not finite, or refused by the plant
        :raises EndedError: the run had already ended
        :raises SimulationError: the simulation failed; only ``reset`` and ``restore`` help then
        """

    def push(self, impulse: Sequence[float], *, body: str | int | None = None, duration: float = 0.05) -> None:
        """Pushes a body's centre of mass from now on: impulse in the world frame, shape (3,) [N·s], spread over a duration [s]. Without
        a body it pushes the base, which is the trunk of a biped."""

    def truth(self) -> Any:
        """Data that only the simulation knows, as a NumPy record: ``base_position`` [m], ``contact_force`` [N] and so on; docs/WIRE.md, Truth.
        For evaluation. A real robot cannot measure it."""

    def snapshot(self) -> Snapshot:
        """The present state."""

    def restore(self, snapshot: Snapshot) -> NDArray[np.int64]:
        """Returns to a state of this plant, or of another plant of an equal scene. What follows has the same bits. Returns :attr:`counts`."""

    @property
    def scene(self) -> Scene: ...
    @property
    def counts(self) -> NDArray[np.int64]:
        """Encoder counts of the joints, shape (8,), as the wire carries them. A read-only view: it changes with each step of this plant, and
        after a step of a batch when it is asked for again."""

    @property
    def angles(self) -> NDArray[np.float64]:
        """Joint angles from the encoder counts, shape (8,) [rad]. A read-only view that changes with each step."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def ended(self) -> bool:
        """Whether the run has reached its duration."""

    @property
    def state(self) -> str:
        """What drove the robot in the last control period: one of ``STATES``."""

    @property
    def energy(self) -> float:
        """Kinetic energy, and potential energy of gravity [J]."""

    @property
    def fallen(self) -> bool:
        """Whether the posture is that of a fallen robot, by the rule of ``biped run``."""

    @property
    def hash(self) -> int:
        """Hash of all states since time zero. Equal hashes mean equal bits."""

@final
class PlantBatch:
    """Plants that step together on all cores, with the GIL released."""

    def __init__(self, plants: Sequence[Plant]) -> None: ...
    def step(self, torques: ArrayLike | None = None, periods: int = 1) -> NDArray[np.int64]:
        """As :meth:`Plant.step` for every plant, with torques of shape (plants, 8) [N·m]. Returns :attr:`counts`. If some plants fail, all
        others have stepped, and the error names the first that failed."""

    @property
    def plants(self) -> tuple[Plant, ...]: ...
    @property
    def counts(self) -> NDArray[np.int64]:
        """Encoder counts after the last ``step`` of the batch, shape (plants, 8). A read-only view."""

    @property
    def angles(self) -> NDArray[np.float64]:
        """Joint angles after the last ``step`` of the batch, shape (plants, 8) [rad]. A read-only view."""

    def __len__(self) -> int: ...

@final
class ControllerSnapshot:
    """The state of a controller, from :meth:`Controller.snapshot`. It cannot be changed. It can be copied, pickled and sent to another process."""

    @staticmethod
    def from_bytes(scene: Scene, data: bytes) -> ControllerSnapshot:
        """The snapshot of a controller of this scene, from :meth:`to_bytes`.

        :raises InputError: of another scene, from another version, or damaged
        """

    def to_bytes(self) -> bytes:
        """The state as bytes, with the version of this package and a hash of the scene."""

@final
class Controller:
    """The walking controller of the paper. It must get every reading of a run exactly once."""

    def __init__(self, scene: Scene) -> None: ...
    def reset(self, *, time: float = 0.0) -> None:
        """Starts again, with the set-points of the scene. `time` is the simulated time of the next reading [s]: a controller that takes over in
        the middle of a run needs it for the scene's stop time.
        """

    def tick(self, counts: ArrayLike) -> NDArray[np.float64]:
        """One control period: encoder counts, shape (8,) int64, to torques, shape (8,) [N·m]. The result is a read-only view that the next
        call overwrites."""

    def set(self, *, speed: float | None = None, period: float | None = None) -> None:
        """Changes the set-points of the gait: walking speed [m/s] and period of two steps [s].

        :raises ControllerError: out of the range of this robot; then nothing changes
        :raises NoEffectError: the robot only stands, or its walk ends already
        """

    def stop(self) -> None:
        """Ends the walk: the robot stops at the end of the step under way. A walk that has ended stays so."""

    def telemetry(self) -> Any:
        """State of the gait in the last control period, as a NumPy record; docs/WIRE.md, Telemetry."""

    def snapshot(self) -> ControllerSnapshot:
        """The present state, with the set-points."""

    def restore(self, snapshot: ControllerSnapshot) -> None:
        """Returns to a state of this controller, or of another controller of an equal scene."""

    @property
    def scene(self) -> Scene: ...

@final
class Session:
    """A running session, from :func:`biped.attach`. It belongs to the thread that opened it.

    As the controller, answer every reading once: ``for counts in session: session.write(torques)``. The loop ends with the run.
    """

    def __init__(self, name: str | None = None, *, patience: float = 10.0, control: bool = True) -> None: ...
    def read(self) -> NDArray[np.int64] | None:
        """Waits for the next reading of the encoders. Returns :attr:`counts`, or None after the plant's goodbye.

        :raises AbsentError: no plant sent sensors for the time of the patience
        """

    def write(self, torques: ArrayLike, telemetry: Any = None) -> None:
        """Answers the reading with torques, shape (8,) [N·m]. Telemetry is a record or bytes of the message Telemetry, for recordings.

        :raises InputError: wrong shape, not finite, or no reading to answer
        """

    def truth(self, timeout: float = 0.0) -> Any:
        """The next record of the truth, data that only the simulation knows; None if none arrives within the timeout [s]. In lockstep the
        plant waits for those who have begun to read, so go on reading."""

    def push(self, impulse: Sequence[float], *, body: str | int | None = None, duration: float = 0.05) -> float:
        """Pushes a body, by default the base: impulse in the world frame, shape (3,) [N·s], spread over a duration [s]. As all requests
        it returns the simulated time at which it took effect [s].

        :raises RefusedError: no such body, or out of range
        :raises AbsentError: the plant does not answer
        """

    def set(self, *, speed: float | None = None, period: float | None = None) -> float:
        """Asks the session's controller for another walking speed [m/s] or period of two steps [s]."""

    def stop(self) -> float:
        """Asks the session's controller to end the walk."""

    def pause(self) -> float:
        """Stops simulated time."""

    def resume(self) -> float:
        """Lets simulated time go on."""

    def step(self, periods: int = 1) -> float:
        """Runs a paused session for some control periods."""

    def reset(self, *, seed: int | None = None) -> float:
        """Starts a new run from time zero."""

    def rearm(self) -> float:
        """Switches the drives on again after a fault."""

    def close(self) -> None:
        """Leaves the session. The end of a ``with`` block does so."""

    @property
    def name(self) -> str: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def counts(self) -> NDArray[np.int64]:
        """Encoder counts of the last reading, shape (8,). A read-only view that the next reading changes."""

    @property
    def angles(self) -> NDArray[np.float64]:
        """Joint angles of the last reading, shape (8,) [rad]. A read-only view that the next reading changes."""

    @property
    def on_set(self) -> Callable[..., object] | None:
        """The function that ``read`` calls for a request of other set-points, with the keywords ``speed`` [m/s] and ``period`` [s], each a number
        or None, such as :meth:`Controller.set`. If it raises a :class:`Error` or ``ValueError``, the request is refused as out of range, and
        if it raises a :class:`NoEffectError`, as one without effect. Without a function, every request is refused."""

    @on_set.setter
    def on_set(self, function: Callable[..., object] | None) -> None: ...
    @property
    def on_stop(self) -> Callable[[], object] | None:
        """The function that ``read`` calls, without arguments, for a request to end the walk, such as :meth:`Controller.stop`. Exceptions and
        the absence of a function mean the same as for ``on_set``."""

    @on_stop.setter
    def on_stop(self, function: Callable[[], object] | None) -> None: ...
    @property
    def begins(self) -> bool:
        """Whether the last reading was the first one of a run. The controller must start from its initial state then."""

    @property
    def time(self) -> float:
        """Simulated time of the last reading [s]."""

    def __iter__(self) -> Session: ...
    def __next__(self) -> NDArray[np.int64]: ...
    def __enter__(self) -> Session: ...
    def __exit__(self, *reason: object) -> None: ...

@final
class PlantSession:
    """The session of ``biped run SCENE --plant COMMAND``, for the program COMMAND: a simulator, or the driver of a robot, in lockstep.

    It does what docs/WIRE.md asks of a plant: it numbers and sends sensors and truth, checks commands, delays and loses those of a
    ``[link]`` table, and announces the end, also after an exception in a ``with`` block. It belongs to the thread that opened it.
    """

    def __init__(self) -> None: ...
    def exchange(self, counts: ArrayLike, truth: Any = None) -> NDArray[np.float64] | None:
        """Sends encoder counts, shape (8,), and waits for the answer. Returns the torques for the control period that begins now, shape (8,)
        [N·m], or None at the end of the scene. The torques are a read-only view that the next call overwrites; the drives limit them.

        Truth is a record or bytes of the message Truth, for recordings and figures. Stamps, counters, times and the command need not be
        filled in. Counts and truth hold for the same instant.

        :raises AbsentError: no controller answered for the time of the session's patience
        :raises InputError: wrong shape or type, or a call after the end
        """

    def close(self) -> None:
        """Announces the end of the run, if that has not happened, and leaves the session. The end of a ``with`` block does so."""

    @property
    def scene(self) -> Scene: ...
    @property
    def time(self) -> float:
        """Simulated time of the last exchange [s]."""

    @property
    def state(self) -> str:
        """What drives the robot: one of ``STATES``."""

    def __enter__(self) -> PlantSession: ...
    def __exit__(self, *reason: object) -> None: ...
