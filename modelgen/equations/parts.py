"""Every element as a part of its driveline: its template, which elements share, its symbols, and the nodes of its flanges.

Part of the grammar; the steps of ``modelgen.equations.assembly`` after the parameters pass these records along.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from modelgen.equations.parameter_table import Symbols
from modelgen.equations.records import Template
from modelgen.equations.template import build_template, template_key
from modelgen.model import Element


@dataclass(frozen=True)
class Part:
    """An element with its law: ``symbols`` maps those of the template to the driveline's, ``nodes`` its flanges to nodes."""

    element: Element
    index: int
    template: Template
    names_in_laws: frozenset[str]
    symbols: Symbols
    nodes: Mapping[str, int]

    @property
    def name(self) -> str:
        return self.element.name

    @property
    def where(self) -> str:
        return self.element.where


class TemplateTable:
    """The templates of a driveline; elements whose laws are the same share one."""

    def __init__(self, elements: Sequence[Element]) -> None:
        self.templates: list[Template] = []
        self.indices: list[int] = []
        index_of: dict[Any, int] = {}
        for element in elements:
            key = template_key(element)
            if key not in index_of:
                index_of[key] = len(self.templates)
                self.templates.append(build_template(element))
            self.indices.append(index_of[key])

    @property
    def senses(self) -> list[int]:
        """Sense of rotation of each element."""
        return [self.templates[index].sense for index in self.indices]

    def parts(self, elements: Sequence[Element], symbols: Sequence[Symbols], node_of: Mapping[str, int]) -> list[Part]:
        """The elements with their templates; ``node_of`` gives the node of ``element.flange``."""
        names = [frozenset(_names_in_laws(template)) for template in self.templates]
        parts = []
        for element, index, table in zip(elements, self.indices, symbols, strict=True):
            template = self.templates[index]
            nodes = {flange: node_of[f"{element.name}.{flange}"] for flange in template.flanges}
            parts.append(Part(element, index, template, names[index], table, nodes))
        return parts


def _names_in_laws(template: Template) -> set[str]:
    """Names of all symbols in the laws of a template; those of a clock also where only its harmonics are left."""
    laws: list[sympy.Expr] = [each.expression for each in template.definitions]
    laws += [*template.torques.values(), *template.rates.values()]
    laws += [template.stored_energy, template.dissipated_power, template.supplied_power]
    laws += [region for modes in template.modes for region in modes.regions.values()] + [hold.speed for hold in template.holds]
    for guard in template.guards:
        laws += [guard.expression, *(law for reset in guard.resets for law in (reset.present, reset.value))]
    names = {symbol.name for law in laws for symbol in law.free_symbols}
    return names | {f"{harmonic.clock}.angle" for harmonic in template.harmonics}
