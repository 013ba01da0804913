"""What sticks in the static state: elements that hold a speed at zero with a torque of their own, up to a limit.

Below ``static_state``. The static state adds holding torque times |slip since the start| to the energy, so each holder either
sticks (slip zero, torque within its limits) or has slipped (torque at its limit, against the slip). Which does which is found by
trial: all stick first; one whose torque would exceed its limit slips, and one whose slip is driven back sticks again. Where
several holders stick redundantly, their torques are those with the least squares of utilization, torque per limit.
Source: R. T. Rockafellar, Convex Analysis (1970), sec. 31 (conditions); F. Pfeiffer, C. Glocker, Multibody Dynamics with
Unilateral Contacts (1996), ch. 6.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled
from modelgen.lowering.holders import UNLIMITED, holder_names
from modelgen.solvers.descent import Found, Rest, settle
from modelgen.solvers.equilibrium import Coordinates

Array = NDArray[np.float64]
AT_REST = 1e-9  # of the fastest mean speed: a slip that is none
EXCESS = 1e-9  # of a limit: what counts as beyond it
INSIDE = 4e-7  # of a limit: how far inside it a run starts, or its rounding and errors would tear loose what is at its limit


@dataclass(frozen=True, eq=False)
class Holders:
    """The holders whose mean slip is zero: ``by_speed`` (holders, groups), ``by_multiplier`` (groups, holders), limits [N*m]."""

    names: tuple[str, ...]
    by_speed: Array
    by_multiplier: Array
    lower: Array
    upper: Array

    def act_on(self, rotation: Array) -> bool:
        """Whether one of them resists a rotation (groups,)."""
        size = np.abs(self.by_speed) @ np.abs(rotation)
        return bool(np.any(np.abs(self.by_speed @ rotation) > 1e-12 * size))

    @property
    def limit(self) -> Array:
        """The larger limit of each."""
        return np.maximum(np.abs(self.lower), np.abs(self.upper))


def holders_at_rest(model: Compiled, p: Array, mean: Array, own: Array, coordinates: Coordinates) -> Holders:
    """The holders of a model that do not slip in the mean; the others slide, with their sliding torque."""
    names, zeros = holder_names(model.equations), np.zeros(len(coordinates.ratio))
    if not names:
        return Holders((), np.zeros((0, len(zeros))), np.zeros((len(zeros), 0)), np.zeros(0), np.zeros(0))
    slip, *rest = (each.full() for each in model.mean_model.holders(zeros, zeros, own, p, mean))
    fastest = float(np.abs(coordinates.speed).max(initial=0.0))
    still = np.abs(slip.ravel()) <= AT_REST * fastest if fastest else slip.ravel() == 0.0
    by_speed, by_multiplier, lower, upper = rest
    return Holders(
        tuple(name for name, is_still in zip(names, still, strict=True) if is_still),
        by_speed[still], by_multiplier[:, still], lower.ravel()[still], upper.ravel()[still],
    )  # fmt: skip


def stick_and_slip(rest: Rest, holders: Holders) -> Found:
    """The static state with what sticks."""
    slip_by_place = holders.by_speed @ rest.to_angles
    limits = np.vstack([holders.lower, holders.upper])
    slipping = np.zeros(len(holders.names), dtype=int)  # 0 sticks, +1 at its upper limit, -1 at its lower
    tried: set[tuple[int, ...]] = set()
    found = Found(np.zeros(rest.to_angles.shape[1]))
    while tuple(slipping) not in tried:
        tried.add(tuple(slipping))
        stuck = slipping == 0
        torques = np.where(slipping > 0, limits[1], np.where(slipping < 0, limits[0], 0.0))
        basis = _null_space(slip_by_place[stuck])
        inner = settle(rest.over(basis, holders.by_multiplier @ torques))
        if inner.missing is not None:
            return replace(inner, place=basis @ inner.place)
        place = basis @ inner.place
        unbalanced = rest.force(place) + rest.to_angles.T @ holders.by_multiplier @ torques
        shares, left = _utilization(rest.to_angles.T @ holders.by_multiplier[:, stuck], unbalanced, holders, stuck)
        torques[stuck] = shares
        found = Found(place, holding=dict(zip(holders.names, torques.tolist(), strict=True)), remarks=inner.remarks)
        back = [k for k in np.flatnonzero(~stuck).tolist() if _drives(holders, rest, place, k, torques[k])]
        if back:
            slipping[back[0]] = 0
        elif left is not None:
            slipping[np.flatnonzero(stuck)[left]] = 1 if shares[left] > 0 else -1
        else:
            begin = _inside(rest, holders, basis, np.where(stuck, 0.0, torques)) if not stuck.all() else None
            return replace(found, begin=begin, remarks=(*found.remarks, *_said(holders, slip_by_place, stuck, torques)))
    return replace(found, missing="which elements stick and which slip does not settle")


def _inside(rest: Rest, holders: Holders, basis: Array, torques: Array) -> Array | None:
    """The place at rest with the torques of what has slipped a little inside their limits: a run starts there, and it holds."""
    found = settle(rest.over(basis, holders.by_multiplier @ ((1 - INSIDE) * torques)))
    return None if found.missing is not None else np.asarray(basis @ found.place)


def _null_space(rows: Array) -> Array:
    """Columns that span what the rows leave free."""
    if not rows.size:
        return np.eye(rows.shape[1])
    size = np.abs(rows).max(axis=1, keepdims=True)
    _, values, vectors = np.linalg.svd(rows / np.where(size > 0, size, 1.0))
    return np.asarray(vectors[int((values > 1e-10 * values.max(initial=0.0)).sum()) :].T)


def _utilization(arms: Array, unbalanced: Array, holders: Holders, stuck: NDArray[np.bool_]) -> tuple[Array, int | None]:
    """Torques of what sticks, of least squares of utilization, and the first that must slip because no such torques suffice."""
    limit = np.minimum(holders.limit[stuck], UNLIMITED)
    finite = limit[limit < UNLIMITED].max(initial=0.0)
    scale = np.where(limit < UNLIMITED, limit, max(1e6 * finite, np.abs(unbalanced).max(initial=0.0), 1.0))
    scale = np.where(scale > 0, scale, 1e-300)
    lower, upper = holders.lower[stuck] / scale, holders.upper[stuck] / scale
    shares, fixed = np.zeros(len(scale)), np.zeros(len(scale), dtype=bool)
    first: int | None = None
    while not fixed.all():
        known = arms[:, fixed] @ (scale * shares)[fixed]
        shares[~fixed] = np.linalg.lstsq(arms[:, ~fixed] * scale[~fixed], -unbalanced - known, rcond=1e-12)[0]
        excess = np.where(fixed, 0.0, np.maximum(shares - upper, lower - shares))
        worst = int(excess.argmax())
        if excess[worst] <= EXCESS:
            break
        first = worst if first is None else first
        shares[worst], fixed[worst] = np.clip(shares[worst], lower[worst], upper[worst]), True
    remains = np.abs(arms @ (scale * shares) + unbalanced).max(initial=0.0)
    suffices = remains <= 1e-9 * max(np.abs(unbalanced).max(initial=0.0), 1e-300)
    return scale * shares, None if suffices else first


def _drives(holders: Holders, rest: Rest, place: Array, holder: int, torque: float) -> bool:
    """Whether what has slipped would have been driven by its own torque: it then sticks instead."""
    angle = rest.to_angles @ place
    work = float(holders.by_multiplier[:, holder] * torque @ angle)
    return work > 1e-12 * float(np.abs(holders.by_multiplier[:, holder] * torque) @ np.abs(angle))


def _said(holders: Holders, slip_by_place: Array, stuck: NDArray[np.bool_], torques: Array) -> tuple[str, ...]:
    """What sticks redundantly, and what has slipped."""
    said = []
    names = [holders.names[k] for k in np.flatnonzero(stuck)]
    rows = slip_by_place[stuck]
    if len(names) and np.linalg.matrix_rank(rows / np.maximum(np.abs(rows).max(axis=1, keepdims=True), 1e-300)) < len(names):
        said.append(f"{', '.join(names)} stick redundantly: their torques are those of least squares of utilization")
    if slid := [f"{holders.names[k]} ({torques[k]:.6g} N*m)" for k in np.flatnonzero(~stuck)]:
        said.append(f"slipped before it came to rest: {', '.join(slid)}")
    return tuple(said)
