"""Question: how do the sources add up in a mode, order by order?

A source that puts the torque T e^(i order phi) on a node works on a mode in proportion to T times the shape there. The vectors
of all sources, turned by their phases (firing order), add up to the phase-vector sum: large for the major orders, nearly zero
where the firings cancel. A misfire is one vector short.
Sources: J. P. Den Hartog, Mechanical Vibrations (1956), sec. 5.4; W. Ker Wilson, Practical Solution of Torsional Vibration
Problems, vol. 1 (1956), ch. 7.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.energy_shares import FlangeMap
from modelgen.analysis.linear.excitation import excitation
from modelgen.analysis.linear.modal import modal
from modelgen.errors import CaseError, nearest
from modelgen.solvers.bound_model import bind
from modelgen.solvers.coupled_modes import coupling_words

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class PhaseVectorResult:
    """Vectors [N*m] of every source on every elastic mode, for shapes whose largest physical entry is 1.

    ``orders`` per turn of the reference shaft; ``sources``: elements that excite; ``modes``: numbers from 0 as in ``modal``,
    with ``frequencies`` [Hz]; ``vectors`` (modes, sources, orders); ``critical_speeds`` (modes, orders) [rad/s] where order and
    mode meet.
    """

    model: str
    orders: tuple[Fraction, ...]
    sources: tuple[str, ...]
    modes: tuple[int, ...]
    frequencies: Array
    vectors: Complex
    critical_speeds: Array

    @property
    def sums(self) -> Complex:
        """Phase-vector sums (modes, orders) [N*m]."""
        return np.asarray(self.vectors.sum(axis=1))

    @property
    def addition(self) -> Array:
        """Length of each sum per sum of the lengths: 1 where all sources pull together, 0 where they cancel."""
        lengths = np.abs(self.vectors).sum(axis=1)
        return np.asarray(np.where(lengths > 0, np.abs(self.sums) / np.where(lengths > 0, lengths, 1.0), 0.0))

    def of(self, source: str) -> Complex:
        """Vectors (modes, orders) of one source. Raises CaseError with the nearest name."""
        if source not in self.sources:
            raise CaseError(f"phase vectors of {self.model!r}", f"no source {source!r}", nearest(source, self.sources))
        return self.vectors[:, self.sources.index(source)]


def phase_vectors(
    model: Any, parameters: Mapping[str, Any] | None = None, highest_order: float | None = None
) -> PhaseVectorResult:
    """Phase vectors at the operating point for the model's parameters with some changed by name.

    Raises CaseError where stiffness or damping are not symmetric: a mode answers to torques by another shape than its own.

    Two cylinders that fire half a turn apart cancel in the first order and pull together in the second:

    >>> from modelgen import Driveline, HarmonicTorque, Inertia, Shaft, assemble, lower
    >>> row = {"cosine": [100.0, 100.0], "base": "turn"}
    >>> line = Driveline("twin", speed="1200 rpm", reference="a", bases={"turn": 1}, elements=[
    ...     Inertia("a", inertia=1.0), Inertia("b", inertia=1.0), Inertia("load", inertia=2.0),
    ...     Shaft("crank", "a", "b", stiffness=1e9), Shaft("shaft", "b", "load", stiffness=1e5),
    ...     HarmonicTorque("first", "a", **row), HarmonicTorque("second", "b", phase="180 deg", **row)])
    >>> phase_vectors(lower(assemble(line))).addition[0].round(3).tolist()
    [0.0, 1.0]
    """
    bound = bind(model, parameters=parameters, question="phase_vectors")
    model, point, modes = bound.model, bound.operating_point, modal(bound)
    coupling = coupling_words(point.stiffness, point.damping)
    if coupling:
        what = f"rest on shapes that a torque works on, which are not those of the motion here: {coupling.partition(':')[0]}"
        raise CaseError(f"phase vectors of {model.name!r}", what, "ask forced, which solves with the full matrices")
    shaking = excitation(model, point, highest_order=highest_order)
    torque, where = shaking.by_flange, FlangeMap.of(model)
    elastic = range(modes.rigid, len(modes.frequencies))
    worked = modes.shapes[where.flange_node][:, list(elastic), None] * torque[:, None, :]
    vectors = np.zeros((len(model.equations.instances), *worked.shape[1:]), dtype=complex)
    np.add.at(vectors, where.flange_element, worked)
    size = np.abs(torque).max(initial=0.0)
    active = sorted({int(where.flange_element[k]) for k in np.flatnonzero(np.any(np.abs(torque) > 1e-12 * size, axis=1))})
    frequencies = modes.frequencies[list(elastic)]
    orders = np.array([float(order) for order in shaking.orders])
    return PhaseVectorResult(
        model=model.name,
        orders=shaking.orders,
        sources=tuple(model.equations.instances[k].name for k in active),
        modes=tuple(elastic),
        frequencies=frequencies,
        vectors=vectors[active].swapaxes(0, 1),
        critical_speeds=2 * np.pi * frequencies[:, None] / orders,
    )
