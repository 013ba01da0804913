"""An element that nobody would hear: methods with nearly the right name, and elements that answer nothing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from modelgen.errors import ModelError, NamingError
from modelgen.model import Element, Flange, Param, quantity


@pytest.fixture(autouse=True)
def _kinds_as_before() -> Iterator[None]:
    known = dict(Element.vocabulary)
    yield
    Element.vocabulary.clear()
    Element.vocabulary.update(known)


def spring(self: Any) -> Any:
    return {self.a: -self.k * (self.a.angle - self.b.angle), self.b: self.k * (self.a.angle - self.b.angle)}


def defined(**methods: Any) -> type[Element]:
    return type("Odd", (Element,), {"a": Flange(), "b": Flange(), "k": Param("N*m/rad"), **methods})


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        *(("torque", "torques"), ("Torques", "torques"), ("inertia", "inertias"), ("constrain", "constraints")),
        *(("rate", "rates"), ("guard", "guards"), ("hold", "holds"), ("region", "regions")),
        *(("kinetic_energies", "kinetic_energy"), ("potential_energy", "stored_energy"), ("disipated_power", "dissipated_power")),
    ],
)
def test_a_misspelt_method_is_refused_with_the_nearest_name(written: str, meant: str) -> None:
    words = rf"element class Odd: defines {written}\(\), which nobody asks for; nearest is '{meant}'"
    with pytest.raises(NamingError, match=words):
        defined(**{written: spring})
    assert "odd" not in Element.vocabulary


def test_helpers_and_quantities_of_such_names_are_lawful() -> None:
    def torque(self: Any) -> Any:
        return self.k * (self.a.angle - self.b.angle)

    def torques(self: Any) -> Any:
        return {self.a: -self.torque(), self.b: self.torque()}

    assert defined(torque=torque, torques=torques)("x", "m", "n", k=1.0).kind == "odd"
    Element.vocabulary.pop("odd")
    assert defined(torque=quantity("N*m")(torque), torques=spring)("x", "m", "n", k=1.0).kind == "odd"


def test_a_base_class_without_answers_is_lawful_but_no_element_of_it() -> None:
    base = defined()
    with pytest.raises(ModelError, match=r"odd 'x': exerts nothing and does nothing; define torques\(\), inertias\(\)"):
        base("x", "m", "n", k=1.0)
    assert type("Heard", (base,), {"torques": spring})("x", "m", "n", k=1.0).kind == "heard"
