"""What the figures of gear meshes draw: stiffness, damping and backlash of every gear pair, as the model has them.

From a compiled driveline at its operating point to ``gear_meshes``. The model's curves come from its own output channels, the
exact stiffness and the fitting errors from the tooth geometry (``modelgen.gears``) where the stiffness follows from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.equations.records import Instance
from modelgen.errors import CaseError, nearest
from modelgen.gears import Gear, GearMesh, SeriesErrors, mesh_damping, series_errors
from modelgen.lowering import Compiled
from modelgen.solvers import OperatingPoint, operating_point

Array = NDArray[np.float64]

SAMPLES = 1200  # per mesh period
FORMS = ("corrected", "literal")
SAME = 1e-9
GEOMETRY = ("module", "face_width", "pressure_angle", "young_modulus", "poisson_ratio", "shear_factor")


@dataclass(frozen=True, eq=False)
class MeshCurves:
    """One gear pair over two mesh periods; ``phase`` counts in periods from where a tooth pair enters contact.

    ``stiffness`` [N/m] and ``damping`` [N*s/m] as the model has them; ``exact`` [N/m] from the teeth and ``errors`` of its series
    (None where the stiffness is given otherwise), ``order`` of the model's series; ``forms`` the damping in the corrected form
    [N*s/m] and as printed in the paper [N*m*s/rad] (empty where the coefficient is given); ``form`` the one in use.
    ``deflection`` [m] is that of the static state.
    """

    name: str
    teeth: tuple[int, int]
    period: float
    contact_ratio: float | None
    phase: Array
    stiffness: Array
    mean_stiffness: float
    exact: Array | None
    errors: SeriesErrors | None
    order: int | None
    damping: Array
    forms: dict[str, Array]
    form: str
    damping_ratio: float | None
    half_backlash: float
    deflection: float


@dataclass(frozen=True, eq=False)
class GearMeshes:
    """The gear pairs of a driveline, for the figures of their stiffness, damping and backlash."""

    model: str
    pairs: tuple[MeshCurves, ...]

    def __getitem__(self, name: str) -> MeshCurves:
        found = {pair.name: pair for pair in self.pairs}
        if name not in found:
            raise CaseError(f"gear meshes of {self.model!r}", f"there is no gear pair {name!r}", nearest(name, found))
        return found[name]


def gear_meshes(
    model: Compiled, point: OperatingPoint | None = None, names: Sequence[str] | None = None, highest_order: int = 30
) -> GearMeshes:
    """Curves of the named gear pairs (all by default) at an operating point, errors of the series up to an order.

    Raises CaseError for a driveline without elastic gear pairs and for an unknown name.

    >>> from modelgen import assemble, load, lower
    >>> meshes = gear_meshes(lower(assemble(load("fracturing-truck"))))
    >>> [f"{pair.name} {pair.mean_stiffness:.5e} N/m, rms {pair.errors.rms[10]:.1%}" for pair in meshes.pairs]
    ['transmission_mesh 2.46466e+09 N/m, rms 4.1%', 'pump_mesh 4.91019e+09 N/m, rms 4.1%']
    """
    point = point or operating_point(model)
    equations = model.equations
    meshing = {each.name: each for each in equations.instances if f"{each.name}.mesh_stiffness" in model.outputs}
    where = f"gear meshes of {model.name!r}"
    if not meshing:
        raise CaseError(where, "it has no elastic gear pair", "give a driveline with a GearPair")
    for name in names or ():
        if name not in meshing:
            raise CaseError(where, f"there is no gear pair {name!r}", nearest(name, meshing))
    return GearMeshes(model.name, tuple(_Pair(model, point, meshing[name]).curves(highest_order) for name in names or meshing))


class _Pair:
    """One gear pair of a compiled driveline."""

    def __init__(self, model: Compiled, point: OperatingPoint, instance: Instance) -> None:
        self.model, self.point, self.instance = model, point, instance
        template = model.equations.templates[instance.template]
        entry = {symbol: index for index, symbol in enumerate(model.parameters.symbols)}
        self.entries = {key: [entry[instance.symbols[symbol]] for symbol in symbols] for key, symbols in template.parameters}

    def value(self, key: str) -> float | None:
        """A parameter at the operating point; None where this pair has no such parameter."""
        return float(self.point.p[self.entries[key][0]]) if self.entries.get(key) else None

    def number(self, key: str, default: float = 0.0) -> float:
        value = self.value(key)
        return default if value is None else value

    def curves(self, highest_order: int) -> MeshCurves:
        name = self.instance.name
        clock = next(iter(self.instance.clocks.values()))
        frequency = float(self.model.mean_model.frequencies_at(self.point.p)[clock])
        period = 2 * np.pi / frequency if frequency > 0 else 0.0
        phase = np.linspace(0.0, 2.0, 2 * SAMPLES + 1)
        wanted = [f"{name}.{last}" for last in ("mesh_stiffness", "mesh_damping", "deflection", "error", "radius_a", "radius_b")]
        found = self.model.channels(phase * period, np.tile(self.point.start, (len(phase), 1)), self.point.p, wanted)
        stiffness, damping, deflection, error, radius_a, radius_b = (found[each] for each in wanted)
        mesh = self._mesh()
        forms = self._forms(stiffness, float(radius_a[0]), float(radius_b[0]))
        in_use = next((form for form, values in forms.items() if np.allclose(values, damping, rtol=SAME, atol=0.0)), "value")
        rows = len(self.entries.get("geometry_rows", self.entries.get("stiffness_cosine", ())))
        return MeshCurves(
            name=name,
            teeth=(int(self.number("teeth_a")), int(self.number("teeth_b"))),
            period=period,
            contact_ratio=mesh.transverse_contact_ratio if mesh else self.value("contact_ratio"),
            phase=phase,
            stiffness=stiffness,
            mean_stiffness=float(np.mean(stiffness[: 2 * SAMPLES])),
            exact=mesh.stiffness(_beside_jumps(phase)) if mesh else None,
            errors=series_errors(mesh, highest_order) if mesh else None,
            order=(rows // 2 if "geometry_rows" in self.entries else rows) or None,
            damping=damping,
            forms=forms,
            form=in_use,
            damping_ratio=self.value("damping_ratio"),
            half_backlash=self.number("half_backlash"),
            # The mean state under mean torques; the momentary mesh error does not belong to it.
            deflection=float(deflection[0] + error[0] - self.number("error_mean")),
        )

    def _mesh(self) -> GearMesh | None:
        if any(self.value(key) is None for key in GEOMETRY):
            return None
        module, width, pressure_angle, young, poisson, shear = (self.number(key) for key in GEOMETRY)
        shifts = [self.number(f"profile_shift_{end}") for end in ("a", "b")]
        teeth = [int(self.number(f"teeth_{end}")) for end in ("a", "b")]
        one, two = (Gear(count, module, shift, pressure_angle) for count, shift in zip(teeth, shifts, strict=True))
        return GearMesh(one, two, width, young, poisson, shear)

    def _forms(self, stiffness: Array, radius_a: float, radius_b: float) -> dict[str, Array]:
        ratio = self.value("damping_ratio")
        if ratio is None:
            return {}
        model, point = self.model, self.point
        nodes = [self.instance.nodes[flange] for flange in ("a", "b")]
        rows = model.mean_model.nodes_at(point.p)[nodes]
        j_a, j_b = (float(1 / (row @ np.linalg.solve(point.mass, row))) for row in rows)
        return {form: mesh_damping(stiffness, j_a, j_b, radius_a, radius_b, ratio, form) for form in FORMS}


def _beside_jumps(phase: Array) -> Array:
    """The same phases, the last one inside its period, so that both periods end alike."""
    return np.where(phase == 2.0, 2.0 - 1e-12, phase)
