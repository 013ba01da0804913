"""Figures of sections, bifurcation diagrams, maps and frequency sweeps: readable, and what they show is what the results hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from modelgen.analysis import SectionResult, classify
from modelgen.analysis.nonlinear.bifurcation import BifurcationResult, Column
from modelgen.analysis.nonlinear.frequency_sweep import Change, FrequencySweepResult, SweepPoint
from modelgen.analysis.nonlinear.maps import MapResult
from modelgen.errors import CaseError
from modelgen.plots import plot
from modelgen.solvers import Outcome

CHANNELS, UNITS = ("shaft.twist", "mesh.deflection"), ("rad", "m")


def section(period: int = 1, settled: bool = True) -> SectionResult:
    turn = np.linspace(0, 2 * np.pi, 200)
    circle = np.column_stack([0.01 * np.cos(turn), 2e-5 * np.cos(turn)])
    around = np.column_stack([-np.sin(turn), -2e-3 * np.sin(turn)])
    places = np.arange(60) % period if period else 3 * np.arange(60)
    return SectionResult(
        model="driveline",
        parameters={"zeta": 0.02},
        section="common period 0.5 s: crank 1",
        channels=CHANNELS,
        units=UNITS,
        times=np.zeros(60),
        values=circle[places],
        rates=around[places],
        orbit_values=circle,
        orbit_rates=around,
        orbit_periods=period or 8,
        sequence=circle[places] / 0.01,
        complete=True,
        transient=12,
        period=period,
        residual=0.0 if settled else 0.3,
        still=1e-6,
        settled=settled,
        outcome=Outcome.SUCCESS,
        message="",
    )


def column(value: float, branch: str, period: int, settled: bool = True) -> Column:
    rng = np.random.default_rng(int(1000 * value) + 1)
    base = np.array([[0.01, 1e-5]]) * (1 + value)
    levels = np.arange(20) % max(1, period)
    points = base * (1 + 0.1 * levels[:, None]) if settled else base * rng.normal(size=(20, 1))
    return Column(value, branch, points, points, period, 1e-8 if settled else 0.5, settled, 30, points[-1], Outcome.SUCCESS, "")


def diagram(branches: tuple[str, ...] = ("independent",)) -> BifurcationResult:
    values = np.linspace(0, 0.05, 6)
    periods = (0, 7, 4, 2, 1, 1)
    columns = tuple(
        column(float(value), branch, period, settled=period > 0)
        for branch in branches
        for value, period in zip(values, periods, strict=True)
    )
    return BifurcationResult("driveline", "zeta", "1", values, CHANNELS, UNITS, columns, "common period 0.5 s: crank 1", 1e-6)


def point(frequency: float, rms: float, settled: bool = True) -> SweepPoint:
    return SweepPoint(frequency, frequency, (rms,), (-rms,), (rms,), 0.1 * (rms > 2e-6), 0.0, 1, 1e-8, settled)


def sweep() -> FrequencySweepResult:
    frequencies = np.linspace(400.0, 900.0, 11)
    up = [point(f, 1e-6 if f < 600 else 4e-6) for f in frequencies.tolist()]
    down = [point(f, 1e-6 if f < 500 else 4e-6, settled=f != 700.0) for f in frequencies.tolist()]
    changes = (Change("forward", "jump", 598.0, 599.0, 1e-6, 4e-6), Change("backward", "jump", 499.0, 498.0, 4e-6, 1e-6))
    return FrequencySweepResult("driveline", "mesh", ("mesh.approach",), ("m",), tuple(up), tuple(down), changes)


def cells() -> MapResult:
    shape = (3, 4)
    grid = np.arange(12.0).reshape(shape)
    peak = np.radians(0.1 + 0.05 * grid)
    peak[0, 0] = np.nan
    return MapResult(
        model="driveline",
        first="speed",
        first_unit="rad/s",
        first_values=np.linspace(100, 200, 4),
        second="load",
        second_unit="N*m",
        second_values=np.array([100.0, 500.0, 900.0]),
        inertias=("engine",),
        peak_angle=peak,
        where=np.zeros(shape, dtype=np.int64),
        meshes=("mesh",),
        least_force={"mesh": 1e3 * (grid - 4)},
        apart={"mesh": np.where(grid < 6, 0.3, 0.0)},
        back={"mesh": np.where(grid < 2, 0.1, 0.0)},
        repeats=np.ones(shape, dtype=np.int64),
        settled=np.ones(shape, dtype=np.bool_),
        failures={(0, 0): "no equilibrium"},
        revolutions=8,
        base="crank",
    )


def said(figure: Figure) -> str:
    return " ".join(text.get_text().replace("\n", " ") for text in figure.texts)


@pytest.mark.parametrize(
    "result",
    [section(), section(3), section(0, False), diagram(), diagram(("forward", "backward")), sweep(), cells()],
    ids=lambda result: type(result).__name__,
)
def test_readable(result: object, readable: Callable[..., None]) -> None:
    readable(plot(result))


def test_section_points_are_on_the_motion() -> None:
    figure = plot(section(3), verdict=classify(section(3).sequence))
    motion, points = figure.axes[0].lines
    assert len(motion.get_xdata()) == 200
    assert np.degrees(section(3).values[:, 0]) == pytest.approx(np.asarray(points.get_xdata()))
    assert points.get_markerfacecolor() != "white"
    assert "Verdict: period 3." in said(figure)
    assert "zeta = 0.02" in said(figure)
    loose = plot(section(0, False))
    assert loose.axes[0].lines[1].get_markerfacecolor() == "white"
    assert "do not come back" in said(loose)
    assert "no attractor" in said(plot(section(), verdict=classify(section().sequence, conservative=True)))
    empty = section()
    with pytest.raises(CaseError, match="holds no points"):
        plot(replace(empty, times=np.zeros(0)))


def test_diagram_colors_are_periods() -> None:
    figure = plot(diagram())
    colors = {line.get_color(): np.asarray(line.get_xdata()) for line in figure.axes[0].lines}
    assert len(colors) == 5  # unsettled, 7, 4, 2, 1
    assert np.unique(colors["#8A8A8A"]).tolist() == [0.0]
    assert len(colors["#8A8A8A"]) == 20
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["period 1", "period 2", "period 4", "period 7", "did not come to stand still"]
    assert "1 of 6 columns did not come to stand still" in said(figure)
    residuals = figure.axes[-1]
    assert residuals.get_yscale() == "log"
    with pytest.raises(CaseError, match="has one value"):
        plot(replace(diagram(), values=np.array([1.0])))


def test_sweep_is_broken_at_its_jumps() -> None:
    figure = plot(sweep())
    forward = np.asarray(figure.axes[0].lines[0].get_ydata(), dtype=float)
    assert np.isnan(forward).sum() == 1
    assert {text.get_text() for text in figure.axes[0].texts} >= {"598.5 Hz", "498.5 Hz"}
    assert "1 points did not come to stand still" in said(figure)


def test_map_panels() -> None:
    figure = plot(cells(), limit="0.4 deg")
    titles = [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]
    assert titles == ["largest vibration angle, 0-peak", "mesh: rattle", "mesh: off the driving flank", "mesh: least mesh force"]
    drawn = [each for axes in figure.axes[:4] for each in axes.collections if isinstance(each, QuadMesh)]
    assert np.asarray(drawn[1].get_array()).ravel().tolist() == [0.0, 2.0, *[1.0] * 4, *[0.0] * 6]
    assert "1 cells could not be run" in said(figure)
    assert "Red line: 0.4 degrees" in said(figure)
    with pytest.raises(CaseError, match="axis with one value"):
        plot(replace(cells(), first_values=np.array([1.0])))
