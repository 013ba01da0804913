"""What a question about motion is asked of: a case, or a model, of which a case is then made.

Part of ``solvers``, beside ``bound_model``. A question that decides by itself how long it runs takes any model that ``bind``
takes.
"""

from __future__ import annotations

from typing import Any

from modelgen.solvers.bound_model import compiled_of
from modelgen.solvers.case import Case

UNUSED = 1.0  # s: the end of a case whose question runs as long as it needs


def asked_case(x: Any, question: str, defaults: dict[str, Any] | None = None, **settings: Any) -> Case:
    """The case that a question is asked of, with the ``settings`` that are not None in place of its own.

    Of anything but a case one is made, with the ``defaults`` where ``settings`` say nothing. Raises CaseError for what is no
    model, and for a case without one.

    >>> asked_case("two-disk-gear", "poincare", {"tolerance": 1e-7}).tolerance
    1e-07
    """
    given = {name: value for name, value in settings.items() if value is not None}
    model = compiled_of(x, question)
    if isinstance(x, Case):
        return x.change(**given) if given else x
    return Case(model, **{"end": UNUSED, **(defaults or {}), **given})
