"""Figures of sweeps: curves over one parameter, maps over two, and a cross for every point that failed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PathCollection, QuadMesh

from modelgen.analysis import SweepResult
from modelgen.errors import CaseError
from modelgen.plots import plot


def result(names: tuple[str, ...], axes: tuple[list[float], ...], sampling: str = "grid") -> SweepResult:
    """A sweep whose first quantity is the sum of the swept values, its third point failed."""
    grid = tuple(np.array(axis) for axis in axes)
    values = np.stack([each.ravel() for each in np.meshgrid(*grid, indexing="ij")], axis=1)
    table = np.stack([values.sum(axis=1), -values.sum(axis=1)], axis=1)
    table[2] = np.nan
    outcomes = tuple("DIVERGED" if k == 2 else "SUCCESS" for k in range(len(values)))
    return SweepResult(
        "made_up", sampling, names, ("rad/s", "1")[: len(names)], values, grid if sampling == "grid" else (),
        ("shaft.torque.highest", "shaft.torque.lowest"), ("N*m", "N*m"), table, {}, (), np.zeros(0), outcomes,
        ("",) * len(values), ("",) * len(values),
    )  # fmt: skip


def test_curves_over_one_parameter() -> None:
    figure = plot(result(("speed",), ([100.0, 200.0, 300.0, 400.0],)))
    upper, lower = figure.axes
    line, cross = upper.lines
    assert line.get_xdata() == pytest.approx(np.array([100, 200, 300, 400]) * 30 / np.pi)
    assert np.asarray(line.get_ydata())[[0, 1, 3]].tolist() == [100, 200, 400]
    assert cross.get_xdata() == pytest.approx([300 * 30 / np.pi])
    assert upper.get_ylabel() == "[N·m]"
    assert lower.get_xlabel() == "speed [rpm]"
    assert "1 failed (crosses)" in figure.texts[1].get_text()


def test_a_map_over_two_parameters() -> None:
    figure = plot(result(("speed", "zeta"), ([100.0, 200.0], [1.0, 2.0, 3.0])), names=["shaft.torque.highest"])
    (field,) = [each for each in figure.axes[0].collections if isinstance(each, QuadMesh)]
    shown = np.ma.asarray(field.get_array()).reshape(3, 2)
    assert shown[:, 1].tolist() == [201, 202, 203]
    assert shown.mask.tolist() == [[False, False], [False, False], [True, False]]
    assert figure.axes[0].get_ylabel() == "zeta [-]"


def test_dots_over_two_parameters_without_a_grid() -> None:
    figure = plot(result(("speed", "zeta"), ([100.0, 200.0], [1.0, 2.0, 3.0]), "random"), names=["shaft.torque.lowest"])
    (dots,) = [each for each in figure.axes[0].collections if isinstance(each, PathCollection)]
    assert len(np.asarray(dots.get_offsets())) == 5


def test_what_cannot_be_drawn() -> None:
    one = result(("speed",), ([100.0, 200.0, 300.0],))
    with pytest.raises(CaseError, match="3 parameters were swept: a, b, c; draw sweeps over one or two"):
        plot(replace(one, names=("a", "b", "c")))
    with pytest.raises(CaseError, match=r"nearest is 'shaft.torque.highest'"):
        plot(one, names=["shaft.torque.higest"])
    with pytest.raises(CaseError, match="shows statistics only"):
        plot(one, names=[])
