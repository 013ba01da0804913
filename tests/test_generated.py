"""The folders of ``generated/``: fresh, and C that builds anywhere, runs clean, and says what the product says."""

from __future__ import annotations

import functools
import re
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from modelgen import assemble, load, lower, simulate
from modelgen.cli.generate_check import check_folder, read_manifest
from modelgen.cli.generate_folder import as_case
from modelgen.solvers import Solution

GENERATED = Path(__file__).resolve().parent.parent / "generated"
MODELS = sorted(folder.name for folder in GENERATED.iterdir() if folder.is_dir())
CC = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang") or ""
CXX = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++") or ""
SANITIZERS = ("-std=c99", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
STRICTER = ("-Wpedantic", "-Wshadow", "-Wconversion")
every_model = pytest.mark.parametrize("model", MODELS)
SLOW = ("fracturing-truck",)  # its text differs from that of the idle truck in numbers only
each_under_sanitizers = pytest.mark.parametrize(
    "model", [pytest.param(model, marks=[pytest.mark.slow] if model in SLOW else []) for model in MODELS]
)

DRIVER = """
#include "NAME.h"
#include <stdio.h>
#include <string.h>
/* Two runs with different parameters, in turn; then each alone. Fixed steps, and steps with error control. */
static void advance(MODEL_run *run, int adaptive, int k) {
  if (adaptive) MODEL_advance(run);
  else if (MODEL_step(run, 1e-5 * (double)k) != MODEL_OK) printf("failed\\n");
}
static void start(MODEL_run *run, int adaptive, int second) {
  double p[MODEL_P], x[MODEL_X];
  int i;
  for (i = 0; i < MODEL_P; ++i) {
    p[i] = MODEL_parameter_values[i];
    if (second && strcmp(MODEL_parameter_names[i], "xi") == 0) p[i] *= 2;
  }
  for (i = 0; i < MODEL_X; ++i) x[i] = MODEL_start[i];
  if (MODEL_init(run, 0, second ? x : 0, second ? p : 0) != MODEL_OK) printf("failed\\n");
  if (adaptive) MODEL_begin(run, 0.01, 1e-6);
}
int main(void) {
  MODEL_run together[2], alone;
  double x[MODEL_X], y[MODEL_X], rates[MODEL_X], outputs[MODEL_Y], jacobian[MODEL_J], difference = 0;
  int adaptive, k, second;
  for (adaptive = 0; adaptive < 2; ++adaptive) {
    for (second = 0; second < 2; ++second) start(&together[second], adaptive, second);
    for (k = 1; k <= 50; ++k)
      for (second = 0; second < 2; ++second) advance(&together[second], adaptive, k);
    for (second = 0; second < 2; ++second) {
      start(&alone, adaptive, second);
      for (k = 1; k <= 50; ++k) advance(&alone, adaptive, k);
      MODEL_state(&alone, alone.time, x);
      MODEL_state(&together[second], together[second].time, y);
      printf("%s ", memcmp(x, y, sizeof x) == 0 && alone.time > 0 && alone.steps == 50 ? "same" : "different");
      for (k = 0; k < MODEL_X; ++k) difference += second ? x[k] - rates[k] : 0;
      memcpy(rates, x, sizeof x);
    }
  }
  MODEL_rates(alone.c, alone.time, x, rates);
  MODEL_outputs(alone.c, alone.time, x, outputs);
  MODEL_jacobian(alone.c, alone.time, x, jacobian);
  printf("%s", difference != 0 ? "apart" : "the parameter changes nothing");
  return 0;
}
"""


def built(compiler: str, sources: Iterable[Path], target: Path, *options: str) -> Path:
    libraries = [] if "-c" in options else ["-lm"]
    order = [compiler, *options, *map(str, sources), *libraries, "-o", str(target)]
    done = subprocess.run(order, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    assert done.stderr == ""
    return target


def sources(model: str) -> list[Path]:
    return sorted((GENERATED / model).glob("*.c"))


def run(program: Path, *arguments: str, code: int = 0) -> str:
    done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == code, done.stderr
    return done.stdout if code == 0 else done.stderr


def trajectory(text: str) -> tuple[list[str], np.ndarray]:
    names, *rows = text.splitlines()
    return names.split(","), np.array([[float(value) for value in row.split(",")] for row in rows])


@functools.cache
def reference(name: str) -> Solution:
    """The default case by the product itself."""
    model = lower(assemble(load(name)))
    return simulate(as_case(model, read_manifest(GENERATED / name).case))


@functools.cache
def sanitized(model: str, place: Path) -> Path:
    """The equations under sanitizers, built once for all that is linked with them."""
    empty = place / "empty.c"
    empty.write_text("int main(void) { return 0; }\n")
    if subprocess.run([CC, *SANITIZERS, str(empty), "-o", str(place / "empty")], capture_output=True, check=False).returncode:
        pytest.skip(f"{CC} has no sanitizers")
    return built(CC, [GENERATED / model / f"{model}.c"], place / f"{model}.o", *SANITIZERS, "-c")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("generated")


@pytest.fixture
def compiler() -> str:
    if not CC:
        pytest.skip("there is no C compiler (cc, gcc, clang)")
    return CC


@every_model
def test_it_is_fresh(model: str) -> None:
    found = check_folder(GENERATED / model)
    assert found.problems == (), f"repair with: {found.repair}"


def test_there_are_showcases() -> None:
    assert {"fracturing-truck", "fracturing-truck-idle", "two-disk-gear"} <= set(MODELS)


@every_model
def test_the_program_builds_without_a_warning_and_ends_where_the_product_does(model: str, compiler: str, place: Path) -> None:
    program = built(compiler, sources(model), place / model, "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", *STRICTER)
    names, values = trajectory(run(program))
    solution = reference(model)
    assert names[0] == "time [s]"
    assert [name.partition(" ")[0] for name in names[1:]] == list(solution.channels)
    for name, column in zip(names[1:], values[:, 1:].T, strict=True):
        channel, unit = re.fullmatch(r"(\S+)(?: \[(.+)\])?", name).groups()
        expected = solution[channel]
        assert (unit or "1") == solution.unit(channel)
        size = np.abs(expected).max()
        assert abs(column[-1] - expected[-1]) <= 1e-9 * size, channel
        assert np.abs(column - expected).max() <= 1e-8 * size, channel
    assert np.allclose(values[:, 0], solution.times, rtol=1e-11, atol=0)


def test_fixed_steps_are_those_of_the_product(compiler: str, place: Path) -> None:
    program = built(compiler, sources("two-disk-gear"), place / "fixed", "-std=c99", "-O2")
    names, values = trajectory(run(program, "--fixed", "3e-5", "--end", "0.004", "--samples", "5", "xi=0.08"))
    model = lower(assemble(load("two-disk-gear")))
    case = as_case(model, read_manifest(GENERATED / "two-disk-gear").case)
    changed = case.change(end=0.004, samples=5, options={"fixed_step": 3e-5}, parameters={"xi": 0.08})
    solution = simulate(changed)
    for name, column in zip(names[1:], values[:, 1:].T, strict=True):
        expected = solution[name.partition(" ")[0]]
        assert np.abs(column - expected).max() <= 1e-10 * np.abs(expected).max(), name


def test_the_step_control_is_that_of_the_product(compiler: str, place: Path) -> None:
    """Under load no flank parts, so at a coarse tolerance too the steps are the same but for rounding."""
    program = built(compiler, sources("fracturing-truck"), place / "control", "-std=c99", "-O0")
    names, values = trajectory(run(program, "--tolerance", "1e-5"))
    model = lower(assemble(load("fracturing-truck")))
    solution = simulate(as_case(model, read_manifest(GENERATED / "fracturing-truck").case).change(tolerance=1e-5))
    for name, column in zip(names[1:], values[:, 1:].T, strict=True):
        expected = solution[name.partition(" ")[0]]
        assert np.abs(column - expected).max() <= 1e-9 * np.abs(expected).max(), name


@every_model
def test_it_is_also_cpp(model: str, compiler: str, place: Path) -> None:
    if not CXX:
        pytest.skip("there is no C++ compiler (c++, g++, clang++)")
    program = place / f"{model}.cpp"
    built(CXX, sources(model), program, "-x", "c++", "-std=c++11", "-O0", "-Wall", "-Wextra", "-Werror", *STRICTER)
    assert run(program, "--samples", "2", "--end", "1e-4").count("\n") == 3


@each_under_sanitizers
def test_runs_side_by_side_do_not_meet(model: str, compiler: str, place: Path) -> None:
    driver = place / f"{model}_driver.c"
    driver.write_text(DRIVER.replace("NAME", model).replace("MODEL", model.replace("-", "_")))
    options = (*SANITIZERS, "-Wall", "-Wextra", "-Werror", f"-I{GENERATED / model}")
    program = built(compiler, [driver, sanitized(model, place)], place / f"{model}_driver", *options)
    assert run(program) == "same same same same apart"


@each_under_sanitizers
def test_the_program_is_clean_under_sanitizers(model: str, compiler: str, place: Path) -> None:
    parts = [GENERATED / model / f"{model}_solver.c", sanitized(model, place)]
    program = built(compiler, parts, place / f"{model}_clean", *SANITIZERS)
    assert run(program, "--end", "1e-3", "--tolerance", "1e-8").count("\n") == 202
    assert run(program, "--end", "1e-3", "--fixed", "1e-5", "xi=0.2").count("\n") == 202


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nothing",), "neither an option nor NAME=VALUE of a parameter"),
        (("xj=1",), "neither an option nor NAME=VALUE of a parameter"),
        (("xi=nan",), "give a finite number"),
        (("xi=1x",), "give a finite number"),
        (("xi=",), "give a finite number"),
        (("mesh.module=0.004",), "others were computed from it; change the model and generate anew"),
        (("--end", "0"), "is no option, or what follows it is no such number"),
        (("--end",), "is no option, or what follows it is no such number"),
        (("--fixed", "inf"), "is no option, or what follows it is no such number"),
        (("--samples", "1"), "is no option, or what follows it is no such number"),
        (("--unknown", "1"), "is no option, or what follows it is no such number"),
    ],
)
def test_the_program_refuses_in_one_line(arguments: tuple[str, ...], words: str, compiler: str, place: Path) -> None:
    program = place / "refusing"
    if not program.exists():
        built(compiler, sources("two-disk-gear"), program, "-std=c99", "-O0")
    message = run(program, *arguments, code=2)
    assert words in message
    assert message.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--fixed", "0.01", "--end", "1000"), "a state has diverged"),
        (("pinion.inertia=0",), "stopped at 0 s: a rate or state is no finite number"),
    ],
)
def test_a_run_that_fails_says_where(arguments: tuple[str, ...], words: str, compiler: str, place: Path) -> None:
    program = place / "failing"
    if not program.exists():
        built(compiler, sources("two-disk-gear"), program, "-std=c99", "-O0")
    assert words in run(program, *arguments, code=1)


@every_model
def test_it_carries_no_license_no_place_and_no_date(model: str) -> None:
    for path in (GENERATED / model).iterdir():
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"licen[sc]e|copyright|/home/|/tmp/|/work/|\b20\d\d-\d\d-\d\d", text, re.IGNORECASE), path.name


@every_model
def test_nothing_is_global_or_allocated(model: str) -> None:
    text = (GENERATED / model / f"{model}.c").read_text(encoding="utf-8")
    assert not re.search(r"\b(malloc|calloc|realloc|free|static double \w+[;=\[])\b", text)
    variables = re.findall(r"^(?!static|void|int|#|/| |}|typedef|INLINE|S_)(\w.*)$", text, re.MULTILINE)
    assert all(line.startswith("const ") for line in variables), variables
