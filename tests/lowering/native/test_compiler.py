"""Which compiler is taken, and what is said when there is none or it fails."""

from __future__ import annotations

import ctypes
import importlib.metadata
import os
import stat
import sys
from pathlib import Path

import pytest

from modelgen.lowering.native.compiler import COMMANDS, Compiler, NoCompilerError, find_compiler


def fake(folder: Path, name: str, words: str = "version 1", code: int = 0) -> Path:
    program = folder / name
    program.write_text(f"#!/bin/sh\necho '{words}'\necho 'file.c:1: error: {words}' >&2\nexit {code}\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return program


def test_the_order_is_cc_gcc_clang_ziglang(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.metadata, "version", lambda name: {"ziglang": "0.13"}[name])
    path = {"PATH": str(tmp_path)}
    assert find_compiler(path).command == (sys.executable, "-m", "ziglang", "cc")
    for name in reversed(COMMANDS):
        program = fake(tmp_path, name)
        assert find_compiler(path).command == (str(program),)
    own = fake(tmp_path, "mycc")
    assert find_compiler({**path, "CC": "mycc -m64"}).command == (str(own), "-m64")


def test_without_any_compiler_one_line_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", missing)
    with pytest.raises(
        NoCompilerError, match=r"no C compiler .* install gcc or clang or the extra modelgen\[native\], or run on CasADi"
    ):
        find_compiler({"PATH": str(tmp_path)})


def test_a_compiler_that_does_not_work_is_named(tmp_path: Path) -> None:
    fake(tmp_path, "gcc", code=3)
    with pytest.raises(NoCompilerError, match="gcc --version ends with code 3"):
        find_compiler({"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"})


def test_the_first_complaint_of_the_compiler_is_shown(tmp_path: Path) -> None:
    compiler = Compiler((str(fake(tmp_path, "gcc", "unknown type", code=1)),), "1")
    with pytest.raises(NoCompilerError, match=r"failed: file\.c:1: error: unknown type; run on CasADi's virtual machine"):
        compiler.build(tmp_path / "a.c", tmp_path / "a.so")


def test_a_build_is_known_by_version_and_options(tmp_path: Path) -> None:
    program = fake(tmp_path, "gcc")
    first = find_compiler({"PATH": str(tmp_path)}).identity()
    assert first == find_compiler({"PATH": str(tmp_path)}).identity()
    program.write_text(program.read_text().replace("version 1", "version 2, newer"))
    assert find_compiler({"PATH": str(tmp_path)}).identity() != first
    assert Compiler(("cc", "-m32"), "1").identity() != Compiler(("cc",), "1").identity()


def test_ziglang_builds_where_there_is_nothing_else(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="the extra modelgen[native] is not installed")
    compiler = find_compiler({"PATH": str(tmp_path)})
    (tmp_path / "one.c").write_text("int one(void) { return 1; }\n")
    compiler.build(tmp_path / "one.c", tmp_path / "one.so")
    assert ctypes.CDLL(str(tmp_path / "one.so")).one() == 1
