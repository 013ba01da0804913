"""Operating maps: rattle by speed and load of the dimensionless gear pair, and cells that cannot be run."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.analysis.nonlinear.maps import MapResult, operating_map
from modelgen.errors import CaseError, Interrupted, NamingError
from modelgen.model import NamedParameter
from modelgen.solvers import Case

from .gear_pair_oscillator import oscillator

SPEEDS, LOADS = [0.3, 1.0, 1.6], [0.02, 0.2]


def loaded() -> Case:
    """The oscillator with one load for both torques."""
    from dataclasses import replace

    from modelgen.elements import HarmonicTorque

    line = oscillator()
    elements = [each for each in line.elements if each.kind != "harmonic_torque"]
    elements += [HarmonicTorque("drive", "pinion", mean="load"), HarmonicTorque("brake", "wheel", mean="minus")]
    named = {"load": NamedParameter(0.1, unit="N*m"), "minus": NamedParameter(expression="-load", unit="N*m")}
    return Case(replace(line, elements=tuple(elements), parameters=named), end=1.0, tolerance=1e-6)


@pytest.fixture(scope="module")
def found() -> MapResult:
    return operating_map(loaded(), ("speed", SPEEDS), ("load", LOADS), revolutions=24, longest=2000.0)


def test_rattle_is_where_the_vibration_passes_the_load(found: MapResult) -> None:
    linear = np.array([abs(0.05 * w * w / complex(1 - w * w, 0.1 * w)) for w in SPEEDS])
    wanted = linear[None, :] > np.array(LOADS)[:, None]
    assert (found.rattle() > 0).tolist() == wanted.tolist()
    assert (found.rattle("mesh") == found.rattle()).all()
    assert (found.apart["mesh"] > 0).tolist() == wanted.tolist()
    assert found.rattle().shape == (2, 3)
    assert not found.failures
    assert found.settled.all()


def test_least_force_of_the_linear_cells(found: MapResult) -> None:
    for row, load in enumerate(LOADS):
        for column, w in enumerate(SPEEDS):
            if not found.rattle()[row, column]:
                size = abs(0.05 * w * w * (1 + 0.1j * w) / complex(1 - w * w, 0.1 * w))
                assert found.least_force["mesh"][row, column] == pytest.approx(load - size, abs=2e-4)
                assert found.repeats[row, column] == 1


def test_peak_angle(found: MapResult) -> None:
    # The error is shared by two equal wheels on base radii of 1: each takes half of the approach.
    w = SPEEDS[0]
    size = abs(0.05 * w * w / complex(1 - w * w, 0.1 * w) + 0.05) / 2
    assert found.peak_angle[1, 0] == pytest.approx(size, rel=5e-3)
    assert "6 cells" in str(found)


def test_a_cell_that_fails_is_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    from modelgen.solvers.problem import Budget

    case = loaded().change(options={"budget": Budget(max_steps=20)})
    broken = operating_map(case, ("speed", [1.0, 1.1]), ("load", [0.1, 0.2]), revolutions=2)
    assert len(broken.failures) == 4
    assert np.isnan(broken.peak_angle).all()
    assert (broken.rattle() == -1).all()
    assert "budget of 20 steps" in broken.failures[0, 0]


def test_ctrl_c_keeps_the_cells_that_are_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modelgen.analysis.nonlinear.maps.BATCH", 2)

    def press(done: float) -> None:
        if done > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="what was computed") as stopped:
        operating_map(loaded(), ("speed", [1.0, 1.1]), ("load", [0.1, 0.2]), revolutions=2, progress=press)
    kept = stopped.value.result
    assert kept.missing == 2
    assert set(kept.failures.values()) == {"Ctrl-C came before it was run"}
    assert np.isnan(kept.peak_angle).tolist() == [[False, False], [True, True]]


def test_refusals() -> None:
    case = loaded()
    with pytest.raises(CaseError, match="on both axes"):
        operating_map(case, ("speed", [1.0]), ("speed", [2.0]))
    with pytest.raises(NamingError, match="'lod': is not known"):
        operating_map(case, ("speed", [1.0]), ("lod", [2.0]))
    with pytest.raises(CaseError, match=r"give \(parameter, values\)"):
        operating_map(case, "speed", ("load", [2.0]))  # type: ignore[arg-type]
    with pytest.raises(CaseError, match="revolutions: is 0"):
        operating_map(case, ("speed", [1.0]), ("load", [2.0]), revolutions=0)
    with pytest.raises(CaseError, match="no gear pair 'mash'"):
        operating_map(case, ("speed", [1.0, 1.1]), ("load", [0.2, 0.3]), revolutions=1).rattle("mash")
