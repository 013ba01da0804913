"""Equations to Compiled: CasADi expressions of a whole driveline, put together from its blocks. The compiler's main sentence.

Third stage of the flow. One pass over the instances serves three models: the model in its chosen states, the mean model (time
quantities replaced by their means) and the model in physical angles, which linearization and equilibrium use.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from modelgen.equations.records import Equations, Harmonic, Instance
from modelgen.lowering.blocks import Block
from modelgen.lowering.compiled import Compiled
from modelgen.lowering.parameters import MODAL, ParameterTable
from modelgen.lowering.visitor import Visitor


@dataclass
class Motion:
    """Angles and speeds that the laws are evaluated at, as CasADi expressions."""

    forms: list[ca.SX]
    form_rates: list[ca.SX]
    angles: list[ca.SX]
    speeds: list[ca.SX]
    deviations: list[ca.SX]
    own: ca.SX


@dataclass
class Forces:
    """What the laws give: torques on the nodes, mass terms, rates of own states, and every named quantity."""

    torque: list[ca.SX]
    mass: dict[tuple[int, int], ca.SX]
    rates: list[ca.SX]
    values: dict[str, ca.SX]
    powers: dict[str, ca.SX]
    by_element: list[tuple[ca.SX, ca.SX]]


def lower(equations: Equations) -> Compiled:
    """CasADi functions of the equations. Raises LoweringError for a law that has no numeric counterpart.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> model = lower(assemble(Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=7.0)])))
    >>> model.rhs(0.0, [0.0, 1.0, 0.0, 0.0], model.parameters.vector()).tolist()  # twist 1 rad
    [0.0, 0.0, -1.4, -4.9]
    """
    return _Lowering(equations).compiled()


class _Lowering:
    def __init__(self, equations: Equations) -> None:
        self.eq = equations
        self.parameters = ParameterTable(equations)
        self.p, self.table = self.parameters.vector_symbol, self.parameters.table
        self.visit = Visitor(self.table, f"driveline {equations.name!r}")
        self.blocks = [Block(template) for template in equations.templates]
        self.t = ca.SX.sym("t")
        self.x = ca.SX.sym("x", len(equations.states))
        self.clock_angles = ca.SX.sym("clock", len(equations.clocks))
        speed = self.table[equations.speed] if equations.speed is not None else ca.SX(0)
        self.mean_speeds = [self.visit(each) * speed for each in equations.mean_speeds]
        self.frequencies = [self.visit(clock.multiple) * speed for clock in equations.clocks]
        self.ratios = [self.visit(each) for each in equations.ratios]
        self.node_ratio = [self.visit(node.ratio) for node in equations.nodes]
        self.coefficients = [{g: self.visit(c) for g, c in form.coefficients.items()} for form in equations.forms]
        self.order = len(equations.steps)
        self.group_inertia = self._group_inertia()
        self.given = [self._given(instance) for instance in equations.instances]

    # -- what does not depend on the state -------------------------------------------------------------------------------------

    def _parameters_of(self, instance: Instance) -> ca.SX:
        block = self.blocks[instance.template]
        return ca.vertcat(*(self.table[instance.symbols[s]] for s in block.slots.parameters))

    def _group_inertia(self) -> list[ca.SX]:
        """Inertia of each group as its first node sees it, of the inertias that do not depend on angle."""
        total = [ca.SX(0)] * len(self.eq.groups)
        for instance in self.eq.instances:
            template = self.eq.templates[instance.template]
            if not template.mass:
                continue
            symbols = {local: self.table[other] for local, other in instance.symbols.items()}
            for (f, g), expression in template.mass.items():
                if f == g and expression.free_symbols <= set(symbols):
                    node = instance.nodes[f]
                    group = self.eq.nodes[node].group
                    total[group] += self.node_ratio[node] ** 2 * Visitor(symbols, instance.name)(expression)
        return total

    def _given(self, instance: Instance) -> list[ca.SX]:
        """Parameters, node inertias and fixed quantities of an instance."""
        block = self.blocks[instance.template]
        nodes = [instance.nodes[flange] for flange in block.template.flanges]
        inertias = ca.vertcat(*(self.group_inertia[self.eq.nodes[n].group] / self.node_ratio[n] ** 2 for n in nodes))
        given = [self._parameters_of(instance), inertias]
        return [*given, block.fixed(*given)]

    def _harmonics(self) -> dict[tuple[int, int, str], ca.SX]:
        """sin and cos of the multiples of each clock that any law asks for, by repeated products of one sine and cosine."""
        wanted: dict[int, set[int]] = {}
        for instance in self.eq.instances:
            for h in self.eq.templates[instance.template].harmonics:
                wanted.setdefault(instance.clocks[h.clock], set()).add(h.order)
        found: dict[tuple[int, int, str], ca.SX] = {}
        for clock, orders in wanted.items():
            angle = self.clock_angles[clock]
            known = {1: (ca.sin(angle), ca.cos(angle))}
            for order in sorted(orders):
                found[clock, order, "sin"], found[clock, order, "cos"] = _multiple(order, known)
        return found

    def _clock_values(self, instance: Instance, harmonics: dict[tuple[int, int, str], ca.SX]) -> ca.SX:
        template = self.eq.templates[instance.template]
        values = [self.t]
        for name in template.clocks:
            index = instance.clocks.get(name)
            values += [ca.SX(0), ca.SX(0)] if index is None else [self.clock_angles[index], self.frequencies[index]]
        values += [self._wave(instance, h, harmonics) for h in template.harmonics]
        return ca.vertcat(*values)

    @staticmethod
    def _wave(instance: Instance, h: Harmonic, harmonics: dict[tuple[int, int, str], ca.SX]) -> ca.SX:
        return harmonics[instance.clocks[h.clock], h.order, h.wave]

    # -- motion ------------------------------------------------------------------------------------------------------------------

    def _from_states(self, x: ca.SX) -> Motion:
        n, eq = self.order, self.eq
        own = x[2 * n :]
        full_angle, vibrating_angle = self._placed(x[:n], True), self._placed(x[:n], False)
        full_speed, vibrating_speed = self._placed(x[n : 2 * n], True), self._placed(x[n : 2 * n], False)
        speeds = [self.mean_speeds[g] + full_speed[g] for g in range(len(eq.groups))]
        forms, rates = [], []
        for form, coefficients in zip(eq.forms, self.coefficients, strict=True):
            if form.state is not None:
                forms.append(x[form.state])
                rates.append(x[n + form.state])
            elif form.sees_angle:
                # A closed loop: its rigid part is zero by construction and must not come in through rounding.
                forms.append(_sum(c * vibrating_angle[g] for g, c in coefficients.items()))
                rates.append(_sum(c * vibrating_speed[g] for g, c in coefficients.items()))
            else:
                forms.append(ca.SX(0))
                rates.append(_sum(c * speeds[g] for g, c in coefficients.items()))
        return Motion(forms, rates, self._turned(full_angle), speeds, full_angle, own)

    def _from_angles(self, angles: ca.SX, speeds: ca.SX, own: ca.SX) -> Motion:
        """Motion given by deviations of the group angles and speeds from uniform rotation."""
        deviation, rate = ca.vertsplit(angles), ca.vertsplit(speeds)
        forms = [_sum(c * deviation[g] for g, c in coefficients.items()) for coefficients in self.coefficients]
        absolute = [mean + each for mean, each in zip(self.mean_speeds, rate, strict=True)]
        rates = [
            _sum(c * (rate if form.sees_angle else absolute)[g] for g, c in coefficients.items())
            for form, coefficients in zip(self.eq.forms, self.coefficients, strict=True)
        ]
        return Motion(forms, rates, self._turned(deviation), absolute, deviation, own)

    def _placed(self, values: ca.SX, with_roots: bool) -> list[ca.SX]:
        placed: dict[int, ca.SX] = {}
        for step in self.eq.steps:
            if step.form is None:
                placed[step.group] = values[step.state] if with_roots else ca.SX(0)
            else:
                coefficients = self.coefficients[step.form]
                rest = _sum(c * placed[g] for g, c in coefficients.items() if g != step.group)
                placed[step.group] = (values[step.state] - rest) / coefficients[step.group]
        return [placed[g] for g in range(len(self.eq.groups))]

    def _turned(self, deviations: list[ca.SX]) -> list[ca.SX]:
        return [mean * self.t + each for mean, each in zip(self.mean_speeds, deviations, strict=True)]

    # -- laws --------------------------------------------------------------------------------------------------------------------

    def _forces(self, motion: Motion, timed: list[ca.SX], clocks: list[ca.SX]) -> Forces:
        eq = self.eq
        result = Forces([ca.SX(0)] * len(eq.nodes), {}, [ca.SX(0)] * (len(eq.states) - 2 * self.order), {}, {}, [])
        for number, instance in enumerate(eq.instances):
            block = self.blocks[instance.template]
            template = block.template
            values = [value for form in instance.forms for value in (motion.forms[form], motion.form_rates[form])]
            for flange in template.flanges:
                node = instance.nodes[flange]
                group = eq.nodes[node].group
                values += [self.node_ratio[node] * motion.angles[group], self.node_ratio[node] * motion.speeds[group]]
            values += [motion.own[state - 2 * self.order] for state in instance.states]
            named, torque, rates, powers, mass = block.state(
                *self.given[number], clocks[number], timed[number], ca.vertcat(*values)
            )
            for flange, each in zip(template.flanges, ca.vertsplit(torque) if template.flanges else [], strict=True):
                result.torque[instance.nodes[flange]] += each
            for state, symbol in zip(instance.states, (s for _, s, *_ in template.states), strict=True):
                result.rates[state - 2 * self.order] = rates[list(template.rates).index(symbol)]
            for (f, g), each in zip(template.mass, ca.vertsplit(mass) if template.mass else [], strict=True):
                key = (instance.nodes[f], instance.nodes[g])
                result.mass[key] = result.mass.get(key, ca.SX(0)) + each
            result.by_element.append((torque, mass))
            prefix = f"{instance.name}." if instance.name else ""
            for names, column in (
                (block.fixed_names, self.given[number][2]),
                (block.timed_names, timed[number]),
                (block.state_names, named),
            ):
                result.values.update({f"{prefix}{name}": column[row] for row, name in enumerate(names)})
            for row, name in enumerate(("stored_energy", "dissipated_power", "supplied_power")):
                result.powers[f"{instance.name}.{name}"] = powers[row]
        if eq.modal_ratio is not None:
            self._add_modal_damping(motion, result)
        return result

    def _add_modal_damping(self, motion: Motion, forces: Forces) -> None:
        """Torques -C (speed less uniform rotation); C acts on groups and is zero for the rigid rotation."""
        n = len(self.eq.groups)
        matrix = ca.reshape(self.p[self.parameters.slices[MODAL]], n, n)
        rates = ca.vertcat(*(s - mean for s, mean in zip(motion.speeds, self.mean_speeds, strict=True)))
        torque = -ca.mtimes(matrix, rates)
        first: dict[int, int] = {}
        for index, node in enumerate(self.eq.nodes):
            if node.group not in first and node.ratio == 1:
                first[node.group] = index
        for group, index in first.items():
            forces.torque[index] += torque[group]
        forces.powers["modal_damping.dissipated_power"] = -ca.dot(torque, rates)

    def _by_group(self, forces: Forces) -> tuple[ca.SX, dict[tuple[int, int], ca.SX]]:
        nodes, r = self.eq.nodes, self.node_ratio
        torque = [ca.SX(0)] * len(self.eq.groups)
        for index, node in enumerate(nodes):
            torque[node.group] += r[index] * forces.torque[index]
        mass: dict[tuple[int, int], ca.SX] = {}
        for (a, b), value in forces.mass.items():
            key = (nodes[a].group, nodes[b].group)
            mass[key] = mass.get(key, ca.SX(0)) + r[a] * r[b] * value
        return ca.vertcat(*torque), mass

    def _accelerations(self, torque: ca.SX, mass: dict[tuple[int, int], ca.SX]) -> ca.SX:
        n = len(self.eq.groups)
        if all(a == b for a, b in mass):
            return ca.vertcat(*(torque[g] / mass[g, g] for g in range(n)))
        return ca.solve(_matrix(mass, n), torque)

    # -- the record --------------------------------------------------------------------------------------------------------------

    def compiled(self) -> Compiled:
        eq, n = self.eq, self.order
        clock_values = [self._clock_values(i, self._shared_harmonics()) for i in eq.instances]
        timed = [
            self.blocks[i.template].timed(*given, clocks)
            for i, given, clocks in zip(eq.instances, self.given, clock_values, strict=True)
        ]
        motion = self._from_states(self.x)
        forces = self._forces(motion, timed, clock_values)
        torque, mass = self._by_group(forces)
        acceleration = self._accelerations(torque, mass)
        second = []
        for step in eq.steps:
            terms = {step.group: ca.SX(1)} if step.form is None else self.coefficients[step.form]
            second.append(_sum(c * acceleration[g] for g, c in terms.items()))
        ode = ca.vertcat(
            self.x[n : 2 * n, 0], *second, *forces.rates
        )  # the column, or a slice of one number has the shape (1, 0)
        outputs = self._outputs(motion, forces, acceleration, mass)
        at_time = ca.vertcat(*(f * self.t for f in self.frequencies)) if self.frequencies else ca.SX(0, 1)

        def now(expression: ca.SX) -> ca.SX:
            return ca.substitute(expression, self.clock_angles, at_time) if self.frequencies else expression

        ode, y = (ca.cse(now(each)) for each in (ode, ca.vertcat(*outputs.values())))
        return Compiled(
            equations=eq,
            parameters=self.parameters,
            expressions={"t": self.t, "x": self.x, "p": self.p, "ode": ode, "outputs": y},
            states=tuple(state.name for state in eq.states),
            outputs=tuple(outputs),
            units=tuple({each.name: each.unit for each in eq.outputs}[name] for name in outputs),
            mean_model=self._mean_model(timed),
        )

    def _shared_harmonics(self) -> dict[tuple[int, int, str], ca.SX]:
        if not hasattr(self, "_known_harmonics"):
            self._known_harmonics = self._harmonics()
        return self._known_harmonics

    def _outputs(
        self, motion: Motion, forces: Forces, acceleration: ca.SX, mass: dict[tuple[int, int], ca.SX]
    ) -> dict[str, ca.SX]:
        eq = self.eq
        found = {**forces.values, **forces.powers}
        found.update(self._gear_torques(forces, acceleration))
        weight = [r * value for r, value in zip(self.ratios, _diagonal(mass, len(eq.groups)), strict=True)]
        total = _sum(w * r for w, r in zip(weight, self.ratios, strict=True))
        mean = _sum(w * each for w, each in zip(weight, motion.deviations, strict=True)) / total
        for instance in eq.instances:
            template = eq.templates[instance.template]
            if not template.mass or len(template.flanges) != 1:
                continue
            node = instance.nodes[template.flanges[0]]
            g, r = eq.nodes[node].group, self.node_ratio[node]
            elastic = motion.deviations[g] if eq.grounded[g] else motion.deviations[g] - self.ratios[g] * mean
            parts = {"angle": motion.angles[g], "angle_deviation": motion.deviations[g], "elastic_angle": elastic}
            parts.update(speed=motion.speeds[g], acceleration=acceleration[g])
            found.update({f"{instance.name}.{name}": r * value for name, value in parts.items()})
        speeds = ca.vertcat(*motion.speeds)
        found["total.kinetic_energy"] = ca.dot(speeds, ca.mtimes(_matrix(mass, len(eq.groups)), speeds)) / 2
        for name in ("stored_energy", "dissipated_power", "supplied_power"):
            found[f"total.{name}"] = _sum(value for key, value in forces.powers.items() if key.endswith(f".{name}"))
        return {each.name: found[each.name] for each in eq.outputs}

    def _gear_torques(self, forces: Forces, acceleration: ca.SX) -> dict[str, ca.SX]:
        """Torque through each rigid gear, from the balance of its nodes: G^T lambda = M angle'' - torques."""
        eq = self.eq
        rows = [{node: self.visit(c) for node, c in row.items()} for row in eq.constraints]
        if not rows:
            return {}
        n = len(eq.nodes)
        g = ca.SX(len(rows), n)
        for index, row in enumerate(rows):
            for node, c in row.items():
                g[index, node] = c
        second = ca.vertcat(*(self.node_ratio[i] * acceleration[node.group] for i, node in enumerate(eq.nodes)))
        rest = ca.mtimes(_matrix(forces.mass, n), second) - ca.vertcat(*forces.torque)
        multiplier = ca.solve(ca.mtimes(g, g.T), ca.mtimes(g, rest))
        found, row_of = {}, 0
        for instance in eq.instances:
            template = eq.templates[instance.template]
            if template.constraints:
                first = instance.nodes[template.flanges[0]]
                found[f"{instance.name}.torque"] = -multiplier[row_of] * rows[row_of][first]
                row_of += len(template.constraints)
        return found

    def _mean_model(self, timed: list[ca.SX]) -> dict[str, ca.Function]:
        """Functions for equilibrium and linearization; see ``Compiled.mean_model``."""
        eq = self.eq
        n, own_count = len(eq.groups), len(eq.states) - 2 * self.order
        angles, speeds, own = ca.SX.sym("angle", n), ca.SX.sym("speed", n), ca.SX.sym("own", own_count)
        sizes = [len(self.blocks[i.template].timed_names) for i in eq.instances]
        mean = ca.SX.sym("w", sum(sizes))
        slots = ca.vertsplit(mean, [sum(sizes[:k]) for k in range(len(sizes) + 1)]) if sizes else []
        still = [ca.vertcat(*(ca.SX(0) for _ in self.blocks[i.template].slots.clocks)) for i in eq.instances]
        motion = self._from_angles(angles, speeds, own)
        forces = self._forces(motion, slots, still)
        torque, mass = self._by_group(forces)
        outputs = ca.vertcat(*self._outputs(motion, forces, self._accelerations(torque, mass), mass).values())
        by_flange, by_mass_term = (ca.vertcat(*column) for column in zip(*forces.by_element, strict=True))
        torque, matrix, outputs, by_flange, by_mass_term = (
            ca.substitute(each, self.t, 0) for each in (torque, _matrix(mass, n), outputs, by_flange, by_mass_term)
        )
        completed = ca.SX(self.p)
        for name, expression in self.parameters._expressions.items():
            completed[self.parameters.slices[name]] = expression(self.p)
        given = [angles, speeds, own, self.p, mean]
        explicit = [ca.SX(flag) for i in eq.instances for flag in self.blocks[i.template].explicit_mean]
        means = [self.blocks[i.template].mean(*given_) for i, given_ in zip(eq.instances, self.given, strict=True)]
        placed = ca.vertcat(*self._placed(self.x[: self.order], True))
        rates = ca.vertcat(*self._placed(self.x[self.order : 2 * self.order], True))
        coordinates = []
        for vector in (angles, speeds):
            for step in eq.steps:
                terms = {step.group: ca.SX(1)} if step.form is None else self.coefficients[step.form]
                coordinates.append(_sum(c * vector[g] for g, c in terms.items()))
        functions: dict[str, tuple[list[ca.SX], list[ca.SX]]] = {
            "torque": (given, [torque, ca.vertcat(*forces.rates)]),
            "linear": (given, [matrix, -ca.jacobian(torque, speeds), -ca.jacobian(torque, angles)]),
            "elements": (given, [by_flange, by_mass_term]),
            "outputs": (given, [outputs]),
            "completed": ([self.p], [completed]),
            "timed": ([self.clock_angles, self.t, self.p], [ca.vertcat(*timed)]),
            "means": ([self.p], [ca.vertcat(*means), ca.vertcat(*explicit)]),
            "angles": ([self.x, self.p], [placed, rates]),
            "coordinates": ([angles, speeds, own, self.p], [ca.vertcat(*coordinates, own)]),
            "frequencies": ([self.p], [ca.vertcat(*self.frequencies)]),
            "node_ratios": ([self.p], [ca.vertcat(*self.node_ratio)]),
            "ratios": ([self.p], [ca.vertcat(*self.ratios), ca.vertcat(*self.mean_speeds)]),
        }
        return {name: ca.Function(name, inputs, outs) for name, (inputs, outs) in functions.items()}


def _multiple(order: int, known: dict[int, tuple[ca.SX, ca.SX]]) -> tuple[ca.SX, ca.SX]:
    """sin and cos of a multiple of an angle from those of its halves: rounding grows with log2(order) products only."""
    if order not in known:
        (s1, c1), (s2, c2) = _multiple(order // 2, known), _multiple(order - order // 2, known)
        known[order] = (s1 * c2 + c1 * s2, c1 * c2 - s1 * s2)
    return known[order]


def _sum(terms: Any) -> ca.SX:
    total = ca.SX(0)
    for term in terms:
        total += term
    return total


def _matrix(entries: dict[tuple[int, int], ca.SX], size: int) -> ca.SX:
    matrix = ca.SX(size, size)
    for (row, column), value in entries.items():
        matrix[row, column] += value
    return matrix


def _diagonal(mass: dict[tuple[int, int], ca.SX], size: int) -> list[ca.SX]:
    return [mass.get((g, g), ca.SX(0)) for g in range(size)]
