"""The language: elements, their declarations, drivelines and model files. The first stage of the flow."""

from modelgen.model.declarations import Choice, Clock, Derived, Flange, Guard, Orders, Param, State, quantity
from modelgen.model.driveline import BaseFrequency, Driveline, NamedParameter
from modelgen.model.element import Element, Shared, harmonic_rows
from modelgen.model.tables import PeriodicTable

__all__ = [
    "BaseFrequency",
    "Choice",
    "Clock",
    "Derived",
    "Driveline",
    "Element",
    "Flange",
    "Guard",
    "NamedParameter",
    "Orders",
    "Param",
    "PeriodicTable",
    "Shared",
    "State",
    "harmonic_rows",
    "quantity",
]
