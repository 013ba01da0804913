"""The equivalent system: a driveline as inertias and stiffnesses referred to one shaft, as a table for makers and reports.

Part of ``exchange``, beside ``mass_elastic``, which reads the table back. With r the speed of a shaft per speed of the
reference shaft, J_ref = r^2 J, k_ref = r^2 k, c_ref = r^2 c (W. Ker Wilson, Practical Solution of Torsional Vibration Problems,
vol. 1), about an operating point: meshes have their mean stiffness on the loaded flank.
"""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.exchange.mass_elastic import GROUND
from modelgen.lowering import Compiled
from modelgen.solvers import OperatingPoint

Array = NDArray[np.float64]
NEGLIGIBLE = 1e-13  # of the diagonal: what rounding leaves of a coupling that is none
HEADER = ("name", "J_referred [kg*m^2]", "ratio", "to", "k_referred [N*m/rad]", "c_referred [N*m*s/rad]", "shaft")


@dataclass(frozen=True)
class EquivalentInertia:
    """An inertia: its own value and the referred one [kg*m^2], its speed per speed of the reference shaft."""

    name: str
    inertia: float
    referred: float
    ratio: float


@dataclass(frozen=True)
class EquivalentShaft:
    """What joins two inertias (``end`` "ground" for a tie to ground): referred stiffness [N*m/rad] and damping [N*m*s/rad].

    ``elements`` are those of the driveline that act there; ``damping`` is None where it does not belong to single shafts.
    """

    start: str
    end: str
    elements: tuple[str, ...]
    stiffness: float
    damping: float | None


@dataclass(frozen=True)
class EquivalentTable:
    """A driveline referred to its reference shaft; ``csv`` is the table as text, ``write`` puts it into a file."""

    model: str
    reference: str
    inertias: tuple[EquivalentInertia, ...]
    shafts: tuple[EquivalentShaft, ...]
    remarks: tuple[str, ...] = ()

    def csv(self) -> str:
        """The table as text, one row per inertia with the connection that starts there; numbers read back without loss."""
        text = io.StringIO()
        head = f"equivalent system of {self.model}, referred to {self.reference}"
        text.writelines(f"# {line}\n" for line in (head, *self.remarks))
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(HEADER)
        waiting = list(self.shafts)
        for inertia in self.inertias:
            first = next((shaft for shaft in waiting if shaft.start == inertia.name), None)
            if first is not None:
                waiting.remove(first)
            writer.writerow([inertia.name, repr(inertia.referred), _fraction(inertia.ratio), *_connection(first)])
        for shaft in waiting:
            writer.writerow([shaft.start, "", "", *_connection(shaft)])
        return text.getvalue()

    def write(self, path: str | Path) -> Path:
        """Writes the table, whole or not at all."""
        path = Path(path)
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
        try:
            temporary.write_text(self.csv(), encoding="utf-8")
            os.replace(temporary, path)
        except OSError as error:
            raise CaseError(str(path), f"cannot be written: {error.strerror}", "check the path and its permissions") from None
        return path


def equivalent_table(model: Compiled, point: OperatingPoint) -> EquivalentTable:
    """The equivalent system of a driveline about an operating point.

    Raises CaseError for a driveline that is no chain or network of inertias and springs (inertia that couples shafts, negative
    stiffness).

    >>> from modelgen import Driveline, Inertia, RigidGear, Shaft, assemble, lower, operating_point
    >>> line = Driveline("geared", reference="engine", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("pinion", inertia=1.0), Inertia("load", inertia=80.0),
    ...     Shaft("coupling", "engine", "pinion", stiffness=1e5), Shaft("wheel_shaft", b="load", stiffness=4e6),
    ...     RigidGear("gear", "pinion", "wheel_shaft.a", teeth_a=20, teeth_b=80)])
    >>> table = equivalent_table(model := lower(assemble(line)), operating_point(model))
    >>> [(each.name, each.referred, each.ratio) for each in table.inertias]
    [('engine', 5.0, 1.0), ('pinion', 1.0, 1.0), ('load', 5.0, 0.25)]
    >>> [(each.start, each.end, each.elements, each.stiffness) for each in table.shafts]
    [('engine', 'pinion', ('coupling',), 100000.0), ('pinion', 'load', ('wheel_shaft',), 250000.0)]
    """
    eq, ratio, where = model.equations, point.coordinates.ratio, f"equivalent system of {model.name!r}"
    mass, stiffness, damping = (each * np.outer(ratio, ratio) for each in (point.mass, point.stiffness, point.damping))
    names = [name.replace(".", "_") for name in eq.groups]
    coupled = _beyond_rounding(mass)
    if coupled:
        i, j = coupled[0]
        raise CaseError(where, f"inertia couples {names[i]!r} and {names[j]!r}", "tabulate only inertias on single shafts")
    modal = eq.modal_ratio is not None
    remarks = ["damping is modal and belongs to no single shaft: left out"] if modal else []
    elements, shafts, taken = _acting(model), [], set()
    springs, dampers = _beyond_rounding(stiffness, ground=True), [] if modal else _beyond_rounding(damping, ground=True)
    for i, j in sorted({*springs, *dampers}):
        acting = elements.get((i, j), ())
        shown = " + ".join(acting) or f"{names[i]} to {names[j] if j >= 0 else GROUND}"
        k = _between(stiffness, i, j) if (i, j) in springs else 0.0
        c = _between(damping, i, j) if (i, j) in dampers else 0.0
        if k < 0:
            what = f"the stiffness of {shown} is {k:g} N*m/rad"
            raise CaseError(where, what, "choose an operating point where it is positive")
        if c < 0 or (j >= 0 and k == 0):
            remarks.append(f"damping of {shown} has no place in a table of shafts: left out")
            continue
        # From the end that has no connection yet, so that most rows hold one each.
        start, end = (j, i) if i in taken and j >= 0 and j not in taken else (i, j)
        taken.add(start)
        shafts.append(EquivalentShaft(names[start], names[end] if end >= 0 else GROUND, acting, k, None if modal else c))
    own = zip(names, np.diag(point.mass).tolist(), np.diag(mass).tolist(), ratio.tolist(), strict=True)
    inertias = tuple(EquivalentInertia(*each) for each in own)
    reference = eq.reference or names[int(np.argmin(np.abs(ratio - 1)))]
    return EquivalentTable(model.name, reference, inertias, tuple(shafts), tuple(remarks))


def _beyond_rounding(matrix: Array, ground: bool = False) -> list[tuple[int, int]]:
    """Pairs of groups that a symmetric matrix couples; with ``ground``, (i, -1) where a row sum is not zero."""
    size = np.sqrt(np.abs(np.outer(np.diag(matrix), np.diag(matrix))))
    pairs = [(int(i), int(j)) for i, j in np.argwhere(np.triu(np.abs(matrix) > NEGLIGIBLE * size, 1))]
    sums = np.abs(matrix.sum(axis=1)) > NEGLIGIBLE * np.abs(matrix).sum(axis=1)
    return pairs + [(int(i), -1) for i in np.flatnonzero(sums) if ground]


def _between(matrix: Array, i: int, j: int) -> float:
    return float(-matrix[i, j] if j >= 0 else matrix[i].sum())


def _acting(model: Compiled) -> dict[tuple[int, int], tuple[str, ...]]:
    """Names of the elements that exert torques between two groups, or on one alone (paired with -1)."""
    eq, found = model.equations, dict[tuple[int, int], tuple[str, ...]]()
    for instance in eq.instances:
        groups = sorted({group for node in instance.nodes.values() for group in eq.nodes[node].row})
        pairs = combinations(groups, 2) if len(groups) > 1 else [(groups[0], -1)]
        template = eq.templates[instance.template]
        if template.relatives if len(groups) > 1 else template.stored_energy or template.dissipated_power:
            found.update({(i, j): (*found.get((i, j), ()), instance.name) for i, j in pairs})
    return found


def _connection(shaft: EquivalentShaft | None) -> list[str]:
    if shaft is None:
        return ["", "", "", ""]
    damping = repr(shaft.damping) if shaft.damping else ""
    return [shaft.end, repr(shaft.stiffness) if shaft.stiffness else "", damping, "_".join(shaft.elements)]


def _fraction(ratio: float) -> str:
    """A ratio of tooth numbers as a fraction; any other as a decimal, which no gear can have."""
    exact = Fraction(ratio).limit_denominator(10**6)
    return str(exact) if abs(float(exact) - ratio) <= 1e-15 * ratio else repr(ratio)
