"""Figure of the forced response: amplitudes of the orders and of their sum over speed, with limits and critical speeds.

Draws ``ForcedResult`` of ``modelgen.analysis``. At one speed the orders stand side by side as bars.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modelgen.analysis.linear.campbell import CampbellResult
from modelgen.analysis.linear.forced import ForcedResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import axis_label, definition, display, number, quantity_text, words
from modelgen.plots.speed_axis import RPM, TIMES, line_of, order_text, set_speed, source_text, spread
from modelgen.plots.style import INK, SMALL, TEXT, VERMILION, filled, panels, sheet, styled
from modelgen.units import read_quantity

Array = NDArray[np.float64]
KINDS = ("angle_deviation", "torque", "shear_stress", "force")
MOST = 6  # channels
FAR = 2.5  # limits that many times above the largest value are only named: drawn, they would flatten the curves
CROWD = 10  # bars, of more the numbers are small
NAMES = 2.9  # cm for a name beside a panel


@plot.register
@styled
def plot_forced(
    result: ForcedResult,
    /,
    *,
    channels: Sequence[str] | None = None,
    limits: Mapping[str, float | str] | None = None,
    critical: CampbellResult | None = None,
    count: int = 5,
) -> Figure:
    """Half peak to peak of all orders together, and amplitudes of the ``count`` strongest orders, of each channel over speed.

    ``channels``: up to 6; by default the inertia, shaft, stress and mesh that swing most. ``limits`` by channel: numbers in the
    channel's SI unit, or texts such as "0.5 deg". ``critical``: the Campbell diagram whose critical speeds of the orders shown
    are marked. Raises CaseError for unknown channels and where nothing is excited, UnitError for a limit in another unit.
    """
    where = f"forced response of {result.model!r}"
    names = _largest(result) if channels is None else list(channels)
    if not (0 < len(names) <= MOST and count >= 1):
        raise CaseError(where, f"{len(names)} channels and {count} orders are to be shown", f"name 1 to {MOST} channels")
    if not result.orders:
        raise CaseError(where, "nothing excites it", "give it harmonic torques or gear meshes")
    bounds = {name: _bound(result, name, value, where) for name, value in (limits or {}).items()}
    for name in bounds:
        if name not in names:
            raise CaseError(where, f"a limit is given for {name!r}, which is not shown", "add it to the channels")
    single = len(result.speeds) == 1
    exact = all(result.swing(name).exact for name in names)
    at = f" at {result.speeds[0] * RPM:.5g} rpm" if single else ""
    figure = sheet(result.model, f"forced response{at}", _detail(result, count, exact), height=0.8 + 4.9 * len(names))
    rows = [axes for (axes,) in panels(figure, len(names), share_x=not single)]
    for axes, name in zip(rows, names, strict=True):
        order = np.argsort(-np.abs(result[name]).max(axis=0), kind="stable")[:count]
        strongest = sorted(int(k) for k in order if np.abs(result[name][:, k]).max() > 0)
        (_bars if single else _curves)(axes, result, name, strongest, bounds.get(name))
        if critical is not None and not single:
            _critical(axes, result, strongest, critical)
        title = f"{words(name.rpartition('.')[0])}: {definition(name)}"
        axes.set_title(title, fontsize=TEXT, fontweight="bold", color=INK, pad=16 if critical is not None and not single else 4)
    figure.align_ylabels(rows)
    if single:
        rows[-1].set_xlabel(f"order [per turn of the reference shaft] ({TIMES} multiple of its base)")
    else:
        set_speed(rows[-1], result.speeds)
    return figure


def _bound(result: ForcedResult, name: str, value: float | str, where: str) -> float:
    """A limit in the SI unit of its channel."""
    where = f"{where}, limit of {name!r}"
    bound = read_quantity(value, result.unit(name), where) if isinstance(value, str) else float(value)
    if not 0 < bound < inf:
        raise CaseError(where, f"is {value!r}", "give a positive value")
    return bound


def _largest(result: ForcedResult) -> list[str]:
    """Of every kind of channel the one that swings most; torques are those of elements that twist."""
    twisting = {name.rpartition(".")[0] for name in result.channels if name.endswith(".twist")}
    found = []
    for kind in KINDS:
        own = [name for name in result.channels if name.rpartition(".")[2] == kind]
        if kind == "torque" and twisting:
            own = [name for name in own if name.rpartition(".")[0] in twisting]
        if own:
            found.append(max(own, key=lambda name: float(np.abs(result[name]).sum(axis=1).max())))
    return found or list(result.channels[:1])


def _detail(result: ForcedResult, count: int, exact: bool) -> str:
    summed = "over their common cycle, phases included" if exact else (
        "as a bound: each source is summed with its phases, and the sources added, because together they repeat too late"
    )  # fmt: skip
    few = f", the {count} strongest of {len(result.orders)}" if count < len(result.orders) else ""
    shaken = ""
    if result.parametric:
        share = max(result.parametric.values())
        shaken = f" Linear, with mean mesh stiffness, which in fact varies by up to {100 * share:.2g} %."
    return (
        f"All orders together: half peak to peak, {summed}. Orders per turn of the reference shaft, 0-peak{few}. "
        f"Physical values.{shaken}"
    )


def _tick(result: ForcedResult, k: int) -> str:
    return f"{order_text(result.orders[k])}\n({', '.join(f'{TIMES}{multiple}' for _, multiple in result.sources(k))})"


def _order(result: ForcedResult, k: int) -> str:
    return order_text(result.orders[k], result.sources(k))


def _curves(axes: Axes, result: ForcedResult, name: str, strongest: Sequence[int], limit: float | None) -> None:
    whole, speeds = result.swing(name).half_pp, result.speeds * RPM
    shown = display(result.unit(name), float(whole.max()))
    axes.plot(speeds, shown(whole), color=INK, linewidth=1.6, label="all orders together", zorder=4)
    for index, k in enumerate(strongest):
        color, dashes = line_of(index)
        amplitude = shown(np.abs(result[name][:, k]))
        axes.plot(speeds, amplitude, color=color, linestyle=dashes, linewidth=1.0, label=_wrapped(_order(result, k)), zorder=3)
    _limit(axes, limit, float(whole.max()), result.unit(name), shown.factor)
    axes.set_ylim(bottom=0)
    axes.set_ylabel(axis_label(name, shown.unit))
    axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), handlelength=2.6)


def _bars(axes: Axes, result: ForcedResult, name: str, strongest: Sequence[int], limit: float | None) -> None:
    """The strongest orders and their sum, at the only speed."""
    whole = float(result.swing(name).half_pp[0])
    shown = display(result.unit(name), whole)
    heights = [*(float(abs(result[name][0, k])) for k in strongest), whole]
    bases = list(dict.fromkeys(", ".join(map(source_text, result.bases[k])) for k in strongest))
    for index, k in enumerate(strongest):
        source = ", ".join(map(source_text, result.bases[k]))
        new = source not in [bar.get_label() for bar in axes.containers]
        axes.bar(index, shown(heights[index]), 0.6, color=line_of(bases.index(source))[0], edgecolor=INK, linewidth=0.3,
                 label=_wrapped(source) if new else "_", zorder=3)  # fmt: skip
    axes.bar(len(strongest), shown(whole), 0.6, color="white", edgecolor=INK, linewidth=0.8, hatch="////", zorder=3,
             label="all orders together")  # fmt: skip
    size = SMALL if len(heights) <= CROWD else 5.0
    for index, height in enumerate(heights):
        axes.annotate(number(float(shown(height)), 3), (index, shown(height)), xytext=(0, 1.5), textcoords="offset points",
                      ha="center", fontsize=size)  # fmt: skip
    axes.set_xticks(range(len(heights)), [*(_tick(result, k) for k in strongest), "all"], fontsize=size)
    _limit(axes, limit, whole, result.unit(name), shown.factor)
    axes.margins(y=0.12)
    axes.grid(axis="x", visible=False)
    axes.set_ylabel(axis_label(name, shown.unit))
    axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5))


def _limit(axes: Axes, limit: float | None, largest: float, unit: str, factor: float) -> None:
    if limit is None:
        return
    said = f"limit {quantity_text(limit, unit, 4)}".replace(" °", "°")
    if limit > FAR * largest:
        axes.plot([], [], linestyle="none", label=_wrapped(f"{said} (far above)"))
    else:
        axes.axhline(limit * factor, color=VERMILION, linewidth=1.4, label=said, zorder=5)


def _wrapped(text: str) -> str:
    return "\n".join(filled(text, SMALL, NAMES))


def _critical(axes: Axes, result: ForcedResult, strongest: Sequence[int], critical: CampbellResult) -> None:
    """Critical speeds of the orders shown, as dotted lines in their color with the speed above, the strongest that have room."""
    place = {result.orders[k]: index for index, k in enumerate(strongest)}
    low, high = float(result.speeds[0]), float(result.speeds[-1])
    own = [each for each in critical.critical if each.line.order in place and low <= each.speed <= high]
    own = sorted(own, key=lambda each: (-each.line.vector_sum, -each.line.torque))[:9]
    gap = (high - low) * RPM / 12.5
    labels = spread([each.speed * RPM for each in own], gap, low * RPM + gap / 3, high * RPM - gap / 3)
    for each, label in zip(own, labels, strict=True):
        color = line_of(place[each.line.order])[0]
        axes.axvline(each.speed * RPM, color=color, linewidth=0.8, linestyle=(0, (1, 1.5)), zorder=1)
        axes.annotate(
            f"{each.speed * RPM:.0f}", (each.speed * RPM, 1), xycoords=("data", "axes fraction"), xytext=(label, 1.045),
            textcoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=6.5, color=color, annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": color, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
