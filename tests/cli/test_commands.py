"""The smaller commands: help, list, check, show, elements."""

from __future__ import annotations

from pathlib import Path

import pytest

from modelgen import __version__
from modelgen.cli.commands import commands
from modelgen.drivelines import catalogue

from .conftest import SMALL, Invoke


def test_the_version(invoke: Invoke) -> None:
    assert invoke("--version").stdout == f"modelgen, version {__version__}\n"


@pytest.mark.parametrize("name", ["", *sorted(commands.commands)])
def test_every_help_has_examples(invoke: Invoke, name: str) -> None:
    result = invoke(*([name] if name else []), "--help")
    assert result.exit_code == 0
    assert "Usage: modelgen" in result.stdout
    assert "  Examples:\n    modelgen " in result.stdout


def test_every_example_is_lawful(invoke: Invoke) -> None:
    """Each line of help that shows a command names a command and options that exist."""
    for name, command in commands.commands.items():
        context = command.make_context(name, ["--help"], resilient_parsing=True)
        known = {option for each in command.get_params(context) for option in each.opts}
        for line in (command.epilog or "").splitlines():
            words = line.split()
            if words[:1] == ["modelgen"]:
                assert words[1] in commands.commands
                if words[1] == name:
                    assert {word for word in words if word.startswith("--")} <= known


def test_the_catalogue_is_listed(invoke: Invoke) -> None:
    listed = invoke("list").stdout
    assert all(name in listed for name in catalogue())
    assert "40 elements" in listed


def test_check_sums_up(invoke: Invoke, small: Path) -> None:
    result = invoke("check", small)
    assert result.exit_code == 0
    assert "driveline 'small': 7 elements" in result.stdout
    assert "3 degrees of freedom" in result.stdout
    assert "load.scale = 1.33333333 balances the mean power" in result.stdout
    assert "natural frequencies [Hz]: 0, " in result.stdout
    assert result.stdout.endswith("the model is right\n")


def test_check_says_that_a_model_drifts(invoke: Invoke, tmp_path: Path) -> None:
    path = tmp_path / "drifting.toml"
    path.write_text(SMALL.replace('balance = ["load"]', "drifts = true"), encoding="utf-8")
    assert "declared to drift: the reference shaft gains 34.48 rad/s every second" in invoke("check", path).stdout


def test_show_prints_the_equations(invoke: Invoke, small: Path) -> None:
    assert invoke("show", small).stdout.startswith("# Equations of motion: small")
    assert r"\begin{align" in invoke("show", small, "--latex").stdout


def test_elements_are_described(invoke: Invoke) -> None:
    assert {"shaft", "gear_pair", "inertia"} <= {line.split()[0] for line in invoke("elements").stdout.splitlines()}
    described = invoke("elements", "shaft").stdout
    assert "stiffness [N*m/rad] required" in described
    assert "damping = per_shaft | modal" in described


@pytest.mark.parametrize(("cause", "code"), [(KeyboardInterrupt(), 130), (SystemExit(143), 143)])
def test_a_signal_inside_a_call_of_casadi(invoke: Invoke, monkeypatch: pytest.MonkeyPatch, cause: Exception, code: int) -> None:
    def interrupted(*_: object) -> None:
        raise SystemError("returned a result with an exception set") from cause

    monkeypatch.setattr("modelgen.drivelines.load", interrupted)
    result = invoke("check", "fracturing-truck")
    assert result.exit_code == code
    assert "Traceback" not in result.stderr
