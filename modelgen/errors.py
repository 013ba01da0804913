"""The words of failure: every refusal says where, what was found, and what to do.

Stands above everything else: any package may raise these, none catches them silently.
A message reads ``where: problem; remedy`` so that it can be understood without a traceback.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any


class ModelgenError(Exception):
    """A refusal in one sentence: ``where: problem; remedy``.

    >>> raise ModelError("shaft 's'", "stiffness is -1 N*m/rad", "give a positive value")
    Traceback (most recent call last):
    ...
    modelgen.errors.ModelError: shaft 's': stiffness is -1 N*m/rad; give a positive value
    """

    def __init__(self, where: str, problem: str, remedy: str = "") -> None:
        self.where, self.problem, self.remedy = where, problem, remedy
        super().__init__(f"{where}: {problem}" + (f"; {remedy}" if remedy else ""))

    def __reduce__(self) -> tuple[type, tuple[str, str, str]]:
        # The default reduction would call the class with the joined message only, and a worker's error would be lost.
        return type(self), (self.where, self.problem, self.remedy)


class ModelError(ModelgenError):
    """The driveline as described cannot exist or cannot be solved."""


class ModelFileError(ModelError):
    """A model file cannot be read; ``where`` names the file and, if known, the line or table."""


class NamingError(ModelError):
    """A name is unlawful, already taken, or unknown."""


class UnitError(ModelError):
    """A unit is unknown, missing, or of the wrong dimension."""


class BalanceError(ModelError):
    """The mean torques do not balance, so the operating speed cannot be held."""


class LoweringError(ModelgenError):
    """A symbolic expression has no numeric counterpart."""


class CaseError(ModelgenError):
    """A request (case, option, argument, channel) cannot be carried out."""


class RunFailedError(ModelgenError):
    """A run that a question rests on did not reach its end."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C came after a part of a question was answered; ``result`` is that part, and says what is missing."""

    def __init__(self, result: Any) -> None:
        self.result = result
        super().__init__("interrupted; what was computed is the result of this exception")


_INSTEAD = {
    "Case": {"Equations": "Case(lower(equations), end=1.0)", "Compiled": "Case(model, end=1.0)", "": "Case(line, end=1.0)"},
    "Driveline": {"": "a Driveline, such as load(file)"},
    "Equations": {"Driveline": "assemble(line)", "": "assemble(line), or system(...)"},
    "Solution": {"Case": "simulate(case)", "": "simulate(Case(line, end=1.0))"},
    "OperatingPoint": {"": "operating_point(model)"},
    "Window": {"": "settled_window(model, point)"},
    "ForcedResult": {"": "forced(model, speeds)"},
}


def refuse_unless(given: Any, kind: type, question: str) -> None:
    """Raises CaseError unless a question is asked of what it can take; the remedy leads from what was given to that.

    >>> refuse_unless(3, dict, "modal")
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: modal: is asked of int, not of dict; give a dict
    """
    if not isinstance(given, kind):
        name = type(given).__name__
        ways = _INSTEAD.get(kind.__name__, {"": f"a {kind.__name__}"})
        raise CaseError(question, f"is asked of {name}, not of {kind.__name__}", f"give {ways.get(name, ways[''])}")


def nearest(name: str, known: Iterable[str]) -> str:
    """The remedy for an unknown name: the nearest known one, or the list when it is short.

    >>> nearest("shaft.tork", ["shaft.torque", "shaft.twist"])
    "nearest is 'shaft.torque'"
    """
    options = list(known)
    close = difflib.get_close_matches(name, options, n=1, cutoff=0.5)
    if close:
        return f"nearest is {close[0]!r}"
    if not options:
        return "there are none here"
    shown = ", ".join(options[:12]) + (", ..." if len(options) > 12 else "")
    return f"known are {shown}"
