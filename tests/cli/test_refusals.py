"""What the command line refuses, by its words: one line on stderr, the right exit code, and nothing on the disk."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import SMALL, Invoke


def refused(result: object, code: int) -> str:
    """The one line that a refused command prints, without what it says of its progress."""
    assert result.exit_code == code, (result.stdout, result.stderr)  # type: ignore[attr-defined]
    lines = result.stderr.splitlines()  # type: ignore[attr-defined]
    assert "Traceback" not in result.stderr  # type: ignore[attr-defined]
    assert lines[-1].startswith("modelgen: ")
    return str(lines[-1].removeprefix("modelgen: "))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--set", "zetta=0.02"), "--set zetta: driveline 'small' has no parameter 'zetta'; nearest is 'zeta'"),
        (("--set", "coupling.stifness=3 N*m/rad"), "shaft 'coupling' has no parameter 'stifness'; nearest is 'stiffness'"),
        (("--set", "copling.stiffness=3 N*m/rad"), "there is no element or kind 'copling'; nearest is 'coupling'"),
        (("--set", "coupling.stiffness=3"), "coupling', stiffness"),
        (("--set", "coupling.stiffness=3 kg"), "'kg' has the dimension"),
        (("--set", "coupling.stiffness=-3 N*m/rad"), "give a positive value"),
        (("--set", "coupling.name=other"), "has no parameter 'name'"),
        (("--set", "coupling.kind_or_name=other"), "has no parameter 'kind_or_name'"),
        (("--set", "drive_mean=5"), "has no unit"),
        (("--set", "drive_cosine=5 N*m"), "is a series of 2 numbers; change it in the model file"),
        (("--set", "zeta"), "is no assignment; write NAME=VALUE"),
        (("--set", "zeta="), "is no assignment"),
        (("--set", "zeta=small"), "'small' is not a number"),
        (("--set", "mesh.teeth_a=20.5"), "give a whole number"),
        (("--speed", "1900"), "has no unit"),
        (("--speed", "-5 rpm"), "give a positive speed"),
        (("--damping", "pershaft"), "damping is 'pershaft'; nearest is 'per_shaft'"),
        (("--damping", "value"), "damping_coefficient is missing"),
        (("--mesh-damping", "corected"), "nearest is 'corrected'"),
        (("--mesh-reading", "scaled", "--set", "xi=0.05"), "leave one out"),
        (("--solver", "rk5"), "there is none named 'rk5'; nearest is 'rk4'"),
        (("--crosscheck", "cvode"), "there is no solver 'cvode'; nearest is 'cvodes'"),
        (("--tolerance", "-1"), "tolerance: is -1.0; give a positive number"),
        (("--tolerance", "nan"), "give a finite number"),
        (("--max-seconds", "0"), "give a positive number"),
        (("--window", "1", "2"), "has no unit"),
        (("--window", "2 s", "1 s"), "give two times that follow each other"),
        (("--window", "-1 s", "1 s"), "from 0 s up"),
    ],
)
def test_a_wrong_option(invoke: Invoke, small: Path, tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    assert words in refused(invoke("run", small, "--out", tmp_path / "deep" / "out", *options), 2)
    assert list(tmp_path.iterdir()) == []


def test_the_scaled_reading_needs_shared_parameters(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(SMALL.replace('damping_ratio = "xi"', "damping_ratio = 0.1"), encoding="utf-8")
    line = refused(invoke("run", tmp_path / "own.toml", "--out", tmp_path / "out", "--mesh-reading", "scaled"), 2)
    assert "does not share one damping ratio" in line


def test_damping_of_what_is_not_there(invoke: Invoke, tmp_path: Path) -> None:
    lone = 'format = 1\nname = "lone"\n[elements.disk]\nkind = "inertia"\ninertia = "1 kg*m^2"\n'
    (tmp_path / "lone.toml").write_text(lone, encoding="utf-8")
    assert "has no shaft" in refused(invoke("run", tmp_path / "lone.toml", "--out", tmp_path / "out", "--damping", "modal"), 2)


@pytest.mark.parametrize("command", [("run", "--out", "out"), ("show",)])
def test_a_model_that_is_not_there(
    invoke: Invoke, tmp_path: Path, command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name, *rest = command
    assert "nearest is 'fracturing-truck'" in refused(invoke(name, "fracturing-trick", *rest), 2)
    assert "cannot be read: No such file" in refused(invoke(name, "there/is/none.toml", *rest), 2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no format"),
        ("format = 2", "has format 2; write format = 1"),
        ("format = ", "is not TOML"),
        (SMALL.replace('kind = "shaft"', 'kind = "shafft"'), "nearest is 'shaft'"),
        (SMALL.replace('b = "pinion"', 'b = "pinon"', 1), "nearest is 'pinion'"),
        (SMALL.replace('"20 kN*m/rad"', "20000"), "has no unit"),
        (SMALL.replace('"20 kN*m/rad"', '"20 kg"'), "'kg' has the dimension"),
        (SMALL.replace('damping_ratio = "zeta"', 'damping_ratio = "eta"'), "there is no parameter 'eta'"),
        (SMALL.replace('balance = ["load"]', ""), "mean torques leave"),
        (SMALL.replace('inertia = "0.3 kg*m^2"', 'inertia = "0 kg*m^2"'), "give a positive value"),
        (SMALL.replace("drive_mean = {", "drive_mean.x = {"), "unknown key 'x'"),
    ],
)
def test_a_wrong_file(invoke: Invoke, tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text, encoding="utf-8")
    result = invoke("check", path)
    assert words in refused(result, 1)
    assert len(result.stderr.splitlines()) == 1
    assert words in refused(invoke("run", path, "--out", tmp_path / "out"), 2)
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_is_no_text(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "wrong.toml").write_bytes(b"\xff\xfe")
    assert "is not UTF-8 text" in refused(invoke("check", tmp_path / "wrong.toml"), 1)
    assert "is no file" in refused(invoke("check", tmp_path), 1)


def test_line_breaks_stay_out_of_the_line(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    line = refused(invoke("run", small, "--out", tmp_path / "out", "--set", "a\nb=1"), 2)
    assert line.startswith("--set a b: ")


def test_an_unknown_kind(invoke: Invoke) -> None:
    assert "nearest is 'gear_pair'" in refused(invoke("elements", "gearpair"), 2)


@pytest.mark.parametrize(
    "arguments", [("run",), ("run", "small"), ("sow",), ("run", "x", "--out", "y", "--start", "hot"), ("--nonsense",)]
)
def test_a_wrong_usage(invoke: Invoke, arguments: tuple[str, ...]) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert "Usage:" in result.stderr


@pytest.mark.parametrize("arguments", [("equivalent", "a" * 4000), ("check", "a" * 4000), ("check", "a" * 4000 + ".toml")])
def test_a_name_that_no_file_can_have(invoke: Invoke, arguments: tuple[str, ...]) -> None:
    result = invoke(*arguments, *(("--out", "x.toml") if arguments[0] == "equivalent" else ()))
    assert "File name too long" in result.stderr or "is neither in the catalogue nor a model file" in result.stderr


@pytest.mark.parametrize("command", ["equivalent", "modal", "sweep"])
def test_a_place_that_no_file_can_have(invoke: Invoke, small: Path, command: str) -> None:
    over = ("--over", "zeta=0.1:0.2:2") if command == "sweep" else ()
    line = refused(invoke(command, small, "--out", "a" * 4000, *over), 2)
    assert line.endswith(("File name too long; check the path and its permissions", "File name too long; check the path"))


def test_exponents_over_less_than_one_cycle(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    short = ("--revolutions", 1, "--transient", 0, "--tolerance", "1e-4", "--set", "zeta=0.1")
    result = invoke("lyapunov", small, "--out", tmp_path / "out", *short)
    assert result.exit_code in (0, 1), result.stderr
    assert "nan" not in result.stdout
