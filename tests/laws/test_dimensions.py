"""Units agree: give any parameter that a law uses another unit, and the law is refused."""

from __future__ import annotations

import pytest

from modelgen.equations.template import build_template
from modelgen.errors import UnitError
from modelgen.model import Derived, Param, quantity


def used(element):
    """Declared names that the element's laws really use; the others may only feed a derived parameter."""
    law = build_template(element).law
    found = [*law["definitions"].values(), *law["torques"].values(), *law["inertias"].values(), *law["rates"].values()]
    found += [law["stored_energy"], law["dissipated_power"], law["supplied_power"], *element.constraints()]
    return {symbol for expression in found for symbol in getattr(expression, "free_symbols", ())}


def test_a_wrong_unit_of_any_parameter_is_refused(bench, monkeypatch):
    element, symbols = bench.element, used(bench.element)
    for name, param in element.declared(Param).items():
        length = element.lengths.get(name) if param.series else None
        if not param.exists(element.choices) or not symbols & set(param.symbols(length)):
            continue
        with monkeypatch.context() as patch:
            patch.setattr(param, "unit", "kg" if param.unit == "1" else f"{param.unit}*kg")
            with pytest.raises(UnitError, match=rf"^{element.where}: .*\[.*\].*"):
                build_template(element)


def test_a_wrong_unit_of_any_quantity_is_refused(bench, monkeypatch):
    declared = {**bench.element.declared(quantity), **bench.element.declared(Derived)}
    for each in declared.values():
        if isinstance(each, Derived) and (not each.exists(bench.element.choices) or each.count(bench.element) == 0):
            continue  # a check has no numbers, so no unit
        if isinstance(each, quantity) and each.law(bench.element) == 0:
            continue  # zero has every unit
        with monkeypatch.context() as patch:
            patch.setattr(each, "unit", f"{each.unit}*kg" if each.unit != "1" else "kg")
            with pytest.raises(UnitError, match=rf"^{bench.element.where}: .*\[.*\].*"):
                build_template(bench.element)
