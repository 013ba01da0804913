"""The language: elements, their declarations, drivelines and model files. The first stage of the flow."""

from modelgen.model.declarations import Choice, Clock, Derived, Flange, Orders, Param, State, quantity
from modelgen.model.driveline import Driveline
from modelgen.model.element import Element, harmonic_rows
from modelgen.model.modes import Guard, Modes, Multiplier
from modelgen.model.named import BaseFrequency, NamedParameter
from modelgen.model.tables import PeriodicTable
from modelgen.model.values import Shared

__all__ = [
    "BaseFrequency",
    "Choice",
    "Clock",
    "Derived",
    "Driveline",
    "Element",
    "Flange",
    "Guard",
    "Modes",
    "Multiplier",
    "NamedParameter",
    "Orders",
    "Param",
    "PeriodicTable",
    "Shared",
    "State",
    "harmonic_rows",
    "quantity",
]
