"""From an element class to a template: its laws once, in the form that the compiler needs.

Part of the grammar; it knows no element by name. Four things happen to the laws an element wrote: named quantities are put in
order of use; every sum of flange angles becomes a relative angle (so that a uniform rotation drops out exactly, not by
cancellation); sine and cosine of a clock become shared harmonics; and what depends on time alone is set apart, so that it has
a mean.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import sympy

from modelgen.equations.dimensions import DimensionCheck
from modelgen.equations.records import Definition, Harmonic, Relative, Template
from modelgen.errors import ModelError, NamingError
from modelgen.model import Clock, Derived, Element, Flange, Param, State, quantity
from modelgen.model.declarations import TIME, UNIT_CONSTANTS
from modelgen.units import NUMBER, dimension_of

Expressions = dict[str, sympy.Expr]


def template_key(element: Element) -> tuple[Any, ...]:
    """What two elements must share to share a template: class, switches, orders, lengths of series, sense."""
    lengths = tuple(sorted(element.lengths.items()))
    return type(element), tuple(element.choices.items()), tuple(element.harmonics.items()), lengths, tuple(element.clocks)


def build_template(element: Element) -> Template:
    """The template of an element; raises ModelError or UnitError where its laws are not lawful."""
    return _Builder(element).build()


class _Builder:
    def __init__(self, element: Element) -> None:
        self.element, self.where = element, element.where
        self.flanges = {name: flange.symbols for name, flange in element.declared(Flange).items()}
        self.angles = {symbols.angle: name for name, symbols in self.flanges.items()}
        self.speeds = {symbols.speed: name for name, symbols in self.flanges.items()}
        self.params = {k: p for k, p in element.declared(Param).items() if p.exists(element.choices)}
        self.derived = {k: d for k, d in element.declared(Derived).items() if d.exists(element.choices)}
        self.states = element.declared(State)
        self.clocks = {name: clock.symbols for name, clock in element.declared(Clock).items()}
        self.quantities = element.declared(quantity)

    # -- the laws as written -----------------------------------------------------------------------------------------------

    def build(self) -> Template:
        e = self.element
        written = self._ordered({name: self._read(each.law(e), name) for name, each in self.quantities.items()})
        torques = {self._flange(f, "torques"): self._read(x, f"torque on {f.name}") for f, x in e.torques().items()}
        inertias = {self._flange(f, "inertias"): self._read(x, f"inertia on {f.name}") for f, x in e.inertias().items()}
        mass = {(name, name): self._constant(self._written_out(x, written), f"inertia on {name}") for name, x in inertias.items()}
        kinetic = e.kinetic_energy()
        if kinetic is not None:
            self._lagrange(self._written_out(self._read(kinetic, "kinetic energy"), written), mass, torques)
        constraints = [self._written_out(self._read(x, "constraint"), written) for x in e.constraints()]
        rates = {symbol: self._read(x, f"rate of {symbol}") for symbol, x in e.rates().items()}
        own = {state.symbol for state in self.states.values()}
        if set(rates) != own:
            raise ModelError(self.where, "has own states without a rate, or rates without a state", "give one rate per State")
        powers = {key: self._read(getattr(e, key)(), key) for key in ("stored_energy", "dissipated_power", "supplied_power")}
        law = {"definitions": dict(written), "torques": dict(torques), "inertias": dict(inertias), "rates": dict(rates), **powers}
        law["kinetic_energy"] = kinetic
        self._check_units(written, torques, mass, constraints, rates, powers)

        ones = dict.fromkeys(UNIT_CONSTANTS, sympy.Integer(1))
        blocks: Expressions = {**{f"def {k}": x for k, x in written.items()}, **{f"torque {k}": x for k, x in torques.items()}}
        blocks.update({f"rate {k}": x for k, x in rates.items()})
        blocks.update({f"mass {f} {g}": x for (f, g), x in mass.items()})
        blocks.update(powers)
        blocks = {key: x.xreplace(ones) for key, x in blocks.items()}
        self._fixed = self._parameter_definitions({k[4:]: x for k, x in blocks.items() if k.startswith("def ")})
        relatives, absolute = self._relate(blocks)
        harmonics = self._harmonize(blocks)
        definitions = self._definitions(blocks)
        guards = tuple(e.guards())
        ratio = e.modal_damping()
        if ratio is not None and ratio not in {p.symbol() for p in self.params.values() if not p.series}:
            raise ModelError(self.where, f"modal damping is {ratio}", "return one of the element's own parameters, or None")
        return Template(
            kind=e.kind,
            title=type(e).__name__,
            flanges=tuple(self.flanges),
            parameters=tuple((k, p.symbols(e.lengths.get(k) if p.series else None)) for k, p in self.params.items())
            + tuple((k, d.symbols(e)) for k, d in self.derived.items()),
            clocks=tuple(self.clocks),
            harmonics=harmonics,
            states=tuple((k, s.symbol, s.unit, s.start, s.scale) for k, s in self.states.items()),
            definitions=definitions,
            relatives=relatives,
            absolute_angles=absolute,
            torques={k: blocks[f"torque {k}"] for k in torques},
            mass={(f, g): blocks[f"mass {f} {g}"] for f, g in mass},
            constraints=tuple(self._linear(x) for x in constraints),
            rates={k: blocks[f"rate {k}"] for k in rates},
            stored_energy=blocks["stored_energy"],
            dissipated_power=blocks["dissipated_power"],
            supplied_power=blocks["supplied_power"],
            modal_ratio=None if ratio is None else ratio.name,
            guards=guards,
            sense=e.sense,
            law=law,
        )

    def _read(self, value: Any, what: str) -> sympy.Expr:
        if isinstance(value, sympy.Expr):
            unknown = value.free_symbols - self._known()
            if unknown:
                names = ", ".join(sorted(map(str, unknown)))
                raise ModelError(self.where, f"{what} uses {names}", "use only the element's own declarations")
            return value
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ModelError(self.where, f"{what} is {value!r}", "return a SymPy expression")
        return sympy.Integer(value) if isinstance(value, int) or value == 0 else sympy.Float(value)

    def _known(self) -> set[sympy.Symbol]:
        if not hasattr(self, "_names"):
            self._names = set(self._dimensions()) | set(UNIT_CONSTANTS)
        return self._names

    def _flange(self, symbols: Any, what: str) -> str:
        if symbols not in self.flanges.values():
            raise ModelError(self.where, f"{what} names {symbols!r}", "use the element's own flanges as keys, such as self.a")
        return str(symbols.name)

    def _ordered(self, written: Expressions) -> Expressions:
        """Quantities in order of use. Raises ModelError where they define each other."""
        symbols = {self.quantities[name].symbol: name for name in written}
        waiting = {name: {symbols[s] for s in x.free_symbols if s in symbols} for name, x in written.items()}
        ordered: Expressions = {}
        while waiting:
            ready = [name for name, needs in waiting.items() if needs <= set(ordered)]
            if not ready:
                raise ModelError(self.where, f"quantities {', '.join(waiting)} define each other", "break the circle")
            for name in ready:
                ordered[name] = written[name]
                del waiting[name]
        return ordered

    def _written_out(self, expression: sympy.Expr, written: Expressions) -> sympy.Expr:
        """The expression without names of quantities, so that derivatives see what they stand for."""
        laws = {self.quantities[name].symbol: law for name, law in written.items()}
        while expression.free_symbols & laws.keys():
            expression = expression.xreplace(laws)
        return expression

    def _constant(self, expression: sympy.Expr, what: str) -> sympy.Expr:
        varying = expression.free_symbols - self._parameters() - set(UNIT_CONSTANTS)
        if varying:
            remedy = "an inertia that depends on angle belongs in kinetic_energy()"
            raise ModelError(self.where, f"{what} depends on {', '.join(sorted(map(str, varying)))}", remedy)
        return expression

    def _parameters(self) -> set[sympy.Symbol]:
        found = {s for k, p in self.params.items() for s in p.symbols(self.element.lengths.get(k) if p.series else None)}
        return found | {s for d in self.derived.values() for s in d.symbols(self.element)}

    # -- units -------------------------------------------------------------------------------------------------------------

    def _dimensions(self) -> dict[sympy.Symbol, Any]:
        units: list[tuple[sympy.Symbol, str]] = [(TIME, "s"), *UNIT_CONSTANTS.items()]
        for flange in self.flanges.values():
            units += [(flange.angle, "rad"), (flange.speed, "rad/s"), (flange.inertia, "kg*m^2")]
        for clock in self.clocks.values():
            units += [(clock.angle, "rad"), (clock.frequency, "rad/s")]
        for name, param in self.params.items():
            units += [(s, param.unit) for s in param.symbols(self.element.lengths.get(name) if param.series else None)]
        for each in self.derived.values():
            units += [(symbol, each.unit) for symbol in each.symbols(self.element)]
        units += [(state.symbol, state.unit) for state in self.states.values()]
        units += [(named.symbol, named.unit) for named in self.quantities.values()]
        twice = [symbol.name for index, (symbol, _) in enumerate(units) if symbol in {other for other, _ in units[:index]}]
        if twice:
            raise NamingError(self.where, f"declares two things that its laws both call {twice[0]!r}", "rename one of them")
        return {symbol: dimension_of(unit) for symbol, unit in units}

    def _check_units(
        self, written: Expressions, torques: Expressions, mass: Mapping[Any, sympy.Expr], constraints: Iterable[sympy.Expr],
        rates: Mapping[sympy.Symbol, sympy.Expr], powers: Expressions,
    ) -> None:  # fmt: skip
        check = DimensionCheck(self._dimensions(), self.where)
        for name, expression in written.items():
            check.require(expression, self.quantities[name].unit, name)
            if (mean := self.quantities[name].mean) is not None:
                check.require(self._read(mean(self.element), f"mean of {name}"), self.quantities[name].unit, f"mean of {name}")
        for flange, expression in torques.items():
            check.require(expression, "N*m", f"torque on {flange}")
        for (flange, _), expression in mass.items():
            check.require(expression, "kg*m^2", f"inertia on {flange}")
        for expression in constraints:
            check.of(expression, "constraint")
        units = {state.symbol: state.unit for state in self.states.values()}
        for symbol, expression in rates.items():
            check.require(expression * TIME, units[symbol], f"rate of {symbol} times a second")
        for name, expression in powers.items():
            check.require(expression, "J" if name == "stored_energy" else "W", name)

    # -- Lagrange, for inertias that depend on angle -------------------------------------------------------------------------

    def _lagrange(self, energy: sympy.Expr, mass: dict[tuple[str, str], sympy.Expr], torques: Expressions) -> None:
        """Mass terms and velocity torques of a kinetic energy quadratic in the flange speeds."""
        names = list(self.flanges)
        varying = energy.free_symbols - self._parameters() - set(self.angles) - set(self.speeds)
        if varying:
            found = ", ".join(sorted(map(str, varying)))
            raise ModelError(
                self.where, f"kinetic energy depends on {found}", "write it with parameters, flange angles and speeds"
            )
        for f in names:
            momentum = energy.diff(self.flanges[f].speed)
            extra = energy.diff(self.flanges[f].angle)
            for g in names:
                term = momentum.diff(self.flanges[g].speed)
                if term.free_symbols & set(self.speeds):
                    term = sympy.simplify(term)  # slow, and most energies are plainly quadratic
                if term.free_symbols & set(self.speeds):
                    raise ModelError(
                        self.where, "kinetic energy is not quadratic in the speeds", "write T = sum of J(angle) speed^2 / 2"
                    )
                if term != 0:
                    mass[f, g] = mass.get((f, g), sympy.Integer(0)) + term
                extra -= momentum.diff(self.flanges[g].angle) * self.flanges[g].speed
            if extra != 0:
                torques[f] = torques.get(f, sympy.Integer(0)) + extra

    # -- relative angles -------------------------------------------------------------------------------------------------------

    def _parameter_definitions(self, written: Expressions) -> dict[sympy.Symbol, sympy.Expr]:
        """Quantities that depend on parameters only, written out in parameters."""
        parameters = self._parameters()
        fixed: dict[sympy.Symbol, sympy.Expr] = {}
        for name, expression in written.items():
            if expression.free_symbols <= parameters | set(fixed):
                fixed[self.quantities[name].symbol] = expression.xreplace(fixed)
        return fixed

    def _linear(self, expression: sympy.Expr) -> dict[str, sympy.Expr]:
        """Coefficients of a linear combination of flange angles; raises ModelError if it is anything else."""
        result = {}
        for name, flange in self.flanges.items():
            coefficient = expression.diff(flange.angle)
            if coefficient != 0:
                result[name] = coefficient.xreplace(self._fixed)
        rest = expression.xreplace({flange.angle: sympy.Integer(0) for flange in self.flanges.values()})
        if (
            rest != 0
            or any(c.free_symbols & (set(self.angles) | set(self.speeds) | {TIME}) for c in result.values())
            or not result
        ):
            raise ModelError(
                self.where, f"constraint {expression} is no linear combination of angles", "write n_a * angle_a - n_b * angle_b"
            )
        return result

    def _relate(self, blocks: Expressions) -> tuple[tuple[Relative, ...], tuple[str, ...]]:
        """Replaces sums of flange angles and speeds by relative ones, in place; returns them and what is seen absolutely."""
        constant = self._parameters() | set(self._fixed)
        found: list[tuple[dict[str, sympy.Expr], dict[str, bool]]] = []
        symbols: list[tuple[sympy.Symbol, sympy.Symbol]] = []

        def form(coefficients: dict[str, sympy.Expr], is_angle: bool) -> tuple[int, sympy.Expr]:
            first = next(iter(coefficients))
            shape = {f: sympy.cancel((c / coefficients[first]).xreplace(self._fixed)) for f, c in coefficients.items()}
            for index, (known, seen) in enumerate(found):
                start = known[next(iter(known))]
                if {f: sympy.cancel((c / start).xreplace(self._fixed)) for f, c in known.items()} == shape:
                    seen["angle"] |= is_angle
                    return index, coefficients[first] / known[first]
            found.append((coefficients, {"angle": is_angle}))
            index = len(found)
            symbols.append(
                (sympy.Symbol(f"relative_{index}.angle", real=True), sympy.Symbol(f"relative_{index}.rate", real=True))
            )
            return index - 1, sympy.Integer(1)

        def gathered(e: sympy.Add, table: Mapping[sympy.Symbol, str], is_angle: bool) -> sympy.Expr:
            terms: dict[str, sympy.Expr] = {}
            rest = []
            for arg in e.args:
                c, x = arg.as_independent(*self.angles, *self.speeds, as_Add=False)
                if x in table:
                    terms[table[x]] = terms.get(table[x], sympy.Integer(0)) + c
                else:
                    rest.append(arg)
            if len(terms) < 2:
                return e
            coefficients, lead = {f: terms[f] for f in self.flanges if f in terms}, sympy.Integer(1)
            if not all(c.free_symbols <= constant for c in coefficients.values()):
                # A common factor that varies stays outside: c(t) * speed a - c(t) * speed b is c(t) * (speed a - speed b).
                lead = next(iter(coefficients.values()))
                coefficients = {f: sympy.cancel(c / lead) for f, c in coefficients.items()}
                if not all(c.free_symbols <= constant for c in coefficients.values()):
                    return e
            index, factor = form(coefficients, is_angle)
            factor *= lead
            return sympy.Add(factor * symbols[index][0 if is_angle else 1], *rest)

        def rewrite(e: sympy.Basic) -> sympy.Basic:
            if not e.args or not e.free_symbols & (set(self.angles) | set(self.speeds)):
                return e
            e = e.func(*(rewrite(arg) for arg in e.args))
            if isinstance(e, sympy.Add):
                e = gathered(e, self.angles, True)
            if isinstance(e, sympy.Add):
                e = gathered(e, self.speeds, False)
            return e

        for key in list(blocks):
            blocks[key] = rewrite(blocks[key])
        self._ground(blocks, found, symbols)
        names = {blocks[f"def {name}"]: name for name in reversed([k[4:] for k in blocks if k.startswith("def ")])}
        relatives, check = [], DimensionCheck(self._dimensions(), self.where)
        for index, ((coefficients, seen), (angle, rate)) in enumerate(zip(found, symbols, strict=True), 1):
            name = names.get(angle, f"relative_{index}" if index > 1 else "relative")
            size = check.of(next(iter(coefficients.values())), name)
            unit = self.quantities[name].unit if name in self.quantities else "rad" if size in (None, NUMBER) else str(size)
            relatives.append(
                Relative(name, unit, angle, rate, {f: c.xreplace(self._fixed) for f, c in coefficients.items()}, seen["angle"])
            )
        used = set().union(*(x.free_symbols for x in blocks.values()))
        return tuple(relatives), tuple(name for symbol, name in self.angles.items() if symbol in used)

    def _ground(self, blocks: Expressions, found: list[Any], symbols: list[Any]) -> None:
        """An angle seen by itself, not only through sine and cosine, ties the node to ground: it becomes a relative angle too."""
        periodic: dict[sympy.Basic, sympy.Dummy] = {}
        for x in blocks.values():
            for wave in x.atoms(sympy.sin, sympy.cos, sympy.tan):
                if wave.free_symbols & set(self.angles):
                    periodic.setdefault(wave, sympy.Dummy())
        back = {dummy: wave for wave, dummy in periodic.items()}
        for angle, name in self.angles.items():
            if any(angle in x.xreplace(periodic).free_symbols for x in blocks.values()):
                index = len(found) + 1
                pair = (sympy.Symbol(f"relative_{index}.angle", real=True), sympy.Symbol(f"relative_{index}.rate", real=True))
                found.append(({name: sympy.Integer(1)}, {"angle": True}))
                symbols.append(pair)
                swap = {angle: pair[0], self.flanges[name].speed: pair[1]}
                for key, x in blocks.items():
                    blocks[key] = x.xreplace(periodic).xreplace(swap).xreplace(back)

    # -- time ---------------------------------------------------------------------------------------------------------------

    def _harmonize(self, blocks: Expressions) -> tuple[Harmonic, ...]:
        """Replaces sin(n * clock angle) and cos(n * clock angle) by symbols, in place."""
        waves: dict[sympy.Basic, Harmonic] = {}
        for name, clock in self.clocks.items():
            for x in blocks.values():
                if clock.angle not in x.free_symbols:
                    continue
                for wave in sorted(x.atoms(sympy.sin, sympy.cos), key=str):
                    order = wave.args[0] / clock.angle
                    if isinstance(order, sympy.Integer) and order > 0 and wave not in waves:
                        shape = "sin" if isinstance(wave, sympy.sin) else "cos"
                        waves[wave] = Harmonic(sympy.Symbol(f"{name}.{shape}_{order}", real=True), name, int(order), shape)
        swap = {wave: harmonic.symbol for wave, harmonic in waves.items()}
        for key in list(blocks):
            blocks[key] = blocks[key].xreplace(swap)
        return tuple(waves.values())

    def _definitions(self, blocks: Expressions) -> tuple[Definition, ...]:
        """The definitions with their stages; parts of other laws that depend on time only become hidden definitions."""
        clocks = {s for c in self.clocks.values() for s in (c.angle,)}
        time = {
            TIME,
            *clocks,
            *(s for x in blocks.values() for s in x.free_symbols if "." in s.name and s.name.split(".")[0] in self.clocks),
        }
        time -= {c.frequency for c in self.clocks.values()}
        moving = set(self.angles) | set(self.speeds) | {s.symbol for s in self.states.values()}
        result: list[Definition] = []
        timed: set[sympy.Symbol] = set(time)
        stated: set[sympy.Symbol] = set(moving)

        def stage(x: sympy.Expr) -> str:
            free = x.free_symbols
            if free & stated or any(s.name.startswith("relative_") for s in free):
                return "state"
            return "time" if free & timed else "parameter"

        def split(x: sympy.Expr, name: str) -> sympy.Expr:
            """Sets parts that depend on time only apart from an expression that depends on the state too."""
            if isinstance(x, sympy.Symbol) or not x.free_symbols & timed or not isinstance(x, sympy.Expr):
                return x
            if stage(x) == "time":
                symbol = sympy.Symbol(f"{name}_{len(result)}", real=True)
                result.append(Definition(symbol.name, symbol, x, "1", "time", hidden=True))
                timed.add(symbol)
                return symbol
            if isinstance(x, (sympy.Add, sympy.Mul)):
                alone = [arg for arg in x.args if stage(arg) != "state"]
                if any(stage(arg) == "time" for arg in alone):
                    rest = [arg for arg in x.args if stage(arg) == "state"]
                    joined = x.func(*alone)
                    return x.func(
                        joined if isinstance(joined, sympy.Symbol) else split(joined, name), *(split(arg, name) for arg in rest)
                    )
            if isinstance(x, sympy.Piecewise):
                return x
            return x.func(*(split(arg, name) for arg in x.args))

        for key in [k for k in blocks if k.startswith("def ")]:
            name = key[4:]
            each, where = self.quantities[name], stage(blocks[key])
            expression = split(blocks[key], f"{name}_time") if where == "state" else blocks[key]
            mean = self._read(each.mean(self.element), f"mean of {name}") if each.mean is not None and where == "time" else None
            result.append(Definition(name, each.symbol, expression, each.unit, where, mean))
            (stated if where == "state" else timed if where == "time" else set()).add(each.symbol)
        for key in [k for k in blocks if not k.startswith("def ")]:
            blocks[key] = split(blocks[key], key.replace(" ", "_") + "_time")
        return tuple(result)
