"""Gear pair: an elastic spur mesh with backlash. Vocabulary of drivelines, below ``model``.

Follows the paper's Eq. 9-17: Fourier mesh stiffness, mesh damping, mesh error, backlash, and the line-of-action force. Eq. 10 as
printed pairs the inertias with the wrong radii and has the unit of a torque per speed; the default is the corrected form, the
printed one is the named form ``literal``.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees, radians
from typing import Any

import numpy as np
import sympy

from modelgen.errors import ModelError
from modelgen.gears import mesh_stiffness_rows
from modelgen.model import Choice, Clock, Derived, Element, Flange, Modes, Orders, Param, PeriodicTable, harmonic_rows, quantity
from modelgen.model.declarations import UNIT_AREA, FlangeSymbols

FOURIER, TABLE, RECTANGULAR, GEOMETRY = ({"mesh": form} for form in ("fourier", "table", "rectangular", "geometry"))
DEFAULT_ORDERS = tuple(range(1, 11))


def rows_from_geometry(stiffness_orders: tuple[int, ...], **geometry: float) -> list[float]:
    """Mean, cosine rows and sine rows [N/m] of the mesh stiffness that follows from the teeth (Eq. 1-9)."""
    orders = stiffness_orders or DEFAULT_ORDERS
    teeth = {
        f"{name}_{end}": geometry.pop(f"{name}_{letter}")
        for name in ("teeth", "profile_shift")
        for end, letter in ((1, "a"), (2, "b"))
    }
    teeth.update(teeth_1=int(teeth["teeth_1"]), teeth_2=int(teeth["teeth_2"]))
    mean, cosine, sine = mesh_stiffness_rows(order=max(orders), **teeth, **geometry)  # type: ignore[arg-type]  # names are its own
    return [mean, *(cosine[n - 1] for n in orders), *(sine[n - 1] for n in orders)]


def base_circles(pressure_angle: float) -> tuple[float, ...]:
    """Nothing, for a pressure angle at which a gear has a base circle. Raises ModelError for others."""
    if 0 < pressure_angle < radians(89):
        return ()
    problem = f"its pressure angle is {degrees(pressure_angle):.6g} deg, at which a gear has no base circle"
    raise ModelError("gear_pair", problem, "give an angle of some 14 to 30 deg, with its unit")


def lowest_stiffness(
    stiffness_orders: tuple[int, ...], mean_stiffness: float, stiffness_cosine: Any, stiffness_sine: Any
) -> tuple[float, ...]:
    """Nothing, for rows whose sum is positive over the whole mesh period. Raises ModelError with the least value for others."""
    count = max(len(stiffness_cosine), len(stiffness_sine))
    if mean_stiffness > sum(map(abs, (*stiffness_cosine, *stiffness_sine))):
        return ()
    orders = np.array(stiffness_orders or range(1, count + 1))[:count]
    rows = [np.pad(np.asarray(each, dtype=float), (0, count - len(each))) for each in (stiffness_cosine, stiffness_sine)]
    amplitude = rows[0] - 1j * rows[1]

    def at(phase: Any) -> Any:
        return mean_stiffness + (amplitude @ np.exp(1j * np.outer(orders, phase))).real

    phases = np.linspace(0, 2 * np.pi, 64 * int(orders.max()) + 1)
    for _ in range(8):  # ever closer to the least value
        best = phases[int(np.argmin(at(phases)))]
        width = phases[1] - phases[0]
        phases = np.linspace(best - width, best + width, 33)
    least = float(at(np.array([best]))[0])
    if least > 0:
        return ()
    turn = best / (2 * np.pi) % 1.0
    problem = f"its mesh stiffness falls to {least:.6g} N/m at {turn:.4f} of the mesh period"
    raise ModelError("gear_pair", problem, "make the rows smaller or the mean larger: a mesh pushes back at every angle")


class GearPair(Element):
    """Two gears in mesh along the line of action, a driving b when torque flows forward.

    Equations: delta = r_a angle_a - r_b angle_b - e(t); F = k(t) f(delta) + c(t) d(delta)/dt with
    f = delta - b, 0 or delta + b beyond, within and behind the backlash 2 b; torques -r_a F on a and +r_b F on b.
    Mesh stiffness k(t), with t = 0 where a tooth pair enters contact: Fourier rows (``mesh="fourier"``), samples over one mesh
    period joined by straight lines (``table``), two levels (``rectangular``), or rows that follow from the teeth (``geometry``).
    Mesh damping: ``corrected`` c = 2 xi sqrt(k m_e), m_e = J_a J_b / (J_a r_b^2 + J_b r_a^2); ``literal`` as the paper prints it.
    Its viscous part acts always, or with ``viscous="contact_only"`` in contact only and without pulling the flanks together.
    Modes ``flank``: the driving flanks touch (``drive``), the back ones (``coast``), or none (``free``).
    """

    sense = -1

    a, b = Flange("driving gear"), Flange("driven gear")
    contact = Clock("a", order="teeth_a", doc="tooth passing")
    teeth_a = Param(positive=True, integer=True, doc="teeth of the gear on a")
    teeth_b = Param(positive=True, integer=True, doc="teeth of the gear on b")
    radii = Choice("module", "given", doc="whether base radii follow from the module or are given")
    module = Param("m", positive=True, when={"radii": "module"}, doc="module")
    pressure_angle = Param("rad", default=radians(20), positive=True, when={"radii": "module"}, doc="pressure angle")
    has_base_circles = Derived("m", base_circles, of=("pressure_angle",), count=lambda self: 0, when={"radii": "module"})
    base_radius_a = Param("m", positive=True, when={"radii": "given"}, doc="base radius on a; that on b follows from the teeth")

    mesh = Choice("fourier", "table", "rectangular", "geometry", doc="form of the mesh stiffness over one mesh period")
    mean_stiffness = Param("N/m", positive=True, when=FOURIER, doc="k0")
    stiffness_cosine = Param("N/m", default=(), series=True, when=FOURIER, doc="rows with cosine, order 1, 2, ...")
    stiffness_sine = Param("N/m", default=(), series=True, when=FOURIER, doc="rows with sine, order 1, 2, ...")
    stiffness_orders = Orders(
        when={"mesh": ("fourier", "geometry")}, doc="harmonics of the mesh frequency; from the teeth, 1 to 10"
    )
    stays_positive = Derived(
        "N/m",
        lowest_stiffness,
        of=("stiffness_orders", "mean_stiffness", "stiffness_cosine", "stiffness_sine"),
        count=lambda self: 0,
        when=FOURIER,
    )
    stiffness_table = Param("N/m", positive=True, series=True, when=TABLE, doc="equally spaced samples over one mesh period")
    stiffness_high = Param("N/m", positive=True, when=RECTANGULAR, doc="stiffness while two pairs are in contact")
    stiffness_low = Param("N/m", positive=True, when=RECTANGULAR, doc="stiffness while one pair is in contact")
    contact_ratio = Param(positive=True, least=1.0, largest=2.0, when=RECTANGULAR, doc="contact ratio, between 1 and 2")
    face_width = Param("m", positive=True, when=GEOMETRY, doc="face width")
    young_modulus = Param("Pa", default=206e9, positive=True, when=GEOMETRY, doc="Young's modulus")
    poisson_ratio = Param(default=0.3, nonnegative=True, when=GEOMETRY, doc="Poisson's ratio")
    shear_factor = Param(default=1.0, positive=True, when=GEOMETRY, doc="1 as in Eq. 5, 1.2 for Timoshenko's rectangle")
    profile_shift_a = Param(default=0.0, when=GEOMETRY, doc="profile shift coefficient on a")
    profile_shift_b = Param(default=0.0, when=GEOMETRY, doc="profile shift coefficient on b")
    geometry_rows = Derived(
        "N/m",
        rows_from_geometry,
        of=(
            "stiffness_orders", "teeth_a", "teeth_b", "module", "face_width", "pressure_angle", "young_modulus", "poisson_ratio",
            "shear_factor", "profile_shift_a", "profile_shift_b",
        ),
        count=lambda self: 1 + 2 * len(self.stiffness_orders or DEFAULT_ORDERS),
        when=GEOMETRY,
        doc="mean, cosine rows, sine rows from the teeth",
    )  # fmt: skip

    damping = Choice("corrected", "literal", "value", doc="form of the mesh damping")
    damping_ratio = Param(default=0.0, nonnegative=True, when={"damping": ("corrected", "literal")}, doc="xi")
    damping_coefficient = Param("N*s/m", nonnegative=True, when={"damping": "value"}, doc="c along the line of action")
    viscous = Choice("always", "contact_only", doc="whether the viscous force acts without contact")
    error_mean = Param("m", default=0.0, doc="e0")
    error_amplitude = Param("m", default=0.0, doc="e_r of e(t) = e0 + e_r sin(w_m t + phase)")
    error_phase = Param("rad", default=0.0, doc="phase of the mesh error")
    half_backlash = Param("m", default=0.0, nonnegative=True, doc="b, half the backlash along the line of action")

    # The force of flanks that meet with a damper between them begins with a jump; without it the law has a kink only.
    flank = Modes("free", "drive", "coast", continuous={"viscous": "always"}, doc="which flanks touch")

    @quantity("m")
    def radius_a(self) -> Any:
        """Base radius of the gear on a."""
        return self.base_radius_a if self.radii == "given" else self.module * self.teeth_a * sympy.cos(self.pressure_angle) / 2

    @quantity("m")
    def radius_b(self) -> Any:
        """Base radius of the gear on b: the base pitches are equal."""
        # Written with the module where there is one: then the ratio of the radii reduces to that of the teeth, exactly.
        if self.radii == "given":
            return self.base_radius_a * self.teeth_b / self.teeth_a
        return self.module * self.teeth_b * sympy.cos(self.pressure_angle) / 2

    def _mean_stiffness(self) -> Any:
        if self.mesh == "fourier":
            return self.mean_stiffness
        if self.mesh == "geometry":
            return self.geometry_rows[0]
        if self.mesh == "table":
            return sympy.Add(*self.stiffness_table) / len(self.stiffness_table)
        return self.stiffness_low + (self.contact_ratio - 1) * (self.stiffness_high - self.stiffness_low)

    @quantity("N/m", mean=_mean_stiffness)
    def mesh_stiffness(self) -> Any:
        """Mesh stiffness k(t)."""
        angle = self.contact.angle
        if self.mesh == "table":
            return PeriodicTable(angle / (2 * sympy.pi), *self.stiffness_table)
        if self.mesh == "rectangular":
            turns = angle / (2 * sympy.pi)
            high = turns - sympy.floor(turns) < self.contact_ratio - 1
            return sympy.Piecewise((self.stiffness_high, high), (self.stiffness_low, True))
        orders, cosine, sine = self.stiffness_orders, (), ()
        if self.mesh == "fourier":
            cosine, sine = self.stiffness_cosine, self.stiffness_sine
        else:
            orders = orders or DEFAULT_ORDERS
            cosine, sine = self.geometry_rows[1 : 1 + len(orders)], self.geometry_rows[1 + len(orders) :]
        rows = harmonic_rows(self.where, orders, cosine, sine)
        waves = [term for n, a, b in rows for term in (a * sympy.cos(n * angle), b * sympy.sin(n * angle))]
        return sympy.Add(self._mean_stiffness(), *waves)

    @quantity("N*s/m")
    def mesh_damping(self) -> Any:
        """Mesh damping c(t); in the literal form its unit is that of the printed equation."""
        if self.damping == "value":
            return self.damping_coefficient
        j_a, j_b, r_a, r_b = self.a.inertia, self.b.inertia, self.radius_a, self.radius_b
        if self.damping == "corrected":
            mass = j_a * j_b / (j_a * r_b**2 + j_b * r_a**2)
        else:
            # As printed; the unit area brings the unit to kg without changing the printed number.
            mass = j_a * j_b * r_a**2 * r_b**2 / (r_a**2 * j_a + r_b**2 * j_b) / UNIT_AREA**2
        return 2 * self.damping_ratio * sympy.sqrt(self.mesh_stiffness * mass)

    @quantity("m")
    def error(self) -> Any:
        """Mesh error e(t)."""
        return self.error_mean + self.error_amplitude * self._error_wave(sympy.sin)

    @quantity("m/s")
    def error_rate(self) -> Any:
        """Time derivative of the mesh error."""
        return self.error_amplitude * self.contact.frequency * self._error_wave(sympy.cos)

    def _error_wave(self, wave: Any) -> Any:
        angle, phase = self.contact.angle, self.error_phase
        shifted = sympy.cos if wave is sympy.sin else sympy.sin
        sign = 1 if wave is sympy.sin else -1
        return wave(angle) * sympy.cos(phase) + sign * shifted(angle) * sympy.sin(phase)

    @quantity("m")
    def approach(self) -> Any:
        """Relative displacement along the line of action, without the error."""
        return self.radius_a * self.a.angle - self.radius_b * self.b.angle

    @quantity("m")
    def deflection(self) -> Any:
        """Mesh deflection delta."""
        return self.approach - self.error

    @quantity("m/s")
    def deflection_rate(self) -> Any:
        """Rate of the mesh deflection."""
        return self.radius_a * self.a.speed - self.radius_b * self.b.speed - self.error_rate

    @quantity("m")
    def penetration(self) -> Any:
        """Backlash function f(delta): how far the flanks are pressed into each other."""
        delta, gap = self.deflection, self.half_backlash
        if self.viscous == "contact_only":
            # Flanks that part with the force that has come to zero are pressed into each other still, and swing back freely.
            return sympy.Piecewise((delta - gap, delta >= gap), (delta + gap, delta <= -gap), (0, True))
        return self.flank.drive * (delta - gap) + self.flank.coast * (delta + gap)

    def _contact_force(self, penetration: Any) -> Any:
        return self.mesh_stiffness * penetration + self.mesh_damping * self.deflection_rate

    @quantity("N")
    def force(self) -> Any:
        """Mesh force along the line of action, positive on the driving flank."""
        if self.viscous == "always":
            return self._contact_force(self.penetration)
        delta, gap = self.deflection, self.half_backlash
        return self.flank.drive * self._contact_force(delta - gap) + self.flank.coast * self._contact_force(delta + gap)

    def regions(self) -> Mapping[sympy.Symbol, Any]:
        # The border belongs to the contact: without backlash the slope at rest is that of the mesh, not of a gap of no width.
        drive, coast = self.deflection - self.half_backlash, -self.deflection - self.half_backlash
        if self.viscous == "contact_only":
            # Flanks touch and push: the lesser of both is the depth, or the force per stiffness where the damper would pull.
            pull = self.mesh_damping * self.deflection_rate / self.mesh_stiffness
            drive, coast = drive + sympy.Min(0, pull), coast + sympy.Min(0, -pull)
        return {self.flank.drive: drive, self.flank.coast: coast}

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.a: -self.radius_a * self.force, self.b: self.radius_b * self.force}

    def stored_energy(self) -> Any:
        return self.mesh_stiffness * self.penetration**2 / 2

    def dissipated_power(self) -> Any:
        return (self.force - self.mesh_stiffness * self.penetration) * self.deflection_rate

    def supplied_power(self) -> Any:
        # The prescribed error does work against the viscous force; against the elastic one it is in the stored energy.
        return -(self.force - self.mesh_stiffness * self.penetration) * self.error_rate
