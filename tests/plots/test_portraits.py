"""Figures of motions at a place and of diagrams side by side: what is drawn, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from modelgen.analysis.nonlinear.bifurcation import BifurcationResult, Column
from modelgen.analysis.nonlinear.sections import SectionResult
from modelgen.errors import CaseError
from modelgen.plots.diagram_readings import diagram_readings
from modelgen.plots.portraits import portraits
from modelgen.solvers import Outcome

TURN = np.linspace(0, 2 * np.pi, 200)
CHANNEL = "disk.elastic_angle"


def section(period: int) -> SectionResult:
    points = np.zeros((20, 1)) if period else np.cos(np.arange(20.0))[:, None]
    return SectionResult(
        *("made up", {"zeta": 0.1}, "common period 0.5 s: firing 1", (CHANNEL,), ("rad",), np.zeros(20), points, points),
        *(np.cos(TURN)[:, None], -np.sin(TURN)[:, None], 1 if period else 8, points, True, 5, period, 1e-8, 1e-6, period > 0),
        *(Outcome.SUCCESS, ""),
    )


def diagram(unsettled: int) -> BifurcationResult:
    columns = []
    for k in range(5):
        period = 0 if k < unsettled else 1
        points = np.full((16, 1), 0.1 * k)
        columns.append(
            Column(0.01 * k, "independent", points, points, period, 1e-8, period > 0, 3, points[-1], Outcome.SUCCESS, "")
        )
    values = np.array([each.value for each in columns])
    return BifurcationResult("made up", "zeta", "1", values, (CHANNEL,), ("rad",), tuple(columns), "common period 0.5 s: x", 1e-6)


def test_a_row_for_each_section() -> None:
    figure = portraits({"fixed": section(0), "scaled": section(1)}, CHANNEL, 0.5, notes={"fixed": "a note"})
    assert len(figure.axes) == 6
    response, plane, cut = figure.axes[3:]
    assert response.get_xlim() == pytest.approx((0.0, 0.5))
    assert figure.axes[0].get_xlim() == pytest.approx((0.0, 4.0))
    assert plane.get_xlim() == cut.get_xlim()
    assert np.degrees(1.0) == pytest.approx(max(plane.lines[0].get_xdata()))  # in degrees
    assert "period 1" in " ".join(each.get_text() for each in cut.texts)
    assert "a note" in " ".join(each.get_text() for each in figure.axes[0].texts)


def test_wrong_portraits() -> None:
    with pytest.raises(CaseError, match="no sections"):
        portraits({}, CHANNEL, 0.5)
    with pytest.raises(CaseError, match=f"nearest is '{CHANNEL}'"):
        portraits({"one": section(1)}, "disk.elastic_angel", 0.5)
    with pytest.raises(CaseError, match="no points"):
        portraits({"one": replace(section(1), times=np.zeros(0))}, CHANNEL, 0.5)


def test_diagrams_side_by_side() -> None:
    figure = diagram_readings({"fixed": diagram(0), "scaled": diagram(2)})
    assert len(figure.axes) == 4
    assert "2 of 5 columns" in " ".join(each.get_text() for each in figure.axes[1].texts)
    assert [each.get_text() for each in figure.legends[0].get_texts()] == ["period 1", "did not come to stand still"]
    low, high = figure.axes[0].get_xlim()
    assert low < 0 < 0.04 < high  # columns at the ends are seen whole


def test_wrong_diagrams() -> None:
    with pytest.raises(CaseError, match="there are none"):
        diagram_readings({})
    with pytest.raises(CaseError, match="differ in parameter"):
        diagram_readings({"fixed": diagram(0), "other": replace(diagram(0), parameter="xi")})
