"""What guards that never fire cost: the rated truck with and without events, on each engine. Not run by pytest.

    python tests/bench/guards.py [seconds simulated] [repetitions] [runs in lanes]

Both runs take the same steps; processor time is compared, the best of alternating repetitions: in generated C one trajectory of
ten times the seconds, in lanes so many damping ratios, then CasADi's virtual machine.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

from modelgen import assemble, load, lower
from modelgen.solvers import Case, operating_point, simulate
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.problem import SolverOptions
from modelgen.solvers.simulate import initial_value_problem

SWITCH = ("off", "on")


def compare(name: str, runs: dict[str, Callable[[], object]], repetitions: int) -> None:
    """Prints processor time with events off and on, and what the guards cost."""
    best = dict.fromkeys(SWITCH, np.inf)
    for _ in range(repetitions + 1):  # the first one builds
        for events in SWITCH:
            start = time.process_time()
            runs[events]()
            best[events] = min(best[events], time.process_time() - start)
    cost = best["on"] / best["off"] - 1
    print(f"{name:34} off {best['off']:.4f} s, on {best['on']:.4f} s: guards cost {cost:.1%}", flush=True)


def main(seconds: float, repetitions: int, count: int) -> None:
    """Prints what guards cost on every engine."""
    model = lower(assemble(load("fracturing-truck")))

    def case(events: str, backend: str, end: float, **values: float) -> Case:
        return Case(model, end=end, samples=11, parameters=values, options={"events": events, "backend": backend})

    def lanes(events: str) -> Callable[[], object]:
        values = [{"zeta": float(zeta)} for zeta in np.linspace(0.01, 0.08, count)]
        problems = [
            initial_value_problem(case(events, "c", 10 * seconds, **each), operating_point(model, each))[0] for each in values
        ]
        return lambda: solve_lanes(problems, SolverOptions(tolerance=1e-4), threads=1)

    def single(events: str, backend: str, end: float) -> Callable[[], object]:
        return lambda: simulate(case(events, backend, end))

    for name, backend, end in (("generated C", "c", 10 * seconds), ("virtual machine", "vm", seconds)):
        compare(name, {events: single(events, backend, end) for events in SWITCH}, repetitions)
    compare(f"generated C, {count} in lanes", {events: lanes(events) for events in SWITCH}, repetitions)


if __name__ == "__main__":
    given = dict(zip(("seconds", "repetitions", "count"), sys.argv[1:], strict=False))
    main(float(given.get("seconds", 0.2)), int(given.get("repetitions", 7)), int(given.get("count", 16)))
