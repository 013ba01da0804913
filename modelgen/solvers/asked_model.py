"""What a linear question is asked of: a compiled model, or a case, whose model holds the case's own values.

Part of ``solvers``, beside ``case``; the questions of ``analysis`` begin with it.
"""

from __future__ import annotations

from typing import Any

from modelgen.errors import CaseError, refuse_unless
from modelgen.lowering import Compiled
from modelgen.solvers.case import Case


def asked_model(asked: Any, question: str) -> Compiled:
    """The model of a case, with the parameters of the case, or the model itself. Raises CaseError for anything else.

    >>> asked_model("a text", "modal")
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: modal: is asked of str, not of Compiled; give lower(assemble(line))
    """
    if isinstance(asked, Case):
        if asked.model is None:
            remedy = "a loaded case cites its model only; give it the driveline"
            raise CaseError(question, "the case has no compiled model", remedy)
        return asked.model
    refuse_unless(asked, Compiled, question)
    model: Compiled = asked
    return model
