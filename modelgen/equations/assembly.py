"""Driveline to Equations: parameters, nodes, groups, coordinates, clocks, outputs. The grammar's main sentence.

Element by element: each contributes torques to its nodes, nobody writes one big Lagrangian (a Lagrange derivation proves this
in the tests). Second stage of the flow: ``Driveline -> Equations``.
"""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import sympy

from modelgen.equations.dimensions import DimensionCheck
from modelgen.equations.records import (
    BaseClock,
    DerivedParameter,
    Equations,
    Form,
    Instance,
    Node,
    Output,
    Parameter,
    StateVariable,
    Step,
    Template,
)
from modelgen.equations.template import build_template, template_key
from modelgen.equations.topology import (
    Exact,
    check_connected,
    check_senses,
    join_flanges,
    place,
    reference_node,
    shaft_node,
    solve_ratio,
)
from modelgen.errors import ModelError, UnitError
from modelgen.model import Clock, Derived, Driveline, Element, Flange, Orders, Param, Shared
from modelgen.model.expressions import read_expression
from modelgen.model.values import check_value
from modelgen.units import dimension_of

SPEED = "speed"


def assemble(line: Driveline) -> Equations:
    """The equations of motion of a driveline. Raises ModelError, NamingError or UnitError where it cannot exist.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> print(assemble(line))  # doctest: +ELLIPSIS
    equations of 'two_disks': 2 degrees of freedom
      4 states: 1 rigid and 1 vibrating angles, their rates
      ...
    """
    return _Assembler(line).assemble()


class _Assembler:
    def __init__(self, line: Driveline) -> None:
        self.line, self.where = line, f"driveline {line.name!r}"
        if not line.elements:
            raise ModelError(self.where, "has no elements", "add inertias and what joins them")
        self.parameters: list[Parameter] = []
        self.derived: list[DerivedParameter] = []
        self.by_name: dict[str, Parameter] = {}
        self.templates: list[Template] = []
        self.template_of: dict[Any, int] = {}
        self.names_in_laws: list[set[str]] = []

    def assemble(self) -> Equations:
        line = self.line
        self._shared_parameters()
        elements = [self._with_lengths(element) for element in line.elements]
        local = [self._own_parameters(element) for element in elements]
        chosen = [self._template(element) for element in elements]
        self.exact = Exact({s: v for p in self.parameters for s, v in zip(p.symbols, p.values, strict=True)})
        flanges, node_of = join_flanges(line)
        check_connected(line, flanges, node_of)
        check_senses(elements, [self.templates[index].sense for index in chosen], node_of)
        reference = reference_node(line, node_of)
        self._groups(elements, chosen, local, flanges, node_of, reference)
        self._check_inertia(elements, chosen, node_of)
        forms, form_ids = self._forms(elements, chosen, local, node_of)
        placement = self._placement(forms, self.nodes[reference].group)
        return self._records(elements, chosen, local, node_of, forms, form_ids, placement)

    # -- parameters --------------------------------------------------------------------------------------------------------

    def _add(self, parameter: Parameter) -> None:
        self.parameters.append(parameter)
        self.by_name[parameter.name] = parameter

    def _shared_parameters(self) -> None:
        if self.line.speed is not None:
            symbol = sympy.Symbol(SPEED, positive=True)
            self._add(Parameter(SPEED, "rad/s", (symbol,), (self.line.speed,), positive=True))
        for name, named in self.line.parameters.items():
            values = named.value if isinstance(named.value, tuple) else (named.value,)
            symbols = tuple(_symbol(name, row if isinstance(named.value, tuple) else None) for row in range(1, len(values) + 1))
            self._add(Parameter(name, named.unit, symbols, values, isinstance(named.value, tuple), note=named.note))
        scalars = {p.name: p.symbols[0] for p in self.parameters if not p.series}
        units = {p.symbols[0]: dimension_of(p.unit) for p in self.parameters if not p.series}
        for index, parameter in enumerate(self.parameters):
            named_or_none = self.line.parameters.get(parameter.name)
            if named_or_none is None or named_or_none.expression is None:
                continue
            where = f"parameter {parameter.name!r}"
            expression = read_expression(named_or_none.expression, scalars, where)
            circular = {p.symbols[0] for p in self.parameters if self._has_expression(p.name)} & expression.free_symbols
            if circular:
                raise ModelError(
                    where, f"its expression uses {next(iter(circular))}, which is an expression too", "use plain parameters in it"
                )
            found = DimensionCheck(units, where).of(expression, "its expression")
            known = {s: v for p in self.parameters for s, v in zip(p.symbols, p.values, strict=True)}
            try:
                value = float(expression.xreplace({s: sympy.Float(known[s]) for s in expression.free_symbols}))
            except (TypeError, ValueError, ArithmeticError):
                value = math.nan
            if not math.isfinite(value):
                raise ModelError(where, "its expression has no finite real value", "check the parameters it uses")
            unit = parameter.unit
            if found is not None and found != dimension_of(unit):
                if unit != "1":
                    raise UnitError(
                        where, f"its expression has the dimension {found}", f"its unit is {unit} [{dimension_of(unit)}]"
                    )
                unit = str(found)
            new = Parameter(parameter.name, unit, parameter.symbols, (value,), expression=expression, note=parameter.note)
            self.parameters[index] = self.by_name[parameter.name] = new

    def _has_expression(self, name: str) -> bool:
        named = self.line.parameters.get(name)
        return named is not None and named.expression is not None

    def _with_lengths(self, element: Element) -> Element:
        """A copy that knows the lengths of series given by the driveline's parameters, so that its law can be written out."""
        element = copy.copy(element)
        element.lengths = dict(element.lengths)
        for key, value in element.values.items():
            named = self.line.parameter_of(element, key)
            if named is None:
                continue
            param = element.declared(Param)[key]
            series = isinstance(named.value, tuple)
            assert isinstance(value, Shared)
            where = f"{element.where}, {key}"
            if series != param.series:
                shape = ("a series", "one number") if series else ("one number", "a series")
                raise ModelError(where, f"parameter {value.name!r} is {shape[0]}", f"{shape[1]} is asked for")
            if series:
                element.lengths[key] = len(named.value)  # type: ignore[arg-type]  # a tuple where it is a series
        return element

    def _own_parameters(self, element: Element) -> dict[sympy.Symbol, sympy.Symbol]:
        """The element's parameters in the driveline's table; returns template symbol -> driveline symbol."""
        table: dict[sympy.Symbol, sympy.Symbol] = {}
        names: dict[str, str] = {}
        for key, value in element.values.items():
            param = element.declared(Param)[key]
            local = param.symbols(element.lengths.get(key) if param.series else None)
            if isinstance(value, Shared):
                shared = self.by_name[value.name]
                where = f"{element.where}, {key}"
                if dimension_of(shared.unit) != dimension_of(param.unit):
                    raise UnitError(where, f"parameter {value.name!r} is in {shared.unit}", f"{param.unit} is asked for")
                if ("Hz" in shared.unit) != ("Hz" in param.unit):  # their numbers differ by 2 pi
                    raise UnitError(where, f"parameter {value.name!r} is in {shared.unit}", f"{param.unit} is asked for")
                for entry in shared.values:
                    check_value(entry, param, f"{where}, parameter {value.name!r}")
                self._limit(shared, param)
                table.update(zip(local, shared.symbols, strict=True))
                names[key] = value.name
                continue
            name = f"{element.name}.{key}"
            values = value if isinstance(value, tuple) else (value,)
            symbols = tuple(_symbol(name, row if param.series else None, param) for row in range(1, len(values) + 1))
            limits: dict[str, Any] = {"positive": param.positive, "nonnegative": param.nonnegative, "integer": param.integer}
            self._add(Parameter(name, param.unit, symbols, values, param.series, **limits))
            table.update(zip(local, symbols, strict=True))
            names[key] = name
        for key, derived in element.declared(Derived).items():
            if not derived.exists(element.choices):
                continue
            local = derived.symbols(element)
            name = f"{element.name}.{key}"
            symbols = tuple(_symbol(name, row) for row in range(1, len(local) + 1))
            missing = [of for of in derived.of if of not in names and of not in element.declared(Orders)]
            if missing:
                raise ModelError(
                    element.where, f"{key} follows from {missing[0]}, which its switches leave out", "change the switches"
                )
            arguments = {of: names[of] if of in names else getattr(element, of) for of in derived.of}
            self.derived.append(DerivedParameter(name, derived.unit, symbols, derived.function, arguments))
            table.update(zip(local, symbols, strict=True))
        return table

    def _limit(self, shared: Parameter, param: Param) -> None:
        """A shared parameter must stay lawful for every element that uses it."""
        limits = {key: getattr(shared, key) or getattr(param, key) for key in ("positive", "nonnegative", "integer")}
        self.by_name[shared.name] = replace(shared, **limits)
        self.parameters[self.parameters.index(shared)] = self.by_name[shared.name]

    def _template(self, element: Element) -> int:
        key = template_key(element)
        if key not in self.template_of:
            self.template_of[key] = len(self.templates)
            self.templates.append(build_template(element))
            self.names_in_laws.append(_names_in_laws(self.templates[-1]))
        return self.template_of[key]

    # -- nodes and groups ----------------------------------------------------------------------------------------------------

    def _groups(self, elements: Any, chosen: Any, local: Any, flanges: Any, node_of: Any, reference: int) -> None:
        """Groups of nodes that rigid constraints join, with the ratio of each node to its group (1 for the reference shaft)."""
        constraints = []
        for element, index, table in zip(elements, chosen, local, strict=True):
            for row in self.templates[index].constraints:
                terms: dict[int, sympy.Expr] = {}
                for flange, c in row.items():
                    node = node_of[f"{element.name}.{flange}"]
                    terms[node] = terms.get(node, sympy.Integer(0)) + c.xreplace(table)
                constraints.append((element, terms))
        placement = place(len(flanges), [terms for _, terms in constraints], reference)
        roots = {group: sympy.Integer(1) for group, index in placement.steps if index is None}
        ratio = solve_ratio(placement.steps, [terms for _, terms in constraints], roots)
        group_of: dict[int, int] = {}
        for node, index in placement.steps:
            if index is None:
                group_of[node] = len(set(group_of.values()))
            else:
                others = [other for other in constraints[index][1] if other != node]
                if not others:
                    raise ModelError(
                        constraints[index][0].where, "its constraint fixes one node to ground", "use a ground spring"
                    )
                group_of[node] = group_of[others[0]]
        for index in placement.dependent:
            element, terms = constraints[index]
            total = sympy.Add(*(c * ratio[node] for node, c in terms.items()))
            if not self.exact.vanishes(total, next(iter(terms.values()))):
                raise ModelError(
                    element.where, "closes a loop of rigid gears whose ratios do not agree", "check the tooth numbers on the loop"
                )
        inertial = {f"{e.name}.{f}" for e, i in zip(elements, chosen, strict=True) for f, _ in self.templates[i].mass}
        self.nodes = []
        order = {group: index for index, group in enumerate(dict.fromkeys(group_of[node] for node in range(len(flanges))))}
        for node, members in enumerate(flanges):
            named = next((name for name in members if name in inertial), members[0])
            name = named.split(".")[0] if len(self.line[named.split(".")[0]].declared(Flange)) == 1 else named
            self.nodes.append(Node(name, tuple(members), order[group_of[node]], ratio[node]))
        self.groups = [
            next(node.name for node in self.nodes if node.group == group and node.ratio == 1) for group in order.values()
        ]
        self.constraint_rows = [dict(terms) for _, terms in constraints]

    def _check_inertia(self, elements: Any, chosen: Any, node_of: Any) -> None:
        heavy = {
            self.nodes[node_of[f"{e.name}.{f}"]].group
            for e, i in zip(elements, chosen, strict=True)
            for f, g in self.templates[i].mass
            if f == g
        }
        for group, name in enumerate(self.groups):
            if group in heavy:
                continue
            node = next(node for node in self.nodes if node.group == group)
            raise ModelError(
                f"node {name!r}",
                f"has no inertia; it joins {', '.join(node.flanges)}",
                "put an Inertia on it, or merge the elements",
            )
        constant = {
            self.nodes[node_of[f"{e.name}.{f}"]].group
            for e, i in zip(elements, chosen, strict=True)
            for (f, g), x in self.templates[i].mass.items()
            if f == g and x.free_symbols <= {s for _, symbols in self.templates[i].parameters for s in symbols}
        }
        for element, index in zip(elements, chosen, strict=True):
            for flange in self.templates[index].flanges:
                node = self.nodes[node_of[f"{element.name}.{flange}"]]
                if node.group not in constant and f"{flange}.inertia" in self.names_in_laws[index]:
                    what = f"needs the inertia at its flange {flange!r}, but node {node.name!r} has none that is constant"
                    raise ModelError(element.where, what, "put an Inertia on it, or choose another form of damping")

    # -- relative angles and coordinates ---------------------------------------------------------------------------------------

    def _forms(self, elements: Any, chosen: Any, local: Any, node_of: Any) -> tuple[list[Form], list[tuple[int, ...]]]:
        forms: list[Form] = []
        ids: list[tuple[int, ...]] = []
        for element, index, table in zip(elements, chosen, local, strict=True):
            mine = []
            for relative in self.templates[index].relatives:
                terms: dict[int, sympy.Expr] = {}
                for flange, c in relative.coefficients.items():
                    node = self.nodes[node_of[f"{element.name}.{flange}"]]
                    terms[node.group] = terms.get(node.group, sympy.Integer(0)) + c.xreplace(table) * node.ratio
                if len(relative.coefficients) > 1 and len(terms) == 1:
                    if not self.exact.vanishes(next(iter(terms.values())), sympy.Integer(1)):
                        raise ModelError(
                            element.where, "joins two shafts that a rigid gear already joins", "take one of them out"
                        )
                    terms = {}
                mine.append(len(forms))
                forms.append(Form(f"{element.name}.{relative.name}", relative.unit, terms, relative.sees_angle))
            ids.append(tuple(mine))
        return forms, ids

    def _placement(self, forms: list[Form], first: int) -> Any:
        seen = [index for index, form in enumerate(forms) if form.sees_angle and form.coefficients]
        placement = place(len(self.groups), [forms[index].coefficients for index in seen], first)
        steps = [(group, None if index is None else seen[index]) for group, index in placement.steps]
        rows = [form.coefficients for form in forms]
        # Ratios count from the reference shaft and ignore ground, so that a locked driveline can still refer its angles.
        turning = [index for index, row in enumerate(rows) if len(row) > 1]
        loose = place(len(self.groups), [rows[index] for index in turning], first)
        loose_steps = [(group, None if index is None else turning[index]) for group, index in loose.steps]
        ones = {group: sympy.Integer(1) for group, index in loose_steps if index is None}
        self.ratios = [each for _, each in sorted(solve_ratio(loose_steps, rows, ones).items())]
        roots = {group: self.ratios[group] for group, index in steps if index is None}
        mean = solve_ratio(steps, rows, roots)
        for index in (seen[each] for each in placement.dependent):
            row = rows[index]
            total = sympy.Add(*(c * mean[group] for group, c in row.items()))
            if len(row) > 1 and not self.exact.vanishes(total, next(iter(row.values()))):
                name = forms[index].name.rpartition(".")[0]
                raise ModelError(
                    f"element {name!r}", "closes a loop whose gear ratios do not agree", "check the tooth numbers on the loop"
                )
        self.mean = [each for _, each in sorted(mean.items())]
        self.grounded = [bool(each == 0) for each in self.mean]
        return steps

    # -- the record -----------------------------------------------------------------------------------------------------------

    def _records(
        self, elements: Any, chosen: Any, local: Any, node_of: Any, forms: list[Form], form_ids: Any, steps: Any
    ) -> Equations:
        line = self.line
        states: list[StateVariable] = []
        records: list[Step] = []
        for group, index in steps:
            if index is None:
                name = line.reference if line.reference and not states else self.groups[group]
                states.append(StateVariable(f"{name}.angle_deviation", "rad", "rigid"))
            else:
                states.append(StateVariable(forms[index].name, forms[index].unit, "vibrating"))
                forms[index] = Form(forms[index].name, forms[index].unit, forms[index].coefficients, True, len(records))
            records.append(Step(group, len(records), index))
        states += [StateVariable(f"{s.name}_rate", f"{s.unit}/s", s.kind, is_rate=True) for s in states]
        clocks, clock_ids = self._clocks(elements, local, node_of)
        instances = []
        for element, index, table, ids, own_clocks in zip(elements, chosen, local, form_ids, clock_ids, strict=True):
            template = self.templates[index]
            own = tuple(range(len(states), len(states) + len(template.states)))
            states += [StateVariable(f"{element.name}.{k}", u, "own", start=x, scale=s) for k, _, u, x, s in template.states]
            nodes = {flange: node_of[f"{element.name}.{flange}"] for flange in template.flanges}
            instances.append(Instance(element.name, index, table, nodes, own_clocks, ids, own))
        rigid = self._rigid(elements, chosen, node_of, records)
        by_name = {parameter.name: parameter for parameter in self.parameters}
        return Equations(
            name=line.name,
            description=line.description,
            templates=tuple(self.templates),
            instances=tuple(instances),
            parameters=tuple(self.parameters),
            derived=tuple(self.derived),
            nodes=tuple(self.nodes),
            groups=tuple(self.groups),
            grounded=tuple(self.grounded),
            ratios=tuple(self.ratios),
            mean_speeds=tuple(self.mean),
            forms=tuple(forms),
            steps=tuple(records),
            clocks=tuple(clocks),
            states=tuple(states),
            outputs=tuple(self._outputs(elements, chosen)),
            rigid=rigid,
            reference=line.reference,
            speed=by_name[SPEED].symbols[0] if SPEED in by_name else None,
            modal_ratio=self._modal(elements, chosen),
            balanced=tuple(f"{name}.{line[name].balanced_by}" for name in line.balanced),
            drifts=line.drifts,
            constraints=tuple(self.constraint_rows),
            guards=tuple((e.name, guard) for e, i in zip(elements, chosen, strict=True) for guard in self.templates[i].guards),
            modes={},
            assemblies=dict(line.assemblies),
        )

    def _clocks(self, elements: Any, local: Any, node_of: Any) -> tuple[list[BaseClock], list[dict[str, int]]]:
        clocks: list[BaseClock] = []
        index: dict[str, int] = {}
        for name, base in self.line.bases.items():
            ratio = sympy.Integer(1)
            if base.shaft is not None:
                ratio = self._ratio(shaft_node(self.line, base.shaft, node_of, f"base frequency {name!r}, shaft"))
            index[name] = len(clocks)
            clocks.append(BaseClock(name, ratio * _rational(base.order)))
        found: list[dict[str, int]] = []
        used: set[str] = set()
        for element, table in zip(elements, local, strict=True):
            mine: dict[str, int] = {}
            for key, clock in element.declared(Clock).items():
                names = self.names_in_laws[self.template_of[template_key(element)]]
                runs = bool(names & {f"{key}.angle", f"{key}.frequency"})
                if clock.flange is None:
                    if runs or key in element.clocks:
                        mine[key] = index[self.line.clock_base(element, key)]
                        used |= {self.line.clock_base(element, key)} if runs else set()
                    continue
                order = clock.order
                factor = table[element.declared(Param)[order].symbol()] if isinstance(order, str) else _rational(Fraction(order))
                mine[key] = len(clocks)
                clocks.append(BaseClock(f"{element.name}.{key}", factor * self._ratio(node_of[f"{element.name}.{clock.flange}"])))
                used |= {clocks[-1].name} if runs else set()
            found.append(mine)
        if used and self.line.speed is None:
            first = ", ".join(repr(name) for name in sorted(used)[:3])
            raise ModelError(
                self.where, f"has base frequencies ({first}) but no operating speed", 'give speed="1500 rpm" and a reference'
            )
        return clocks, found

    def _ratio(self, node: int) -> sympy.Expr:
        return self.ratios[self.nodes[node].group] * self.nodes[node].ratio

    def _rigid(self, elements: Any, chosen: Any, node_of: Any, steps: list[Step]) -> tuple[int, ...]:
        """Rigid rotations whose angle no law sees."""
        if any(self.templates[index].absolute_angles for index in chosen):
            return ()
        return tuple(step.state for step in steps if step.form is None)

    def _modal(self, elements: Any, chosen: Any) -> str | None:
        names = set()
        for element, index in zip(elements, chosen, strict=True):
            key = self.templates[index].modal_ratio
            if key is not None:
                value = element.values[key]
                names.add(value.name if isinstance(value, Shared) else f"{element.name}.{key}")
        if len(names) > 1 and len({self.by_name[name].values for name in names}) > 1:
            listed = ", ".join(sorted(names))
            raise ModelError(
                self.where, f"modal damping has different ratios ({listed})", "share one parameter: all modes have one ratio"
            )
        return sorted(names)[0] if names else None

    def _outputs(self, elements: Any, chosen: Any) -> list[Output]:
        outputs = []
        for element, index in zip(elements, chosen, strict=True):
            template = self.templates[index]
            outputs += [Output(f"{element.name}.{d.name}", d.unit) for d in template.definitions if not d.hidden]
            if template.constraints:
                outputs.append(Output(f"{element.name}.torque", "N*m"))
            if template.mass and len(template.flanges) == 1:
                units = ("rad", "rad", "rad", "rad/s", "rad/s^2")
                names = ("angle", "angle_deviation", "elastic_angle", "speed", "acceleration")
                outputs += [Output(f"{element.name}.{name}", unit) for name, unit in zip(names, units, strict=True)]
            for name, law in (("stored_energy", "J"), ("dissipated_power", "W")):
                if getattr(template, name) != 0:
                    outputs.append(Output(f"{element.name}.{name}", law))
            mine = [output.name for output in outputs if output.name.startswith(f"{element.name}.")]
            for name in mine:
                if mine.count(name) > 1:
                    what = f"names a quantity {name.partition('.')[2]!r}, which modelgen adds itself"
                    raise ModelError(element.where, what, "rename the quantity")
        totals = {"kinetic_energy": "J", "stored_energy": "J", "dissipated_power": "W", "supplied_power": "W"}
        return outputs + [Output(f"total.{name}", unit) for name, unit in totals.items()]


def _symbol(name: str, row: int | None, param: Param | None = None) -> sympy.Symbol:
    integer = True if param is not None and param.integer else None
    positive = True if param is not None and param.positive else None
    return sympy.Symbol(name if row is None else f"{name}[{row}]", real=True, integer=integer, positive=positive)


def _rational(value: Fraction) -> sympy.Rational:
    return sympy.Rational(value.numerator, value.denominator)


def _names_in_laws(template: Template) -> set[str]:
    """Names of all symbols in the laws of a template; those of a clock also where only its harmonics are left."""
    laws = [*(d.expression for d in template.definitions), *template.torques.values(), *template.rates.values()]
    laws += [template.stored_energy, template.dissipated_power, template.supplied_power]
    names = {symbol.name for law in laws for symbol in law.free_symbols}
    return names | {f"{harmonic.clock}.angle" for harmonic in template.harmonics}
