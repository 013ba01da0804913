"""A symbolic-to-numeric model compiler for drivelines.

``Driveline -> Equations -> Compiled`` + ``Case -> Solution -> Result -> Figure``. Names are imported when first used, so that
``import modelgen`` is quick.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "model": (
        "BaseFrequency Choice Clock Derived Driveline Element Flange Guard Modes Multiplier NamedParameter Orders Param "
        "PeriodicTable Shared State harmonic_rows quantity"
    ),
    "model.files": "read_model write_model",
    "drivelines": "catalogue load",
    "elements": (
        "Brake ElasticStop GearPair GroundDamper GroundSpring HardStop HarmonicTorque Inertia RigidGear Shaft SteppedTorque"
    ),
    "equations": "Equations assemble system",
    "lowering": "Compiled Section lower",
    "solvers": "SOLVERS BoundModel Budget Case Outcome Solution bind crosscheck operating_point simulate",
    "analysis": (
        "angles bifurcation campbell classify forced frequency_sweep gear_hammer lyapunov_exponents modal "
        "operating_map periodic_orbit phase_vectors poincare sensitivities settled settled_window sweep"
    ),
    "plots": "draw plot save",
    "reports.run": "run",
    "errors": "BalanceError CaseError LoweringError ModelError ModelFileError ModelgenError NamingError UnitError",
}
_WHERE = {name: f"modelgen.{home}" for home, names in _HOME.items() for name in names.split()}

__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        return getattr(importlib.import_module(_WHERE[name]), name)
    raise AttributeError(f"module 'modelgen' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
