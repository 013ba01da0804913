"""The questions that an element may answer, and the refusal of answers that nobody asks for.

Part of the language, below ``element``. A method named ``torque`` where ``torques`` is asked for would make an element that
exerts nothing, without a word; so a name that is nearly a question is refused when the class is defined, and an element without
any answer when it is made.
"""

from __future__ import annotations

import difflib
from types import FunctionType

from modelgen.errors import ModelError, NamingError

QUESTIONS = (
    *("torques", "inertias", "kinetic_energy", "constraints", "rates", "stored_energy", "dissipated_power", "supplied_power"),
    *("modal_damping", "regions", "guards", "holds"),
)
NEAR = 0.75
"""How alike (0 to 1) a method's name may be to a question before it counts as misspelt; torque and torques are 0.92."""
LONGER = {"energy": "stored_energy", "potential_energy": "stored_energy", "power": "dissipated_power"}
"""Names that are no slip of the pen, and still mean a question."""


def refuse_misspelt(cls: type, base: type) -> None:
    """Raises NamingError for a method of a class that is nearly a question which the class does not answer."""
    for name, value in vars(cls).items():
        if not isinstance(value, (FunctionType, staticmethod, classmethod)) or name.startswith("_") or hasattr(base, name):
            continue
        close = difflib.get_close_matches(name.lower(), QUESTIONS, n=1, cutoff=NEAR)
        meant = close[0] if close else LONGER.get(name.lower())
        # A helper of this name is lawful beside the answer itself.
        if meant and getattr(cls, meant) is getattr(base, meant):
            remedy = f"nearest is {meant!r}; a quantity is marked with @quantity(unit)"
            raise NamingError(f"element class {cls.__name__}", f"defines {name}(), which nobody asks for", remedy)


def refuse_idle(cls: type, base: type, where: str) -> None:
    """Raises ModelError for an element whose class answers no question: it exerts nothing and does nothing."""
    if all(getattr(cls, name) is getattr(base, name) for name in QUESTIONS):
        asked = "torques(), inertias(), constraints() or another of " + ", ".join(QUESTIONS[4:])
        raise ModelError(where, "exerts nothing and does nothing", f"define {asked}")
