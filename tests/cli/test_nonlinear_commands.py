"""``modelgen bifurcation``, ``poincare`` and ``map``: their files on a small geared driveline, and refusals by their words."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from .conftest import Invoke
from .test_modal_command import rows
from .test_refusals import refused


@pytest.fixture(scope="module")
def diagram(invoke: Invoke, small: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bifurcation") / "out"
    over = ("--over", "zeta", "0.1", "0.3", "--count", "3", "--strobes", "16", "--channel", "coupling.twist")
    result = invoke("bifurcation", small, "--out", folder, *over)
    assert result.exit_code == 0, result.output
    assert "bifurcation diagram of 'small' over zeta: 3 values from 0.1 to 0.3 1, 1 branches, periods 1" in result.stdout
    return folder


def test_files_of_a_diagram(diagram: Path) -> None:
    assert {path.name for path in diagram.iterdir()} == {"bifurcation.csv", "columns.csv", "bifurcation.json", "bifurcation.png"}
    columns = rows(diagram / "columns.csv")
    assert [row["zeta [1]"] for row in columns] == ["0.1", "0.2", "0.3"]
    assert {row["period [strobes]"] for row in columns} == {"1"}
    assert {row["settled"] for row in columns} == {"yes"}
    strobes = rows(diagram / "bifurcation.csv")
    assert len(strobes) == 3 * 16
    assert float(strobes[0]["coupling.twist [rad]"]) > 0
    assert json.loads((diagram / "bifurcation.json").read_text())["unsettled_columns"] == 0


def test_a_diagram_and_a_map_over_a_row_of_a_series(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    row = ("drive_cosine[2]", "8 N*m", "12 N*m")
    options = ("--count", "2", "--strobes", "16", "--channel", "coupling.twist")
    result = invoke("bifurcation", small, "--out", tmp_path / "diagram", "--over", *row, *options)
    assert result.exit_code == 0, result.output
    assert [each["drive_cosine[2] [N*m]"] for each in rows(tmp_path / "diagram" / "columns.csv")] == ["8", "12"]
    axes = ("--first", "speed", "1400 rpm", "1500 rpm", "--second", *row, "--columns", "2", "--rows", "2")
    assert invoke("map", small, "--out", tmp_path / "map", *axes).exit_code == 0
    assert [each["drive_cosine[2] [N*m]"] for each in rows(tmp_path / "map" / "map.csv")] == ["8", "8", "12", "12"]


def test_ctrl_c_keeps_what_is_done(invoke: Invoke, small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from modelgen.cli.progress import Progress

    def press(progress: Progress, done: float) -> None:
        if done > 0.4:
            raise KeyboardInterrupt

    monkeypatch.setattr("modelgen.cli.progress.Progress.fraction", press)
    monkeypatch.setattr("modelgen.analysis.nonlinear.bifurcation.BATCH", 1)
    monkeypatch.setattr("modelgen.analysis.nonlinear.maps.BATCH", 1)
    options = ("--over", "zeta", "0.1", "0.3", "--count", "3", "--strobes", "16", "--channel", "coupling.twist")
    result = invoke("bifurcation", small, "--out", tmp_path / "diagram", *options)
    assert result.exit_code == 130
    assert "interrupted; 2 columns were not run, the others are kept in" in result.stderr
    assert [row["zeta [1]"] for row in rows(tmp_path / "diagram" / "columns.csv")] == ["0.1"]
    axes = ("--first", "speed", "1400 rpm", "1500 rpm", "--second", "zeta", "0.1", "0.2", "--columns", "2", "--rows", "2")
    result = invoke("map", small, "--out", tmp_path / "map", *axes)
    assert result.exit_code == 130
    assert "interrupted; 2 cells were not run, the others are kept in" in result.stderr
    assert len(rows(tmp_path / "map" / "map.csv")) == 4


def test_a_section_with_its_verdict(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    result = invoke("poincare", small, "--out", tmp_path / "out", "--strobes", "16", "--prove")
    assert result.exit_code == 0, result.output
    assert "verdict: period 1, decided by orbit: period 1 proven" in result.stdout
    data = json.loads((tmp_path / "out" / "section.json").read_text())
    assert (data["verdict"], data["kind"], data["period"], data["undamped"]) == ("period 1", "periodic", 1, False)
    points = rows(tmp_path / "out" / "section.csv")
    assert len(points) == 16
    assert "rate of fan.elastic_angle [rad/s]" in points[0]


def test_a_section_by_a_surface(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    surface = ("--surface", "coupling.twist=0.3 deg", "--end", "0.4", "--channel", "coupling.twist")
    result = invoke("poincare", small, "--out", tmp_path / "out", *surface)
    assert result.exit_code == 0, result.output
    assert "surface coupling.twist = 0.00523599 rad" in result.stdout
    points = rows(tmp_path / "out" / "section.csv")
    assert {round(float(row["coupling.twist [rad]"]), 8) for row in points} == {0.00523599}


def test_a_map(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    axes = (
        "--first",
        "speed",
        "1000 rpm",
        "1500 rpm",
        "--second",
        "drive_mean",
        "5 N*m",
        "100 N*m",
        "--columns",
        "3",
        "--rows",
        "2",
    )
    result = invoke("map", small, "--out", tmp_path / "out", *axes, "--limit", "0.5 deg")
    assert result.exit_code == 0, result.output
    assert "speed x drive_mean, 6 cells" in result.stdout
    table = rows(tmp_path / "out" / "map.csv")
    assert len(table) == 6
    assert {row["mesh rattle"] for row in table} <= {"none", "one-sided", "two-sided"}
    light, full = table[0], table[3]
    assert float(light["mesh least force [N]"]) < float(full["mesh least force [N]"])
    assert json.loads((tmp_path / "out" / "map.json").read_text())["cells"] == 6


def test_refusals(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for arguments, words in (
        (("bifurcation", small, "--out", out, "--over", "zeto", "0", "1"), "nearest is 'zeta'"),
        (("bifurcation", small, "--out", out, "--over", "zeta", "1", "0"), "give the lower value first"),
        (("bifurcation", small, "--out", out, "--over", "drive_cosine", "1", "2"), "sweep a row of it, such as drive_cosine[1]"),
        (("bifurcation", small, "--out", out, "--over", "drive_cosine[3]", "1", "2"), "has no such row; it has 2"),
        (("bifurcation", small, "--out", out, "--over", "speed", "1 m", "2 m"), "--over speed"),
        (("poincare", small, "--out", out, "--base", "motor_ordr"), "nearest is 'motor_order'"),
        (("poincare", small, "--out", out, "--surface", "coupling.twist"), "CHANNEL=VALUE"),
        (("poincare", small, "--out", out, "--channel", "fan.angle_deviation"), "take fan.elastic_angle"),
        (("map", small, "--out", out, "--first", "speed", "1 rpm", "2 rpm", "--second", "speed", "1 rpm", "2 rpm"), "both axes"),
        (("poincare", "fracturing-truck", "--out", out), "repeats only after 2484 turns"),
    ):
        assert words in refused(invoke(*arguments), 2)
    assert not out.exists()


def test_transmission_error_over_mesh_frequency(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    swept = ("--speeds", "1000 rpm", "1400 rpm", "--count", "4", "--channel", "mesh.force", "--close", "0")
    result = invoke("transmission-error", small, "--out", tmp_path / "out", *swept)
    assert result.exit_code == 0, result.output
    assert "frequency sweep of 'mesh' in 'small': 4 mesh frequencies from" in result.stdout
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        f"transmission_error.{kind}" for kind in ("csv", "json", "png")
    }
    table = rows(tmp_path / "out" / "transmission_error.csv")
    assert [row["direction"] for row in table] == ["upward"] * 4 + ["downward"] * 4
    up, down = ([float(row["mesh.approach rms about its mean [m]"]) for row in table[k : k + 4]] for k in (0, 4))
    assert up == pytest.approx(down, rel=1e-2)  # no branch of its own on the way down
    assert min(up) > 0
    data = json.loads((tmp_path / "out" / "transmission_error.json").read_text())
    assert (data["mesh"], data["speeds"], data["unsettled_points"]) == ("mesh", 4, 0)
    assert data["largest_rms"] == pytest.approx(max(up + down))


def test_transmission_error_refusals(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for model, arguments, words in (
        (small, ("--speeds", "1400 rpm", "1000 rpm"), "give two positive speeds, the lower one first"),
        (small, ("--speeds", "1000 rpm", "1400 rpm", "--mesh", "mash"), "nearest is 'mesh'"),
        (small, ("--speeds", "1000 rpm", "1400 rpm", "--channel", "mesh.fore"), "nearest is 'mesh.force'"),
        ("fracturing-truck-commensurate", ("--speeds", "1000 rpm", "1400 rpm"), "has 2 gear pairs; name one of"),
    ):
        assert words in refused(invoke("transmission-error", model, "--out", out, *arguments), 2)
    assert not out.exists()


def test_a_proof_is_no_evidence_on_points_that_do_not_show_the_orbit(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    surface = ("--surface", "coupling.twist=0.3 deg", "--end", "0.4", "--channel", "coupling.twist", "--prove")
    result = invoke("poincare", small, "--out", tmp_path / "out", *surface)
    assert result.exit_code == 0, result.output
    assert "decided by orbit" not in result.stdout
    assert "beside that, shooting: period 1 proven: residual" in result.stdout
    assert "these points do not show it" in result.stdout
