"""Figures of the linear questions: readable, and what they show is what the results hold."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import degrees, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from modelgen.analysis import (
    CampbellResult,
    ForcedResult,
    HammerResult,
    SensitivityResult,
    campbell,
    forced,
    gear_hammer,
    sensitivities,
)
from modelgen.analysis.limits.check import LimitsResult, check_limits
from modelgen.analysis.limits.rulebook import rule
from modelgen.analysis.measurements.compare import ComparisonResult, compare
from modelgen.analysis.measurements.measurement import Measurement
from modelgen.errors import CaseError, UnitError
from modelgen.plots import damper_power, energy_shares, plot, save
from modelgen.plots.speed_axis import spread

RPM = 30 / pi
ANGLE, TORQUE = "engine.angle_deviation", "coupling.torque"


@dataclass(frozen=True)
class Linear:
    """Everything linear that can be drawn of one driveline."""

    modes: Any
    campbell: CampbellResult
    at_speed: CampbellResult
    forced: ForcedResult
    single: ForcedResult
    hammer: HammerResult
    sensitivities: SensitivityResult
    limits: LimitsResult
    comparison: ComparisonResult


@pytest.fixture(scope="module")
def linear(results: Any) -> Linear:
    model, speeds = results.case.model, np.linspace(600, 2400, 19) / RPM
    swept = forced(model, speeds, diameters={"coupling": "60 mm"}, highest_order=70)
    values = {
        "engine.vibration_angle": "0.3 deg",
        "pump.vibration_angle": "0.7 deg",
        "coupling.vibratory_torque": "1.2 kN*m",
        "mode 1 (40 Hz) / firing.separation_margin": 0.0,
        "mode 2 (55 Hz) / firing.separation_margin": 0.25,
        "coupling.vibratory_stress": "30 MPa",
    }
    shaft = rule("kr_propulsion_shaft_continuous")
    given = {"tensile_strength": "600 MPa", "shape_factor": "integral_flange", "diameter": "60 mm"}
    torque = rule("coupling_vibratory_torque").given(continuous_vibratory_torque="1.5 kN*m")
    shafts = [shaft.given(**given, speed_ratio=ratio) for ratio in (0.8, 1.2)]  # the second lies beyond the rule
    rules = ["syt_5211_angle", torque, "api_617_separation", *shafts]
    times, run = np.linspace(0.09, 0.23, 1401), results.solution
    record = {name: 1.2 * np.interp(times, run.times, run[name]) for name in (ANGLE, TORQUE)}
    units = {ANGLE: "rad", TORQUE: "N*m"}
    measured = Measurement("bench.csv", "time", "t", times, record, units, units)
    return Linear(
        modes=results.modes,
        campbell=campbell(model, speeds, operating=["1400 rpm", "1600 rpm"]),
        at_speed=campbell(model, speeds),
        forced=swept,
        single=forced(model, highest_order=70),
        hammer=gear_hammer(swept),
        sensitivities=sensitivities(model, count=5),
        limits=check_limits(values, rules, "branched"),
        comparison=compare(run, measured, base="firing_order", orders=[1, 2, 3]),
    )


MAKERS: dict[str, Callable[[Linear], Figure]] = {
    "campbell": lambda r: plot(r.campbell),
    "campbell_at_one_speed": lambda r: plot(r.at_speed, margin=0.2, count=3),
    "campbell_without_near_ones": lambda r: plot(r.at_speed, margin=0.0),
    "forced": lambda r: plot(r.forced, critical=r.campbell, limits={"coupling.shear_stress": "1 MPa"}),
    "forced_channels": lambda r: plot(r.forced, channels=[ANGLE], limits={ANGLE: "80 deg"}, count=2),
    "forced_at_one_speed": lambda r: plot(r.single, limits={TORQUE: 300.0}, channels=[TORQUE, "mesh.force"]),
    "damper_power": lambda r: damper_power(r.forced),
    "damper_power_at_one_speed": lambda r: damper_power(r.single),
    "hammer": lambda r: plot(r.hammer),
    "hammer_at_one_speed": lambda r: plot(gear_hammer(r.single)),
    "limits": lambda r: plot(r.limits),
    "sensitivities": lambda r: plot(r.sensitivities),
    "energy_shares": lambda r: energy_shares(r.modes, modes=3),
    "comparison": lambda r: plot(r.comparison),
    "comparison_whole": lambda r: plot(r.comparison, last=None),
}


def notes(figure: Figure) -> str:
    texts = [text for axes in figure.axes for text in (*axes.texts, axes._left_title)]
    return " | ".join(text.get_text() for text in (*texts, *figure.texts)).replace("\n", " ")


@pytest.mark.parametrize("name", MAKERS)
def test_figure_is_readable(name: str, linear: Linear, readable: Callable[..., None]) -> None:
    figure = MAKERS[name](linear)
    readable(figure)
    assert figure.get_label().startswith("branched: ")
    assert figure.get_size_inches()[0] == pytest.approx(16 / 2.54)


def test_same_input_gives_the_same_bytes(linear: Linear, tmp_path: Path) -> None:
    first, second = (save(plot(linear.campbell), tmp_path / f"{k}.png").read_bytes() for k in range(2))
    assert first == second


# -- Campbell ----------------------------------------------------------------------------------------------------------------


def test_every_crossing_of_the_lines_shown_is_a_dot(linear: Linear) -> None:
    figure = plot(linear.campbell, margin=0.1)
    shafts, meshes = figure.axes[:2]
    assert (shafts.get_title("left"), meshes.get_title("left")) == ("orders of the shafts", "orders of the gear meshes")
    for axes in (shafts, meshes):
        dots = {(round(float(x), 6), round(float(y), 6)): line.get_color() for line in axes.lines if line.get_marker() == "o"
                for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)}  # fmt: skip
        drawn = {float(line.get_ydata()[0] / line.get_xdata()[0]) * 60 for line in axes.lines if len(line.get_xdata()) > 1}
        wanted = {
            (round(each.speed * RPM, 6), round(each.frequency, 6)): each.margin
            for each in linear.campbell.critical
            if each.frequency <= axes.get_ylim()[1] and any(abs(order / float(each.line.order) - 1) < 1e-9 for order in drawn)
        }
        assert dots.keys() == wanted.keys()
        assert dots
        for place, margin in wanted.items():
            assert (dots[place] == "white") == (abs(margin) > 0.1)


def test_the_margin_decides_what_is_listed(linear: Linear) -> None:
    near = [each for each in linear.campbell.critical if abs(each.margin) <= 0.1]
    assert near
    listed = notes(plot(linear.campbell, margin=0.1))
    assert all(f"{each.speed * RPM:.4g} rpm" in listed for each in near)
    figure = plot(linear.at_speed, margin=0.0)
    assert "no critical speeds of the orders shown within 0 % of it" in notes(figure)
    assert len(figure.axes) == 2


@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        (lambda r: replace(r, speeds=r.speeds[:1], frequencies=r.frequencies[:1]), {}, "is asked at one speed; give"),
        (lambda r: replace(r, lines=()), {}, "has no vibrating mode or no order"),
        (lambda r: r, {"margin": -0.1}, "margin is -0.1, count 9"),
    ],
)
def test_campbell_diagram_needs_a_range(change: Any, options: Any, words: str, linear: Linear) -> None:
    with pytest.raises(CaseError, match=words):
        plot(change(linear.campbell), **options)


# -- forced response ---------------------------------------------------------------------------------------------------------


def test_curves_are_amplitudes_and_half_of_the_swing(linear: Linear) -> None:
    result = linear.forced
    axes = plot(result, channels=[ANGLE], count=2, limits={ANGLE: "0.5 deg"}).axes[0]
    whole, *orders = (np.asarray(line.get_ydata(), dtype=float) for line in axes.lines[:3])
    assert whole == pytest.approx(degrees(1) * result.swing(ANGLE).half_pp)
    sizes = np.abs(result[ANGLE])
    strongest = sorted(np.argsort(-sizes.max(axis=0), kind="stable")[:2])
    for line, k in zip(orders, strongest, strict=True):
        assert line == pytest.approx(degrees(1) * sizes[:, k])
    assert axes.lines[0].get_xdata() == pytest.approx(result.speeds * RPM)
    assert "limit 0.5°" in [text.get_text() for text in axes.get_legend().get_texts()]
    assert float(axes.lines[3].get_ydata()[0]) == pytest.approx(0.5)


def test_a_limit_far_above_is_named_but_flattens_nothing(linear: Linear) -> None:
    axes = plot(linear.forced, channels=[TORQUE], limits={TORQUE: "9 MN*m"}).axes[0]
    assert any(re.match(r"limit 9 MN·m.*far", text.get_text(), re.DOTALL) for text in axes.get_legend().get_texts())
    assert axes.get_ylim()[1] < 1.5 * max(line.get_ydata().max() for line in axes.lines if len(line.get_ydata()))


def test_critical_speeds_of_the_orders_shown_are_marked(linear: Linear) -> None:
    figure = plot(linear.forced, channels=[TORQUE], critical=linear.campbell, count=1)
    k = int(np.abs(linear.forced[TORQUE]).max(axis=0).argmax())
    own = {f"{each.speed * RPM:.0f}" for each in linear.campbell.critical if each.line.order == linear.forced.orders[k]}
    assert {text.get_text() for text in figure.axes[0].texts} == own
    assert own


def test_by_default_the_largest_of_each_kind_is_shown(linear: Linear) -> None:
    titles = [axes.get_title("left") for axes in plot(linear.forced).axes]
    kinds = ["angle less uniform rotation", "torque", "shear stress", "mesh force along the line of action"]
    assert [title.partition(": ")[2] for title in titles] == kinds
    assert titles[2].startswith("coupling")


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"channels": ["coupling.torq"]}, CaseError, "no channel 'coupling.torq'; nearest is 'coupling.torque'"),
        ({"channels": []}, CaseError, "0 channels and 5 orders are to be shown; name 1 to 6"),
        ({"channels": [ANGLE], "limits": {TORQUE: 1.0}}, CaseError, "limit is given for 'coupling.torque', which is not shown"),
        ({"channels": [ANGLE], "limits": {ANGLE: "5 MPa"}}, UnitError, "limit of 'engine.angle_deviation'"),
        ({"channels": [ANGLE], "limits": {ANGLE: -1.0}}, CaseError, "is -1.0; give a positive value"),
    ],
)
def test_impossible_forced_figure_is_refused(options: Any, error: Any, words: str, linear: Linear) -> None:
    with pytest.raises(error, match=words):
        plot(linear.forced, **options)


def test_bars_of_power_add_up(linear: Linear) -> None:
    result = linear.forced
    axes = damper_power(result, speed="1500 rpm").axes[0]
    at = int(np.abs(result.speeds - 1500 / RPM).argmin())
    total = dict(zip(result.dampers, result.power[at].sum(axis=1), strict=True))
    lengths = np.array([[bar.get_width() for bar in container] for container in axes.containers]).sum(axis=0)
    names = [label.get_text().replace(" ", "_") for label in axes.get_yticklabels()]
    factor = {"W": 1.0, "kW": 1e-3, "mW": 1e3}[axes.get_xlabel().partition("[")[2].rstrip("]")]
    assert lengths == pytest.approx([factor * total[name] for name in names])
    assert sorted(lengths, reverse=True) == pytest.approx(lengths.tolist())
    with pytest.raises(CaseError, match="is computed from 600 to 2400 rpm, not at 3000 rpm"):
        damper_power(result, speed="3000 rpm")
    with pytest.raises(CaseError, match="has no damper that works"):
        damper_power(replace(result, power=np.zeros_like(result.power)))


def test_hammer_is_shaded_where_the_load_reaches_zero(linear: Linear) -> None:
    load = linear.hammer.gears["mesh"]
    assert load.hammer.any()
    assert not load.hammer.all()
    figure = plot(linear.hammer)
    (area,) = (each for each in figure.axes[0].collections if isinstance(each, PolyCollection))
    spans = [path.get_extents().intervalx for path in area.get_paths()]
    for speed, hammers in zip(linear.hammer.speeds * RPM, load.hammer, strict=True):
        assert any(low - 1e-6 <= speed <= high + 1e-6 for low, high in spans) == hammers
    assert "mesh: hammers; vibration at most" in notes(figure)
    calm = replace(load, hammer=np.zeros_like(load.hammer))
    assert "mesh: does not hammer" in notes(plot(replace(linear.hammer, gears={"mesh": calm})))
    with pytest.raises(CaseError, match="holds no gear"):
        plot(replace(linear.hammer, gears={}))


# -- limits ------------------------------------------------------------------------------------------------------------------


def test_bars_are_the_used_part_of_each_limit(linear: Linear) -> None:
    figure = plot(linear.limits)
    angle, torque, separation = figure.axes[:3]
    assert [bar.get_width() for bars in angle.containers for bar in bars] == pytest.approx([140, 60])
    assert [bar.get_width() for bars in torque.containers for bar in bars] == pytest.approx([80])
    assert [bar.get_width() for bars in separation.containers for bar in bars] == pytest.approx([200, 40])  # no margin: cut
    said = notes(figure)
    assert "0.7° (≤ 0.5°), fail" in said
    assert "1.2 kN·m (≤ 1.5 kN·m), pass" in said
    assert "25 % (≥ 10 %), pass" in said
    assert "30 MPa: not judged" in said


def test_rules_taken_on_trust_are_hatched_and_named(linear: Linear) -> None:
    figure = plot(linear.limits)
    assert "was not seen (syt_5211_angle, coupling_vibratory_torque, api_617_separation)" in notes(figure)
    hatched = [any(bar.get_hatch() for bars in axes.containers for bar in bars) for axes in figure.axes]
    assert hatched == [True, True, True, False]
    assert "[kr_propulsion_shaft_continuous]" in figure.axes[3].get_title("left")


def test_rows_beyond_the_count_are_said_and_none_is_refused(linear: Linear) -> None:
    assert "3 rows with more left are not shown" in notes(plot(linear.limits, count=1))
    with pytest.raises(CaseError, match="0 rows are to be drawn"):
        plot(replace(linear.limits, rows=()))


# -- sensitivities and energies ----------------------------------------------------------------------------------------------


def test_bars_are_the_largest_relative_slopes(linear: Linear) -> None:
    result = linear.sensitivities
    figure = plot(result, modes=2, count=3)
    for panel, axes in enumerate(figure.axes):
        mode = result.rigid + panel
        assert axes.get_title("left") == f"mode {mode}: {result.frequencies[mode]:.4g} Hz"
        names, slopes = zip(*result.largest(mode, 3), strict=True)
        assert [bars[0].get_width() for bars in axes.containers] == pytest.approx(slopes)
        written = [name.replace("_", " ").replace(".", ", ") for name in names]
        assert [label.get_text() for label in axes.get_yticklabels()] == written
    with pytest.raises(CaseError, match="0 of 4 vibrating modes are to be drawn"):
        plot(result, modes=0)


def test_differenced_ones_are_hatched(linear: Linear) -> None:
    result = linear.sensitivities
    assert "by differences" not in notes(plot(replace(result, methods=("derivative",) * len(result.methods))))
    figure = plot(replace(result, methods=("differences",) * len(result.methods)))
    assert "Hatched: by differences" in notes(figure)
    assert all(bars[0].get_hatch() for axes in figure.axes for bars in axes.containers)


def test_shares_are_those_of_the_mode(linear: Linear) -> None:
    modes = linear.modes
    axes = energy_shares(modes, modes=1, count=4).axes[0]
    first = modes.rigid
    size = np.maximum(modes.kinetic[:, first], modes.potential[:, first])
    wanted = [modes.elements[k] for k in np.argsort(-size, kind="stable")[:4]]
    assert [label.get_text().replace(" ", "_") for label in axes.get_yticklabels()] == wanted
    widths = sorted(bar.get_width() for bars in axes.containers for bar in bars)
    assert widths[-4:] == pytest.approx(sorted(100 * np.sort(size)[-4:]))


# -- comparison --------------------------------------------------------------------------------------------------------------


def test_signals_and_orders_lie_over_each_other(linear: Linear) -> None:
    figure = plot(linear.comparison, last=None)
    channel = linear.comparison.channels[1]
    signals, orders = figure.axes[2:4]
    simulated, measured = (np.asarray(line.get_ydata()) for line in signals.lines)
    factor = channel.simulated[0] / simulated[0]
    assert factor * simulated == pytest.approx(channel.simulated)
    assert factor * measured == pytest.approx(channel.measured)
    heights = [[factor * bar.get_height() for bar in bars] for bars in orders.containers]
    assert heights[0] == pytest.approx([each.measured for each in channel.orders])
    assert heights[1] == pytest.approx([each.simulated for each in channel.orders])
    assert "(\N{MINUS SIGN}17 %)" in notes(figure)


def test_the_last_periods_are_shown(linear: Linear) -> None:
    low, high = plot(linear.comparison, last=2).axes[0].get_xlim()
    assert high - low == pytest.approx(2 / linear.comparison.frequency, rel=0.01)
    with pytest.raises(CaseError, match="2 channels over 0 periods"):
        plot(linear.comparison, last=0)


def test_labels_keep_apart_and_inside(rng: np.random.Generator) -> None:
    places = rng.uniform(0, 10, 12).tolist()
    found = spread(places, 0.7, 0.0, 10.0)
    order = np.argsort(places, kind="stable")
    assert np.diff(np.array(found)[order]).min() >= 0.7 - 1e-8
    assert min(found) >= -1e-8
    assert max(found) <= 10 + 1e-8
    assert spread([2.0, 6.0], 1.0, 0.0, 10.0) == [2.0, 6.0]
    assert spread([5.0, 5.0, 5.0], 9.0, 0.0, 10.0) == [0.0, 5.0, 10.0]  # no room: as far apart as can be
    assert spread([], 1.0, 0.0, 1.0) == []
