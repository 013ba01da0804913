"""What the net asks: every command on every catalogued driveline, briefly and at the settings that users take.

A question is a command line. It is asked in this process, on the virtual machine, with tables written to the last digit and no
picture rendered; its answer is what it prints and the folder that it fills.
"""

from __future__ import annotations

import contextlib
import math
import os
import shlex
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest import mock

import matplotlib as mpl
import matplotlib.figure
import numpy as np
from click.testing import CliRunner

import modelgen.elements  # noqa: F401 - makes the vocabulary known
from modelgen.cli.commands import commands
from modelgen.model import Element
from modelgen.reports import tables

TRUCK, COMMENSURATE, IDLE, GEAR = MODELS = (
    *("fracturing-truck", "fracturing-truck-commensurate", "fracturing-truck-idle"),
    "two-disk-gear",
)
LINEAR, RUN, RATTLE = 1e-12, 1e-9, 1e-6
"""How far a figure may be from the kept one, per largest of its kind: in questions of linear algebra, after a run in time, and
after a run at a fixed tolerance of 1e-6 through contacts, whose steps follow the last digit of the machine."""


@dataclass(frozen=True)
class Question:
    """A command line, and how far its figures may lie from the kept ones.

    OUT stands for the folder of the answer, RECORDING for a recording, TABLE:MODEL for a maker's table of that model.
    ``words``: what is printed is kept word by word. ``needs``: a module without which it is not asked; "cc" is a C compiler.
    """

    name: str
    line: str
    within: float = RUN
    words: bool = False
    needs: str = ""

    def __str__(self) -> str:
        return self.name


def short_questions() -> list[Question]:
    """Every command on every driveline, with horizons of milliseconds."""
    found = [Question("list", "list", LINEAR, words=True), Question("elements", "elements", LINEAR, words=True)]
    for model in MODELS:
        found += _linear(model, "4") + _runs(model, SHORT)
    found += _periodic(GEAR, "xi 0.03 0.06", SHORT) + _periodic(COMMENSURATE, "zeta 0.03 0.04", SHORT)
    found += _jumps(GEAR, "", "1700 rpm", "1800 rpm", "3", "20")
    found.append(replace(_sweep(TRUCK, "0.02:0.05:2", "0 s", "20 ms", "c"), name=f"{TRUCK}.sweep-in-c", needs="cc"))
    return found


def full_questions() -> list[Question]:
    """The commands at the settings that users take; what is kept is a digest of each table."""
    found = []
    for model in MODELS:
        found += _linear(model, "41")[2:] + _runs(model, FULL)
    found += _periodic(GEAR, "xi 0.02 0.08", FULL) + _periodic(COMMENSURATE, "zeta 0.02 0.05", FULL)
    found += _jumps(GEAR, "", "2500 rpm", "5000 rpm", "21", "200")
    found += _jumps(COMMENSURATE, " --mesh pump_mesh", "1850 rpm", "1950 rpm", "3", "4")
    found.append(Question("reproduce", "reproduce paper --quick --out OUT"))
    return found


@dataclass(frozen=True)
class Settings:
    """Lengths of the runs: of ``run``, ``compare``, ``crosscheck``, ``referee``, of a map and of a search for a period.

    ``tight``: for drivelines whose gears rattle; at the tolerance of every day their figures change with a machine's rounding.
    """

    run: str
    compare: str
    crosscheck: str
    referee: str
    sweep: tuple[str, str, str]
    limits: bool
    map: str
    strobes: str
    count: str
    lyapunov: str
    orbit: str
    tight: str


SHORT = Settings(
    run='--window "0 s" "20 ms" --crosscheck none',
    compare='--window "10 ms" "30 ms"',
    crosscheck='--end "5 ms" --solvers rk4,dopri5,dop853 --tolerances 1e-11',
    referee='--end "2 ms" --samples 51',
    sweep=("0.8:1:2", "0 s", "20 ms"),
    limits=False,
    map="--columns 2 --rows 2 --revolutions 1 --tolerance 1e-10",
    strobes="--strobes 16 --transient 4 --tolerance 1e-9",
    count="2",
    lyapunov="--revolutions 2 --transient 1 --tolerance 1e-9",
    orbit="--settle 6 --tolerance 1e-9",
    tight="--solver dop853 --tolerance 1e-12",
)
FULL = Settings(
    run="--crosscheck rk4,cvodes",
    compare='--window "1 s" "1.2 s"',
    crosscheck='--end "0.2 s"',
    referee='--end "20 ms"',
    sweep=("0.5:1:8", "0.5 s", "0.6 s"),
    limits=True,
    map="--columns 8 --rows 4 --revolutions 2",
    strobes="--strobes 60 --transient 60",
    count="11",
    lyapunov="--revolutions 100",
    orbit="",
    tight="",
)
SPEEDS = {GEAR: '"900 rpm" "1500 rpm"'}
COLUMN = {GEAR: "mesh.force=force"}


def _linear(model: str, count: str) -> list[Question]:
    """Questions without a run in time; the first two speak of the model itself."""
    speeds = SPEEDS.get(model, '"1700 rpm" "2100 rpm"')
    # Both sides of the idle truck's teeth touch: 1406 orders over a cycle of 2484 turns take minutes.
    low = " --highest-order 6" if model == IDLE else ""
    few = {IDLE: "2", COMMENSURATE: "2"}.get(model, count)
    asked = (
        ("check", f"check {model}", True),
        ("show", f"show {model}", True),
        ("modal", f"modal {model} --out OUT", False),
        ("campbell", f"campbell {model} --out OUT --speeds {speeds} --count {count}", False),
        ("forced", f"forced {model} --out OUT --speeds {speeds} --count {few} --no-refine{low}", False),
        ("limits-forced", f"limits {model} --out OUT --response forced", False),
        ("equivalent", f"equivalent {model} --out OUT/table.csv", True),
        ("new", f"new copy --from TABLE:{model} --out OUT/copy.toml", True),
        ("generate", f"generate {model} --out OUT", False),
    )
    return [
        Question(f"{model}.{name}", line, LINEAR, words)
        for name, line, words in asked
        # That of the idle truck takes all orders; the gear pair chooses no rule to be held against.
        if (model, name) not in ((IDLE, "limits-forced"), (GEAR, "limits-forced"))
    ]


def _runs(model: str, settings: Settings) -> list[Question]:
    """Questions of one run or of many."""
    column = COLUMN.get(model, "coupling.torque=torque")
    drive = "drive_mean" if model == GEAR else "firing_mean"
    span = '"250 N*m" "300 N*m"' if model == GEAR else '"900 N*m" "1000 N*m"'
    speeds = SPEEDS.get(model, '"1800 rpm" "1900 rpm"')
    axes = f"--first speed {speeds} --second {drive} {span}"
    tight = settings.tight if model in (GEAR, IDLE) else ""
    loaded = f'--set {drive}="{"300" if model == GEAR else "1000"} N*m"' if settings.tight and model in (GEAR, IDLE) else ""
    asked = [
        ("run", f"run {model} --out OUT {settings.run} {tight}", ""),
        ("compare", f"compare {model} RECORDING --out OUT --channel {column} {settings.compare} {loaded}", ""),
        ("crosscheck", f"crosscheck {model} --out OUT {settings.crosscheck}", ""),
        ("referee", f"referee {model} --out OUT {settings.referee}", "mujoco"),
        ("map", f"map {model} --out OUT {axes} {settings.map}", "" if model == GEAR else "cc"),
    ]
    if settings.limits and model != GEAR:
        asked.append(("limits", f"limits {model} --out OUT", ""))
    rattling = {(GEAR, "compare"), (IDLE, "run"), (IDLE, "crosscheck"), (IDLE, "referee")}
    runs = [
        Question(f"{model}.{name}", line, RATTLE if (model, name) in rattling else RUN, needs=needs)
        for name, line, needs in asked
    ]
    return [*runs, _sweep(model, *settings.sweep, "vm", tight)]


def _sweep(model: str, values: str, first: str, last: str, backend: str, more: str = "") -> Question:
    over = "drive.scale" if model == GEAR else "firing_1.scale"
    if backend == "c":
        over = "zeta"
    options = f'--window "{first}" "{last}" --samples 101 --workers 0 --backend {backend} {more}'
    return Question(f"{model}.sweep", f"sweep {model} --out OUT --over {over}={values} {options}")


def _periodic(model: str, over: str, settings: Settings) -> list[Question]:
    """Questions of motions that come back."""
    asked = (
        ("poincare", f"{settings.strobes}"),
        ("bifurcation", f"--over {over} --count {settings.count} {settings.strobes}"),
        ("orbit", settings.orbit),
        ("lyapunov", settings.lyapunov),
    )
    needs = "cc" if model == COMMENSURATE else ""  # a period of the pump is 10^5 evaluations
    return [Question(f"{model}.{name}", f"{name} {model} --out OUT {options}", needs=needs) for name, options in asked]


def _jumps(model: str, more: str, lowest: str, highest: str, count: str, transient: str) -> list[Question]:
    speeds = f'--speeds "{lowest}" "{highest}" --count {count} --transient {transient}'
    return [Question(f"{model}.transmission-error", f"transmission-error {model} --out OUT {speeds}{more}")]


def ask(question: Question, folder: Path) -> tuple[str, Path]:
    """What the command prints, and the folder that it filled. Raises AssertionError where it does not end well."""
    out = folder / "out"
    with pinned(native=question.needs == "cc"):
        line = _prepared(question.line, folder, out)
        if "OUT/" in question.line:
            out.mkdir()
        result = CliRunner().invoke(commands, shlex.split(line), prog_name="modelgen")
    assert result.exit_code == 0, f"{line}: {result.output}{result.exception!r}"
    return result.stdout.replace(str(out), "OUT"), out


def _prepared(line: str, folder: Path, out: Path) -> str:
    """The command line with its folder, and with the recording or table that it asks for, which is made here."""
    if "RECORDING" in line:
        recording = folder / "recording.csv"
        _write_recording(recording)
        line = line.replace("RECORDING", str(recording))
    if "TABLE:" in line:
        model = line.partition("TABLE:")[2].split()[0]
        table = folder / "table.csv"
        done = CliRunner().invoke(commands, ["equivalent", model, "--out", str(table)], prog_name="modelgen")
        assert done.exit_code == 0, done.output
        line = line.replace(f"TABLE:{model}", str(table))
    return line.replace("OUT", str(out))


def _write_recording(path: Path) -> None:
    """A recording that nobody made: two waves and a mean, 0.5 ms apart."""
    with path.open("w", encoding="utf-8") as file:
        file.write("time [s],torque [N*m],force [N]\n")
        for k in range(4001):
            t = 5e-4 * k
            wave = 900 + 300 * math.sin(2 * math.pi * 47.5 * t) + 80 * math.cos(2 * math.pi * 95 * t)
            file.write(f"{t!r},{wave!r},{2 * wave!r}\n")


@contextlib.contextmanager
def pinned(native: bool = False) -> Iterator[None]:
    """Tables to the last digit; no picture rendered, as its bytes are no figures; no C unless ``native``."""
    plain = np.savetxt

    def to_the_last_digit(*arguments: Any, **named: Any) -> None:
        plain(*arguments, **{**named, "fmt": "%.17g"})

    def cell(value: Any) -> Any:
        if isinstance(value, float):
            return repr(float(value)) if math.isfinite(value) else ""
        return "" if value is None else value

    # Elements that other tests of this process have defined are none of the product's.
    own = {kind: cls for kind, cls in Element.vocabulary.items() if cls.__module__.startswith("modelgen.")}
    environment = {} if native else {"CC": "no-compiler-in-the-net"}
    with (
        mock.patch.dict(os.environ, environment),
        mock.patch.dict(Element.vocabulary, own, clear=True),
        mock.patch.object(tables, "_cell", cell),
        mock.patch.object(np, "savetxt", to_the_last_digit),
        mock.patch.object(mpl.figure.Figure, "savefig"),
        mock.patch.object(mpl.figure.Figure, "draw_without_rendering"),
    ):
        yield
