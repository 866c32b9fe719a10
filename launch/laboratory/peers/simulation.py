"""What the engines' files share. An engine's `Simulation` has `reset`, `run(steps)`, and `row`, the state as `metrics` wants it."""

import statistics

import numpy as np


class Traced:
    """Watches the whole scene."""

    def trace(self, steps, stride):
        """Rows from the start of the scene on."""
        self.reset()
        rows = [self.row()]
        for _ in range(stride, steps + 1, stride):
            self.run(stride)
            rows.append(self.row())
        return np.array(rows)


class Timed(Traced):
    """One whose `step` returns the seconds that it took in the engine, nothing of ours counted; 0 if it was not needed."""

    def run(self, steps):
        """Advances, recording nothing."""
        for _ in range(steps):
            self.step()

    def seconds(self, steps):
        """Median time of a step in the engine."""
        return statistics.median([spent for _ in range(steps) if (spent := self.step())])
