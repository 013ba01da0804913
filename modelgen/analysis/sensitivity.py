"""Question: how does each natural frequency change with each parameter?

d(omega^2)/dp = q^T (dK/dp - omega^2 dM/dp) q for shapes with q^T M q = 1. K and M are differentiated through the whole parameter
vector: through shared parameters, their expressions, means over time, the quantities a law works with. What no derivative exists
for is differenced, and the result says so: parameters derived by a NumPy function (mesh stiffness from the teeth), and the
static angles of a driveline whose stiffness depends on them. Modes that share a frequency: the slopes of the frequencies into
which the parameter splits them.
Sources: R. L. Fox, M. P. Kapoor, AIAA J. 6 (1968) 2426; for repeated modes I. U. Ojalvo, AIAA J. 26 (1988) 361.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear_model import mapped
from modelgen.analysis.modal import repeated_modes
from modelgen.analysis.natural_modes import natural_modes
from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.equilibrium import own_start
from modelgen.solvers.operating_point import OperatingPoint, operating_point

Array = NDArray[np.float64]
SAMPLES = 256  # of a turn, for derivatives of means that no element states
STEP = 1e-3  # of a parameter, for differences; they are extrapolated to the fourth order
SMALL = 1e-5  # step from zero


@dataclass(frozen=True, eq=False)
class SensitivityResult:
    """Slopes of the natural frequencies.

    ``frequencies`` [Hz] of all modes, the first ``rigid`` of them zero, whatever the parameters; ``parameters`` with ``units``
    and ``values`` (a row of a series is ``name[3]``); ``slopes`` (modes, parameters) [Hz per unit]; ``relative``: the same as
    relative change of the frequency per relative change of the parameter. ``methods`` by parameter: "derivative" or
    "differences". ``repeated``: modes that share a frequency. ``whole``: parameters that are whole numbers, which have no
    slope.
    """

    model: str
    frequencies: Array
    rigid: int
    parameters: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    slopes: Array
    methods: tuple[str, ...]
    repeated: tuple[tuple[int, ...], ...]
    whole: tuple[str, ...]

    @property
    def relative(self) -> Array:
        """Relative change of each frequency per relative change of each parameter."""
        safe = np.where(self.frequencies != 0, self.frequencies, 1.0)
        return np.asarray(self.slopes * self.values / safe[:, None])

    def __getitem__(self, parameter: str) -> Array:
        """Slopes (modes,) [Hz per unit] with one parameter. Raises CaseError with the nearest name."""
        if parameter in self.whole:
            raise CaseError(f"sensitivities of {self.model!r}", f"{parameter!r} is a whole number", "compare two drivelines")
        if parameter not in self.parameters:
            raise CaseError(
                f"sensitivities of {self.model!r}", f"no parameter {parameter!r}", nearest(parameter, self.parameters)
            )
        return self.slopes[:, self.parameters.index(parameter)]

    def largest(self, mode: int, count: int = 5) -> list[tuple[str, float]]:
        """The parameters that a mode (from 0) depends on most, with its relative slope."""
        order = np.argsort(-np.abs(self.relative[mode]), kind="stable")[:count]
        return [(self.parameters[k], float(self.relative[mode, k])) for k in order if self.relative[mode, k] != 0]


def sensitivities(
    model: Compiled, parameters: Mapping[str, Any] | None = None, point: OperatingPoint | None = None, count: int | None = None
) -> SensitivityResult:
    """Sensitivities of all natural frequencies, or of the ``count`` lowest, to every named parameter, at the operating point.

    Raises what ``operating_point`` raises.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=3.0), Inertia("load", inertia=1.0), Shaft("shaft", "engine", "load", stiffness=3e5)])
    >>> result = sensitivities(lower(assemble(line)))
    >>> result.largest(1)  # omega^2 = k (1/J_a + 1/J_b)
    [('shaft.stiffness', 0.5), ('load.inertia', -0.375), ('engine.inertia', -0.125)]
    """
    point = point or operating_point(model, parameters)
    modes = natural_modes(point.mass, point.stiffness, point.coordinates)
    keep = len(modes.squares) if count is None else count
    clusters = repeated_modes(modes)
    names, entries, whole = _entries(model)
    directions, differenced = _directions(model, point.p, entries, parameters or {})
    means = _mean_slopes(model, point, directions)
    angles: Array | None = None
    squares = np.zeros((len(modes.squares), len(entries)))
    cluster_of = {mode: cluster for cluster in clusters for mode in cluster}
    for mode in range(modes.free, keep):
        cluster = cluster_of.get(mode, (mode,))
        if mode != cluster[0]:
            continue
        block = np.zeros((len(entries), len(cluster), len(cluster)))
        for i, first in enumerate(cluster):
            for j, second in enumerate(cluster[: i + 1]):
                by_p, by_mean, by_angle = _gradient(
                    model, point, modes.squares[mode], modes.shapes[:, first], modes.shapes[:, second]
                )
                block[:, i, j] = by_p @ directions + by_mean @ means
                if np.any(by_angle):
                    angles = _angle_slopes(model, parameters, point, names) if angles is None else angles
                    moved = by_angle @ angles
                    block[:, i, j] += moved
                    differenced |= moved != 0
                block[:, j, i] = block[:, i, j]
        squares[list(cluster)] = np.linalg.eigvalsh(block).T
    omega = np.sqrt(np.abs(modes.squares))
    slopes = np.where(omega[:, None] > 0, squares / np.where(omega > 0, 4 * np.pi * omega, 1.0)[:, None], 0.0)
    units = {name: each.unit for name, each in model.parameters.parameters.items()}
    return SensitivityResult(
        model=model.name,
        frequencies=modes.frequencies[:keep],
        rigid=modes.free,
        parameters=names,
        units=tuple(units[name.partition("[")[0]] for name in names),
        values=point.p[entries],
        slopes=slopes[:keep],
        methods=tuple("differences" if each else "derivative" for each in differenced),
        repeated=tuple(cluster for cluster in clusters if cluster[-1] < keep),
        whole=whole,
    )


def _entries(model: Compiled) -> tuple[tuple[str, ...], list[int], tuple[str, ...]]:
    """Labels and entries in p of all parameters that may be set, and those that are whole numbers."""
    labels = model.parameters.labels()
    names, entries, whole = [], [], []
    for name, parameter in model.parameters.parameters.items():
        where = model.parameters.slices[name]
        if parameter.integer:
            whole.append(name)
            continue
        names += labels[where]
        entries += range(where.start, where.stop)
    return tuple(names), entries, tuple(whole)


@functools.lru_cache(maxsize=16)
def _gradient_function(model: Compiled) -> ca.Function:
    """(angle, speed, own, p, w, square, left, right) -> gradient of left^T (K - square M) right by p, w and angle."""
    given = model.mean_model["torque"].sx_in()
    angle, p, mean = given[0], given[3], given[4]
    n = angle.numel()
    square, left, right = ca.SX.sym("square"), ca.SX.sym("left", n), ca.SX.sym("right", n)
    torque = model.mean_model["torque"](*given)[0]
    mass = model.mean_model["linear"](*given)[0]
    value = -ca.dot(left, ca.jtimes(torque, angle, right)) - square * ca.dot(left, ca.mtimes(mass, right))
    slopes = [ca.densify(ca.jacobian(value, each)) for each in (p, mean, angle)]
    return ca.Function("gradient", [*given, square, left, right], slopes)


def _gradient(model: Compiled, point: OperatingPoint, square: float, left: Array, right: Array) -> list[Array]:
    zeros, own = np.zeros(len(point.angle)), own_start(model)
    found = _gradient_function(model)(point.angle, zeros, own, point.p, point.mean, square, left, right)
    return [np.asarray(each).ravel() for each in found]


def _directions(model: Compiled, p: Array, entries: list[int], given: Mapping[str, Any]) -> tuple[Array, NDArray[np.bool_]]:
    """How the whole of p moves with each parameter (entries of p, parameters), and for which differences were needed."""
    table = model.parameters
    completed = np.asarray(_completion(model)(p).full())
    moves = completed[:, entries]
    for name in given:
        moves[table.slices[name.partition("[")[0]]] = 0.0  # a value given by hand follows no expression
    moves[entries, range(len(entries))] = 1.0
    differenced = np.zeros(len(entries), dtype=bool)
    limited = _limited(model)
    for name, derived in table.derived.items():
        sources = {key: source for key, source in derived.arguments.items() if isinstance(source, str)}
        read = np.zeros(len(p), dtype=bool)
        for source in sources.values():
            read[table.slices[source]] = True

        def value(at: Array, derived: Any = derived) -> Array:
            arguments = {}
            for key, source in derived.arguments.items():
                part = at[table.slices[source]] if isinstance(source, str) else source
                series = isinstance(source, str) and table.parameters[source].series
                arguments[key] = part if series or not isinstance(source, str) else float(part[0])
            return np.asarray(derived.function(**arguments), dtype=float).ravel()

        for column, entry in enumerate(entries):
            if np.any(moves[read, column]):
                moves[table.slices[name], column] = _difference(
                    lambda h, c=column: value(p + h * moves[:, c]), float(p[entry]), bool(limited[entry])
                )
                differenced[column] = True
    return moves, differenced


def _limited(model: Compiled) -> NDArray[np.bool_]:
    """Entries of p that may not be negative."""
    found = np.zeros(model.parameters.size, dtype=bool)
    for name, parameter in model.parameters.parameters.items():
        found[model.parameters.slices[name]] = parameter.nonnegative
    return found


@functools.lru_cache(maxsize=16)
def _completion(model: Compiled) -> ca.Function:
    """p -> derivative of p, completed by its expressions, by p."""
    completed = model.mean_model["completed"]
    p = completed.sx_in()[0]
    return ca.Function("completion", [p], [ca.jacobian(completed(p), p)])


def _difference(function: Callable[[float], Array], value: float, one_sided: bool) -> Array:
    """Slope at 0 by central differences of two steps, extrapolated; upward only from a zero that may not become negative."""
    h = STEP * abs(value) or STEP
    if one_sided and not value:
        h, still = SMALL, function(0.0)
        return np.asarray((4 * function(h / 2) - function(h) - 3 * still) / h)
    coarse, fine = ((function(step) - function(-step)) / (2 * step) for step in (h, h / 2))
    return np.asarray((4 * fine - coarse) / 3)


def _mean_slopes(model: Compiled, point: OperatingPoint, directions: Array) -> Array:
    """How the means of what varies with time move with each parameter (quantities, parameters)."""
    function = model.mean_model["means"]
    p = point.p
    flags = np.asarray(function(p)[1]).ravel()
    slopes = _means_by_p(model)(p).full() @ directions
    sampled = np.flatnonzero(flags == 0)
    if not sampled.size or not set(sampled.tolist()) & _felt(model):
        return np.asarray(slopes)
    turns = np.tile(np.arange(SAMPLES) * (2 * np.pi / SAMPLES), (len(model.equations.clocks), 1))
    along = mapped(_timed_along(model), SAMPLES)
    for column in range(directions.shape[1]):
        values = np.asarray(along(turns, np.zeros((1, SAMPLES)), p, directions[:, column]))
        slopes[sampled, column] = values.mean(axis=1)[sampled]
    return np.asarray(slopes)


@functools.lru_cache(maxsize=16)
def _felt(model: Compiled) -> frozenset[int]:
    """Quantities that mass or stiffness depends on."""
    linear = model.mean_model["linear"]
    return frozenset(column for out in (0, 2) for column in linear.jac_sparsity(out, 4).get_triplet()[1])


@functools.lru_cache(maxsize=16)
def _means_by_p(model: Compiled) -> ca.Function:
    means = model.mean_model["means"]
    p = means.sx_in()[0]
    return ca.Function("means_by_p", [p], [ca.jacobian(means(p)[0], p)])


@functools.lru_cache(maxsize=16)
def _timed_along(model: Compiled) -> ca.Function:
    """(clock angles, t, p, direction) -> slope of what varies with time, as p moves in a direction."""
    timed = model.mean_model["timed"]
    clocks, t, p = timed.sx_in()
    direction = ca.SX.sym("direction", p.numel())
    return ca.Function("timed_along", [clocks, t, p, direction], [ca.densify(ca.jtimes(timed(clocks, t, p), p, direction))])


def _angle_slopes(model: Compiled, values: Mapping[str, Any] | None, point: OperatingPoint, names: tuple[str, ...]) -> Array:
    """How the static angles move with each parameter, by differences (groups, parameters)."""
    table, limited = model.parameters, _limited(model)
    # A mean torque changed by itself no longer balances; the small drift is let pass.
    model = replace(model, equations=replace(model.equations, drifts=True))
    columns = []
    for name in names:
        where = table.slices[name.partition("[")[0]]
        row = int(name.partition("[")[2].rstrip("]") or 1) - 1
        entry = where.start + row
        at = float(point.p[entry])
        moved = functools.partial(_static_angles, model, values or {}, name, at)
        columns.append(_difference(moved, at, bool(limited[entry])))
    return np.array(columns).T


def _static_angles(model: Compiled, values: Mapping[str, Any], name: str, at: float, step: float) -> Array:
    return operating_point(model, {**values, name: at + step}).angle
