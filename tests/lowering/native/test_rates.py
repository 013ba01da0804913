"""Right-hand sides of whole drivelines: virtual machine, C and lanes say the same."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import assemble, load, lower
from modelgen.drivelines import catalogue
from modelgen.lowering.native import native_solver

pytestmark = pytest.mark.usefixtures("compiled_here")


@pytest.mark.parametrize("name", catalogue())
@pytest.mark.parametrize("lanes", [False, True])
def test_catalogued_drivelines_at_random_places(name: str, lanes: bool) -> None:
    model = lower(assemble(load(name)))
    solver, rng = native_solver(model.rhs_function, lanes), np.random.default_rng(1)
    p, n = model.parameters.vector(), len(model.states) // 2
    for _ in range(1000):
        # Within the first periods: later, the virtual machine's own phases are worse than this bound.
        x, t = 1e-2 * rng.standard_normal(len(model.states)), rng.uniform(0, 0.02)
        expected, found = model.rhs(t, x, p), solver.rates(t, x, p)
        for group in (slice(0, n), slice(n, 2 * n)):
            assert np.abs(found - expected)[group].max() <= 1e-13 * np.abs(expected[group]).max()
