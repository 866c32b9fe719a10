"""Recordings of ``biped run --record`` as arrays and tables."""

from __future__ import annotations

from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _biped
from .records import records

if TYPE_CHECKING:
    import pandas


class Recording(dict[str, Any]):
    """Arrays of records by topic: ``sensors``, ``command``, ``telemetry``, ``truth`` and ``served``.

    ``recording["truth"].base_position`` has the shape (messages, 3). Fields that another topic contains are zero.
    """

    #: The scene that was run.
    scene: _biped.Scene
    #: Simulated times of the messages of each topic [s].
    times: dict[str, NDArray[np.float64]]
    #: Calendar time of the first message (UTC).
    begun: str
    #: Why the recording is cut short, or None.
    truncated_by: str | None

    def __init__(self, path: str | PathLike[str]) -> None:
        super().__init__()
        self._path = fspath(path)
        self.scene, topics, self.begun, self.truncated_by = _biped.read_recording(self._path)
        self.times = {topic: _seconds(times) for topic, (times, _) in topics.items()}
        self.update({topic: records(topic.capitalize(), messages) for topic, (_, messages) in topics.items()})

    def table(self) -> pandas.DataFrame:
        """One row per control period with the latest values of all topics, as ``biped convert --table`` writes it."""
        import pandas

        times, messages = _biped.read_table(self._path)
        return pandas.DataFrame({"time_s": _seconds(times)} | dict(_columns(records("Truth", messages))))


def read_recording(path: str | PathLike[str]) -> Recording:
    """Reads a recording. A recording that is cut short is read up to its last valid part.

    :raises RecordingError: the file is not a recording of this program, or has another wire format
    """
    return Recording(path)


def _seconds(times: bytes) -> NDArray[np.float64]:
    return np.frombuffer(times, np.uint64) / 1e9


def _columns(array: Any, prefix: str = "") -> Any:
    """Names, such as ``stamp.seq`` or ``angle[3]``, and values of all columns."""
    for field in array.dtype.names:
        name, values = prefix + field, array[field]
        if values.dtype.names:
            yield from _columns(values, name + ".")
        elif values.ndim > 1:
            yield from ((f"{name}[{index}]", column) for index, column in enumerate(values.T))
        else:
            yield name, values
