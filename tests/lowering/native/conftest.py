"""A cache of its own for the tests of native code, shared by all of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from modelgen.lowering.native import NoCompilerError
from modelgen.lowering.native.compiler import find_compiler


@pytest.fixture(scope="session")
def native_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("native")
    folder.chmod(0o700)
    return folder


@pytest.fixture
def compiled_here(native_cache: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Native code is built into the cache of the tests; skipped where there is no compiler."""
    try:
        find_compiler()
    except NoCompilerError as reason:
        pytest.skip(str(reason))
    monkeypatch.setenv("MODELGEN_CACHE", str(native_cache))
    return
