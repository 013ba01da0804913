"""A whole driveline as flat SymPy equations: M q'' = f(t, q, q', p) in the angles of its nodes.

Part of the grammar, for reading, teaching and proofs; nothing is computed from it. It starts from the laws as the elements wrote
them and leaves out relative angles, harmonics and stages, so it is a second road to what ``lowering`` computes. For some
ten degrees of freedom; at hundreds of them SymPy is slow.

Rigid gears and planetary sets leave some angles independent, the groups', and q holds these (each that of one node):
absolute, [rad], in the forward sense of its shaft. Assembly per node is the textbook one (Nestorides, A Handbook on Torsional
Vibration).
"""

from __future__ import annotations

from collections.abc import Iterable

import sympy

from modelgen.equations.records import Equations, Instance, Node
from modelgen.errors import NamingError
from modelgen.model.declarations import TIME, UNIT_CONSTANTS

Gradient = dict[sympy.Symbol, sympy.Expr]


def coordinates(equations: Equations) -> tuple[tuple[sympy.Symbol, ...], tuple[sympy.Symbol, ...]]:
    """The angles q [rad] and speeds q' [rad/s] of the groups, as symbols ``theta_name`` and ``omega_name``.

    Raises NamingError where a parameter or state has such a name.
    """
    flat = FlatEquations(equations)
    return tuple(flat.angles), tuple(flat.speeds)


def definitions(equations: Equations) -> list[tuple[sympy.Symbol, sympy.Expr]]:
    """The named quantities of every element, ``element.quantity``, each in terms of those before it.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> definitions(assemble(line))[0]
    (shaft.twist, theta_engine - theta_load)
    """
    return FlatEquations(equations).definitions


def mass_matrix(equations: Equations) -> sympy.Matrix:
    """M [kg*m^2] over the groups; it depends on the angles where an element's inertia does.

    >>> from modelgen import Driveline, Inertia, RigidGear, assemble
    >>> line = Driveline("geared", elements=[
    ...     Inertia("motor", inertia=0.1), Inertia("drum", inertia=90.0),
    ...     RigidGear("gear", "motor", "drum", teeth_a=20, teeth_b=60)])
    >>> mass_matrix(assemble(line))
    Matrix([[drum.inertia*gear.teeth_a**2/gear.teeth_b**2 + motor.inertia]])
    """
    return FlatEquations(equations).mass()


def forces(equations: Equations, named: bool = False) -> sympy.Matrix:
    """f [N*m] over the groups, a column: written out, or with ``named`` in terms of ``definitions``.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> forces(assemble(line), named=True)
    Matrix([
    [-shaft.torque],
    [ shaft.torque]])
    """
    flat = FlatEquations(equations)
    return flat.finished(flat.torques(), named)


def rates(equations: Equations, named: bool = False) -> sympy.Matrix:
    """Time derivatives of the elements' own states, a column in the order of ``equations.states``."""
    flat = FlatEquations(equations)
    return flat.finished(flat.rates, named)


def linearized(equations: Equations, named: bool = False) -> tuple[sympy.Matrix, sympy.Matrix, sympy.Matrix]:
    """M, C = -df/dq' and K = -df/dq at whatever angles, speeds, time and own states are put in.

    With ``named`` the derivative of a nonlinear law stays in terms of its quantities (``definitions``).

    >>> from modelgen import Driveline, GroundSpring, Inertia, assemble
    >>> line = Driveline("torsion_pendulum", elements=[Inertia("disk", inertia=2.0), GroundSpring("wire", "disk", stiffness=8.0)])
    >>> linearized(assemble(line))
    (Matrix([[disk.inertia]]), Matrix([[wire.damping]]), Matrix([[wire.stiffness]]))
    """
    flat = FlatEquations(equations)
    return flat.mass(), *(flat.finished(flat.derivative(of), named) for of in (flat.speeds, flat.angles))


class FlatEquations:
    """The laws of all instances in the symbols of the driveline."""

    def __init__(self, equations: Equations) -> None:
        self.eq = equations
        self.angles = [sympy.Symbol(f"theta_{name}", real=True) for name in equations.groups]
        self.speeds = [sympy.Symbol(f"omega_{name}", real=True) for name in equations.groups]
        self.own = {
            index: sympy.Symbol(state.name, real=True) for index, state in enumerate(equations.states) if state.kind == "own"
        }
        self._check_names()
        self.operating_speed = equations.speed if equations.speed is not None else sympy.Integer(0)
        self.constant_mass = self._constant_mass()
        self.definitions: list[tuple[sympy.Symbol, sympy.Expr]] = []
        self.node_torque: list[sympy.Expr] = [sympy.Integer(0)] * len(equations.nodes)
        self.node_mass: dict[tuple[int, int], sympy.Expr] = {}
        own_rates: dict[int, sympy.Expr] = {}
        for instance in equations.instances:
            template, table = equations.templates[instance.template], self.table_of(instance)
            for name, written in template.law["definitions"].items():
                self.definitions.append((table[sympy.Symbol(name, real=True)], written.xreplace(table)))
            for flange, torque in template.law["torques"].items():
                self.node_torque[instance.nodes[flange]] += torque.xreplace(table)
            for (f, g), inertia in template.mass.items():
                key = (instance.nodes[f], instance.nodes[g])
                self.node_mass[key] = self.node_mass.get(key, sympy.Integer(0)) + inertia.xreplace(table)
            for index, (_, symbol, *_) in zip(instance.states, template.states, strict=True):
                own_rates[index] = template.law["rates"][symbol].xreplace(table)
        self.rates = sympy.Matrix(len(own_rates), 1, [rate for _, rate in sorted(own_rates.items())])

    def _check_names(self) -> None:
        others = {symbol for parameter in self.eq.parameters for symbol in parameter.symbols} | set(self.own.values())
        for symbol in (*self.angles, *self.speeds):
            if symbol.name in {other.name for other in others}:
                what = "an angle" if symbol in self.angles else "a speed"
                raise NamingError(
                    f"driveline {self.eq.name!r}", f"{symbol.name!r} would stand for {what} too", "rename the parameter or state"
                )

    def _constant_mass(self) -> sympy.Matrix:
        """The part of M that no angle changes."""
        n = len(self.eq.groups)
        total = sympy.zeros(n, n)
        for instance in self.eq.instances:
            for (f, g), inertia in self.eq.templates[instance.template].mass.items():
                if f == g and inertia.free_symbols <= set(instance.symbols):
                    row = self.eq.nodes[instance.nodes[f]].row
                    for i, c in row.items():
                        for j, d in row.items():
                            total[i, j] += c * d * inertia.xreplace(dict(instance.symbols))
        return total

    def _inertia_at(self, node: Node) -> sympy.Expr:
        """What resists a torque on the node while the other rotations are free: 1 / (n M^-1 n^T), with the node's row n."""
        mass, group = self.constant_mass, node.group
        if group is None and not node.row:
            return sympy.Integer(0)
        if group is not None and all(mass[group, other] == 0 for other in range(mass.cols) if other != group):
            return mass[group, group] / node.row[group] ** 2
        row = sympy.Matrix(mass.cols, 1, lambda i, _: node.row.get(i, sympy.Integer(0)))
        return 1 / (row.T * mass.LUsolve(row))[0]

    def table_of(self, instance: Instance) -> dict[sympy.Symbol, sympy.Expr]:
        """What each symbol of a law stands for in the driveline."""
        eq, template = self.eq, self.eq.templates[instance.template]
        table: dict[sympy.Symbol, sympy.Expr] = {**dict.fromkeys(UNIT_CONSTANTS, sympy.Integer(1)), **instance.symbols}
        for flange in template.flanges:
            node = eq.nodes[instance.nodes[flange]]
            table[sympy.Symbol(f"{flange}.angle", real=True)] = node.over(self.angles)
            table[sympy.Symbol(f"{flange}.speed", real=True)] = node.over(self.speeds)
            table[sympy.Symbol(f"{flange}.inertia", positive=True)] = self._inertia_at(node)
        for name, index in instance.clocks.items():
            frequency = eq.clocks[index].multiple * self.operating_speed
            table[sympy.Symbol(f"{name}.angle", real=True)] = frequency * TIME
            table[sympy.Symbol(f"{name}.frequency", real=True)] = frequency
        for index, (_, symbol, *_) in zip(instance.states, template.states, strict=True):
            table[symbol] = self.own[index]
        prefix = f"{instance.name}." if instance.name else ""
        switched = [*template.multipliers, *(flag for modes in template.modes for flag in modes.symbols)]
        table.update({symbol: sympy.Symbol(prefix + symbol.name, real=True) for symbol in switched})
        table.update(
            {sympy.Symbol(name, real=True): sympy.Symbol(prefix + name, real=True) for name in template.law["definitions"]}
        )
        return table

    # -- assembly per group ----------------------------------------------------------------------------------------------------

    def mass(self) -> sympy.Matrix:
        """M, written out."""
        n, nodes = len(self.angles), self.eq.nodes
        matrix = sympy.zeros(n, n)
        for (a, b), inertia in self.node_mass.items():
            for i, c in nodes[a].row.items():
                for j, d in nodes[b].row.items():
                    matrix[i, j] += c * d * inertia
        return self.finished(matrix, named=False)

    def element_torques(self) -> sympy.Matrix:
        """Sum of the torques of the elements on each group, without modal damping, which belongs to the whole driveline."""
        column = sympy.zeros(len(self.angles), 1)
        for node, torque in zip(self.eq.nodes, self.node_torque, strict=True):
            for group, c in node.row.items():
                column[group] += c * torque
        return column

    def torques(self) -> sympy.Matrix:
        """f: all torques on each group."""
        column = self.element_torques()
        if self.eq.modal_ratio is not None:
            relative = [w - mean * self.operating_speed for w, mean in zip(self.speeds, self.eq.mean_speeds, strict=True)]
            column -= self._modal_damping() * sympy.Matrix(relative)
        return column

    def _modal_damping(self) -> sympy.Matrix:
        """The matrix that gives every elastic mode the same damping ratio; its entries are numbers worked out with the modes."""
        n = len(self.angles)
        return sympy.Matrix(n, n, lambda i, j: sympy.Symbol(f"modal.damping[{i + j * n + 1}]", real=True))

    def derivative(self, of: Iterable[sympy.Symbol]) -> sympy.Matrix:
        """-df/dx for the symbols x, by the chain rule through the definitions."""
        symbols, known = list(of), dict[sympy.Symbol, Gradient]()
        for symbol, written in self.definitions:
            known[symbol] = self._gradient(written, symbols, known)
        rows = [self._gradient(torque, symbols, known) for torque in self.torques()]
        n = len(symbols)
        return sympy.Matrix(n, n, lambda i, j: -rows[i].get(symbols[j], sympy.Integer(0)))

    @staticmethod
    def _gradient(expression: sympy.Expr, symbols: list[sympy.Symbol], known: dict[sympy.Symbol, Gradient]) -> Gradient:
        result: Gradient = {}
        for symbol in sorted(expression.free_symbols, key=str):
            inner = {symbol: sympy.Integer(1)} if symbol in symbols else known.get(symbol, {})
            if inner:
                outer = expression.diff(symbol)
                for x, slope in inner.items():
                    result[x] = result.get(x, sympy.Integer(0)) + outer * slope
        return result

    def finished(self, matrix: sympy.Matrix, named: bool) -> sympy.Matrix:
        """The matrix as it is, or with all named quantities written out."""
        if named:
            return matrix
        written: dict[sympy.Symbol, sympy.Expr] = {}
        for symbol, expression in self.definitions:
            written[symbol] = expression.xreplace(written)
        return matrix.applyfunc(lambda entry: entry.xreplace(written))
