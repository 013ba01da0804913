"""What a law may not do with its symbols: ask NumPy or ``math`` for a number, or Python for a decision.

Below ``template``. A law is written once, with symbols; NumPy's functions and Python's ``if`` want numbers, and end in a
TypeError that speaks of neither. Here it becomes a sentence that says what to write.
"""

from __future__ import annotations

import re
import traceback

from modelgen.errors import ModelError

_REMEDIES = (
    (re.compile(r"truth value|relational|Relational"), "decides with if, and, or, max or min", "sympy.Piecewise or sympy.Max"),
    (re.compile(r"no callable (?P<name>\w+) method"), "calls numpy.{name}", "sympy.{name}"),
    (re.compile(r"loop of ufunc|ufunc '(?P<name>\w+)'"), "calls NumPy", "the function of that name in sympy"),
    (re.compile(r"[Cc]annot convert expression to (float|int)"), "asks for a number", "the function of that name in sympy"),
)
_OURS = re.compile(r"[/\\](sympy|numpy|mpmath)[/\\]")


def law_refused(where: str, error: TypeError) -> ModelError | None:
    """The refusal of a law that treats its symbols as numbers; None for any other mistake, which is the author's own to read."""
    for pattern, does, instead in _REMEDIES:
        if found := pattern.search(str(error)):
            numpy_name = found.groupdict().get("name") or ""
            sympy_name = re.sub("^arc", "a", numpy_name)
            frames = [each for each in traceback.extract_tb(error.__traceback__) if not _OURS.search(each.filename)]
            law = f"{frames[-1].name}() {does.format(name=numpy_name)}" if frames else f"a law {does}"
            return ModelError(where, f"{law} where a law has symbols, not numbers", f"write {instead.format(name=sympy_name)}")
    return None
