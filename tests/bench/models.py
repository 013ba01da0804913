"""The drivelines that are asked about, where the catalogue does not have them."""

from __future__ import annotations

from modelgen import Driveline, GearPair, HarmonicTorque, Inertia, NamedParameter, Shaft, load
from modelgen.analysis.referee.comparison import with_mean_stiffness


def smooth_truck() -> Driveline:
    """The truck without backlash, at mean mesh stiffness: nothing but sines."""
    return with_mean_stiffness(load("fracturing-truck")).change("gear_pair", half_backlash=0.0)


def repeating_truck() -> Driveline:
    """The truck whose excitation repeats with every turn of the pump, its mesh damping in proportion to that of the shafts."""
    return load("fracturing-truck-commensurate").set(xi=NamedParameter(expression="0.1*zeta/0.035"))


def gear_pair() -> Driveline:
    """Two gears whose mesh loses contact near resonance; in terms of w_n t and the backlash it is the dimensionless gear pair."""
    return Driveline(
        "gear-pair", speed="1000 rpm", reference="pinion",
        elements=[
            Inertia("pinion", inertia=0.01), Inertia("wheel", inertia=0.04),
            GearPair("mesh", "pinion", "wheel", teeth_a=20, teeth_b=40, module="4 mm", mean_stiffness="2e7 N/m",
                     stiffness_cosine=[4e6], stiffness_sine=[0.0], damping_ratio=0.05, half_backlash="20 um"),
            HarmonicTorque("drive", "pinion", mean="20 N*m", base="shake", cosine=[6.0]),
            HarmonicTorque("load", "wheel", mean="-40 N*m"),
        ],
        bases={"shake": ("pinion", 31)},
    )  # fmt: skip


def chain(count: int) -> Driveline:
    """Inertias in a row, a harmonic torque on every eighth, so that no part of it is at rest."""
    disks = [Inertia(f"disk_{k}", inertia=0.5 + 0.01 * (k % 7)) for k in range(count)]
    shafts = [
        Shaft(f"shaft_{k}", f"disk_{k}", f"disk_{k + 1}", stiffness=2e5 + 1e3 * (k % 5), damping_ratio=0.02)
        for k in range(count - 1)
    ]
    drives = [
        HarmonicTorque(
            f"drive_{k}", f"disk_{k}", mean=0.0, sine=[100.0, 40.0, 20.0, 10.0], cosine=[3.0 * k % 50, 5, 0, 1], base="order"
        )
        for k in range(0, count, 8)
    ]
    bases = {"order": ("disk_0", 2)}
    return Driveline(f"chain-{count}", speed="600 rpm", reference="disk_0", elements=[*disks, *shafts, *drives], bases=bases)
