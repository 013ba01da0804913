"""Question: at which frequencies, with which damping and in which shapes does the driveline vibrate?

About an operating point: M q'' + C q' + K q = 0 over group angles, with mean mesh stiffness on the loaded flank.
Sources: M. I. Friswell et al., Dynamics of Rotating Machines (2010), ch. 9; F. Tisseur, K. Meerbergen, SIAM Rev. 43 (2001) 235,
for the state-space form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled
from modelgen.solvers.operating_point import OperatingPoint, operating_point

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModalResult:
    """Modes of a driveline, rigid rotations first.

    ``frequencies`` [Hz] undamped, sorted; ``shapes`` (groups, modes) in physical angles, largest entry 1; ``referred`` the same
    divided by each group's speed ratio; ``damped_frequencies`` [Hz], ``damping_ratios`` and ``decay_rates`` [1/s] of the damped
    vibrating pairs, sorted by frequency; ``names`` of the groups, ``ratio`` their speed per speed of the reference shaft;
    ``rigid``: how many modes are rigid rotations.
    """

    model: str
    names: tuple[str, ...]
    ratio: Array
    frequencies: Array
    shapes: Array
    referred: Array
    damped_frequencies: Array
    damping_ratios: Array
    decay_rates: Array
    rigid: int


def modal(model: Compiled, parameters: Mapping[str, Any] | None = None, point: OperatingPoint | None = None) -> ModalResult:
    """Modes about the operating point for the model's parameters with some changed by name.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=211.4), Inertia("load", inertia=8.3), Shaft("shaft", "engine", "load", stiffness=9.775e6)])
    >>> modal(lower(assemble(line))).frequencies.round(4).tolist()  # openTorsion's two-disk test: 176.1 Hz
    [0.0, 176.0767]
    """
    point = point or operating_point(model, parameters)
    factor = np.linalg.cholesky(point.mass)
    symmetric = np.linalg.solve(factor, np.linalg.solve(factor, point.stiffness).T)
    _, vectors = np.linalg.eigh((symmetric + symmetric.T) / 2)
    shapes = np.linalg.solve(factor.T, vectors)
    shapes = shapes / shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]
    damped, ratios, decay = damped_pairs(point)
    ratio = point.coordinates.ratio
    return ModalResult(
        model=model.name,
        names=model.equations.groups,
        ratio=ratio,
        frequencies=point.frequencies(),
        shapes=shapes,
        referred=shapes / ratio[:, None],
        damped_frequencies=damped,
        damping_ratios=ratios,
        decay_rates=decay,
        rigid=len(point.coordinates.roots),
    )


def damped_pairs(point: OperatingPoint) -> tuple[Array, Array, Array]:
    """Damped frequency [Hz], damping ratio and decay rate [1/s] of every vibrating mode, overdamped ones as frequency 0.

    In the chosen coordinates without the rigid angles, so that their zero eigenvalues do not come in.
    """
    c = point.coordinates
    n, vibrating = len(c.roots) + len(c.forms), [*c.forms]
    back = c.to_states
    damping = back @ np.linalg.solve(point.mass, point.damping @ c.to_angles)
    stiffness = back @ np.linalg.solve(point.mass, point.stiffness @ c.to_angles)
    # States: relative angles, then all rates; a rigid rate stays, because drag may act on it.
    rows = len(vibrating)
    matrix = np.zeros((rows + n, rows + n))
    matrix[:rows, rows:] = np.eye(n)[vibrating]
    matrix[rows:, :rows] = -stiffness[:, vibrating]
    matrix[rows:, rows:] = -damping
    values = np.linalg.eigvals(matrix)
    upper = values[values.imag > 1e-9 * np.abs(values).max(initial=0.0)]
    upper = upper[np.argsort(upper.imag)]
    size = np.abs(upper)
    return upper.imag / (2 * np.pi), -upper.real / np.where(size > 0, size, 1.0), -upper.real
