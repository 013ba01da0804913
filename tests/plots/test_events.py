"""The figure of events: readable, and its marks stand where the log says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modelgen import Case, Driveline, Inertia, Solution, simulate
from modelgen.elements import Brake, GroundSpring
from modelgen.errors import CaseError
from modelgen.lowering import Section
from modelgen.plots import plot_events

BELT = Driveline(
    "belt",
    elements=[
        Inertia("disk", inertia=2.0),
        GroundSpring("wire", "disk", stiffness=8.0),
        Brake("brake", "disk", sliding_torque=1.0, holding_torque=1.5, other_speed=0.1),
    ],
)


@pytest.fixture(scope="module")
def belt() -> Solution:
    return simulate(Case(BELT, end=20.0, start="zero", samples=2001, sections=(Section("disk.speed", 0.0, -1),)))


def test_marks_lie_on_the_channel_and_bars_fill_the_time(belt: Solution, readable: Callable[..., None]) -> None:
    figure = plot_events(belt, "wire.torque")
    readable(figure)
    above, below = figure.axes
    curve, *marks = above.get_lines()
    assert belt.events is not None
    assert sum(len(mark.get_xdata()) for mark in marks) == len(belt.events)
    times = np.sort(np.concatenate([mark.get_xdata() for mark in marks]))
    assert times == pytest.approx(belt.events.times)
    for mark in marks:
        assert mark.get_ydata() == pytest.approx(np.interp(mark.get_xdata(), curve.get_xdata(), curve.get_ydata()))
    widths = [np.ptp(path.vertices[:, 0]) for bars in below.collections for path in bars.get_paths()]
    assert sum(widths) == pytest.approx(20.0)
    assert [text.get_text() for text in below.get_yticklabels()] == ["brake.contact"]


def test_a_log_of_sections_alone_has_no_bars(readable: Callable[..., None]) -> None:
    disk = Driveline("swing", elements=[Inertia("disk", inertia=2.0), GroundSpring("wire", "disk", stiffness=8.0)])
    case = Case(disk, end=5.0, start={"wire.twist": 0.1}, samples=501, sections=(Section("disk.speed", 0.0, 0),))
    figure = plot_events(simulate(case), "wire.twist")
    readable(figure)
    assert len(figure.axes) == 1


def test_too_many_events_are_said_and_not_drawn(belt: Solution, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modelgen.plots.events.MOST_MARKS", 5)
    figure = plot_events(belt, "wire.torque")
    assert len(figure.axes[0].get_lines()) == 1
    assert any("events are too many to be marked" in text.get_text() for text in figure.axes[0].texts)


def test_what_cannot_be_drawn_is_refused(belt: Solution) -> None:
    with pytest.raises(CaseError, match=r"no events were located in this run; simulate with events"):
        plot_events(replace(belt, events=None), "wire.torque")
    with pytest.raises(CaseError, match=r"nearest is 'wire.torque'"):
        plot_events(belt, "wire.tork")
    empty = replace(belt, times=np.zeros(0), states=belt.states[:0], channels={name: np.zeros(0) for name in belt.channels})
    with pytest.raises(CaseError, match="it holds no times"):
        plot_events(empty, "wire.torque")
