"""How eigenvalues of full, unsymmetric matrices change with parameters: by left and right eigenvectors.

Below ``sensitivity``. With (lambda^2 M + lambda G + K) r = 0 and l^T (2 lambda M + G) r = 1,
d lambda = -l^T (lambda^2 dM + lambda dG + dK) r. Source: S. Adhikari, Structural Dynamic Analysis with Generalized Damping Models
(2014), ch. 1 (derivatives of eigenvalues of nonconservative systems).
"""

from __future__ import annotations

import functools
from itertools import product

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled
from modelgen.solvers.coupled_modes import CoupledModes, is_skew
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@functools.lru_cache(maxsize=16)
def _terms(model: Compiled) -> ca.Function:
    """(angle, speed, own, p, w, left, right) -> gradients of left^T (M; G; K) right by p, w and angle, three rows each."""
    given = model.mean_model.torque.sx_in()
    angle, speed, p, mean = given[0], given[1], given[3], given[4]
    left, right = (ca.SX.sym(name, angle.numel()) for name in ("left", "right"))
    torque, mass = model.mean_model.torque(*given)[0], model.mean_model.linear(*given)[0]
    skew = (ca.dot(right, ca.jtimes(torque, speed, left)) - ca.dot(left, ca.jtimes(torque, speed, right))) / 2
    terms = ca.vertcat(ca.dot(left, ca.mtimes(mass, right)), skew, -ca.dot(left, ca.jtimes(torque, angle, right)))
    slopes = [ca.densify(ca.jacobian(terms, each)) for each in (p, mean, angle)]
    return ca.Function("coupled_terms", [*given, left, right], slopes)


def coupled_gradient(
    model: Compiled, point: OperatingPoint, modes: CoupledModes, mode: int, first: int, second: int
) -> list[Complex]:
    """Gradient of the eigenvalue of a mode by p, means and angles, between the vectors of two modes that share it."""
    value = modes.values[mode]
    weights = np.array([value**2, value if is_skew(point.damping) else 0.0, 1.0])
    zeros, own = np.zeros(len(point.angle)), model.mean_model.own_start
    total: list[Complex] = []
    left, right = modes.left[:, first], modes.right[:, second]
    for (a, l_part), (b, r_part) in product(((1, left.real), (1j, left.imag)), ((1, right.real), (1j, right.imag))):
        found = _terms(model)(point.angle, zeros, own, point.p, point.mean, l_part, r_part)
        parts = [-a * b * (weights @ each.full()) for each in found]
        total = [old + new for old, new in zip(total, parts, strict=True)] if total else parts
    return total


def frequency_slopes(value: complex, block: Complex) -> Array:
    """Slopes [Hz per unit] (modes, parameters) of the frequencies of modes that share an eigenvalue.

    ``block`` (parameters, modes, modes): the gradients between them. A mode without oscillation counts as minus its growth.
    """
    slopes = np.linalg.eigvals(block)
    found = slopes.imag if value.imag > 0 else -slopes.real
    return np.asarray(np.sort(found, axis=1).T / (2 * np.pi))
