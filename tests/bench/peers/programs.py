"""Four QP solvers on the quadratic programs that the bench wrote, timed by themselves.

    python programs.py PROGRAMS.json

Prints `family solver nanoseconds error`: medians of the times for setup and solution that the solver itself reports, and the greatest
difference between its G x and ours. G x is unique: G is the identity, or A for impulses f, where x itself is not unique. Each
solver has to reach residuals of 1e-9. DAQP, an active-set method, does so without a setting.
"""

import json
import statistics
import sys

import numpy as np
from scipy import sparse

ROUNDS = 5


def main():
    """Runs every solver on every family."""
    with open(sys.argv[1]) as file:
        families = json.load(file)
    for name, solver in SOLVERS.items():
        try:
            solve = solver()
        except ImportError as error:
            print(f"left out {name}: {error}")
            continue
        for family, programs in families.items():
            times, errors, failed = [], [], 0
            for program in (Program(program) for program in programs):
                try:
                    found = [solve(program) for _ in range(ROUNDS)]
                except Exception:  # a solver's own complaint
                    failed += 1
                    continue
                times.append(statistics.median(seconds for _, seconds in found))
                errors.append(np.abs(program.g @ (found[0][0] - program.ours)).max())
            if times:
                print(f"{family} {name} {1e9 * statistics.median(times):.1f} {max(errors):.1e} {failed}")
            else:
                print(f"left out {name} on {family}: solved none")


class Program:
    """Minimises x.H x/2 + c.x with low <= C x <= high."""

    def __init__(self, program):
        self.h, self.rows = (np.array(program[key], dtype=float) for key in ("h", "rows"))
        self.c, self.low, self.high, self.ours = (
            np.array([np.nan if v is None else v for v in program[key]], dtype=float) for key in ("c", "low", "high", "ours")
        )
        self.low[np.isnan(self.low)], self.high[np.isnan(self.high)] = -np.inf, np.inf
        self.g = np.eye(len(self.c)) if program["unique"] else self.h
        self.equal = self.low == self.high


def daqp():
    """Dual active set."""
    import daqp

    def solve(p):
        big = 1e30
        sense = np.where(p.equal, 5, 0).astype(np.int32)
        low, high = np.maximum(p.low, -big), np.minimum(p.high, big)
        x, _, flag, info = daqp.solve(p.h, p.c, p.rows, high, low, sense)
        if flag < 1:
            raise ValueError(flag)
        return x, info["solve_time"] + info["setup_time"]

    return solve


def osqp():
    """ADMM."""
    import osqp

    def solve(p):
        solver = osqp.OSQP()
        h, rows = sparse.csc_matrix(np.triu(p.h)), sparse.csc_matrix(p.rows)
        settings = {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "verbose": False}
        solver.setup(h, p.c, rows, p.low, p.high, **settings)
        result = solver.solve()
        if result.info.status != "solved":
            raise ValueError(result.info.status)
        return result.x, result.info.run_time

    return solve


def piqp():
    """Proximal interior points."""
    import piqp

    def solve(p):
        solver = piqp.DenseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = 1e-9
        solver.settings.compute_timings = True
        free = ~p.equal
        solver.setup(p.h, p.c, p.rows[p.equal], p.high[p.equal], p.rows[free], p.low[free], p.high[free])
        if solver.solve() != piqp.PIQP_SOLVED:
            raise ValueError("not solved")
        return solver.result.x, solver.result.info.run_time

    return solve


def proxqp():
    """Proximal augmented Lagrangians."""
    import proxsuite

    def solve(p):
        free = ~p.equal
        qp = proxsuite.proxqp.dense.QP(len(p.c), int(p.equal.sum()), int(free.sum()))
        qp.settings.eps_abs, qp.settings.eps_rel, qp.settings.compute_timings = 1e-9, 0.0, True
        low, high = np.maximum(p.low[free], -1e20), np.minimum(p.high[free], 1e20)
        qp.init(p.h, p.c, p.rows[p.equal], p.high[p.equal], p.rows[free], low, high)
        qp.solve()
        if qp.results.info.status != proxsuite.proxqp.QPSolverOutput.PROXQP_SOLVED:
            raise ValueError("not solved")
        return qp.results.x, 1e-6 * (qp.results.info.setup_time + qp.results.info.solve_time)

    return solve


SOLVERS = {"DAQP": daqp, "OSQP": osqp, "PIQP": piqp, "ProxQP": proxqp}

if __name__ == "__main__":
    main()
