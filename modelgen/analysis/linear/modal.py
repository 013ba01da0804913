"""Question: at which frequencies, with which damping and in which shapes does the driveline vibrate?

About an operating point: M q'' + C q' + K q = 0 over group angles, with mean mesh stiffness on the loaded flank. All modes come
from dense matrices (``natural_modes``), some lowest ones of a large driveline from sparse ones (``lowest_modes``).
Sources: M. I. Friswell et al., Dynamics of Rotating Machines (2010), ch. 9; F. Tisseur, K. Meerbergen, SIAM Rev. 43 (2001) 235,
for the state-space form.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.energy_shares import energy_shares
from modelgen.analysis.linear.linear_remarks import mode_remarks
from modelgen.analysis.linear.lowest_modes import lowest_modes
from modelgen.analysis.linear.mode_numbers import mode_cell, mode_name, mode_number
from modelgen.analysis.linear.natural_modes import DampedModes, Modes, damped_modes, natural_modes
from modelgen.analysis.linear.node_counts import node_counts
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.lowering.mean_turn import averaged_words, turned_elements
from modelgen.solvers.bound_model import bind
from modelgen.solvers.coupled_modes import is_skew_sparse
from modelgen.solvers.linear_model import linearize
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
Remarks = tuple[str, ...]
DENSE = 150  # degrees of freedom up to which all modes cost less than a few
GROWS = 1e-9  # of the size of an eigenvalue: growth below it is rounding
SAME = 1e-9  # relative distance of natural frequencies that count as repeated


@dataclass(frozen=True, eq=False)
class ModalResult:
    """Modes of a driveline, rigid rotations first.

    ``names`` of the nodes, ``ratio`` (nodes,) their speed per speed of the reference shaft. ``frequencies`` [Hz] undamped,
    sorted, exactly zero for the first ``rigid`` modes, negative for an unstable one; ``shapes`` (nodes, modes) in physical
    angles, largest entry 1; ``referred`` the same divided by ``ratio``; ``modal_inertia`` [kg*m^2] of the shapes as given.
    ``repeated``: numbers (from 0) of modes that share a frequency; their shapes are one choice of many. ``elements`` with
    ``kinetic`` and ``potential`` (elements, modes): shares of the energy, each summing to 1 (rigid modes have no potential
    energy: zeros). ``damped_frequencies`` [Hz], ``damping_ratios``, ``decay_rates`` [1/s] and complex ``damped_shapes`` (nodes,
    pairs) of the damped modes that oscillate, sorted by frequency; ``pair`` (modes,): which of them is the mode's own, -1 for
    none, ``rates`` (modes, 2) [1/s]: the two rates of an overdamped mode, the slower first, else nan; ``damped`` tells a mode's
    own. ``nodes`` (modes,): places that stand still. ``number`` and ``name``: how a mode is counted. ``complete``: all modes are
    here. If not, the damped ones are those of the damping projected on the modes given, which is exact for proportional damping.
    ``released``: elements that hold a speed in some of their modes, such as brakes that stick; here they hold nothing.
    ``averaged``: elements whose laws depend on the angle of a shaft, averaged over its turns. ``growth`` (modes,) [1/s]: with
    which a mode grows without any damping, 0 for one that does not. ``remarks``: what is to be known of the matrices, such as a
    stiffness that is not symmetric.
    """

    model: str
    names: tuple[str, ...]
    ratio: Array
    frequencies: Array
    shapes: Array
    referred: Array
    modal_inertia: Array
    rigid: int
    repeated: tuple[tuple[int, ...], ...]
    elements: tuple[str, ...]
    kinetic: Array
    potential: Array
    damped_frequencies: Array
    damping_ratios: Array
    decay_rates: Array
    damped_shapes: NDArray[np.complex128]
    pair: NDArray[np.intp]
    rates: Array
    nodes: NDArray[np.intp]
    complete: bool
    released: tuple[str, ...] = ()
    averaged: tuple[str, ...] = ()
    growth: Array = field(default_factory=lambda: np.zeros(0))
    remarks: tuple[str, ...] = ()

    def number(self, mode: int) -> int | None:
        """Number of the mode in a row (from 0): vibrating modes count from 1, a rigid one has none."""
        return mode_number(mode, self.rigid)

    def name(self, mode: int) -> str:
        """The mode in a row (from 0) by name: "mode 1" is the first that vibrates."""
        return mode_name(mode, self.rigid)

    def damped(self, mode: int) -> DampedMode | None:
        """What damping makes of the mode in a row (from 0); None for a rigid one."""
        if mode < self.rigid:
            return None
        own = int(self.pair[mode])
        if own < 0:
            slow, fast = (float(rate) for rate in self.rates[mode])
            return DampedMode(None, None, None, (slow, fast))
        frequency, ratio, decay = (v[own] for v in (self.damped_frequencies, self.damping_ratios, self.decay_rates))
        return DampedMode(float(frequency), float(ratio), float(decay))

    def __str__(self) -> str:
        kind = "all" if self.complete else "lowest"
        rows = [
            f"modes of {self.model!r}: {kind} {len(self.frequencies)}, {self.rigid} rigid; most kinetic, most potential energy in"
        ]
        for mode, frequency in enumerate(self.frequencies):
            kinetic, potential = (
                f"{self.elements[s[:, mode].argmax()]} {s[:, mode].max():.0%}" for s in (self.kinetic, self.potential)
            )
            said = f"  {mode_cell(mode, self.rigid):>5s} {frequency:12.4f} Hz  {kinetic}, "
            rows.append(said + ("none" if mode < self.rigid else f"{potential}; {self.damped(mode)}"))
        if self.released:
            rows.append(
                f"  {', '.join(self.released)}: taken as slipping; what sticks would hold its node, and these are not its modes"
            )
        if self.averaged:
            rows.append(f"  {averaged_words(self.averaged)}")
        rows += [f"  {each}" for each in self.remarks]
        return "\n".join(rows)

    __repr__ = __str__


@dataclass(frozen=True)
class DampedMode:
    """A mode with its damping: ``frequency`` [Hz], ``ratio``, ``decay`` [1/s]; or, overdamped, its two ``rates`` [1/s] alone."""

    frequency: float | None
    ratio: float | None
    decay: float | None
    rates: tuple[float, float] | None = None

    @property
    def growth(self) -> float:
        """Rate [1/s] with which an unstable mode grows, 0 for a stable one."""
        rates = self.rates or (self.decay or 0.0,)
        size = math.hypot(rates[0], 2 * math.pi * (self.frequency or 0.0), rates[-1])
        return -rates[0] if -rates[0] > GROWS * size else 0.0

    def __str__(self) -> str:
        if self.growth and self.rates is not None:
            return "unstable, grows with {:.4g} 1/s (rates of decay {:.4g} and {:.4g} 1/s)".format(self.growth, *self.rates)
        if self.growth:
            return f"unstable, grows with {self.growth:.4g} 1/s (damping ratio {self.ratio:.4g})"
        if self.rates is not None:
            return "overdamped, rates {:.4g} and {:.4g} 1/s".format(*self.rates)
        return f"damping ratio {self.ratio + 0.0:.4g}" if self.ratio is not None else ""


def modal(
    model: Any, parameters: Mapping[str, Any] | None = None, point: OperatingPoint | None = None, count: int | None = None
) -> ModalResult:
    """Modes about the operating point for the model's parameters with some changed by name; all, or the ``count`` lowest.

    Raises CaseError for a driveline without inertias or a count below 1, and what ``operating_point`` raises.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=211.4), Inertia("load", inertia=8.3), Shaft("shaft", "engine", "load", stiffness=9.775e6)])
    >>> result = modal(lower(assemble(line)))
    >>> result.frequencies.round(4).tolist()  # openTorsion's two-disk test: 176.1 Hz
    [0.0, 176.0767]
    >>> dict(zip(result.elements, result.kinetic[:, 1].round(4).tolist()))
    {'engine': 0.0378, 'load': 0.9622, 'shaft': 0.0}
    """
    bound = bind(model, parameters=parameters, question="modal")
    model = bound.model
    size = len(model.equations.groups)
    if not size:
        raise CaseError(f"driveline {model.name!r}", "has no inertias that could vibrate", "ask a driveline of elements")
    if count is not None and (isinstance(count, bool) or not isinstance(count, int) or count < 1):
        raise CaseError("modal, count", f"is {count!r}", "give a whole number from 1 up, or leave it out for all modes")
    if count is not None and point is None and size > max(DENSE, 4 * count) and _is_linear(model):
        p = model.parameters.unbalanced()
        mean, angle = model.mean_model.means_at(p), np.zeros(size)
        mass, damping, stiffness = model.mean_model.linear(angle, np.zeros(size), model.mean_model.own_start, p, mean)
        if not any(is_skew_sparse(each) for each in (damping, stiffness)):
            modes = lowest_modes(mass, stiffness, _rigid(model, p), count)
            return _result(model, p, mean, angle, modes, damped_modes(modes, damping), ())
    point = point or bound.operating_point
    modes = natural_modes(point.mass, point.stiffness, point.coordinates, point.damping).lowest(count)
    linear = linearize(model, point, complex_stiffness=False)
    pairs = damped_modes(modes, linear.damping, linear.stiffness)
    return _result(model, point.p, point.mean, point.angle, modes, pairs, mode_remarks(model, point))


def _result(
    model: Compiled, p: Array, mean: Array, angle: Array, modes: Modes, pairs: DampedModes, remarks: Remarks
) -> ModalResult:
    """Modes over the groups, told over nodes and elements."""
    nodes = model.equations.nodes
    at_nodes = model.mean_model.nodes_at(p)
    ratio = at_nodes @ model.mean_model.ratios_at(p).ratio
    shapes = at_nodes @ modes.shapes
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]
    referred = referred_shapes(shapes / largest, ratio)
    kinetic, potential = energy_shares(model, p, mean, angle, model.mean_model.own_start, modes.motions)
    potential[:, : modes.free] = 0.0
    held = np.any(kinetic != 0, axis=1) | np.any(potential != 0, axis=1)
    return ModalResult(
        model=model.name,
        names=tuple(node.name for node in nodes),
        ratio=ratio,
        frequencies=modes.frequencies,
        shapes=shapes / largest,
        referred=referred,
        modal_inertia=1 / largest**2,
        rigid=modes.free,
        repeated=repeated_modes(modes),
        elements=tuple(each.name for each, has in zip(model.equations.instances, held, strict=True) if has),
        kinetic=kinetic[held],
        potential=potential[held],
        damped_frequencies=pairs.frequencies,
        damping_ratios=pairs.damping_ratios,
        decay_rates=pairs.decay_rates,
        damped_shapes=at_nodes @ pairs.shapes,
        pair=own_pairs(pairs, len(modes.squares)),
        rates=pairs.rates,
        nodes=node_counts(model, referred, potential),
        complete=len(modes.squares) == len(model.equations.groups),
        released=tuple(each.name for each in model.equations.instances if model.equations.templates[each.template].holds),
        averaged=turned_elements(model.equations),
        growth=modes.growth,
        remarks=remarks,
    )


def own_pairs(pairs: DampedModes, count: int) -> NDArray[np.intp]:
    """Which damped mode is each undamped one's own (count,); -1 for none."""
    found = np.full(count, -1, dtype=np.intp)
    mine = np.flatnonzero(pairs.undamped >= 0)
    found[pairs.undamped[mine]] = mine
    return found


def referred_shapes(shapes: Array, ratio: Array) -> Array:
    """Shapes (nodes, modes) per speed ratio of each node; not a number where a node stands still in the mean."""
    turning = ratio[:, None] != 0
    return np.asarray(np.where(turning, shapes / np.where(turning, ratio[:, None], 1.0), np.nan))


def repeated_modes(modes: Modes) -> tuple[tuple[int, ...], ...]:
    """Numbers of elastic modes that share a frequency."""
    clusters: list[list[int]] = []
    for mode in range(modes.free, len(modes.squares)):
        before = modes.squares[mode - 1] if mode > modes.free else None
        if before is not None and abs(modes.squares[mode] - before) <= 2 * SAME * abs(before):
            clusters[-1].append(mode)
        else:
            clusters.append([mode])
    return tuple(tuple(cluster) for cluster in clusters if len(cluster) > 1)


def damped_pairs(point: OperatingPoint) -> DampedModes:
    """The damped modes about a point; own states are held."""
    modes = natural_modes(point.mass, point.stiffness, point.coordinates, point.damping)
    return damped_modes(modes, point.damping, point.stiffness)


def _is_linear(model: Compiled) -> bool:
    """Whether mass and stiffness are the same at every angle, so that no static angles are needed."""
    linear = model.mean_model.linear
    return all(linear.jac_sparsity(row, 0).nnz() == 0 for row in (0, 2))


def _rigid(model: Compiled, p: Array) -> Array:
    """Rigid rotations as columns over the groups."""
    roots = [step.state for step in model.equations.steps if step.form is None]
    states = np.zeros((len(model.states), max(1, len(roots))))
    states[roots, range(len(roots))] = 1.0
    angles = np.asarray(model.mean_model.angles.map(states.shape[1])(states, p)[0])
    return angles[:, : len(roots)]
