"""Compilers and caches of the hostile kind: named in one sentence, and never kept."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from modelgen.lowering.native.cache import cache_folder, library_for
from modelgen.lowering.native.compiler import NoCompilerError, find_compiler
from modelgen.lowering.native.library import _loaded, _probe


def test_an_unfinished_quotation_in_cc_is_said():
    with pytest.raises(NoCompilerError, match=r"\$CC is 'gcc \"': No closing quotation; correct it, or run on"):
        find_compiler({"CC": 'gcc "'})


def test_rubbish_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path / "cache"))

    def rubbish(folder: Path, library: Path) -> None:
        library.write_bytes(b"this is no library")
        library.chmod(stat.S_IRWXU)
        _probe(library, "modelgen_sizes")

    for _ in range(2):
        with pytest.raises(NoCompilerError, match=r"a built library cannot be loaded: .*; set \$MODELGEN_CACHE to a folder"):
            library_for("0" * 64, rubbish)
    assert list((tmp_path / "cache").iterdir()) == []
    with pytest.raises(NoCompilerError, match="cannot be loaded"):
        _loaded(tmp_path / "missing.so")


def test_a_cache_named_by_a_relative_path_is_found_from_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MODELGEN_CACHE", "relative")
    assert cache_folder() == tmp_path / "relative"
