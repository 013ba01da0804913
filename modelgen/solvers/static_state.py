"""The static state under the mean torques: where a simulation starts unless told otherwise.

Between ``equilibrium`` (the mean model in numbers) and ``operating_point``. The state minimizes stored energy, less the work of
the mean torques, plus holding torque times slip over the elements that may stick; ``descent`` finds it for given sticking,
``sticking`` finds what sticks. Rotations that nothing holds accelerate: the torque for that is taken out first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import BalanceError, CaseError
from modelgen.lowering import Compiled
from modelgen.lowering.mean_turn import angles_seen_at_rest
from modelgen.solvers.descent import ROUNDING, Rest, settle
from modelgen.solvers.equilibrium import Coordinates
from modelgen.solvers.sticking import holders_at_rest, stick_and_slip

Array = NDArray[np.float64]
TURNED = (0.0, 0.37, 1.0, 2.3, 4.1)  # rad: where a law of an angle is looked at
BALANCED = 1e-6  # mean power that may remain, relative to the sum of its parts


@dataclass(frozen=True, eq=False)
class StaticState:
    """Angles of the groups [rad] from uniform rotation, and ``drift`` [rad/s^2] of the reference shaft.

    ``holding`` [N*m]: torque of every element that sticks or has slipped. ``remarks``: what the torques alone do not decide.
    ``begin``: the angles where a run starts instead, where something has slipped: a little inside its limit.
    """

    angle: Array
    drift: float
    holding: dict[str, float]
    remarks: tuple[str, ...]
    begin: Array | None = None


def static_state(model: Compiled, p: Array, mean: Array, coordinates: Coordinates) -> StaticState:
    """The static state. Own states are held at their start.

    Raises BalanceError for mean torques that do not balance, CaseError where no equilibrium is found.
    """
    n = len(coordinates.ratio)
    if n == 0:
        return StaticState(np.zeros(0), 0.0, {}, ())
    own, angle = model.mean_model.own_start, np.zeros(n)
    torque, mass = model.mean_model.torque_at(p, mean, angle, own), model.mean_model.matrices_at(p, mean, angle, own).mass
    holders = holders_at_rest(model, p, mean, own, coordinates)
    sizes = model.mean_model.sizes_at(p, mean, angle, own)
    seen = _seen(model, p, mean, coordinates)
    held = [root for root in coordinates.roots if root in seen or holders.act_on(coordinates.to_angles[:, root])]
    drive, drift = _drift(model, torque, sizes, mass, coordinates, held)
    columns = [*coordinates.forms, *held]
    rest = Rest(
        model.mean_model,
        own=own,
        p=p,
        mean=mean,
        to_angles=coordinates.to_angles[:, columns],
        drive=drive,
        mass=mass,
        names=tuple(f"{model.states[k]!r} [{_force_unit(model.equations.states[k].unit)}]" for k in columns),
        acting=float(sizes.max(initial=0.0)),
    )
    found = stick_and_slip(rest, holders) if holders.names else settle(rest)
    if found.missing is not None:
        what = f"has no static equilibrium: {found.missing}"
        raise CaseError(f"driveline {model.name!r}", what, 'start from "zero" or from given states')
    begin = None if found.begin is None else rest.to_angles @ found.begin
    return StaticState(rest.to_angles @ found.place, drift, found.holding, found.remarks, begin)


def _force_unit(unit: str) -> str:
    """The unit of the generalized force along a coordinate."""
    return "N*m" if unit in ("rad", "1") else "N" if unit == "m" else f"J/({unit})"


def _seen(model: Compiled, p: Array, mean: Array, coordinates: Coordinates) -> list[int]:
    """Rotations that do not turn and on which a law of their angle acts, as gravity on an arm: it may hold them."""
    if not angles_seen_at_rest(model.equations):
        return []
    own = model.mean_model.own_start
    found = []
    for root in coordinates.roots:
        rotation = coordinates.to_angles[:, root]
        reached = [model.mean_model.torque_at(p, mean, turn * rotation, own) for turn in TURNED]
        change = max(abs(float(rotation @ (each - reached[0]))) for each in reached)
        size = max(float(model.mean_model.sizes_at(p, mean, turn * rotation, own) @ np.abs(rotation)) for turn in TURNED)
        if change > ROUNDING * size:
            found.append(root)
    return found


def _drift(
    model: Compiled, torque: Array, sizes: Array, mass: Array, coordinates: Coordinates, held: list[int]
) -> tuple[Array, float]:
    """Torques that the rigid acceleration takes up, and that acceleration at the reference shaft."""
    free = [root for root in coordinates.roots if root not in held]
    rigid = coordinates.to_angles[:, free]
    if rigid.shape[1] == 0:
        return np.zeros_like(torque), 0.0
    acceleration = np.linalg.solve(rigid.T @ mass @ rigid, rigid.T @ torque)
    drive = mass @ rigid @ acceleration
    ratio, speed = coordinates.ratio, coordinates.speed
    net, parts = float(ratio @ torque), float(np.abs(ratio * torque).sum())
    drift = net / float(ratio @ mass @ ratio)
    if held or model.equations.drifts or not np.any(speed):
        return drive, drift
    if coordinates.by_speed.shape[1] > 1:
        _check_every_rotation(model, torque, sizes, coordinates)
    elif abs(net) > BALANCED * parts + ROUNDING * float(np.abs(ratio) @ sizes):
        power = net * float(np.max(np.abs(speed / ratio)))
        raise BalanceError(
            f"driveline {model.name!r}",
            f"mean torques leave {net:.6g} N*m ({power:.4g} W) at the reference shaft, "
            f"which would accelerate by {drift:.4g} rad/s^2",
            "use balance(load), change a torque, or declare that it drifts",
        )
    return drive, drift


def _check_every_rotation(model: Compiled, torque: Array, sizes: Array, coordinates: Coordinates) -> None:
    """Raises BalanceError where the mean torques do not balance along one of several free rotations."""
    rounding = ROUNDING * np.abs(coordinates.by_speed.T) @ sizes
    for (name, net, parts), least in zip(remaining_torques(model, torque, coordinates), rounding, strict=True):
        if abs(net) > BALANCED * parts + least:
            what = f"mean torques leave {net:.6g} N*m along the rotation of {name!r} with the other given speeds unchanged"
            raise BalanceError(f"driveline {model.name!r}", what, "use balance(load, ...), one load for each given speed")


def remaining_torques(model: Compiled, torque: Array, coordinates: Coordinates) -> list[tuple[str, float, float]]:
    """R^T torque: shaft of each given speed, what remains of the mean torques along it [N*m], and the sum of their sizes."""
    rows = coordinates.by_speed.T
    names = [str(model.equations.reference), *(name.partition(".")[2] for name in model.parameters.names if _is_speed(name))]
    return [(name, float(row @ torque), float(np.abs(row * torque).sum())) for name, row in zip(names, rows, strict=True)]


def _is_speed(name: str) -> bool:
    return name.startswith("speeds.")

