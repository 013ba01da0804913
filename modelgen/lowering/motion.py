"""Motion: the angles and speeds that the laws are evaluated at, from the chosen states or from physical angles.

Part of ``lower``, on ``fixed``. The states are relative angles where a law sees one, so that a small twist is never the
difference of two large angles; ``motion_of_states`` builds on that. Equilibrium and linearization speak of the groups' own
angles, and ``motion_of_angles`` serves them. Every angle is counted from uniform rotation at the operating speed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from modelgen.lowering.fixed import Fixed


@dataclass(frozen=True, eq=False)
class Motion:
    """Relative angles and rates of the forms; angles, speeds and deviations from uniform rotation of the groups; own states.

    Everything in rad and rad/s, or in m and m/s where a form is a length; own states in units of their own.
    """

    forms: list[ca.SX]
    form_rates: list[ca.SX]
    angles: list[ca.SX]
    speeds: list[ca.SX]
    deviations: list[ca.SX]
    own: ca.SX


def motion_of_states(fixed: Fixed, t: ca.SX, x: ca.SX) -> Motion:
    """Motion at time t [s] in the state x."""
    n = fixed.order
    full_angle, vibrating_angle = group_values(fixed, x[:n]), group_values(fixed, x[:n], rigid=False)
    full_speed, vibrating_speed = group_values(fixed, x[n : 2 * n]), group_values(fixed, x[n : 2 * n], rigid=False)
    speeds = [mean + each for mean, each in zip(fixed.mean_speeds, full_speed, strict=True)]
    forms, rates = [], []
    for form, coefficients in zip(fixed.equations.forms, fixed.coefficients, strict=True):
        if form.state is not None:
            forms.append(x[form.state])
            rates.append(x[n + form.state])
        elif form.sees_angle:
            # A closed loop: its rigid part is zero by construction and must not come in through rounding.
            forms.append(_combined(coefficients, vibrating_angle))
            rates.append(_combined(coefficients, vibrating_speed))
        else:
            forms.append(ca.SX(0))
            rates.append(_combined(coefficients, speeds))
    return Motion(forms, rates, _turned(fixed, t, full_angle), speeds, full_angle, x[2 * n :])


def motion_of_angles(fixed: Fixed, t: ca.SX, angles: ca.SX, speeds: ca.SX, own: ca.SX) -> Motion:
    """Motion given by deviations of the group angles and speeds from uniform rotation."""
    deviation, rate = ca.vertsplit(angles), ca.vertsplit(speeds)
    forms = [_combined(coefficients, deviation) for coefficients in fixed.coefficients]
    absolute = [mean + each for mean, each in zip(fixed.mean_speeds, rate, strict=True)]
    rates = [
        _combined(coefficients, rate if form.sees_angle else absolute)
        for form, coefficients in zip(fixed.equations.forms, fixed.coefficients, strict=True)
    ]
    return Motion(forms, rates, _turned(fixed, t, deviation), absolute, deviation, own)


def group_values(fixed: Fixed, coordinates: ca.SX, rigid: bool = True) -> list[ca.SX]:
    """Angles (or speeds) of the groups from the chosen coordinates; without the rigid rotations unless ``rigid``."""
    placed: dict[int, ca.SX] = {}
    for step in fixed.equations.steps:
        if step.form is None:
            placed[step.group] = coordinates[step.state] if rigid else ca.SX(0)
        elif step.over is not None:
            kept = (state for state in fixed.placed[step.group] if rigid or fixed.equations.steps[state].form is not None)
            placed[step.group] = _combined({state: fixed.placed[step.group][state] for state in kept}, coordinates)
        else:
            coefficients = fixed.coefficients[step.form]
            rest = _combined({group: c for group, c in coefficients.items() if group != step.group}, placed)
            placed[step.group] = (coordinates[step.state] - rest) / coefficients[step.group]
    return [placed[group] for group in range(len(fixed.equations.groups))]


def coordinates_of(fixed: Fixed, values: ca.SX) -> list[ca.SX]:
    """The chosen coordinates of angles (or speeds, or accelerations) of the groups; the other way from ``group_values``."""
    return [
        _combined({step.group: ca.SX(1)} if step.form is None else fixed.coefficients[step.form], values)
        for step in fixed.equations.steps
    ]


def _turned(fixed: Fixed, t: ca.SX, deviations: list[ca.SX]) -> list[ca.SX]:
    return [mean * t + each for mean, each in zip(fixed.mean_speeds, deviations, strict=True)]


def _combined(coefficients: Mapping[int, ca.SX], values: Sequence[ca.SX] | Mapping[int, ca.SX] | ca.SX) -> ca.SX:
    return sum((c * values[group] for group, c in coefficients.items()), start=ca.SX(0))
