"""Question: how does each natural frequency change with each parameter?

d(omega^2)/dp = q^T (dK/dp - omega^2 dM/dp) q for shapes with q^T M q = 1. K and M are differentiated through the whole parameter
vector: through shared parameters, their expressions, means over time, the quantities a law works with. What no derivative exists
for is differenced, and the result says so: parameters derived by a NumPy function (mesh stiffness from the teeth), and the
static angles of a driveline whose stiffness depends on them. Modes that share a frequency: the slopes of the frequencies into
which the parameter splits them. Where matrices are not symmetric, left and right eigenvectors count (``coupled_slopes``).
Sources: R. L. Fox, M. P. Kapoor, AIAA J. 6 (1968) 2426; for repeated modes I. U. Ojalvo, AIAA J. 26 (1988) 361.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.coupled_slopes import coupled_gradient, frequency_slopes
from modelgen.analysis.linear.linear_remarks import mode_remarks
from modelgen.analysis.linear.modal import repeated_modes
from modelgen.analysis.linear.mode_numbers import mode_name
from modelgen.analysis.linear.natural_modes import Modes, natural_modes
from modelgen.analysis.linear.parameter_directions import angle_slopes, mean_slopes, named_entries, parameter_directions
from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.bound_model import bind
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SensitivityResult:
    """Slopes of the natural frequencies.

    ``frequencies`` [Hz] of all modes, the first ``rigid`` of them zero, whatever the parameters; ``parameters`` with ``units``
    and ``values`` (a row of a series is ``name[3]``); ``slopes`` (modes, parameters) [Hz per unit]; ``relative``: the same as
    relative change of the frequency per relative change of the parameter. ``methods`` by parameter: "derivative" or
    "differences". ``repeated``: modes that share a frequency. ``whole``: parameters that are whole numbers, which have no
    slope. ``remarks``: what is to be known of the matrices and laws.
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
    remarks: tuple[str, ...] = ()

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

    def name(self, mode: int) -> str:
        """The mode in a row (from 0) by name: "mode 1" is the first that vibrates."""
        return mode_name(mode, self.rigid)

    def largest(self, mode: int, count: int = 5) -> list[tuple[str, float]]:
        """The parameters that a mode (from 0) depends on most, with its relative slope."""
        order = np.argsort(-np.abs(self.relative[mode]), kind="stable")[:count]
        return [(self.parameters[k], float(self.relative[mode, k])) for k in order if self.relative[mode, k] != 0]


def sensitivities(
    model: Any, parameters: Mapping[str, Any] | None = None, point: OperatingPoint | None = None, count: int | None = None
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
    bound = bind(model, parameters=parameters, question="sensitivities")
    model, point = bound.model, point or bound.operating_point
    modes = natural_modes(point.mass, point.stiffness, point.coordinates, point.damping)
    coupled, keep = modes.coupled, len(modes.squares) if count is None else count
    clusters = repeated_modes(modes)
    names, entries, whole = named_entries(model)
    directions, differenced = parameter_directions(model, point.p, entries, model.parameters.given)
    means = mean_slopes(model, point, directions)
    angles: Array | None = None
    squares, of_coupled = np.zeros((2, len(modes.squares), len(entries)))
    cluster_of = {mode: cluster for cluster in clusters for mode in cluster}
    for mode in range(modes.free, keep):
        cluster = cluster_of.get(mode, (mode,))
        if mode != cluster[0]:
            continue
        block = np.zeros((len(entries), len(cluster), len(cluster)), dtype=complex if coupled else float)
        for i, first in enumerate(cluster):
            for j, second in enumerate(cluster if coupled else cluster[: i + 1]):
                by_p, by_mean, by_angle = _between(model, point, modes, mode, first, second)
                block[:, i, j] = by_p @ directions + by_mean @ means
                if np.any(by_angle):
                    angles = angle_slopes(model, parameters, point, names) if angles is None else angles
                    moved = by_angle @ angles
                    block[:, i, j] += moved
                    differenced |= moved != 0
                if not coupled:
                    block[:, j, i] = block[:, i, j]
        if coupled:
            of_coupled[list(cluster)] = frequency_slopes(complex(coupled.values[mode]), block)
        else:
            squares[list(cluster)] = np.linalg.eigvalsh(block).T
    slopes = of_coupled if coupled else _of_frequencies(squares, modes.squares)
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
        remarks=mode_remarks(model, point),
    )


def _of_frequencies(slopes: Array, squares: Array) -> Array:
    """Slopes of the frequencies [Hz] from those of their squares [rad^2/s^2]; zero for a rigid rotation."""
    omega = np.sqrt(np.abs(squares))[:, None]
    return np.where(omega > 0, slopes / np.where(omega > 0, 4 * np.pi * omega, 1.0), 0.0)


@functools.lru_cache(maxsize=16)
def _gradient_function(model: Compiled) -> ca.Function:
    """(angle, speed, own, p, w, square, left, right) -> gradient of left^T (K - square M) right by p, w and angle."""
    given = model.mean_model.torque.sx_in()
    angle, p, mean = given[0], given[3], given[4]
    n = angle.numel()
    square, left, right = ca.SX.sym("square"), ca.SX.sym("left", n), ca.SX.sym("right", n)
    torque = model.mean_model.torque(*given)[0]
    mass = model.mean_model.linear(*given)[0]
    value = -ca.dot(left, ca.jtimes(torque, angle, right)) - square * ca.dot(left, ca.mtimes(mass, right))
    slopes = [ca.densify(ca.jacobian(value, each)) for each in (p, mean, angle)]
    return ca.Function("gradient", [*given, square, left, right], slopes)


def _between(model: Compiled, point: OperatingPoint, modes: Modes, mode: int, first: int, second: int) -> list[Any]:
    """The gradient of the square, or of the eigenvalue, of a mode between the vectors of two modes that share it."""
    if modes.coupled is not None:
        return coupled_gradient(model, point, modes.coupled, mode, first, second)
    return _gradient(model, point, modes.squares[mode], modes.shapes[:, first], modes.shapes[:, second])


def _gradient(model: Compiled, point: OperatingPoint, square: float, left: Array, right: Array) -> list[Array]:
    zeros, own = np.zeros(len(point.angle)), model.mean_model.own_start
    found = _gradient_function(model)(point.angle, zeros, own, point.p, point.mean, square, left, right)
    return [np.asarray(each).ravel() for each in found]
