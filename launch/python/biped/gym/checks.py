"""Arguments of the environments. A wrong argument gets a sentence with its name, its value, and the values that are allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import Any

import numpy as np

from .. import InputError
from .loop import Array


def number(what: str, value: Any, unit: str, most: float = np.inf) -> float:
    """A finite number from 0 to ``most``."""
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        result = np.nan
    if not (0.0 <= result <= most and np.isfinite(result)):
        limits = "of 0 or more" if most == np.inf else f"from 0 to {most}"
        raise InputError(f"{what} must be a number {limits} [{unit}], not {value!r}")
    return result


def numbers(what: str, value: Any) -> Array:
    """An array of finite numbers of any shape."""
    try:
        result: Array = np.asarray(value).astype(float, casting="same_kind")
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} must be an array of numbers: {error}") from None
    if not np.isfinite(result).all():
        place = np.argwhere(~np.isfinite(result))[0]
        where = f"number {place[-1]}" + "".join(f" of robot {robot}" for robot in place[:-1])
        raise InputError(f"{what} must be finite, but {where} is {result[tuple(place)]}")
    return result


def mapping(what: str, value: Any, example: str) -> Mapping[str, Any]:
    """A dict, or nothing."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InputError(f"{what} must be a dict such as {example}, not {value!r}")
    return value


def count(what: str, value: Any) -> int:
    """A whole number of 1 or more."""
    if not isinstance(value, Integral) or int(value) < 1:
        raise InputError(f"{what} must be a whole number of 1 or more, not {value!r}")
    return int(value)


def seeds(seed: Any, robots: int) -> Sequence[Any]:
    """The seed of each robot, or None. A seed s gives robot i the seed s + i."""
    if seed is None or isinstance(seed, Integral):
        return [None if seed is None else int(seed) + robot for robot in range(robots)]
    if isinstance(seed, str) or not hasattr(seed, "__len__") or len(seed) != robots:
        raise InputError(f"seed must be a whole number, None, or a list of {robots} of them, one for each robot, not {seed!r}")
    return [int(own) if isinstance(own, Integral) else own for own in seed]
