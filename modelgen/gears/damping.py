"""Mesh damping (Eq. 10), as corrected and as printed.

Works on plain numbers and arrays; the stiffness comes from ``mesh`` or from its Fourier series.

A mesh is a spring between two inertias seen along the line of action. Its equivalent mass is
m_e = J1 J2 / (J1 r_b2^2 + J2 r_b1^2), and damping of a fraction xi of critical is c_m = 2 xi sqrt(k_m m_e) [N s/m]:
``corrected``. The printed Eq. 10 has J1 J2 r_b1^2 r_b2^2 / (r_b1^2 J1 + r_b2^2 J2) [kg m^4] under the root. Its c is then in
N m s/rad, which is no force per velocity, and each inertia stands beside its own radius instead of the other one's:
``literal``, kept to reproduce the paper, 69 to 174 times smaller in number on the fracturing truck's gears.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, ModelError, nearest
from modelgen.gears.bounds import bounded


def equivalent_mass(inertia_1: float, inertia_2: float, base_radius_1: float, base_radius_2: float) -> float:
    """m_e = J1 J2 / (J1 r_b2^2 + J2 r_b1^2) [kg] of two gears along the line of action; J [kg m^2], r_b [m].

    >>> equivalent_mass(2.0, 2.0, 1.0, 1.0)
    1.0
    """
    return inertia_1 * inertia_2 / (inertia_1 * base_radius_2**2 + inertia_2 * base_radius_1**2)


def _printed_inertia(inertia_1: float, inertia_2: float, base_radius_1: float, base_radius_2: float) -> float:
    """J1 J2 r_b1^2 r_b2^2 / (r_b1^2 J1 + r_b2^2 J2) [kg m^4], the fraction in Eq. 10 as printed."""
    squared_1, squared_2 = base_radius_1**2, base_radius_2**2
    return inertia_1 * inertia_2 * squared_1 * squared_2 / (squared_1 * inertia_1 + squared_2 * inertia_2)


_UNDER_THE_ROOT: dict[str, Callable[[float, float, float, float], float]] = {
    "corrected": equivalent_mass,
    "literal": _printed_inertia,
}


def mesh_damping(
    stiffness: NDArray[np.float64] | float,
    inertia_1: float,
    inertia_2: float,
    base_radius_1: float,
    base_radius_2: float,
    damping_ratio: float = 0.1,
    form: str = "corrected",
) -> NDArray[np.float64]:
    """c_m [N s/m] for a mesh stiffness k_m [N/m], in its shape: 2 xi sqrt(k_m times the fraction of the form).

    ``damping_ratio`` is 0.03 to 0.17 in practice and 0.1 in the paper. Raises CaseError for an unknown form, ModelError for
    numbers that are not physical.

    >>> float(mesh_damping(100.0, 2.0, 2.0, 1.0, 1.0, damping_ratio=0.05))
    1.0
    """
    where = "mesh damping"
    if form not in _UNDER_THE_ROOT:
        raise CaseError(where, f"there is no form {form!r}", nearest(str(form), _UNDER_THE_ROOT))
    bounded(damping_ratio, "damping_ratio", where, at_least=0, at_most=10)
    fraction = _UNDER_THE_ROOT[form](
        bounded(inertia_1, "inertia_1", where, "kg*m^2", at_least=1e-15, at_most=1e15),
        bounded(inertia_2, "inertia_2", where, "kg*m^2", at_least=1e-15, at_most=1e15),
        bounded(base_radius_1, "base_radius_1", where, "m", at_least=1e-6, at_most=1e3),
        bounded(base_radius_2, "base_radius_2", where, "m", at_least=1e-6, at_most=1e3),
    )
    stiffness = np.asarray(stiffness, dtype=float)
    lowest = float(np.min(stiffness, initial=math.inf))
    if not (lowest >= 0 and np.all(np.isfinite(stiffness))):
        raise ModelError(where, f"stiffness is {lowest:g} N/m at its lowest", "give finite values >= 0")
    return 2 * damping_ratio * np.sqrt(stiffness * fraction)
