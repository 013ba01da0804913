"""The portable C of the stages: clean under strict warnings as C99 and as C++, and right."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from modelgen import assemble, load, lower
from modelgen.errors import LoweringError
from modelgen.lowering.native.portable import portable_stages

COMPILER = shutil.which("gcc") or shutil.which("clang") or "none"
STRICT = (*["-O1", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off", "-fPIC", "-shared"], "-lm")
needs_compiler = pytest.mark.skipif(COMPILER == "none", reason="there is neither gcc nor clang")


def built(text: str, folder: Path, *language: str) -> ctypes.CDLL:
    source, library = folder / "model.c", folder / "model.so"
    source.write_text(text)
    done = subprocess.run([COMPILER, *language, source, "-o", library, *STRICT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return ctypes.CDLL(str(library))


@needs_compiler
def test_the_stages_of_a_truck_with_two_sets_of_parameters_at_once(tmp_path: Path) -> None:
    model = lower(assemble(load("fracturing-truck")))
    text = portable_stages(model.rhs_function, "truck")
    library = built(text, tmp_path, "-std=c99")
    sizes = dict(part.split(" = ") for part in text.split("enum { ")[1].split(" }")[0].split(", "))
    pointer = ctypes.POINTER(ctypes.c_double)

    def call(name: str, *arguments: np.ndarray | float) -> None:
        plain = [ctypes.c_double(a) if isinstance(a, float) else a.ctypes.data_as(pointer) for a in arguments]
        getattr(library, f"truck_{name}")(*plain)

    sets = [model.parameters.vector(values) for values in ({}, {"zeta": 0.05})]
    prepared = [np.zeros(int(sizes["truck_C"])) for _ in sets]
    for p, c in zip(sets, prepared, strict=True):
        call("parameters", p, c)
    rng, n = np.random.default_rng(4), len(model.states) // 2
    for _ in range(40):
        x, t = 1e-2 * rng.standard_normal(2 * n), float(rng.uniform(0, 0.02))
        for p, c in zip(sets, prepared, strict=True):
            w, rates = np.zeros(int(sizes["truck_W"])), np.zeros(2 * n)
            call("time", c, t, w)
            call("rates", c, w, x, rates)
            expected = model.rhs(t, x, p)
            for group in (slice(0, n), slice(n, 2 * n)):
                assert np.abs(rates - expected)[group].max() <= 1e-13 * np.abs(expected[group]).max()


@needs_compiler
@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no g++")
def test_it_is_also_cpp(tmp_path: Path) -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(ca.if_else(x[0] > p[0], ca.erf(x[1]), ca.fmax(x[0], 2)), ca.sin(p[1] * t) + ca.sign(x[1]) ** 2)
    built(portable_stages(ca.Function("f", [t, x, p], [rates]), "small"), tmp_path, "-x", "c++", "-std=c++11")


@pytest.mark.parametrize("prefix", ["", "1a", "a-b", "a;int b", "a" * 64])
def test_a_prefix_is_an_identifier(prefix: str) -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    with pytest.raises(LoweringError, match="is no prefix of C names; give letters"):
        portable_stages(ca.Function("f", [t, x, p], [x]), prefix)
