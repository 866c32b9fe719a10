"""Base classes of the engines' files.

An engine's `Simulation` has `reset`, `run(steps)` and `row`. A row is the pose `x y z qw qx qy qz` of each body that may touch the
ground; in flight it is the kinetic energy alone. Errors are computed from these rows by `biped chart`, in the same way for every engine.
"""

import statistics

import numpy as np


class Traced:
    """Records the whole scene."""

    def trace(self, steps, stride):
        """Rows from the start of the scene on."""
        self.reset()
        rows = [self.row()]
        for _ in range(stride, steps + 1, stride):
            self.run(stride)
            rows.append(self.row())
        return np.array(rows)


class Timed(Traced):
    """An engine whose `step` returns the seconds spent in the engine, without the Python around it; 0 if it was not called."""

    def run(self, steps):
        """Advances, recording nothing."""
        for _ in range(steps):
            self.step()

    def seconds(self, steps):
        """Median time of a step in the engine."""
        return statistics.median([spent for _ in range(steps) if (spent := self.step())])
