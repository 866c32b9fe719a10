"""Messages of the wire format as NumPy records. docs/WIRE.md explains every field."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._biped import InputError, layout, names

_LAYOUT = {name: (size, fields) for name, size, fields in layout()}
_NUMBERS = {"u32": np.uint32, "u64": np.uint64, "i64": np.int64, "f64": np.float64}

#: Names of ``Telemetry.phase`` and of ``Truth.state``.
PHASES, STATES = names()


def dtype(message: str) -> np.dtype[Any]:
    """The type of a message, such as ``Truth``, with the offsets that it has on the wire."""
    size, fields = _LAYOUT[message]
    return np.dtype(
        {
            "names": [name for name, *_ in fields],
            "formats": [_format(kind) for _, kind, *_ in fields],
            "offsets": [offset for _, _, offset, _ in fields],
            "itemsize": size,
        }
    )


def _format(kind: str) -> Any:
    if kind.startswith("["):  # such as [f64; 3]
        element, count = kind[1:-1].split(";")
        return (_NUMBERS[element], (int(count),))
    return _NUMBERS.get(kind) or dtype(kind)


_TYPES = {message: np.dtype((np.record, dtype(message))) for message in _LAYOUT}


def records(message: str, data: bytes) -> Any:
    """Messages one after another as an array of records."""
    return np.frombuffer(data, _TYPES[message]).view(np.recarray)


def empty(message: str) -> Any:
    """A message of zeros to fill in, such as ``Truth`` for :meth:`PlantSession.exchange`: ``truth.angle[:] = ...``, ``truth.penetration = ...``."""
    if message not in _TYPES:
        raise InputError(f"there is no message {message!r}: the messages are {', '.join(_TYPES)}")
    return np.zeros(1, _TYPES[message])[0]


def record(message: str, data: bytes) -> Any:
    """A message as a record: ``truth.base_position`` or ``truth["base_position"]``."""
    return np.frombuffer(data, _TYPES[message])[0]
