"""Rest under constant torques: Newton's method with a pseudo time step, and where that fails, a descent that cannot.

Below ``static_state``. Inside a backlash there is no stiffness, and the pseudo step carries the flank across the gap to the side
that the torque presses. Where several flanks depend on each other, as in a loop of meshes, the descent minimizes the energy along
each direction; a spring to the start that fades out makes every such problem definite, and leaves angles that nothing decides at
the place nearest to the start in sum(J angle^2). Where the energy is not convex, the torques are raised from zero.
Sources: C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508 (pseudo-transient continuation); A. N. Tikhonov's
regularization; J. Nocedal, S. Wright, Numerical Optimization (2006), ch. 3 (line search).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.mean_model import MeanModel

Array = NDArray[np.float64]
ITERATIONS = 400
FADING = 10.0 ** np.arange(0, -14, -1)  # stiffness of the spring to the start per inertia, of the fastest seen
CONVERGED, ACCEPTED = 1e-14, 1e-9  # force that may remain, per the largest at the start
ROUNDING = 1e-13  # of the torques that act, before they cancel: a force that is none
SOFT = 1e-9  # of the largest eigenvalue: what counts as no stiffness, or as a negative one
NOT_CONVEX = (
    "the energy is not convex: this is the state reached by raising the mean torques from zero, and others may exist"
)
RAISES = 40  # steps of the torques from zero to their values


@dataclass(frozen=True, eq=False)
class Rest:
    """The problem: coordinates u with angles = ``to_angles`` @ u, forces along them, and what they are called.

    ``drive`` [N*m] are the torques on the groups that accelerate; ``extra`` [N*m] further constant ones, as of what slips.
    ``acting`` [N*m] is the largest torque on a group, before torques cancel.
    """

    functions: MeanModel
    own: Array
    p: Array
    mean: Array
    to_angles: Array
    drive: Array
    mass: Array
    names: tuple[str, ...]
    extra: Array | None = None
    acting: float = 0.0

    def torque(self, u: Array) -> Array:
        """Torques on the groups that do not balance [N*m]."""
        angle = self.to_angles @ u
        found = self.functions.torque_at(self.p, self.mean, angle, self.own) - self.drive
        return found if self.extra is None else found + self.extra

    def force(self, u: Array) -> Array:
        """Forces along the coordinates."""
        return np.asarray(self.to_angles.T @ self.torque(u))

    def stiffness(self, u: Array) -> Array:
        """-d force / du."""
        angle = self.to_angles @ u
        matrix = self.functions.matrices_at(self.p, self.mean, angle, self.own).stiffness
        return np.asarray(self.to_angles.T @ matrix @ self.to_angles)

    @property
    def inertia(self) -> Array:
        """Mass matrix of the coordinates."""
        return np.asarray(self.to_angles.T @ self.mass @ self.to_angles)

    @property
    def negligible(self) -> float:
        """Force along a coordinate that is rounding of the torques that act."""
        largest = max(self.acting, float(np.abs(self.drive).max(initial=0.0)))
        if self.extra is not None:
            largest = max(largest, float(np.abs(self.extra).max(initial=0.0)))
        return ROUNDING * largest * float(np.abs(self.to_angles).max(initial=0.0))

    @property
    def is_linear(self) -> bool:
        """Whether the stiffness is the same everywhere."""
        return bool(self.functions.linear.jac_sparsity(2, 0).nnz() == 0)

    def over(self, basis: Array, extra: Array) -> Rest:
        """The same in fewer coordinates v with u = basis @ v, and with further torques on the groups."""
        names = tuple(self.names[int(np.abs(column).argmax())] for column in basis.T)
        return replace(self, to_angles=self.to_angles @ basis, names=names, extra=extra)


@dataclass(frozen=True, eq=False)
class Found:
    """A place at rest, or what is ``missing`` for one; ``begin`` beside it, ``holding`` and ``remarks`` as in ``StaticState``."""

    place: Array
    missing: str | None = None
    holding: dict[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    begin: Array | None = None


def settle(rest: Rest) -> Found:
    """The place at rest nearest to the start that lowers the energy most, or the force that nothing takes."""
    start = np.zeros(rest.to_angles.shape[1])
    size = float(np.abs(rest.force(start)).max(initial=0.0))
    if size == 0.0 and (not len(start) or rest.is_linear):
        return Found(start)
    is_nothing = size <= rest.negligible
    size = max(size, rest.negligible / ACCEPTED) if is_nothing else size
    with np.errstate(all="ignore"):
        place = start if is_nothing else _newton(rest, size)
        is_there = _is_rest(rest, place, size)
        if not is_there and _is_convex(rest, start):
            place = _descended(rest, size)
            is_there = _is_rest(rest, place, size)
        if _is_convex(rest, place):
            return Found(place, remarks=_free_angles(rest, place)) if is_there else Found(place, missing=_missing(rest, place))
        raised = start if is_nothing else _raised(rest, size)
        if _is_rest(rest, raised, size):
            return Found(raised, remarks=(NOT_CONVEX,))
        return Found(start, missing=_missing(rest, raised))


def _newton(rest: Rest, size: float) -> Array:
    """Newton's method with a pseudo time step that grows as the force falls."""
    u = np.zeros(rest.to_angles.shape[1])
    force, inertia = rest.force(u), np.diag(rest.inertia)
    weight, stall = 1.0, 0
    for _ in range(ITERATIONS):
        if np.abs(force).max(initial=0.0) <= CONVERGED * size or stall > 3:
            break
        stiffness = rest.stiffness(u)
        fastest = float(np.max(np.abs(np.diag(stiffness)) / inertia)) or 1.0
        try:
            trial = u + np.linalg.solve(stiffness + np.diag(weight * fastest * inertia), force)
        except np.linalg.LinAlgError:
            break
        new = rest.force(trial)
        if np.linalg.norm(new) <= np.linalg.norm(force) * (1 + 1e-9):
            stall = stall + 1 if np.linalg.norm(new) > 0.5 * np.linalg.norm(force) and np.abs(force).max() < 1e-9 * size else 0
            u, force, weight = trial, new, weight / 10
        else:
            weight *= 4
            stall += weight > 1e12
    return u


def _is_rest(rest: Rest, place: Array, size: float) -> bool:
    force = np.abs(rest.force(place)).max(initial=0.0)
    return bool(np.all(np.isfinite(place)) and force <= ACCEPTED * size)


def _is_convex(rest: Rest, place: Array) -> bool:
    """Whether no stiffness is negative at the start, at the place, and between them."""
    inertia = rest.inertia
    scale = 1 / np.sqrt(np.diag(inertia))
    for share in (1.0,) if rest.is_linear else (0.0, 0.25, 0.5, 0.75, 1.0):
        matrix = rest.stiffness(share * place)
        matrix = (matrix + matrix.T) / 2 * np.outer(scale, scale)
        if not np.all(np.isfinite(matrix)):
            return False
        largest = float(np.abs(matrix).sum(axis=1).max(initial=0.0))
        try:
            np.linalg.cholesky(matrix + max(SOFT * largest, 1e-300) * np.eye(len(matrix)))
        except np.linalg.LinAlgError:
            return False
    return True


def _fastest(rest: Rest) -> float:
    """Largest stiffness per inertia of a coordinate, at the start and away from it."""
    count, inertia = rest.to_angles.shape[1], np.diag(rest.inertia)
    places = [np.zeros(count)]
    if not rest.is_linear:
        places += [sign * reach * np.ones(count) for reach in 10.0 ** np.arange(-6, 1) for sign in (1.0, -1.0)]
    found = [np.abs(np.diag(rest.stiffness(place))) / inertia for place in places]
    return float(np.nanmax([each[np.isfinite(each)].max(initial=0.0) for each in found])) or 1.0


def _descended(rest: Rest, size: float) -> Array:
    """The least energy, with a spring to the start that fades out, so that what nothing decides stays nearest to the start."""
    inertia, fastest = rest.inertia, _fastest(rest)
    u = np.zeros(len(inertia))
    for fading in FADING:
        spring = fading * fastest * inertia

        def force(place: Array, spring: Array = spring) -> Array:
            return np.asarray(rest.force(place) - spring @ place)

        for _ in range(60):
            now = force(u)
            if np.abs(now).max() <= 1e-13 * size:
                break
            stiffness = rest.stiffness(u)
            try:
                direction = np.linalg.solve((stiffness + stiffness.T) / 2 + spring, now)
            except np.linalg.LinAlgError:
                break  # a stiffness so small that nothing of it is left beside the inertias
            step = _along(force, u, direction)
            u = u + step * direction
            if step * np.abs(direction).max() <= 1e-16 * np.abs(u).max():
                break
    return _polished(rest, u, size)


def _along(force: Callable[[Array], Array], u: Array, direction: Array) -> float:
    """Where the force along a direction vanishes: the least energy on that line, as its slope only falls."""

    def slope(step: float) -> float:
        return float(force(u + step * direction) @ direction)

    low, high = 0.0, 1.0
    while slope(high) > 0 and high < 1e12:
        low, high = high, 4 * high
    if low == 0.0 and abs(slope(high)) <= 0.5 * abs(slope(0.0)):
        return high  # Newton's own step is good enough, and ends in one where the law is straight
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if slope(middle) > 0 else (low, middle)
        if high - low <= 1e-12 * high:
            break
    return (low + high) / 2


def _polished(rest: Rest, u: Array, size: float) -> Array:
    """Newton steps without the spring, in the directions that have stiffness."""
    scale = 1 / np.sqrt(np.diag(rest.inertia))
    for _ in range(4):
        force = rest.force(u)
        if np.abs(force).max(initial=0.0) <= CONVERGED * size:
            break
        matrix = rest.stiffness(u) * np.outer(scale, scale)
        trial = u + scale * np.linalg.lstsq(matrix, scale * force, rcond=SOFT)[0]
        if not np.abs(rest.force(trial)).max() < np.abs(force).max():
            break
        u = trial
    return u


def _raised(rest: Rest, size: float) -> Array:
    """The torques raised from zero in steps; at each the motion u' = M^-1 force is followed to its rest."""
    inertia = rest.inertia
    factor = np.linalg.cholesky(inertia)
    u = np.zeros(len(inertia))
    at_start = rest.force(u)
    for load in np.linspace(0.0, 1.0, RAISES + 1)[1:]:
        weight = 1.0
        for _ in range(ITERATIONS):
            force = rest.force(u) - (1 - load) * at_start
            if np.abs(force).max(initial=0.0) <= 1e-12 * size or not np.all(np.isfinite(force)):
                break
            stiffness = rest.stiffness(u)
            slow = np.linalg.solve(factor, np.linalg.solve(factor, (stiffness + stiffness.T) / 2).T)
            if not np.all(np.isfinite(slow)):
                return u
            squares = np.linalg.eigvalsh(slow)
            least = max(-2.0 * squares[0], 0.0)  # never across a maximum
            ridge = max(least + weight * np.abs(squares).max(), 1e-12 * size / np.diag(inertia).max())
            trial = u + np.linalg.solve(stiffness + ridge * inertia, force)
            better = np.abs(rest.force(trial) - (1 - load) * at_start).max() < 2 * np.abs(force).max()
            u, weight = (trial, weight / 4) if better else (u, weight * 4)
    return u


def _missing(rest: Rest, place: Array) -> str:
    """The force that nothing takes, by its largest part."""
    force, at_start = rest.force(place), rest.force(np.zeros(len(place)))
    if not np.abs(force).max() <= 10 * np.abs(at_start).max():
        force = at_start
    worst = int(np.abs(force).argmax())
    name, _, unit = rest.names[worst].rpartition(" [")
    return f"{abs(force[worst]):.6g} {unit.rstrip(']')} along {name} remain, and nothing takes them"


def _free_angles(rest: Rest, place: Array) -> tuple[str, ...]:
    """Which coordinates no stiffness decides at the place."""
    stiffness = np.abs(rest.stiffness(place))
    loose = [name.rpartition(" [")[0] for name, row in zip(rest.names, stiffness, strict=True) if not row.any()]
    return (f"no stiffness decides {_listed(loose)}: taken nearest to the start",) if loose else ()


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
