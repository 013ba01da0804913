"""The README tells the truth: its Python runs and prints what it says, its commands exist, its links lead somewhere.

The figures of the truck are compared with a run in ``test_the_figures_of_the_truck``, which is slow.
"""

from __future__ import annotations

import io
import json
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
    assert seen >= {"run", "check", "show", "list", "elements"}


def test_the_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"^ {4}make (\S+)", README, re.MULTILINE)
    assert {"demo", "test"} <= set(targets)
    assert all(re.search(rf"^{target}:", makefile, re.MULTILINE) for target in targets)


def test_the_links_lead_somewhere() -> None:
    for link in re.findall(r"\]\(([^)#]+)\)", README):
        assert link.startswith("https://") or (ROOT / link).exists(), link


def truck_rows() -> list[list[str]]:
    """The rows of the table of the truck: damping forms, then figures."""
    table = README.split("| shafts, meshes |")[1].split("\n\n")[0]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in table.splitlines()[2:]]


@pytest.mark.slow
@pytest.mark.parametrize("row", truck_rows(), ids=lambda row: row[0])
def test_the_figures_of_the_truck(row: list[str], tmp_path: Path) -> None:
    from click.testing import CliRunner

    from modelgen.cli.commands import commands

    shaft, mesh = row[0].split(", ")
    options = ["--damping", shaft, "--mesh-damping", mesh, "--crosscheck", "none"]
    done = CliRunner().invoke(commands, ["run", "fracturing-truck", "--out", str(tmp_path / "out"), *options])
    assert done.exit_code == 0, done.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    angles, meshes = summary["angles_deg"], summary["mesh"]
    shown = [f"{angles[n][f'vibration_{q}']:.3f}" for n in ("flywheel", "damper", "pump_free_end") for q in ("peak", "half_pp")]
    forces = [meshes[name] for name in ("transmission_mesh", "pump_mesh")]
    shown += [f"{each['force_min_n'] / 1e3:.1f} to {each['force_max_n'] / 1e3:.1f}" for each in forces]
    assert row[1:] == shown
    if (shaft, mesh) == ("per_shaft", "corrected"):
        check_the_claims(angles)


def check_the_claims(angles: dict[str, dict[str, float]]) -> None:
    """What the README says beside the paper's claims."""

    def order(quantity: str, referred: bool = False) -> list[str]:
        size = {name: each[quantity] / (each["referred_ratio"] if referred else 1) for name, each in angles.items()}
        return sorted(size, key=lambda name: -size[name])

    by_vibration, by_elastic, by_referred = order("vibration_peak"), order("elastic_peak"), order("vibration_peak", referred=True)
    assert f"Ours is {angles['damper']['vibration_peak']:.3f}°" in README
    assert [by_vibration.index(name) + 1 for name in ("damper", "flywheel", "pump_free_end")] == [1, 3, 12]
    assert by_elastic[0] == "pump_pinion"
    assert f"largest at the pump pinion with {angles['pump_pinion']['elastic_peak']:.3f}°" in README
    assert by_referred[0] == "pump_free_end"
    referred = angles["pump_free_end"]["vibration_peak"] / angles["pump_free_end"]["referred_ratio"]
    assert f"the pump free end is first with {referred:.2f}°" in README.replace("\n  ", " ")
    assert sum(each["vibration_peak"] > 0.5 for each in angles.values()) == 9
    assert sum(each["vibration_half_pp"] > 0.5 for each in angles.values()) == 2
    assert angles["flywheel"]["vibration_half_pp"] < 0.5
