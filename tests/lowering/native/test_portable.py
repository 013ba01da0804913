"""The portable C of a model: clean under strict warnings as C99 and as C++, and right."""

from __future__ import annotations

import ctypes
import dataclasses
import re
import shutil
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from modelgen import assemble, load, lower
from modelgen.errors import LoweringError, NamingError
from modelgen.lowering import Compiled
from modelgen.lowering.native.portable import portable_stages
from modelgen.lowering.native.portable_files import DefaultCase, harmless, portable_files

COMPILER = shutil.which("gcc") or shutil.which("clang") or "none"
WARNINGS = ("-Wall", "-Wextra", "-Werror", "-pedantic", "-Wshadow", "-Wconversion")
STRICT = (*WARNINGS, "-O1", "-ffp-contract=off", "-fPIC", "-shared", "-lm")
needs_compiler = pytest.mark.skipif(COMPILER == "none", reason="there is neither gcc nor clang")
needs_cpp = pytest.mark.skipif(shutil.which("g++") is None, reason="there is no g++")


def built(files: dict[str, str], folder: Path, *language: str) -> ctypes.CDLL:
    for name, text in files.items():
        (folder / name).write_text(text)
    sources = [name for name in files if name.endswith(".c") and not name.endswith("_solver.c")]
    order = [COMPILER, *language, *sources, "-o", "model.so", *STRICT]
    done = subprocess.run(order, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return ctypes.CDLL(str(folder / "model.so"))


def case_of(model: Compiled) -> DefaultCase:
    """A case with the model's own values, from rest."""
    n = len(model.states)
    return DefaultCase(tuple(model.parameters.vector().tolist()), (0.0,) * n, (1.0,) * n, 0.1, 11, 1e-6)


def sizes_of(header: str) -> dict[str, int]:
    return {name: int(size) for name, size in re.findall(r"_([XPYJCW]) = (\d+)", header)}


@needs_compiler
def test_rates_outputs_and_jacobian_of_a_truck_with_two_sets_of_parameters_at_once(tmp_path: Path) -> None:
    model = lower(assemble(load("fracturing-truck")))
    files = portable_files(model, case_of(model))
    library = built(files, tmp_path, "-std=c99")
    size = sizes_of(files["fracturing-truck.h"])
    assert (size["X"], size["P"], size["Y"]) == (len(model.states), model.parameters.size, len(model.outputs))
    pointer = ctypes.POINTER(ctypes.c_double)

    def call(name: str, *arguments: np.ndarray | float) -> None:
        plain = [ctypes.c_double(a) if isinstance(a, float) else a.ctypes.data_as(pointer) for a in arguments]
        getattr(library, f"fracturing_truck_{name}")(*plain)

    rows, columns = (
        np.array((ctypes.c_int * size["J"]).in_dll(library, f"fracturing_truck_jacobian_{name}")) for name in ("rows", "columns")
    )
    sets = [model.parameters.vector(values) for values in ({}, {"zeta": 0.05})]
    prepared = [np.zeros(size["C"]) for _ in sets]
    for p, c in zip(sets, prepared, strict=True):
        call("prepare", p, c)
    rng, n = np.random.default_rng(4), len(model.states) // 2
    units = np.array(model.units)
    for _ in range(20):
        x, t = 1e-2 * rng.standard_normal(2 * n), float(rng.uniform(0, 0.02))
        for p, c in zip(sets, prepared, strict=True):
            rates, outputs, entries, jacobian = (
                np.zeros(2 * n),
                np.zeros(size["Y"]),
                np.zeros(size["J"]),
                np.zeros((2 * n, 2 * n)),
            )
            for name, target in (("rates", rates), ("outputs", outputs), ("jacobian", entries)):
                call(name, c, t, x, target)
            expected = model.rhs(t, x, p)
            for group in (slice(0, n), slice(n, 2 * n)):
                assert np.abs(rates - expected)[group].max() <= 1e-13 * np.abs(expected[group]).max()
            jacobian[rows, columns] = entries
            wanted = model.jacobian(t, x, p)
            assert np.abs(jacobian - wanted).max() <= 1e-13 * np.abs(wanted).max()
            channels = np.array(list(model.evaluate(t, x, p).values()))
            for unit in set(model.units):
                assert np.abs(outputs - channels)[units == unit].max() <= 1e-12 * max(
                    np.abs(channels[units == unit]).max(), 1e-300
                )


@needs_compiler
@pytest.mark.parametrize("language", [("-std=c99",), pytest.param(("-x", "c++", "-std=c++11"), marks=needs_cpp)])
def test_every_kind_of_operation_is_clean_in_both_languages(tmp_path: Path, language: tuple[str, ...]) -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(ca.if_else(x[0] > p[0], ca.erf(x[1]), ca.fmax(x[0], 2)), ca.sin(p[1] * t) + ca.sign(x[1]) ** 2)
    stages = portable_stages({"rates": ca.Function("f", [t, x, p], [rates])}, "small")
    head = f"enum {{ small_W = {stages.timed} }};\n"
    head += '#ifdef __cplusplus\nextern "C" {\n#endif\nvoid small_prepare(const double *p, double *c);\n'
    head += "void small_rates(const double *c, double t, const double *x, double *r);\n#ifdef __cplusplus\n}\n#endif\n"
    library = built({"small.c": head + stages.text}, tmp_path, *language)
    numbers = ctypes.c_double * 2
    c, found = (ctypes.c_double * max(1, stages.prepared))(), numbers()
    library.small_prepare(numbers(0.5, 3.0), c)
    library.small_rates(c, ctypes.c_double(0.25), numbers(0.7, -0.2), found)
    assert np.allclose(found, [-0.22270258921047847, 1 + np.sin(0.75)], rtol=1e-14, atol=0)  # erf(-0.2): DLMF 7.23


def test_a_function_computes_only_what_it_needs() -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    functions = {
        "rates": ca.Function("f", [t, x, p], [-p * x]),
        "outputs": ca.Function("g", [t, x, p], [ca.sin(p * t) * x]),
    }
    text = portable_stages(functions, "m").text
    rates = text.split("static void rates_at")[1].split("void m_rates")[0]
    assert "clock" not in rates
    assert "clock" in text.split("static void outputs_at")[1]


@pytest.mark.parametrize("prefix", ["", "1a", "a-b", "a;int b", "a" * 64])
def test_a_prefix_is_an_identifier(prefix: str) -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    with pytest.raises(LoweringError, match="is no prefix of C names; give letters"):
        portable_stages({"rates": ca.Function("f", [t, x, p], [x])}, prefix)


@pytest.mark.parametrize("text", ['a"; system("x"); //', "a*/ int b; /*", "a\nb", "a\\", "a??/", "é", "", "a" * 401, "a//b"])
def test_what_ends_a_comment_or_a_string_is_refused(text: str) -> None:
    with pytest.raises(LoweringError, match="may not stand in C; give letters"):
        harmless(text)


@pytest.fixture(scope="module")
def small() -> Compiled:
    return lower(assemble(load("two-disk-gear")))


@pytest.mark.parametrize("name", ["a;b", "../a", "a b", 'a"', "a*/", "double", "a\nb", ""])
def test_a_crafted_name_of_a_model_is_refused(small: Compiled, name: str) -> None:
    crafted = dataclasses.replace(small, equations=dataclasses.replace(small.equations, name=name))
    with pytest.raises(NamingError, match="model name"):
        portable_files(crafted, case_of(small))


@pytest.mark.parametrize("what", ["states", "outputs", "units"])
def test_a_crafted_name_of_a_channel_is_refused(small: Compiled, what: str) -> None:
    names = (*getattr(small, what)[:-1], 'x"};int main(){/*')
    with pytest.raises(LoweringError, match="may not stand in C"):
        portable_files(dataclasses.replace(small, **{what: names}), case_of(small))


def test_a_case_has_all_parameters(small: Compiled) -> None:
    case = dataclasses.replace(case_of(small), parameters=(1.0,))
    with pytest.raises(LoweringError, match=r"has 47 parameters, the case 1; give every parameter its value"):
        portable_files(small, case)


@needs_compiler
@pytest.mark.parametrize("name", ["s", "a1", "c", "rates", "C"])
def test_short_names_do_not_meet_those_of_the_text(small: Compiled, name: str, tmp_path: Path) -> None:
    renamed = dataclasses.replace(small, equations=dataclasses.replace(small.equations, name=name))
    built(portable_files(renamed, case_of(small)), tmp_path, "-std=c99")


def test_sources_of_other_parameters_are_marked(small: Compiled) -> None:
    text = portable_files(small, case_of(small))["two-disk-gear.c"]
    flags = re.search(r"_is_source\[\w+\] = \{([^}]*)\}", text)
    assert flags is not None
    marked = {name for name, flag in zip(small.parameters.labels(), flags[1].split(","), strict=True) if int(flag)}
    assert marked >= {"mesh.module", "mesh.teeth_a", "mesh.young_modulus"}
    assert not marked & {"xi", "pinion.inertia", "drive.cosine[1]", "mesh.geometry_rows[1]", "speed"}
