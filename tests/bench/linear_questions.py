"""Times of linear questions in one run: 1000 frequencies of 50 degrees of freedom beside openTorsion; 1000 degrees of freedom.

Not collected by pytest. Run ``python tests/bench/linear_questions.py``; without openTorsion (``pip install opentorsion``) its
columns are left out. Times are the least of several runs; where other programs run too, set OPENBLAS_NUM_THREADS=1, for small
matrices in contended threads cost many times what they should.
"""

from __future__ import annotations

import importlib.util
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from modelgen import Driveline, Inertia, Shaft, assemble, lower, modal, operating_point
from modelgen.analysis.linear.frequency_response import frequency_response


def chain(count: int) -> Driveline:
    """A free chain of disks and damped shafts that are all a little different."""
    rng = np.random.default_rng(count)
    disks = [Inertia(f"disk_{n}", inertia=float(j)) for n, j in enumerate(rng.uniform(0.5, 3.0, count))]
    shafts = [
        Shaft(f"shaft_{n}", f"disk_{n}", f"disk_{n + 1}", stiffness=float(k), damping="value", damping_coefficient=5.0)
        for n, k in enumerate(rng.uniform(1e5, 1e6, count - 1))
    ]
    return Driveline("chain", elements=(*disks, *shafts))


def least(run: Callable[[], Any], times: int = 5) -> tuple[float, Any]:
    """Least time of some runs [s], and what the last one returned."""
    found, answer = float("inf"), None
    for _ in range(times):
        begin = time.perf_counter()
        answer = run()
        found = min(found, time.perf_counter() - begin)
    return found, answer


def frequency_responses(count: int = 50, frequencies: int = 1000) -> None:
    """The same matrices and forces to both programs."""
    model = lower(assemble(chain(count)))
    point = operating_point(model)
    omega = np.linspace(1.0, 2000.0, frequencies)
    force = np.zeros((count, frequencies), dtype=complex)
    force[0], force[count // 2] = 100.0, 30.0j
    ours, answer = least(lambda: frequency_response(point.mass, point.damping, point.stiffness, omega, force))
    print(f"frequency response, {frequencies} frequencies of {count} degrees of freedom: {ours * 1e3:.1f} ms")
    if importlib.util.find_spec("opentorsion") is None:
        print("  openTorsion is not installed")
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import opentorsion
    values = {each.name: each.values for each in model.equations.parameters}
    disks = [opentorsion.Disk(n, I=values[f"disk_{n}.inertia"][0]) for n in range(count)]
    shafts = [opentorsion.Shaft(n, n + 1, k=values[f"shaft_{n}.stiffness"][0], c=5.0, I=0) for n in range(count - 1)]
    assembly = opentorsion.Assembly(shafts, disk_elements=disks)
    theirs, (other, _) = least(lambda: assembly.ss_response(force, omega), 3)
    print(f"  openTorsion, ss_response: {theirs * 1e3:.1f} ms, {theirs / ours:.1f} times as long")
    print(f"  largest difference {np.abs(answer - other).max() / np.abs(other).max():.1e} of the largest amplitude")


def lowest_modes(count: int = 1000, modes: int = 20) -> None:
    """From elements to the lowest modes of a large driveline, stage by stage."""
    assembling, equations = least(lambda: assemble(chain(count)), 1)
    lowering, model = least(lambda: lower(equations), 1)
    solving, result = least(lambda: modal(model, count=modes), 3)
    print(
        f"{count} degrees of freedom: assemble {assembling:.2f} s, lower {lowering:.2f} s, {modes} lowest modes {solving:.2f} s"
    )
    print(f"  from {result.frequencies[1]:.6g} to {result.frequencies[-1]:.6g} Hz, rigid mode {result.frequencies[0]} Hz")


if __name__ == "__main__":
    frequency_responses()
    lowest_modes()
