"""The common period: after which time does everything that shakes a driveline repeat, and what if that is long?

Below ``strobes``, ``sections``, ``bifurcation``. Every base frequency is an exact rational multiple of the operating speed, so
the common period is exact too: their greatest common divisor. A strobe at any other time shows a curve even of a stable linear
system, because the phase of what was left out runs on from strobe to strobe.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import pi

import numpy as np

from modelgen.analysis.linear.excitation import base_multiples, operating_speed, quantity_names
from modelgen.analysis.linear.synthesis import common_cycle
from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.operating_point import OperatingPoint

LONGEST = 64
"""Turns of the slowest base frequency: a longer common period is no strobe that anybody waits for."""


@dataclass(frozen=True)
class Strobe:
    """A time between strobes: ``period`` [s], ``turns`` of the reference shaft in it, ``cycles`` of each base frequency in it.

    ``complete``: all of them are whole, so that everything repeats and a periodic motion shows single points. ``base``: the base
    frequency of an incomplete strobe, empty for the common period.
    """

    period: float
    turns: Fraction
    cycles: Mapping[str, Fraction]
    complete: bool
    base: str = ""

    def __str__(self) -> str:
        counted = ", ".join(f"{name} {float(each):.6g}" for name, each in self.cycles.items())
        kind = "common period" if self.complete else f"period of {self.base}"
        return f"{kind} {self.period:.6g} s: {counted}"


def acting_bases(model: Compiled, point: OperatingPoint) -> dict[str, Fraction]:
    """Base frequencies that something runs on, as exact multiples of the operating speed.

    Raises CaseError for a quantity that depends on time itself, such as a stepped torque: nothing repeats then.
    """
    timed = model.mean_model.timed
    if aged := sorted(set(timed.jac_sparsity(0, 1).row())):
        name = quantity_names(model)[aged[0]]
        problem = f"quantity {name!r} depends on time itself, so nothing repeats"
        raise CaseError(f"driveline {model.name!r}", problem, "take it out, or hold it constant")
    acting = set(timed.jac_sparsity(0, 0).get_triplet()[1])
    if not acting:
        return {}
    multiples = base_multiples(model, point)
    return {clock.name: multiples[k] for k, clock in enumerate(model.equations.clocks) if k in acting and multiples[k]}


def strobe_of(model: Compiled, point: OperatingPoint, base: str | None = None, longest: float = LONGEST) -> Strobe:
    """The common period of all that shakes, or the period of one named ``base`` frequency.

    Raises CaseError where the common period is longer than ``longest`` periods of the slowest base frequency, and for a driveline
    that nothing shakes periodically.

    >>> from modelgen import assemble, load, lower, operating_point
    >>> model = lower(assemble(load("fracturing-truck-commensurate")))
    >>> print(strobe_of(model, operating_point(model)))
    common period 0.378947 s: engine_half_order 6, pump_crank 1, transmission_mesh.contact 288, pump_mesh.contact 108
    """
    where = f"driveline {model.name!r}"
    orders = acting_bases(model, point)
    if not orders:
        raise CaseError(where, "has nothing that runs on a base frequency, so no period to strobe at", "cut by a surface instead")
    speed = operating_speed(model, point.p)
    if base is not None:
        if base not in orders:
            raise CaseError(f"{where}, strobe", f"there is no acting base frequency {base!r}", nearest(base, orders))
        return _strobe(1 / orders[base], orders, speed, base)
    turns = common_cycle(tuple(orders.values()))
    slowest = min(orders, key=lambda name: orders[name])
    if turns * orders[slowest] > longest:
        raise CaseError(where, _why(orders, turns, speed), _choice(orders, slowest, speed))
    return _strobe(turns, orders, speed, "")


def _strobe(turns: Fraction, orders: Mapping[str, Fraction], speed: float, base: str) -> Strobe:
    cycles = {name: turns * order for name, order in orders.items()}
    complete = all(each.denominator == 1 for each in cycles.values())
    return Strobe(_seconds(turns, speed), turns, cycles, complete, "" if complete else base)


def _seconds(turns: Fraction, speed: float) -> float:
    return float(np.longdouble(turns.numerator) / np.longdouble(turns.denominator) * (2 * np.longdouble(pi)) / speed)


def _why(orders: Mapping[str, Fraction], turns: Fraction, speed: float) -> str:
    listed = ", ".join(f"{name} {order}" for name, order in orders.items())
    return (
        f"repeats only after {_turns(turns)} of the reference shaft ({_seconds(turns, speed):.4g} s), because its base "
        f"frequencies ({listed} per turn) have no shorter common period; a strobe at any of them shows a curve, never one point"
    )


def _choice(orders: Mapping[str, Fraction], slowest: str, speed: float) -> str:
    """What comes nearest: everything but one base frequency, or the curve over the slowest."""
    rests = {left: {name: order for name, order in orders.items() if name != left} for left in orders}
    cycles = {left: common_cycle(tuple(rest.values())) for left, rest in rests.items() if rest}
    least = min(cycles, key=lambda left: cycles[left])
    without = f"without {least!r} it would repeat after {_turns(cycles[least])} ({_seconds(cycles[least], speed):.4g} s)"
    return f"strobe with base={slowest!r} and expect a closed curve, or choose commensurate tooth numbers: {without}"


def _turns(turns: Fraction) -> str:
    return f"{turns} turn{'s' * (turns != 1)}"
