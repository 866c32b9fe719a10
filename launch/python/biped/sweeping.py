"""Any function of a value, over many values: in threads, or on the workers of a Dask scheduler."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

Value = TypeVar("Value")
Result = TypeVar("Result")


def sweep(function: Callable[[Value], Result], values: Iterable[Value], client: Any = None) -> list[Result]:
    """``[function(value) for value in values]`` on all cores, in this order.

        def survives(impulse):
            plant = biped.Plant(scene)
            ...
            return not plant.fallen

        biped.sweep(survives, np.linspace(2, 8, 100))

    Threads run in parallel because a step of a plant releases the GIL. On a Dask scheduler the function and its results are sent between
    processes: a :class:`Scene` can be sent, a plant cannot, so make it within the function. The workers need this package.

    :param client: a ``dask.distributed.Client``, or the address of its scheduler such as ``"tcp://host:8786"``; None for threads
    :raises Exception: the first that the function raises, in the order of the values
    """
    values = list(values)
    if client is None:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return list(pool.map(function, values))
    if isinstance(client, str):
        from distributed import Client

        with Client(client) as own:  # type: ignore[no-untyped-call]
            return sweep(function, values, own)
    return client.gather(client.map(function, values, pure=False))  # type: ignore[no-any-return]
