"""Rules of the house that the tree does not keep yet: each is a count, which may only fall.

Whoever lowers a count writes the lower one here.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent / "modelgen"
BEFORE_ROLES = {"model", "gears", "elements", "errors.py", "units.py"}  # where names and kinds are given
SUFFIX_TESTS = {"endswith", "removesuffix", "startswith"}
KINDS = {"inertia", "shaft", "gear_pair", "harmonic_torque", "brake", "elastic_stop", "hard_stop", "rigid_gear"}
LONGEST_FUNCTION = 60


@functools.cache
def sources() -> dict[str, ast.Module]:
    """The files of the package by their dotted names."""
    found = {}
    for path in sorted(ROOT.rglob("*.py")):
        dotted = ".".join(path.relative_to(ROOT.parent).with_suffix("").parts).removesuffix(".__init__")
        found[dotted] = ast.parse(path.read_text(encoding="utf-8"))
    return found


@functools.cache
def imports(name: str) -> frozenset[str]:
    """The files of the package that one imports, wherever it does so."""
    return frozenset(_imports(sources()[name]))


def _imports(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("modelgen"):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                yield whole if whole in sources() else node.module


def texts(nodes: list[ast.expr]) -> set[str]:
    """The texts that are written out in some expressions."""
    constants = (each.value for node in nodes for each in ast.walk(node) if isinstance(each, ast.Constant))
    return {value for value in constants if isinstance(value, str)}


def name_tests() -> list[str]:
    """Places after ``model`` that read a meaning out of a name's suffix, or ask for an element by its kind."""
    found = []
    for name, tree in sources().items():
        if (name.split(".")[1:] or [""])[0] in {each.removesuffix(".py") for each in BEFORE_ROLES}:
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in SUFFIX_TESTS:
                if any(text.startswith(".") for text in texts(node.args)):
                    found.append(f"{name}:{node.lineno}")
            elif isinstance(node, ast.Compare) and "kind" in ast.unparse(node.left) and KINDS & texts(node.comparators):
                found.append(f"{name}:{node.lineno}")
    return found


def long_functions() -> list[str]:
    """Functions of more than sixty lines."""
    kinds = ast.FunctionDef | ast.AsyncFunctionDef
    return [
        f"{name}.{node.name}"
        for name, tree in sources().items()
        for node in ast.walk(tree)
        if isinstance(node, kinds) and (node.end_lineno or 0) - node.lineno + 1 > LONGEST_FUNCTION
    ]


def circles() -> list[str]:
    """Groups of files that import each other, also inside functions and for type checkers."""
    reached: dict[str, set[str]] = {}

    def reach(name: str) -> set[str]:
        if name not in reached:
            reached[name], edge = set(), [name]
            while edge:
                more = imports(edge.pop()) & sources().keys() - reached[name]
                reached[name] |= more
                edge += more
        return reached[name]

    within = [name for name in sources() if name in reach(name)]
    groups = {frozenset(each for each in within if each in reach(name) and name in reach(each)) for name in within}
    return [", ".join(sorted(group)) for group in groups if len(group) > 1]


def arrows() -> list[str]:
    """Pairs of packages of which one imports the other."""
    pairs = set()
    for name in sources():
        for other in imports(name):
            here, there = ((*each.split("."), "")[1] for each in (name, other))
            if here and there and here != there:
                pairs.add(f"{here} -> {there}")
    return sorted(pairs)


@pytest.mark.parametrize(
    ("count", "known"),
    [(name_tests, 50), (long_functions, 8), (circles, 3), (arrows, 68)],
    ids=["name tests after model", "functions over sixty lines", "circles of files", "arrows between packages"],
)
def test_a_count_falls(count, known):
    found = count()
    assert len(found) <= known, "\n".join(found)
    assert len(found) == known, f"there are only {len(found)} left: write that down here"


def test_the_counters_see_what_they_count():
    assert any(place.startswith("modelgen.analysis.time_domain.angles:") for place in name_tests())
    assert "analysis -> solvers" in arrows()
    assert "modelgen.model" not in " ".join(name_tests())
