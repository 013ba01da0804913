"""The README tells the truth: its Python runs and prints what it says, its commands exist, its links lead somewhere.

The figures of the truck are compared with a run in ``test_the_figures_of_the_truck``, which is slow.
"""

from __future__ import annotations

import io
import re
import shlex
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import pytest

from modelgen.model import Element

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks() -> list[tuple[str, str]]:
    """Python blocks with the text block that shows their output, if one follows at once."""
    found = list(BLOCK.finditer(README))
    pairs = []
    for index, block in enumerate(found):
        if block[1] == "python":
            after = found[index + 1] if index + 1 < len(found) else None
            follows = after is not None and after[1] == "text" and not README[block.end() : after.start()].strip()
            pairs.append((block[2], after[2] if after is not None and follows else ""))
    return pairs


def test_the_python_prints_what_the_readme_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    before = dict(Element.vocabulary)
    namespace: dict[str, Any] = {"__name__": "readme"}
    pairs = blocks()
    assert len(pairs) == README.count("```python") >= 4
    try:
        for code, output in pairs:
            with redirect_stdout(io.StringIO()) as printed:
                exec(compile(code, "README.md", "exec"), namespace)
            assert printed.getvalue().strip() == output.strip(), code
    finally:
        Element.vocabulary.clear()
        Element.vocabulary.update(before)


def test_the_element_of_the_readme_is_short() -> None:
    code = next(code for code, _ in blocks() if "class " in code)
    lines = code[code.index("class ") :].split("\n\n")[0].splitlines()
    assert 0 < len(lines) <= 15


def test_the_commands_exist() -> None:
    from modelgen.cli.commands import commands

    seen = set()
    for line in re.findall(r"^ {4}(?:\.venv/bin/)?modelgen (.+)$", README, re.MULTILINE):
        name, *arguments = shlex.split(line, comments=True)
        command = commands.commands[name]
        command.make_context(name, arguments)  # click refuses what it does not know
        seen.add(name)
    assert seen == set(commands.commands)


def test_the_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"^ {4}make (\S+)", README, re.MULTILINE)
    assert {"demo", "test"} <= set(targets)
    assert all(re.search(rf"^{target}:", makefile, re.MULTILINE) for target in targets)


def test_the_links_lead_somewhere() -> None:
    for link in re.findall(r"\]\(([^)#]+)\)", README):
        assert link.startswith("https://") or (ROOT / link).exists(), link
