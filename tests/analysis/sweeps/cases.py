"""The case that the tests of sweeps run: two disks under a harmonic torque, in generated C where there is a compiler."""

from __future__ import annotations

from typing import Any

from modelgen import Case, Driveline, HarmonicTorque, Inertia, Shaft

COLLECT = ("shaft.torque.highest", "shaft.torque.rms", "shaft.twist.final", "steps")


def two_disks(**changes: Any) -> Driveline:
    return Driveline(
        "two_disks",
        speed="1200 rpm",
        reference="engine",
        bases={"firing": 3},
        parameters={"zeta": 0.05},
        elements=[
            Inertia("engine", inertia=3.0),
            Inertia("load", inertia=1.0),
            Shaft("shaft", "engine", "load", stiffness=3e5, damping_ratio="zeta"),
            HarmonicTorque("torque", "engine", cosine=[40.0, 10.0], base="firing"),
        ],
        **changes,
    )


def small_case(**changes: Any) -> Case:
    return Case(two_disks(), **{"end": 0.05, "samples": 41, **changes})
