"""Which element holds the energy of a mode: shares of kinetic and potential energy.

Below ``modal``. Element e exerts the torques dt_e = -K_e q on its flanges and adds the terms M_e to the mass matrix, so its
shares of a mode q are q^T M_e q / q^T M q and q^T K_e q / q^T K q; over all elements they sum to 1. Nothing is asked of an
element but its torques, so every element has its share, whatever it is.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FlangeMap:
    """Where torques and mass terms act: element and node of each flange, element and nodes of each mass term."""

    flange_element: NDArray[np.intp]
    flange_node: NDArray[np.intp]
    mass_element: NDArray[np.intp]
    mass_nodes: NDArray[np.intp]

    @classmethod
    @functools.lru_cache(maxsize=16)
    def of(cls, model: Compiled) -> FlangeMap:
        """The map of a driveline."""
        eq = model.equations
        flanges, terms = [], []
        for index, instance in enumerate(eq.instances):
            template = eq.templates[instance.template]
            flanges += [(index, instance.nodes[flange]) for flange in template.flanges]
            terms += [(index, instance.nodes[f], instance.nodes[g]) for f, g in template.mass]
        by_flange = np.array(flanges, dtype=np.intp).reshape(-1, 2)
        by_term = np.array(terms, dtype=np.intp).reshape(-1, 3)
        return cls(by_flange[:, 0], by_flange[:, 1], by_term[:, 0], by_term[:, 1:])


@functools.lru_cache(maxsize=16)
def element_stiffness(model: Compiled) -> ca.Function:
    """(angle, speed, own, p, w) -> derivative of every flange torque by the angles, mass terms."""
    elements = model.mean_model.elements
    given = elements.sx_in()
    torque, mass = elements(*given)
    return ca.Function("element_stiffness", given, [ca.jacobian(torque, given[0]), mass])


def energy_shares(model: Compiled, p: Array, mean: Array, angle: Array, own: Array, shapes: Any) -> tuple[Array, Array]:
    """Shares of kinetic and of potential energy, each (elements, modes), of ``shapes`` (groups, modes) about static angles.

    Each column sums to 1; the potential shares of a mode without potential energy are zero. Of complex shapes, whose parts move
    out of phase, the mean energy over a period counts: that of the real part and that of the imaginary one together.
    """
    if np.iscomplexobj(shapes):
        both = (_energies(model, p, mean, angle, own, part) for part in (shapes.real, shapes.imag))
        kinetic, potential = (first + second for first, second in zip(*both, strict=True))
    else:
        kinetic, potential = _energies(model, p, mean, angle, own, shapes)
    return _normalized(kinetic), _normalized(potential)


def _energies(model: Compiled, p: Array, mean: Array, angle: Array, own: Array, shapes: Array) -> tuple[Array, Array]:
    """Twice the kinetic and the potential energy, each (elements, modes)."""
    where = FlangeMap.of(model)
    at_node = model.mean_model.nodes_at(p) @ shapes
    stiffness, mass = element_stiffness(model)(angle, np.zeros(len(angle)), own, p, mean)
    count = len(model.equations.instances)
    potential = _by_element(where.flange_element, -at_node[where.flange_node] * (stiffness @ shapes).full(), count)
    first, second = (at_node[nodes] for nodes in where.mass_nodes.T)
    kinetic = _by_element(where.mass_element, np.asarray(mass).reshape(-1, 1) * first * second, count)
    return kinetic, potential


def _by_element(element: NDArray[np.intp], values: Array, count: int) -> Array:
    total = np.zeros((count, values.shape[1]))
    np.add.at(total, element, values)
    return total


def _normalized(values: Array) -> Array:
    """Columns divided by their sums; a sum that is nothing but rounding leaves zeros."""
    total, size = values.sum(axis=0), np.abs(values).sum(axis=0)
    real = np.abs(total) > 1e-12 * size
    return np.asarray(np.where(real, values / np.where(real, total, 1.0), 0.0))
