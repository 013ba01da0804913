"""Question: at which speeds does an order meet a natural frequency, and how far off is the operating speed?

Natural frequencies over the operating speed (Campbell), lines of all orders that excite (engine, pump, meshes: exact multiples of
the reference shaft), their crossings as critical speeds, and the margin of each to the operating speed or range.
Sources: W. Campbell, Trans. ASME 46 (1924) 31; API RP 684 (interference diagram and separation margins of trains).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.excitation import base_multiples, excitation, operating_speed, vector_sums
from modelgen.analysis.linear.linear_remarks import mode_remarks
from modelgen.analysis.linear.mode_numbers import mode_name
from modelgen.analysis.linear.natural_modes import Modes, natural_modes
from modelgen.analysis.linear.orders import order_name, source_name
from modelgen.analysis.linear.speeds import Parameters, point_at, read_speeds
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.solvers.bound_model import compiled_of
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
SAMPLES = 41
NEGLIGIBLE = 1e-6  # of the largest harmonic torque: lines weaker than that are left out
EXACT = 1e-12  # of a critical speed, where frequencies change with speed


@dataclass(frozen=True)
class OrderLine:
    """An order per turn of the reference shaft, exact; ``sources``: (base frequency, harmonic) it comes from.

    ``torque`` [N*m at the reference shaft]: its largest harmonic torque on any shaft at the operating speed. ``vector_sum``
    [the same]: that of all its sources together, phases included, or of the strongest mesh where that is more: by it orders rank,
    so that firings which cancel come last.
    """

    order: Fraction
    sources: tuple[tuple[str, int], ...]
    torque: float
    vector_sum: float = 0.0

    @property
    def label(self) -> str:
        """Such as ``engine_half_order x 6``."""
        return source_name(self.sources)

    @property
    def name(self) -> str:
        """Such as ``order 3 (engine_half_order x 6)``."""
        return order_name(self.order, self.sources)


@dataclass(frozen=True)
class CriticalSpeed:
    """Where a line meets a mode, at ``speed`` [rad/s] and ``frequency`` [Hz].

    ``mode``: its column in the frequencies (from 0, rigid ones included); ``number``: how it is counted, vibrating modes from 1.
    ``margin``: distance from the operating speed or range, per its nearer end; 0 inside the range, negative below it.
    """

    line: OrderLine
    mode: int
    speed: float
    frequency: float
    margin: float
    number: int


@dataclass(frozen=True, eq=False)
class CampbellResult:
    """``frequencies`` (speeds, modes) [Hz] over ``speeds`` [rad/s], the first ``rigid`` of them zero; ``lines`` by order;
    ``critical`` speeds within the speeds, the nearest to the ``operating`` speed or range (low, high) [rad/s] first. ``remarks``:
    what is to be known of the matrices, and modes that are unstable.
    """

    model: str
    speeds: Array
    frequencies: Array
    rigid: int
    lines: tuple[OrderLine, ...]
    critical: tuple[CriticalSpeed, ...]
    operating: tuple[float, float]
    remarks: tuple[str, ...] = ()

    def within(self, margin: float, share: float = 0.0) -> tuple[CriticalSpeed, ...]:
        """Critical speeds within a margin, of lines with at least this share of the largest harmonic torque."""
        largest = max((line.torque for line in self.lines), default=0.0)
        return tuple(each for each in self.critical if abs(each.margin) <= margin and each.line.torque >= share * largest)

    def __str__(self) -> str:
        low, high = (each * 30 / np.pi for each in self.operating)
        at = f"{low:.6g} rpm" if low == high else f"{low:.6g} to {high:.6g} rpm"
        rows = [f"critical speeds of {self.model!r}, operating at {at}: {len(self.critical)}, the nearest"]
        for each in self.critical[:12]:
            where = f"mode {each.number} ({each.frequency:.4g} Hz), {each.line.name}"
            rows.append(f"  {each.speed * 30 / np.pi:10.2f} rpm  {each.margin:+8.1%}  {where}")
        return "\n".join([*rows, *(f"  {each}" for each in self.remarks)])

    __repr__ = __str__


def campbell(
    model: Any,
    speeds: Any = None,
    parameters: Parameters = None,
    *,
    operating: Any = None,
    highest_order: float | None = None,
) -> CampbellResult:
    """Campbell diagram over ``speeds`` (rising, rad/s or texts; by default a quarter to one and a half of the operating speed).

    ``parameters``: values by name, or a function of the speed that returns them. ``operating``: a speed or the pair (low,
    high), by default the model's own speed. Raises CaseError for speeds that are not lawful, and what ``operating_point``
    raises.

    >>> from modelgen import Driveline, HarmonicTorque, Inertia, Shaft, assemble, lower
    >>> line = Driveline("two_disks", speed="1200 rpm", reference="engine", bases={"firing": 3}, elements=[
    ...     Inertia("engine", inertia=3.0), Inertia("load", inertia=1.0), Shaft("shaft", "engine", "load", stiffness=3e5),
    ...     HarmonicTorque("torque", "engine", cosine=[40.0, 10.0], base="firing")])
    >>> print(campbell(lower(assemble(line))))
    critical speeds of 'two_disks', operating at 1200 rpm: 1, the nearest
         1006.58 rpm    -16.1%  mode 1 (100.7 Hz), order 6 (firing x 2)
    """
    model = compiled_of(model, "campbell")
    own = operating_speed(model, model.parameters.unbalanced())
    listed = read_speeds(model, np.linspace(own / 4, 1.5 * own, SAMPLES) if speeds is None else speeds)
    found = (own, own) if operating is None else tuple(read_speeds(model, operating)[[0, -1]].tolist())
    target = (found[0], found[1])
    modes_at = _modes_at(model, parameters)
    every = [modes_at(float(speed)) for speed in listed]
    rigid, frequencies = every[0].free, np.array([modes.frequencies for modes in every])
    lines = order_lines(model, sum(target) / 2, parameters, highest_order)
    critical = []
    for line in lines:
        for mode in range(rigid, frequencies.shape[1]):
            for speed in _crossings(listed, frequencies[:, mode], float(line.order), modes_at, mode):
                frequency, margin = float(line.order) * speed / (2 * np.pi), _margin(speed, target)
                critical.append(CriticalSpeed(line, mode, speed, frequency, margin, mode - rigid + 1))
    critical.sort(key=lambda each: (abs(each.margin), each.line.order))
    remarks = (
        *mode_remarks(model, point_at(model, sum(target) / 2, parameters)),
        *_unstable(np.array([modes.growth for modes in every]), listed, rigid),
    )
    return CampbellResult(model.name, listed, frequencies, rigid, lines, tuple(critical), target, remarks)


def order_lines(
    model: Compiled, speed: float, parameters: Parameters, highest_order: float | None = None
) -> tuple[OrderLine, ...]:
    """All orders that excite noticeably at a speed [rad/s], and the first order of every other base frequency."""
    point = point_at(model, speed, parameters)
    shaking = excitation(model, point, highest_order=highest_order)
    n = len(point.angle)
    size = np.abs(shaking.amplitudes[:n] * point.coordinates.ratio[:, None]).max(axis=0, initial=0.0)
    together = vector_sums(model, point, shaking)
    found = {
        order: OrderLine(order, sources, float(torque), float(summed))
        for order, sources, torque, summed in zip(shaking.orders, shaking.sources, size, together, strict=True)
        if torque > NEGLIGIBLE * size.max()
    }
    for clock, multiple in zip(model.equations.clocks, base_multiples(model, point), strict=True):
        if multiple and multiple not in found and (highest_order is None or multiple <= highest_order):
            found[multiple] = OrderLine(multiple, ((clock.name, 1),), 0.0)
    return tuple(found[order] for order in sorted(found))


def _unstable(growth: Array, speeds: Array, rigid: int) -> tuple[str, ...]:
    """A sentence for each mode that grows without any damping, at some of the speeds."""
    said = []
    for mode in np.flatnonzero((growth > 0).any(axis=0)).tolist():
        where = speeds[growth[:, mode] > 0] * 30 / np.pi
        at = f"from {where[0]:.6g} to {where[-1]:.6g} rpm, at {len(where)} of {len(speeds)} speeds"
        said.append(f"{mode_name(mode, rigid)} is unstable {at}: it grows with up to {growth[:, mode].max():.4g} 1/s")
    return tuple(said)


def _modes_at(model: Compiled, parameters: Parameters) -> Callable[[float], Modes]:
    """The natural modes at a speed; the same matrices are not solved twice."""
    known: dict[float, Modes] = {}
    solved: list[tuple[OperatingPoint, Modes]] = []

    def at(speed: float) -> Modes:
        if speed not in known:
            point = point_at(model, speed, parameters)
            for before, modes in solved[-1:]:
                if all(np.array_equal(*both) for both in zip(_matrices(before), _matrices(point), strict=True)):
                    known[speed] = modes
                    return modes
            known[speed] = natural_modes(point.mass, point.stiffness, point.coordinates, point.damping)
            solved.append((point, known[speed]))
        return known[speed]

    return at


def _matrices(point: OperatingPoint) -> tuple[Array, Array, Array]:
    """What natural modes depend on: of the damping its skew part."""
    return point.mass, point.stiffness, point.damping - point.damping.T


def _crossings(speeds: Array, frequencies: Array, order: float, at: Callable[[float], Modes], mode: int) -> list[float]:
    """Speeds at which order * speed equals a natural frequency, one for each change of sign between neighboring speeds."""
    distance = frequencies * 2 * np.pi - order * speeds
    found = [float(speeds[k]) for k in np.flatnonzero((distance == 0) & (frequencies > 0))]
    for k in np.flatnonzero((distance[:-1] * distance[1:] < 0) & (frequencies[:-1] > 0) & (frequencies[1:] > 0)):
        if frequencies[k] == frequencies[k + 1]:
            found.append(float(frequencies[k]) * 2 * np.pi / order)
        else:
            found.append(
                _root(float(speeds[k]), float(speeds[k + 1]), lambda s: float(at(s).frequencies[mode]) * 2 * np.pi - order * s)
            )
    return found


def _root(low: float, high: float, function: Callable[[float], float]) -> float:
    """Root between two speeds of different sign, by regula falsi with halved weights (Illinois)."""
    at_low, at_high = function(low), function(high)
    for _ in range(60):
        middle = (low * at_high - high * at_low) / (at_high - at_low)
        value = function(middle)
        if abs(value) <= EXACT * abs(middle):
            return middle
        if value * at_high < 0:
            low, at_low = high, at_high
        else:
            at_low /= 2
        high, at_high = middle, value
        if abs(high - low) < EXACT * abs(high):
            return middle
    raise CaseError("critical speed", f"between {low:g} and {high:g} rad/s does not settle", "ask at more speeds")


def _margin(speed: float, operating: tuple[float, float]) -> float:
    low, high = operating
    return speed / high - 1 if speed > high else speed / low - 1 if speed < low else 0.0
