"""What guards that never fire cost on CasADi's virtual machine: the rated truck with and without events. Not run by pytest.

    python tests/bench/guards.py [seconds simulated] [repetitions]

Both runs take the same steps; processor time is compared, the best of alternating repetitions.
"""

from __future__ import annotations

import sys
import time

from modelgen import assemble, load, lower
from modelgen.solvers import Case, simulate


def main(seconds: float, repetitions: int) -> None:
    """Prints steps, evaluations and processor time of both."""
    model = lower(assemble(load("fracturing-truck")))
    case = Case(model, end=seconds, samples=11)
    best: dict[str, float] = {}
    for _ in range(repetitions):
        for events in ("off", "on"):
            start = time.process_time()
            solution = simulate(case.change(options={"events": events, "backend": "vm"}))
            used = time.process_time() - start
            best[events] = min(best.get(events, used), used)
            log = "none looked for" if solution.events is None else str(len(solution.events))
            cost = solution.statistics
            print(f"events {events:3s}: {cost.steps} steps, {cost.evaluations} evaluations, {used:.3f} s, events: {log}")
    print(f"guards cost {best['on'] / best['off'] - 1:.1%}")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 0.2, int(sys.argv[2]) if len(sys.argv) > 2 else 7)
