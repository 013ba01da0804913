"""The rules of the house, read from the source of ``modelgen`` without running it.

1. Water flows down: a package imports only from those above it in FLOW, also inside functions and for type checkers; where a
   package has rooms, a room imports only from those above it in ROOMS.
2. Each tool has its floor (FLOORS).
3. The grammar knows no element by name: ``equations`` does not import ``elements``.

And: no text reaches an evaluator; a file holds one idea, says which, and is named after it; ``import modelgen`` is light.
Every rule is shown to fail on a small bad source before it is trusted on the tree.
"""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

FLOW = (
    *("errors", "units", "model", "gears", "elements", "drivelines", "equations", "lowering", "solvers", "exchange"),
    *("analysis", "plots", "reports", "notebook", "cli", "__main__"),
)
FLOORS = {
    "sympy": {"model", "elements", "equations", "lowering"},
    "mpmath": {"model", "elements", "equations", "lowering"},
    "casadi": {"lowering", "solvers", "analysis"},
    "matplotlib": {"plots"},
    "pint": {"units"},
}
ROOMS = {  # the order within a package; its own __init__ stands below them all
    "analysis": (
        *("linear", "time_domain", "nonlinear", "stability", "classification"),
        *("limits", "measurements", "referee", "sweeps"),
    ),
}
LIGHT_START = {"errors", "units"}  # what modelgen/__init__.py may load before anybody asks for more

EVALUATORS = {"eval", "exec", "compile", "__import__"}  # as plain names: re.compile is another matter
EVALUATING_FUNCTIONS = {"sympify", "parse_expr", "lambdify", "import_module"}  # under any module's name
EVALUATING_MODULES = {"pickle", "cPickle", "dill", "cloudpickle", "shelve", "marshal", "code", "runpy"}
LOADS_BY_NAME = {"modelgen/__init__.py"}  # loads its own packages, by names written there, when they are first asked for

SAYS_NOTHING = re.compile(r"(^|_)(utils?|helpers?|managers?|misc|common)$|^base$")
LONGEST = 300
LONGER: dict[str, str] = {}  # path: why this one idea needs more lines


@dataclass(frozen=True)
class Import:
    """One imported name, in full: ``modelgen.units.to_si`` or ``sympy.Symbol``."""

    target: str
    line: int
    deferred: bool  # not carried out when the module is loaded

    @property
    def package(self) -> str:
        return self.target.split(".")[0]

    @property
    def room(self) -> str | None:
        """The package of modelgen that is imported; empty for modelgen itself, None for anything else."""
        first, *rest = self.target.split(".")
        return None if first != "modelgen" else rest[0] if rest else ""


@dataclass(frozen=True)
class Module:
    """A source file of modelgen by its path from the root of the project."""

    path: str
    source: str

    @functools.cached_property
    def tree(self) -> ast.Module:
        return ast.parse(self.source, self.path)

    @property
    def dotted(self) -> list[str]:
        """The package that the file stands in, as relative imports count from it."""
        return self.path.split("/")[:-1]

    @property
    def room(self) -> str:
        """The package of modelgen that the file belongs to; empty for modelgen/__init__.py."""
        parts = self.path.removesuffix(".py").split("/")
        return "" if parts[1] == "__init__" else parts[1]

    def imports(self) -> Iterator[Import]:
        yield from self._imports_in(self.tree, deferred=False)

    def _imports_in(self, node: ast.AST, deferred: bool) -> Iterator[Import]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                for alias in child.names:
                    yield Import(alias.name, child.lineno, deferred)
            elif isinstance(child, ast.ImportFrom):
                above = self.dotted[: len(self.dotted) - child.level + 1] if child.level else []
                origin = [*above, *([child.module] if child.module else [])]
                for alias in child.names:
                    yield Import(".".join([*origin, alias.name]), child.lineno, deferred)
            else:
                later = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) or _only_for_type_checkers(child)
                yield from self._imports_in(child, deferred or later)

    def at(self, line: int, words: str) -> str:
        return f"{self.path}:{line}: {words}"


def _only_for_type_checkers(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}


def water_flows_down(module: Module) -> Iterator[str]:
    if module.room and module.room not in FLOW:
        yield module.at(1, f"'{module.room}' has no place in the flow; give it one in FLOW")
        return
    for found in module.imports():
        if found.room is None or found.room == module.room:
            continue
        if found.room not in FLOW:
            # Through its lazy names, modelgen itself would lead anywhere.
            if found.target != "modelgen.__version__":
                yield module.at(found.line, f"imports {found.target}; import from the package that defines it")
        elif not module.room:
            if not found.deferred and found.room not in LIGHT_START:
                yield module.at(found.line, f"loads {found.room} at once; import it where it is used")
        elif FLOW.index(found.room) > FLOW.index(module.room):
            yield module.at(found.line, f"{module.room} imports {found.room}, which stands below it")


def rooms_flow_one_way(module: Module) -> Iterator[str]:
    package, inside = module.room, module.path.split("/")[2:]
    order = ROOMS.get(package, ())
    if not order or inside == ["__init__.py"]:
        return
    here = inside[0]
    if here not in order:
        yield module.at(1, f"'{here}' has no place among the rooms of {package}; give it one in ROOMS")
        return
    for found in module.imports():
        if found.room != package:
            continue
        there = (*found.target.split("."), "")[2]
        if there not in order:
            # Through the names that it shows to others, the package itself would lead anywhere.
            yield module.at(found.line, f"imports {found.target}; import from the room that defines it")
        elif order.index(there) > order.index(here):
            yield module.at(found.line, f"{package}.{here} imports {package}.{there}, which stands below it")


def tools_keep_their_floor(module: Module) -> Iterator[str]:
    for found in module.imports():
        if module.room not in FLOORS.get(found.package, {module.room}):
            yield module.at(found.line, f"{found.package} belongs to {', '.join(sorted(FLOORS[found.package]))}")


def grammar_knows_no_element(module: Module) -> Iterator[str]:
    for found in module.imports():
        if module.room == "equations" and found.room == "elements":
            yield module.at(found.line, "equations imports elements; take what is needed from the records of model")


def text_meets_no_evaluator(module: Module) -> Iterator[str]:
    for found in module.imports():
        name = found.target.split(".")[-1]
        if found.package in EVALUATING_MODULES:
            yield module.at(found.line, f"{found.package} runs what it reads")
        elif name in EVALUATING_FUNCTIONS and module.path not in LOADS_BY_NAME:
            yield module.at(found.line, f"{name} runs what it reads")
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Call) and (called := _evaluator(node)) and module.path not in LOADS_BY_NAME:
            yield module.at(node.lineno, f"{called} runs what it reads")


def _evaluator(call: ast.Call) -> str | None:
    """The name of a called function that turns text or bytes into something that runs."""
    path = ast.unparse(call.func).split(".")
    if path[-1] in EVALUATING_FUNCTIONS or (path[-1] in EVALUATORS and path[:-1] in ([], ["builtins"])):
        return path[-1]
    if path == ["S"] or path in (["sympy", "S"], ["sp", "S"]):
        return "S"  # short for sympify
    if path[-2:] in (["Function", "load"], ["Function", "deserialize"]):
        return ".".join(path[-2:])
    allowed = [keyword.value for keyword in call.keywords if keyword.arg == "allow_pickle"]
    return "allow_pickle" if any(ast.unparse(value) != "False" for value in allowed) else None


def names_say_what(module: Module) -> Iterator[str]:
    for part in module.path.removesuffix(".py").split("/"):
        if SAYS_NOTHING.search(part):
            yield module.at(1, f"'{part}' does not say what is inside")


def heads_say_why(module: Module) -> Iterator[str]:
    if not (ast.get_docstring(module.tree) or "").strip():
        yield module.at(1, "has no docstring; say where it stands in the flow and which source it follows")


def a_file_holds_one_idea(module: Module) -> Iterator[str]:
    lines = len(module.source.splitlines())
    if lines > LONGEST and module.path not in LONGER:
        yield module.at(LONGEST + 1, f"has {lines} lines; find the second idea and give it a file")
    if lines <= LONGEST and module.path in LONGER:
        yield module.at(1, f"has only {lines} lines; take it off LONGER")


Rule = Callable[[Module], Iterator[str]]
RULES: tuple[Rule, ...] = (
    *(water_flows_down, rooms_flow_one_way, tools_keep_their_floor, grammar_knows_no_element),
    *(text_meets_no_evaluator, names_say_what, heads_say_why, a_file_holds_one_idea),
)


@pytest.fixture(scope="module")
def house() -> list[Module]:
    files = sorted((ROOT / "modelgen").rglob("*.py"))
    return [Module(file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8")) for file in files]


def test_the_whole_tree_is_read(house: list[Module]) -> None:
    assert {"modelgen/errors.py", "modelgen/units.py", "modelgen/__main__.py"} <= {module.path for module in house}
    assert {found.target for module in house for found in module.imports()} >= {"modelgen.errors.UnitError", "pint"}
    assert set(LONGER) <= {module.path for module in house}
    for package, rooms in ROOMS.items():
        assert {f"modelgen/{package}/{room}/__init__.py" for room in rooms} <= {module.path for module in house}


@pytest.mark.parametrize("rule", RULES)
def test_the_house_keeps(rule: Rule, house: list[Module]) -> None:
    broken = [words for module in house for words in rule(module)]
    assert not broken, "\n".join(["", *broken])


BAD: list[tuple[Rule, str, str, str]] = [
    (water_flows_down, "model/line.py", "import modelgen.cli", "model imports cli"),
    (water_flows_down, "model/line.py", "from modelgen.solvers import simulate", "model imports solvers"),
    (water_flows_down, "model/line.py", "from modelgen import plots", "model imports plots"),
    (water_flows_down, "model/line.py", "def f():\n    from modelgen.plots import draw", "line.py:2: model imports plots"),
    (water_flows_down, "model/line.py", "from ..gears import geometry", "model imports gears"),
    (water_flows_down, "model/__init__.py", "from ..gears.geometry import Pair", "model imports gears"),
    (water_flows_down, "model/deep/line.py", "from ... import gears", "model imports gears"),
    (water_flows_down, "units.py", "from . import model", "units imports model"),
    (water_flows_down, "errors.py", "from .units import to_si", "errors imports units"),
    (water_flows_down, "model/line.py", "if TYPE_CHECKING:\n    from modelgen.gears import Pair", "model imports gears"),
    (water_flows_down, "analysis/linear/modal.py", "try:\n    from modelgen import notebook\nfinally:\n    pass", "notebook"),
    (water_flows_down, "cli/run.py", "from modelgen import simulate", "import from the package that defines it"),
    (water_flows_down, "cli/run.py", "import modelgen", "import from the package that defines it"),
    (water_flows_down, "cli/run.py", "from modelgen import *", "import from the package that defines it"),
    (water_flows_down, "extras/thing.py", "", "'extras' has no place in the flow"),
    (water_flows_down, "__init__.py", "from modelgen.model import Driveline", "loads model at once"),
    (rooms_flow_one_way, "analysis/modal.py", "", "'modal.py' has no place among the rooms of analysis"),
    (rooms_flow_one_way, "analysis/extras/__init__.py", "", "'extras' has no place among the rooms of analysis"),
    (rooms_flow_one_way, "analysis/linear/modal.py", "from modelgen.analysis.limits.check import Row", "imports analysis.limits"),
    (rooms_flow_one_way, "analysis/linear/modal.py", "from modelgen.analysis.limits import check", "imports analysis.limits"),
    (rooms_flow_one_way, "analysis/linear/modal.py", "def f():\n    import modelgen.analysis.sweeps", "modal.py:2: analysis"),
    (rooms_flow_one_way, "analysis/linear/modal.py", "from ..stability.orbits import Orbit", "imports analysis.stability"),
    (rooms_flow_one_way, "analysis/sweeps/sweep.py", "from modelgen.analysis import modal", "from the room that defines it"),
    (rooms_flow_one_way, "analysis/sweeps/sweep.py", "import modelgen.analysis", "from the room that defines it"),
    (tools_keep_their_floor, "solvers/rk4.py", "import sympy as sp", "sympy belongs to elements, equations"),
    (tools_keep_their_floor, "gears/mesh.py", "from sympy import Symbol", "sympy belongs to"),
    (tools_keep_their_floor, "analysis/linear/modal.py", "def f():\n    import sympy.physics.mechanics", "modal.py:2: sympy"),
    (tools_keep_their_floor, "equations/assembly.py", "import casadi as ca", "casadi belongs to analysis, lowering, solvers"),
    (tools_keep_their_floor, "notebook.py", "import matplotlib.pyplot as plt", "matplotlib belongs to plots"),
    (tools_keep_their_floor, "cli/check.py", "from pint import UnitRegistry", "pint belongs to units"),
    (tools_keep_their_floor, "__init__.py", "def __getattr__(name):\n    import casadi", "casadi belongs to"),
    (grammar_knows_no_element, "equations/assembly.py", "from modelgen.elements.shaft import Shaft", "imports elements"),
    (grammar_knows_no_element, "equations/assembly.py", "from modelgen import elements", "imports elements"),
    (grammar_knows_no_element, "equations/assembly.py", "def f():\n    from .. import elements", "assembly.py:2"),
    (text_meets_no_evaluator, "model/file.py", "x = eval(text)", "eval runs"),
    (text_meets_no_evaluator, "model/file.py", "import builtins\nbuiltins.exec(text)", "exec runs"),
    (text_meets_no_evaluator, "model/file.py", "code = compile(text, 'x', 'exec')", "compile runs"),
    (text_meets_no_evaluator, "model/file.py", "__import__(text)", "__import__ runs"),
    (text_meets_no_evaluator, "model/file.py", "import importlib\nimportlib.import_module(text)", "import_module runs"),
    (text_meets_no_evaluator, "model/file.py", "import sympy as sp\nsp.sympify(text)", "sympify runs"),
    (text_meets_no_evaluator, "model/file.py", "import sympy as sp\nsp.S(text)", "S runs"),
    (text_meets_no_evaluator, "model/file.py", "from sympy import sympify as read", "sympify runs"),
    (text_meets_no_evaluator, "model/file.py", "from sympy.parsing.sympy_parser import parse_expr", "parse_expr runs"),
    (text_meets_no_evaluator, "lowering/call.py", "import sympy as sp\nsp.lambdify(x, e)", "lambdify runs"),
    (text_meets_no_evaluator, "lowering/call.py", "import casadi as ca\nca.Function.load(path)", "Function.load runs"),
    (text_meets_no_evaluator, "lowering/call.py", "Function.deserialize(text)", "Function.deserialize runs"),
    (text_meets_no_evaluator, "solvers/solution.py", "import pickle", "pickle runs"),
    (text_meets_no_evaluator, "solvers/solution.py", "def f():\n    from pickle import loads", "solution.py:2: pickle runs"),
    (text_meets_no_evaluator, "solvers/solution.py", "np.load(path, allow_pickle=True)", "allow_pickle runs"),
    (names_say_what, "model/utils.py", "", "'utils' does not say"),
    (names_say_what, "model/unit_helpers.py", "", "'unit_helpers' does not say"),
    (names_say_what, "solvers/base.py", "", "'base' does not say"),
    (names_say_what, "analysis/manager/modal.py", "", "'manager' does not say"),
    (heads_say_why, "model/line.py", "x = 1", "has no docstring"),
    (heads_say_why, "model/__init__.py", "", "has no docstring"),
    (heads_say_why, "model/line.py", '"""  """', "has no docstring"),
    (a_file_holds_one_idea, "model/line.py", "x = 1\n" * (LONGEST + 1), "has 301 lines"),
]


@pytest.mark.parametrize(("rule", "path", "source", "words"), BAD)
def test_a_broken_rule_is_found(rule: Rule, path: str, source: str, words: str) -> None:
    assert words in "\n".join(rule(Module(f"modelgen/{path}", source)))


def test_every_rule_can_fail() -> None:
    assert {rule for rule, *_ in BAD} == set(RULES)


def test_a_file_that_has_become_short_leaves_the_list(monkeypatch: pytest.MonkeyPatch) -> None:
    module = Module("modelgen/model/line.py", "x = 1\n" * (LONGEST + 1))
    monkeypatch.setitem(LONGER, module.path, "one table")
    assert not list(a_file_holds_one_idea(module))
    assert "take it off LONGER" in "".join(a_file_holds_one_idea(Module(module.path, "x = 1")))


GOOD = [
    ("model/line.py", "from modelgen.errors import ModelError\nfrom ..units import to_si\nfrom .flange import Flange"),
    ("model/base_frequency.py", "import re\nPATTERN = re.compile('a')\nclass F:\n    @classmethod\n    def eval(cls, x): ..."),
    ("model/exact.py", "import sympy as sp\nhalf = sp.S.Half\nthird = sp.Rational('1/3')"),
    ("equations/assembly.py", "from modelgen.model import Driveline\nimport numpy as np\nnp.load(path, allow_pickle=False)"),
    ("lowering/visitor.py", "import sympy as sp\nimport casadi as ca\nca.Function('f', [], [])"),
    ("analysis/limits/check.py", "from modelgen.analysis.linear import modal\nfrom modelgen.analysis.limits import rulebook"),
    ("analysis/__init__.py", "from modelgen.analysis.sweeps.sweep import sweep"),
    ("notebook.py", "from modelgen.plots import draw"),
    ("cli/run.py", "from modelgen import __version__\nfrom modelgen.drivelines import catalogue"),
    ("__main__.py", "from modelgen.cli import main"),
    ("__init__.py", "from modelgen.errors import ModelError\ndef __getattr__(name):\n    from modelgen.model import Driveline"),
    ("__init__.py", "import importlib\nif TYPE_CHECKING:\n    from modelgen.model import Flange\nimportlib.import_module(name)"),
]


@pytest.mark.parametrize(("path", "source"), GOOD)
def test_what_is_lawful_passes(path: str, source: str) -> None:
    module = Module(f"modelgen/{path}", f'"""What it is."""\n{source}\n')
    assert [words for rule in RULES for words in rule(module)] == []


def loaded_after(statement: str) -> set[str]:
    """Top-level names of the modules that a new interpreter holds after a statement."""
    report = "import sys\nprint('loaded:', *{name.split('.')[0] for name in sys.modules})"
    command = [sys.executable, "-W", "error", "-c", f"{statement}\n{report}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].removeprefix("loaded:").split())


def test_heavy_packages_are_seen_when_loaded() -> None:
    assert loaded_after("import sympy") & FLOORS.keys() >= {"sympy", "mpmath"}


def test_import_is_light() -> None:
    loaded = loaded_after("import modelgen")
    assert "modelgen" in loaded
    assert not loaded & FLOORS.keys()


@pytest.mark.skipif(not (ROOT / "modelgen/cli/__init__.py").exists(), reason="there is no command line yet")
def test_help_is_light() -> None:
    ask_for_help = "\n".join(
        [
            "import runpy, sys",
            "sys.argv = ['modelgen', '--help']",
            "try: runpy.run_module('modelgen', run_name='__main__')",
            "except SystemExit as end: assert not end.code, end.code",
        ]
    )
    loaded = loaded_after(ask_for_help)
    assert "modelgen" in loaded
    assert not loaded & FLOORS.keys()
