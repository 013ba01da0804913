"""What shakes a driveline: the harmonics of everything that varies with time, by exact order of the reference shaft.

Below ``forced`` and ``campbell``. The compiled torques are evaluated at the operating point while one base frequency after the
other runs through one turn, and Fourier transformed: exact for Fourier rows, and every element that excites is covered without
being named. At rest on a mean torque a varying mesh stiffness excites too, by the force that it changes; that it also changes the
response to a given force (parametric excitation) is no matter of a linear model with constant coefficients: ``parametric`` says
which elements do so and by how much, and time integration answers it.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.energy_shares import FlangeMap, element_stiffness
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.solvers.linear_model import mapped, seen
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
FEWEST, MOST = 64, 4096  # samples of a turn: doubled until the series meets the curve, which ends early for Fourier rows
OFFSET = 0.381966  # of a step: where the series is held against the curve; no multiple of it is whole
TINY = 1e-11  # share of a row's size below which a harmonic is rounding


@dataclass(frozen=True, eq=False)
class Excitation:
    """Harmonics by order: a quantity is its mean + Re sum_h amplitude_h e^(i order_h phi), phi the angle of the reference shaft.

    ``orders`` per turn of the reference shaft, exact, rising; ``bases`` and ``harmonics``: which base frequencies each comes
    from, and as which multiple; ``amplitudes`` (rows, orders) of the torques on the groups, the rates of own states and the
    channels asked for; ``by_flange`` (flanges, orders) [N*m]: which element puts which torque on the node of each flange;
    ``varying`` (quantities, orders) of what varies with time itself.
    """

    orders: tuple[Fraction, ...]
    bases: tuple[tuple[str, ...], ...]
    harmonics: tuple[tuple[int, ...], ...]
    amplitudes: Complex
    by_flange: Complex
    varying: Complex

    @property
    def sources(self) -> tuple[tuple[tuple[str, int], ...], ...]:
        """Base frequencies of each order, with their multiples."""
        return tuple(tuple(zip(*pair, strict=True)) for pair in zip(self.bases, self.harmonics, strict=True))


def excitation(
    model: Compiled, point: OperatingPoint, channels: tuple[str, ...] = (), highest_order: float | None = None
) -> Excitation:
    """Harmonics of all that varies with time, at the operating point, up to a highest order of the reference shaft.

    Raises CaseError for a quantity that runs on two base frequencies at once.
    """
    rows = tuple(model.output_index(name) for name in channels)
    multiples = base_multiples(model, point)
    found: dict[Fraction, list[tuple[str, int, Complex]]] = {}
    for clock, entries in driven_quantities(model).items():
        multiple = multiples[clock]
        if not multiple:
            continue
        most = None if highest_order is None else int(highest_order / multiple)
        name = model.equations.clocks[clock].name
        for harmonic, column in _series(model, point, rows, clock, entries, most).items():
            found.setdefault(multiple * harmonic, []).append((name, harmonic, column))
    orders = sorted(found)
    heights = [len(point.angle) + len(model.mean_model.own_start) + len(channels), _flange_count(model), len(point.mean)]
    table = np.zeros((sum(heights), len(orders)), dtype=complex)
    for k, order in enumerate(orders):
        table[:, k] = sum(column for *_, column in found[order])
    amplitudes, by_flange, varying = np.split(table, np.cumsum(heights[:-1]))
    return Excitation(
        orders=tuple(orders),
        bases=tuple(tuple(name for name, *_ in found[order]) for order in orders),
        harmonics=tuple(tuple(harmonic for _, harmonic, _ in found[order]) for order in orders),
        amplitudes=amplitudes,
        by_flange=by_flange,
        varying=varying,
    )


def vector_sums(model: Compiled, point: OperatingPoint, shaking: Excitation) -> Array:
    """How strongly each order shakes the train as a whole (orders,) [N*m at the reference shaft], phases included.

    The torques from outside of all sources add up as vectors; what acts between shafts, such as a mesh, adds up to nothing and
    counts by its largest torque on a shaft. The larger of both is taken.
    """
    where = FlangeMap.of(model)
    ratio = model.mean_model.nodes_at(point.p) @ point.coordinates.ratio
    torque = shaking.by_flange * ratio[where.flange_node, None]
    between = np.bincount(where.flange_element, minlength=len(model.equations.instances))[where.flange_element] > 1
    inner = np.abs(torque[between]).max(axis=0, initial=0.0)
    return np.asarray(np.maximum(np.abs(torque.sum(axis=0)), inner))


def _flange_count(model: Compiled) -> int:
    return int(model.mean_model.elements.size1_out(0))


@functools.lru_cache(maxsize=16)
def _shaken(model: Compiled, rows: tuple[int, ...]) -> ca.Function:
    """(angle, speed, own, p, w) -> what is ``seen``, then the torque of every element on every flange."""
    given = seen(model, rows).sx_in()
    return ca.Function(
        "shaken", given, [ca.vertcat(seen(model, rows)(*given), ca.densify(model.mean_model.elements(*given)[0]))]
    )


def base_multiples(model: Compiled, point: OperatingPoint) -> list[Fraction]:
    """Every base frequency as an exact multiple of the operating speed; 0 where it stands still."""
    speed = operating_speed(model, point.p)
    frequencies = model.mean_model.frequencies_at(point.p)
    return [exact_multiple(float(each) / speed) for each in frequencies]


def operating_speed(model: Compiled, p: Array) -> float:
    """Operating speed [rad/s]. Raises CaseError for a driveline without one."""
    if model.equations.speed is None:
        raise CaseError(f"driveline {model.name!r}", "has no operating speed", 'give it one: Driveline(..., speed="1500 rpm")')
    return model.parameters.value(p, "speed")


def exact_multiple(value: float) -> Fraction:
    """The simplest fraction that a double stands for, such as a product of tooth ratios.

    >>> exact_multiple(26 / 46 * 17 / 108)
    Fraction(221, 2484)
    """
    for digits in range(1, 9):
        fraction = Fraction(value).limit_denominator(10**digits)
        if abs(float(fraction) - value) <= 4e-15 * abs(value):
            return fraction
    return Fraction(value)


@functools.lru_cache(maxsize=16)
def driven_quantities(model: Compiled) -> Mapping[int, tuple[int, ...]]:
    """Which quantities run on each base frequency that any runs on."""
    timed = model.mean_model.timed
    pairs = timed.jac_sparsity(0, 0).get_triplet()
    found: dict[int, tuple[int, ...]] = {}
    seen_before: dict[int, int] = {}
    for entry, clock in zip(*pairs, strict=True):
        other = seen_before.setdefault(entry, clock)
        if other != clock:
            names = [model.equations.clocks[each].name for each in (other, clock)]
            where = f"quantity {quantity_names(model)[entry]!r}"
            raise CaseError(where, f"runs on {names[0]!r} and {names[1]!r} at once", "integrate over time instead")
        found[clock] = (*found.get(clock, ()), entry)
    return found


def quantity_names(model: Compiled) -> list[str]:
    """Names of the quantities that vary with time only, in the order of the mean model."""
    eq = model.equations
    return [f"{i.name}.{d.name}" for i in eq.instances for d in eq.templates[i.template].definitions if d.depends == "time"]


def _series(
    model: Compiled, point: OperatingPoint, rows: tuple[int, ...], clock: int, entries: tuple[int, ...], most: int | None
) -> dict[int, Complex]:
    """Complex amplitudes by harmonic of one base frequency, those that are not rounding."""
    samples, quantities = FEWEST, len(point.mean)
    while True:
        steps = np.arange(samples)
        values, between = (_sampled(model, point, rows, clock, entries, (steps + part) / samples) for part in (0.0, OFFSET))
        series = np.fft.rfft(values, axis=1) / samples
        turn = np.exp(2j * np.pi * OFFSET / samples * np.arange(series.shape[1]))
        error = np.abs(np.fft.irfft(series * turn * samples, samples, axis=1) - between)
        size = np.abs(values).max(axis=1, keepdims=True)
        if samples >= MOST or np.all((error <= 1e-10 * size)[:-quantities]):
            break
        samples *= 2
    amplitudes = 2 * series[:, 1 : samples // 2]
    kept = np.flatnonzero(np.any((np.abs(amplitudes) > TINY * size)[:-quantities], axis=0))
    return {int(k) + 1: amplitudes[:, k] for k in kept if most is None or k + 1 <= most}


def _sampled(
    model: Compiled, point: OperatingPoint, rows: tuple[int, ...], clock: int, entries: tuple[int, ...], turns: Array
) -> Array:
    """Torques, rates, channels, flange torques and quantities over ``turns`` of one base frequency, all else at its mean."""
    count, n = len(turns), len(point.angle)
    angles = np.zeros((len(model.equations.clocks), count))
    angles[clock] = 2 * np.pi * turns
    varying = np.repeat(point.mean[:, None], count, axis=1)
    timed = np.asarray(mapped(model.mean_model.timed, count)(angles, np.zeros((1, count)), point.p))
    varying[list(entries)] = timed[list(entries)]
    held = [np.repeat(each[:, None], count, axis=1) for each in (point.angle, np.zeros(n), model.mean_model.own_start)]
    return np.vstack([np.asarray(mapped(_shaken(model, rows), count)(*held, point.p, varying)), varying])


def parametric(model: Compiled, point: OperatingPoint, samples: int = 32) -> dict[str, float]:
    """Elements whose own variation with time changes the stiffness they have, and by what share of it at most.

    Their linear answer is a first approximation: it leaves out that the changed stiffness answers the vibration differently.
    """
    names = [name.rpartition(".")[0] for name in quantity_names(model)]
    felt = set(model.mean_model.linear.jac_sparsity(2, 4).get_triplet()[1])
    index = {instance.name: number for number, instance in enumerate(model.equations.instances)}
    flange_element = FlangeMap.of(model).flange_element
    held = point.angle, np.zeros(len(point.angle)), model.mean_model.own_start, point.p
    stiffness = element_stiffness(model)(*held, point.mean)[0].full()
    found: dict[str, float] = {}
    for clock, entries in driven_quantities(model).items():
        angles = np.zeros((len(model.equations.clocks), samples))
        angles[clock] = 2 * np.pi * np.arange(samples) / samples
        timed = np.asarray(mapped(model.mean_model.timed, samples)(angles, np.zeros((1, samples)), point.p))
        for name in dict.fromkeys(names[entry] for entry in entries if entry in felt):
            mine = [entry for entry in entries if names[entry] == name]
            rows = flange_element == index[name]
            for column in timed.T:
                varying = point.mean.copy()
                varying[mine] = column[mine]
                change = np.abs(element_stiffness(model)(*held, varying)[0].full()[rows] - stiffness[rows]).max()
                own = np.abs(stiffness[rows]).max()
                if change > 1e-9 * own:
                    found[name] = max(found.get(name, 0.0), float(change / own) if own else np.inf)
    return found
