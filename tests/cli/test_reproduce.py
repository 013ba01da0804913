"""``modelgen reproduce paper`` on a small geared driveline with made-up claims: figures, verdicts, report; how it refuses."""

from __future__ import annotations

import json
import re
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from modelgen.cli.progress import Progress
from modelgen.cli.reproduce import WRITTEN, fill
from modelgen.cli.reproduce_work import FULL, QUICK
from modelgen.drivelines import load
from modelgen.drivelines.claims import MotionClaim, claims_of
from modelgen.reports.paper import ClaimRow

from .conftest import Invoke
from .test_refusals import refused

EXTENT = replace(QUICK, points=40, wait=40, strobes=20, transient=20)


@pytest.fixture(scope="module")
def made(small: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[ClaimRow]]:
    of_truck = claims_of("fracturing-truck")
    assert of_truck is not None
    motion = replace(
        of_truck.motion,
        driveline=str(small),
        range=(0.0, 0.2),
        claims=(
            MotionClaim("engine_output", 0.0, "chaotic", 3),
            MotionClaim("engine_output", 0.2, "period 1", 1),
            MotionClaim("pump_free_end", 0.2, "period 2", 1),
            MotionClaim("pump_free_end", 0.2, "period 1", 2),
        ),
    )
    claims = replace(of_truck, roles={"engine_output": "motor", "pump_free_end": "fan"}, motion=motion)
    out = tmp_path_factory.mktemp("reproduced")
    with Progress() as progress:
        rows = fill(out, load(small), claims, EXTENT, "modelgen reproduce paper --out DIR --quick", time.perf_counter(), progress)
    return out, rows


@pytest.fixture(scope="module")
def data(made: tuple[Path, list[ClaimRow]]) -> dict[str, Any]:
    return json.loads((made[0] / "reproduction.json").read_text(encoding="utf-8"))


@pytest.mark.proof
def test_the_folder_holds_thirteen_figures_and_the_report(made: tuple[Path, list[ClaimRow]]) -> None:
    assert sorted(each.name for each in made[0].iterdir()) == sorted(WRITTEN)
    assert all((made[0] / f"fig_{k:02d}.png").read_bytes().startswith(b"\x89PNG") for k in range(1, 14))


@pytest.mark.proof
def test_motions_are_judged_by_their_evidence(made: tuple[Path, list[ClaimRow]]) -> None:
    found = [row for row in made[1] if row.claim.startswith("motion at the") and "0.2" in row.claim]
    same, other = found[:2], found[2:4]  # a claim has a row for each reading, for they differ at this value
    assert [row.verdict for row in same] == ["holds", "holds"]
    assert all("period 1 proven" in row.evidence and "1/s at 95 %" in row.evidence for row in same)
    assert [row.verdict for row in other] == ["does not hold", "does not hold"]
    assert [row.verdict for row in found[4:]] == ["holds in part", "holds in part"]


@pytest.mark.proof
def test_an_undamped_motion_is_no_attractor(made: tuple[Path, list[ClaimRow]], data: dict[str, Any]) -> None:
    (scaled,) = (each for each in data["motions"] if each["mesh_reading"] == "scaled" and each["zeta"] == 0)
    assert (scaled["undamped"], scaled["xi"]) == (True, 0)
    (row,) = (row for row in made[1] if row.claim.startswith("motion at zeta = 0 (reading scaled"))
    assert "no attractor" in row.evidence
    assert "stored energy" in row.evidence


@pytest.mark.proof
def test_the_diagram_says_from_where_on_it_settles(made: tuple[Path, list[ClaimRow]], data: dict[str, Any]) -> None:
    (row,) = (row for row in made[1] if "reading fixed" in row.claim and row.claim.startswith("settles"))
    columns = data["diagrams"]["fixed"]["columns"]
    assert len(columns) == EXTENT.values
    first = min(each["value"] for each in columns if each["settled"] and each["period"] == 1)
    assert (row.verdict, row.model) == ("holds", f"period 1 in every column from zeta = {first:.4g} on")


@pytest.mark.proof
def test_the_report_hangs_together(made: tuple[Path, list[ClaimRow]], data: dict[str, Any], small: Path) -> None:
    text = (made[0] / "reproduction.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\]\((fig_\d\d\.png)\)", text)) == set(WRITTEN[2:])
    assert text.count("| **") == len(made[1]) == len(data["claims"])
    assert "decides\nnothing" in text or "decides nothing" in text
    assert [each["number"] for each in data["figures"]] == list(range(1, 14))
    assert data["seconds"]["all"] > data["seconds"]["figure_9"] > 0
    assert not re.search(r"\n\n\n|<built-in|object at", text)
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert all(line.endswith("|") for line in rows)


@pytest.mark.proof
def test_the_series_only_gets_better(made: tuple[Path, list[ClaimRow]]) -> None:
    row = made[1][0]
    assert (row.paper, row.verdict) == ("10", "does not hold")


def test_the_full_version_is_as_fine_as_the_paper_needs() -> None:
    assert FULL.values >= 200
    assert FULL.strobes >= 150
    assert FULL.readings


def test_refusals(invoke: Invoke, tmp_path: Path) -> None:
    assert invoke("reproduce", "book", "--out", tmp_path / "out").exit_code == 2
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    assert "not empty" in refused(invoke("reproduce", "paper", "--out", tmp_path / "mine"), 2)
    assert "notes.txt" in refused(invoke("reproduce", "paper", "--out", tmp_path / "mine", "--replace"), 2)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["mine"]
