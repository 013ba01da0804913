"""How the inside of a driveline moves with each of its named parameters: the parameter vector, means over time, static angles.

Below ``sensitivity``. Expressions and means are differentiated by CasADi. Parameters derived by a NumPy function, and static
angles, are differenced (two steps, extrapolated to the fourth order).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled
from modelgen.solvers.bound_model import operating_point
from modelgen.solvers.linear_model import mapped
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
SAMPLES = 256  # of a turn, for derivatives of means that no element states
STEP = 1e-3  # of a parameter, for differences
SMALL = 1e-5  # step from zero


def named_entries(model: Compiled) -> tuple[tuple[str, ...], list[int], tuple[str, ...]]:
    """Labels and entries in p of all parameters that may be set, and those that are whole numbers."""
    labels = model.parameters.labels()
    names: list[str] = []
    entries: list[int] = []
    whole: list[str] = []
    for name, parameter in model.parameters.parameters.items():
        where = model.parameters.slices[name]
        if parameter.integer:
            whole.append(name)
            continue
        names += labels[where]
        entries += range(where.start, where.stop)
    return tuple(names), entries, tuple(whole)


def parameter_directions(
    model: Compiled, p: Array, entries: list[int], given: Mapping[str, Any]
) -> tuple[Array, NDArray[np.bool_]]:
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
        read = np.zeros(len(p), dtype=bool)
        for source in derived.arguments.values():
            if isinstance(source, str):
                read[table.slices[source]] = True
        for column, entry in enumerate(entries):
            if np.any(moves[read, column]):
                along = functools.partial(_derived, model, name, p, moves[:, column].copy())
                moves[table.slices[name], column] = _difference(along, float(p[entry]), bool(limited[entry]))
                differenced[column] = True
    return moves, differenced


def _derived(model: Compiled, name: str, p: Array, direction: Array, step: float) -> Array:
    """A derived parameter where p has moved by a step in a direction."""
    table, at = model.parameters, p + step * direction
    arguments: dict[str, Any] = {}
    for key, source in table.derived[name].arguments.items():
        if not isinstance(source, str):
            arguments[key] = source
        else:
            part = at[table.slices[source]]
            arguments[key] = part if table.parameters[source].series else float(part[0])
    return np.asarray(table.derived[name].function(**arguments), dtype=float).ravel()


def _limited(model: Compiled) -> NDArray[np.bool_]:
    """Entries of p that may not be negative."""
    found = np.zeros(model.parameters.size, dtype=bool)
    for name, parameter in model.parameters.parameters.items():
        found[model.parameters.slices[name]] = parameter.nonnegative
    return found


@functools.lru_cache(maxsize=16)
def _completion(model: Compiled) -> ca.Function:
    """p -> derivative of p, completed by its expressions, by p."""
    completed = model.mean_model.completed
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


def mean_slopes(model: Compiled, point: OperatingPoint, directions: Array) -> Array:
    """How the means of what varies with time move with each parameter (quantities, parameters)."""
    function = model.mean_model.means
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
    linear = model.mean_model.linear
    return frozenset(column for out in (0, 2) for column in linear.jac_sparsity(out, 4).get_triplet()[1])


@functools.lru_cache(maxsize=16)
def _means_by_p(model: Compiled) -> ca.Function:
    means = model.mean_model.means
    p = means.sx_in()[0]
    return ca.Function("means_by_p", [p], [ca.jacobian(means(p)[0], p)])


@functools.lru_cache(maxsize=16)
def _timed_along(model: Compiled) -> ca.Function:
    """(clock angles, t, p, direction) -> slope of what varies with time, as p moves in a direction."""
    timed = model.mean_model.timed
    clocks, t, p = timed.sx_in()
    direction = ca.SX.sym("direction", p.numel())
    return ca.Function("timed_along", [clocks, t, p, direction], [ca.densify(ca.jtimes(timed(clocks, t, p), p, direction))])


def angle_slopes(model: Compiled, values: Mapping[str, Any] | None, point: OperatingPoint, names: tuple[str, ...]) -> Array:
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
