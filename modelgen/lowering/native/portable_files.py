"""A whole model as three C files: header, equations with their solver, and a program that prints a trajectory.

Part of the compiler, around ``portable``. The solver is text with the word MODEL in place of the model's name; of the model come
numbers, the stages, and names that were checked to be harmless in strings and comments.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template

import casadi as ca

from modelgen.errors import LoweringError
from modelgen.lowering.compiled import Compiled
from modelgen.lowering.methods import read_tableau
from modelgen.lowering.native.emission import literal
from modelgen.lowering.native.portable import portable_stages
from modelgen.lowering.parameters import MODAL
from modelgen.lowering.step_control import of_method
from modelgen.lowering.tableau import doubled
from modelgen.model.names import model_name

LINE = 126
_HERE = Path(__file__).parent
_HARMLESS = re.compile(r"[A-Za-z0-9_.,^* /()\[\]-]{1,400}")


@dataclass(frozen=True)
class DefaultCase:
    """What the program runs without arguments: values of the parameters, start and scales of the states, and the horizon."""

    parameters: tuple[float, ...]
    start: tuple[float, ...]
    scale: tuple[float, ...]
    end: float
    samples: int
    tolerance: float


def portable_files(model: Compiled, case: DefaultCase) -> dict[str, str]:
    """The C files of a model by their names: ``NAME.h``, ``NAME.c`` and ``NAME_solver.c``.

    Raises NamingError or LoweringError for a name that is not harmless in C, and for an operation without C.
    """
    name = model_name(model.name, "generated C")
    prefix = name.replace("-", "_")
    functions = {"rates": model.rhs_function, "outputs": model.output_function, "jacobian": _entries(model.jacobian_function)}
    stages = portable_stages(functions, prefix)
    states = [state.unit for state in model.equations.states]
    values = {
        "name": name,
        "states": "\n".join(
            f" *   x[{index}]  {harmless(state)} [{harmless(unit)}]"
            for index, (state, unit) in enumerate(zip(model.states, states, strict=True))
        ),
        "stages": stages.text,
        "tables": "\n".join(_tables(model, case, prefix)),
        "X": len(model.states),
        "P": len(case.parameters),
        "Y": len(model.outputs),
        "J": model.jacobian_function.nnz_out(0),
        "C": max(1, stages.prepared),
        "W": max(1, stages.timed),
        "end": literal(case.end),
        "samples": case.samples,
        "tolerance": literal(case.tolerance),
        **{name: literal(number) for name, number in of_method(doubled(read_tableau("rk4"), extrapolate=False).control).items()},
    }
    templates = {".h": "portable_model.h", ".c": "portable_model.c", "_solver.c": "portable_program.c"}
    return {f"{name}{ending}": _filled(file, values, prefix) for ending, file in templates.items()}


def harmless(text: str) -> str:
    """The text itself if it can neither end a comment nor a string of C. Raises LoweringError.

    >>> harmless("N*m/rad")
    'N*m/rad'
    """
    if not _HARMLESS.fullmatch(text) or "*/" in text or "/*" in text or "//" in text:
        raise LoweringError(
            "generated C", f"the name or unit {text!r:.80} may not stand in C", "give letters, digits and underscores"
        )
    return text


def _filled(file: str, values: Mapping[str, object], prefix: str) -> str:
    return Template((_HERE / file).read_text(encoding="utf-8").replace("MODEL", prefix)).substitute(values)


def _entries(jacobian: ca.Function) -> ca.Function:
    """A sparse matrix function as one that gives its entries as a column."""
    t, x, p = (ca.SX.sym(name, *jacobian.size_in(index)) for index, name in enumerate("txp"))
    return ca.Function("entries", [t, x, p], [jacobian(t, x, p).nz[:]])


def _tables(model: Compiled, case: DefaultCase, prefix: str) -> Iterator[str]:
    """The constant tables that the header declares."""
    labels = model.parameters.labels()
    units = _parameter_units(model)
    if not len(case.parameters) == len(labels) == len(units):
        problem = f"has {len(labels)} parameters, the case {len(case.parameters)}"
        raise LoweringError(f"driveline {model.name!r}", problem, "give every parameter its value")
    pattern = model.jacobian_function.sparsity_out(0)
    rows, columns = pattern.get_triplet()
    sources = _sources(model)
    for kind, names, their_units, size in (
        ("state", model.states, [state.unit for state in model.equations.states], "X"),
        ("parameter", labels, units, "P"),
        ("output", model.outputs, model.units, "Y"),
    ):
        for what, texts in (("names", names), ("units", their_units)):
            yield from _table(
                "const char *const", f"{prefix}_{kind}_{what}", f"{prefix}_{size}", (f'"{harmless(text)}"' for text in texts)
            )
    yield from _table("const double", f"{prefix}_start", f"{prefix}_X", map(literal, case.start))
    yield from _table("const double", f"{prefix}_scale", f"{prefix}_X", map(literal, case.scale))
    yield from _table("const double", f"{prefix}_parameter_values", f"{prefix}_P", map(literal, case.parameters))
    flags = (str(int(label.partition("[")[0] in sources)) for label in labels)
    yield from _table("const unsigned char", f"{prefix}_parameter_is_source", f"{prefix}_P", flags)
    yield from _table("const int", f"{prefix}_jacobian_rows", f"{prefix}_J", map(str, rows))
    yield from _table("const int", f"{prefix}_jacobian_columns", f"{prefix}_J", map(str, columns))


def _table(kind: str, name: str, size: str, entries: Iterable[str]) -> Iterator[str]:
    """A constant array, as many entries per line as it holds."""
    yield f"{kind} {name}[{size}] = {{"
    line = "   "
    for entry in entries:
        if len(line) + len(entry) > LINE:
            yield line
            line = "   "
        line += f" {entry},"
    yield line.rstrip(",")
    yield "};"


def _parameter_units(model: Compiled) -> list[str]:
    """A unit for every entry of p."""
    table = model.parameters
    units: list[str] = []
    for name, where in table.slices.items():
        known = table.parameters.get(name) or table.derived.get(name)
        units += [known.unit if known is not None else "N*m*s/rad"] * (where.stop - where.start)
    return units


def _sources(model: Compiled) -> set[str]:
    """Parameters from which others were computed: alone they cannot be changed in C."""
    table, symbols = model.parameters, {}
    for name, parameter in table.parameters.items():
        symbols.update(dict.fromkeys(parameter.symbols, name))
    if table.slices[MODAL].stop > table.slices[MODAL].start:
        return set(table.parameters)  # modal damping rests on all masses and stiffnesses
    found = {source for derived in table.derived.values() for source in derived.arguments.values() if isinstance(source, str)}
    for parameter in table.parameters.values():
        if parameter.expression is not None:
            found |= {symbols[symbol] for symbol in parameter.expression.free_symbols if symbol in symbols}
    return found
