"""A small branched driveline with one gear pair, its results, and what a readable figure is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from modelgen.analysis import AnglesResult, ModalResult, Window, angles, modal
from modelgen.elements import GearPair, GroundDamper, HarmonicTorque, Inertia, Shaft
from modelgen.model import Driveline
from modelgen.plots import GearMeshes, gear_meshes
from modelgen.solvers import Case, CrosscheckResult, Solution, crosscheck, operating_point, simulate


def branched() -> Driveline:
    """An engine that drives a pump through a gear pair, and a fan and an alternator directly."""
    return Driveline(
        "branched",
        speed="1500 rpm",
        reference="engine",
        elements=[
            Inertia("engine", inertia="2.5 kg*m^2"),
            Inertia("fan", inertia="0.4 kg*m^2"),
            Inertia("alternator", inertia="0.1 kg*m^2"),
            Inertia("pinion", inertia="0.05 kg*m^2"),
            Inertia("wheel", inertia="0.8 kg*m^2"),
            Inertia("pump", inertia="1.2 kg*m^2"),
            Shaft("fan_shaft", "engine", "fan", stiffness="20 kN*m/rad", damping_ratio=0.03),
            Shaft("belt", "engine", "alternator", stiffness="3 kN*m/rad", damping_ratio=0.05),
            Shaft("coupling", "engine", "pinion", stiffness="90 kN*m/rad", damping_ratio=0.03),
            GearPair(
                "mesh", "pinion", "wheel", teeth_a=21, teeth_b=63, module="4 mm", mesh="geometry", face_width="30 mm",
                half_backlash="40 um", damping_ratio=0.05,
            ),
            Shaft("pump_shaft", "wheel", "pump", stiffness="60 kN*m/rad", damping_ratio=0.03),
            HarmonicTorque("firing", "engine", mean="300 N*m", cosine=[400.0], base="firing_order"),
            HarmonicTorque("load", "pump", mean="-900 N*m"),
            GroundDamper("bearing", "pump", damping=0.0),
        ],
        bases={"firing_order": ("engine", 2)},
    )  # fmt: skip


@dataclass(frozen=True)
class Results:
    """Everything that can be drawn of one driveline."""

    driveline: Driveline
    case: Case
    solution: Solution
    window: Window
    angles: AnglesResult
    modes: ModalResult
    meshes: GearMeshes
    crosscheck: CrosscheckResult
    impacts: Solution


@pytest.fixture(scope="session")
def results() -> Results:
    driveline = branched()
    case = Case(driveline, end=0.24, samples=2401, tolerance=1e-5)
    point = operating_point(case.model)
    window = Window(0.08, 0.24, 8, "firing_order", 0.02, settled=False)
    solution = simulate(case)
    checked = crosscheck(case.change(end=0.03, samples=101), tolerances=[1e-6, 1e-8])
    return Results(
        driveline=driveline,
        case=case,
        solution=solution,
        window=window,
        angles=angles(solution, window, point),
        modes=modal(case.model, point=point),
        meshes=gear_meshes(case.model, point, highest_order=12),
        crosscheck=checked,
        impacts=simulate(case.change(start="zero", end=0.05, samples=1001)),
    )


def written(figure: Figure) -> Iterator[tuple[Axes | None, Text]]:
    """Every text that is drawn, with its axes."""
    for text in figure.texts:
        yield None, text
    for legend in figure.legends:
        yield from ((None, text) for text in legend.get_texts())
    for axes in figure.axes:
        yield from ((axes, text) for text in axes.texts)
        if not axes.axison:
            continue
        yield from ((axes, text) for text in (axes._left_title, axes.xaxis.label, axes.yaxis.label))
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [tick for tick in axis.get_major_ticks() if low - 1e-12 <= tick.get_loc() <= high + 1e-12]
            yield from ((axes, tick.label1) for tick in ticks if tick.label1.get_visible())


def check_readable(figure: Figure, *, numbers: bool = True) -> None:
    """Nothing leaves the page, nothing lies on anything else, every axis that shows numbers says its unit."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    texts = [text for _, text in written(figure) if text.get_text().strip() and text.get_visible()]
    boxes = [text.get_window_extent(renderer) for text in texts]
    width, height = figure.bbox.width, figure.bbox.height
    for text, box in zip(texts, boxes, strict=True):
        inside = box.x0 > -1 and box.y0 > -1 and box.x1 < width + 1 and box.y1 < height + 1
        assert inside, f"{text.get_text()!r} is clipped: {box}"
    upright = [(text, box) for text, box in zip(texts, boxes, strict=True) if text.get_rotation() in (0.0, 90.0)]
    for (one, box), (other, second) in combinations(upright, 2):
        across = min(box.x1, second.x1) - max(box.x0, second.x0)
        up = min(box.y1, second.y1) - max(box.y0, second.y0)
        assert not (across > 1 and up > 1), f"{one.get_text()!r} lies on {other.get_text()!r}"
    if numbers:
        labels = [label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
        assert labels
        for label in labels:
            assert "[" in label, f"{label!r} has no unit"
            assert "]" in label, f"{label!r} has no unit"


@pytest.fixture(scope="session")
def readable() -> Callable[..., None]:
    return check_readable


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20)
