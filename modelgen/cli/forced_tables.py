"""The files of a forced response: swings by speed, orders with phases, power lost, gear loads, summary, figure.

Part of ``cli``, below the command ``forced``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.analysis import ForcedResult, HammerResult, Swings, gear_hammer
from modelgen.analysis.linear.orders import source_name
from modelgen.plots import damper_power, plot, save
from modelgen.reports.report import digits
from modelgen.reports.tables import RPM, aligned, write_data, write_table

NEGLIGIBLE = 1e-4  # of the largest amplitude of a channel: orders below are left out of the table
SHOWN = (".twist", ".torque", ".angle_deviation", ".shear_stress", ".force")
ROWS = 6  # of each kind of channel on the terminal


def write_forced(
    result: ForcedResult,
    factors: Mapping[str, float],
    folder: Path,
    channels: Sequence[str] = (),
    limits: Mapping[str, str] | None = None,
) -> str:
    """Writes everything and returns what the terminal says of it: sums over long cycles are made once.

    The figure shows ``channels`` and those that have ``limits``, by default those that swing most.
    """
    limits = limits or {}
    shown = list(dict.fromkeys([*channels, *limits]))
    # The figures first: what they refuse should not wait for long tables.
    save(plot(result, channels=shown or None, limits=limits), folder / "forced.png")
    turns = (result.speeds * RPM).tolist()
    swings = {name: result.swing(name) for name in result.channels}
    hammer = gear_hammer(result) if result.gears else None
    header, columns = ["speed [rpm]"], [turns]
    for name, swing in swings.items():
        unit = result.unit(name)
        header += [f"{name} mean [{unit}]", f"{name} 0-peak [{unit}]", f"{name} half p-p [{unit}]"]
        columns += [swing.mean.tolist(), swing.peak.tolist(), swing.half_pp.tolist()]
    write_table(folder / "forced.csv", header, list(zip(*columns, strict=True)))
    header = ["speed [rpm]", "channel", "order [1/turn]", "exact order", "bases", "amplitude [unit]", "unit", "phase [deg]"]
    header.append("sources")
    write_table(folder / "orders.csv", header, _order_rows(result))
    lost = result.power.sum(axis=2)
    if lost.max(initial=0.0) > 0:
        save(damper_power(result), folder / "power.png")
    rows = [[speed, *row] for speed, row in zip(turns, lost.tolist(), strict=True)]
    write_table(folder / "power.csv", ["speed [rpm]", *(f"{name} [W]" for name in result.dampers)], rows)
    if hammer is not None:
        header = ["speed [rpm]", "gear", "unit", "mean [unit]", "alternating [unit]", "least [unit]"]
        header += ["alternating per mean [1]", "hammer"]
        write_table(folder / "gears.csv", header, _gear_rows(turns, hammer))
        save(plot(hammer), folder / "gears.png")
    write_data(folder / "forced.json", forced_data(result, swings, hammer, factors))
    return _text(result, swings, hammer)


def _order_rows(result: ForcedResult) -> Iterator[list[Any]]:
    """Amplitudes with their phases: channel = mean + sum of amplitude cos(order phi + phase), phi the reference shaft's angle."""
    size = np.abs(result.amplitudes)
    kept = size > NEGLIGIBLE * size.max(axis=(0, 2), keepdims=True, initial=0.0)
    for s, speed in enumerate((result.speeds * RPM).tolist()):
        for c, (channel, unit) in enumerate(zip(result.channels, result.units, strict=True)):
            for h in np.flatnonzero(kept[s, c]):
                order, value = result.orders[h], result.amplitudes[s, c, h]
                phase = math.degrees(np.angle(value))
                base, size_of = " ".join(result.bases[h]), float(abs(value))
                yield [speed, channel, float(order), str(order), base, size_of, unit, phase, source_name(result.sources(int(h)))]


def _gear_rows(turns: list[float], hammer: HammerResult) -> Iterator[list[Any]]:
    for name, load in hammer.gears.items():
        columns = (load.mean, load.alternating, load.least, load.ratio)
        for k, speed in enumerate(turns):
            yield [speed, name, load.unit, *(float(values[k]) for values in columns), "yes" if load.hammer[k] else "no"]


def _text(result: ForcedResult, swings: Mapping[str, Swings], hammer: HammerResult | None) -> str:
    """The largest swing of each channel over the speeds, for the terminal."""
    rows, left = [], 0
    for ending in SHOWN:
        found = []
        for name, swing in swings.items():
            if name.endswith(ending):
                unit = result.unit(name)
                worst = int(swing.half_pp.argmax())
                turns = math.pi / 180 if unit == "rad" else 1.0
                values = [swing.mean[worst] / turns, swing.half_pp[worst] / turns, swing.peak[worst] / turns]
                shown = [digits(float(value)) for value in values]
                at = digits(float(result.speeds[worst] * RPM))
                found.append((values[1], [name, *shown, "deg" if unit == "rad" else unit, at]))
        found.sort(key=lambda pair: -pair[0])
        rows += [row for _, row in found[:ROWS]]
        left += max(0, len(found) - ROWS)
    lines = [str(result), aligned(["channel", "mean", "half p-p", "0-peak", "unit", "at [rpm]"], rows)]
    if left:
        lines.append(f"... and {left} smaller ones, in forced.csv")
    if hammer is not None:
        lines.append(str(hammer))
    return "\n".join([*lines, *_remarks(result)])


def _remarks(result: ForcedResult) -> list[str]:
    """What the linear answer leaves out."""
    said = ", ".join(f"{name} by {share:.0%}" for name, share in result.parametric.items())
    return [f"stiffness varies with time in {said}: left out here, time integration (modelgen run) has it"] if said else []


def forced_data(
    result: ForcedResult, swings: Mapping[str, Swings], hammer: HammerResult | None, factors: Mapping[str, float]
) -> dict[str, Any]:
    """The response as plain data: what is largest over the speeds, by channel with its unit, and at which speed."""
    turns = (result.speeds * RPM).tolist()
    worst = {name: int(swing.half_pp.argmax()) for name, swing in swings.items()}
    lost = result.power.sum(axis=2)
    return {
        "model": result.model,
        "speeds_rpm": turns,
        "added_speeds_rpm": [speed * RPM for speed in result.added],
        "changed_parameters": dict(factors),
        "complex_stiffness": result.complex_stiffness,
        "cycle_turns": str(result.cycle),
        "orders_per_turn": [float(order) for order in result.orders],
        "orders": [result.order_name(k) for k in range(len(result.orders))],
        "largest": {
            f"{name} [{result.unit(name)}]": {
                "mean": float(swing.mean[worst[name]]),
                "half_pp": float(swing.half_pp[worst[name]]),
                "peak": float(swing.peak[worst[name]]),
                "at_rpm": turns[worst[name]],
                "exact": swing.exact,
            }
            for name, swing in swings.items()
        },
        "largest_power_lost_w": {name: float(lost[:, k].max()) for k, name in enumerate(result.dampers)},
        "gear_hammer": {
            name: {
                "hammers": bool(load.hammer.any()),
                "at_rpm": [speed for speed, beaten in zip(turns, load.hammer.tolist(), strict=True) if beaten],
                "largest_alternating_per_mean": float(load.ratio.max()),
            }
            for name, load in (hammer.gears if hammer else {}).items()
        },
        "varying_stiffness_shares": dict(result.parametric),
        "remarks": [*_remarks(result), *result.remarks],
    }
