"""Laws that ask Python or NumPy for numbers: one sentence that says what to write in their place."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from modelgen import Driveline, Inertia, assemble
from modelgen.errors import ModelError
from modelgen.model import Element, Flange, Param

CASES: list[tuple[Callable[[Any], Any], str]] = [
    (lambda u: np.sin(u), r"calls numpy.sin where a law has symbols, not numbers; write sympy.sin"),
    (lambda u: np.arctan(u), r"calls numpy.arctan where a law has symbols, not numbers; write sympy.atan"),
    (lambda u: math.sin(u), r"asks for a number where a law has symbols, not numbers; write the function of that name in sympy"),
    (lambda u: u if u > 0 else 0, r"decides with if, .* where a law has symbols, not numbers; write sympy.Piecewise"),
    (lambda u: max(0, u), r"decides with .*max.*; write sympy.Piecewise or sympy.Max"),
    (lambda u: np.where(u > 0, u, 0), r"decides with"),
]


@pytest.fixture(autouse=True)
def _kinds_as_before() -> Iterator[None]:
    known = dict(Element.vocabulary)
    yield
    Element.vocabulary.clear()
    Element.vocabulary.update(known)


def line_with(law: Callable[[Any], Any]) -> Driveline:
    def torques(self: Any) -> Any:
        torque = self.k * law(self.a.angle - self.b.angle)
        return {self.a: -torque, self.b: torque}

    kind = type("Curved", (Element,), {"a": Flange(), "b": Flange(), "k": Param("N*m"), "torques": torques})
    disks = [Inertia("m", inertia=2.0), Inertia("n", inertia=3.0)]
    return Driveline("line", elements=[*disks, kind("q", "m", "n", k=1.0)])


@pytest.mark.parametrize(("law", "words"), CASES)
def test_a_law_that_wants_numbers_is_one_sentence(law: Callable[[Any], Any], words: str) -> None:
    with pytest.raises(ModelError, match=r"^curved 'q': <lambda>\(\) " + words):
        assemble(line_with(law))


def test_any_other_mistake_is_the_authors_own() -> None:
    with pytest.raises(TypeError, match="has no len"):
        assemble(line_with(len))
