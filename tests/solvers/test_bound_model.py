"""One bound model: every question takes whatever holds a driveline, and answers the same for all of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelgen import (
    BoundModel,
    Case,
    Driveline,
    HardStop,
    HarmonicTorque,
    Inertia,
    Shaft,
    assemble,
    bifurcation,
    bind,
    campbell,
    forced,
    lower,
    lyapunov_exponents,
    modal,
    operating_point,
    periodic_orbit,
    phase_vectors,
    poincare,
    sensitivities,
    settled,
    settled_window,
    simulate,
    sweep,
)
from modelgen.errors import CaseError, NamingError
from modelgen.model.files import write_model

PARTS = [
    *(Inertia("m", inertia=1.0), Inertia("n", inertia=2.0)),
    Shaft("s", "m", "n", stiffness="zeta_k", damping_ratio=0.05),
    *(HarmonicTorque("d", "m", base="turn", mean=10.0, cosine=[3.0]), HarmonicTorque("l", "n", mean=-4.0)),
]


def line() -> Driveline:
    named = {"zeta_k": "900 N*m/rad"}
    return Driveline("b", elements=PARTS, speed=20.0, reference="m", bases={"turn": 1}, parameters=named).balance("l")


def written(folder: Path) -> Path:
    write_model(line(), folder / "b.toml")
    return folder / "b.toml"


FORMS: dict[str, Callable[[Path], Any]] = {
    "driveline": lambda _: line(),
    "equations": lambda _: assemble(line()),
    "compiled": lambda _: lower(assemble(line())),
    "bound": lambda _: bind(line()),
    "case": lambda _: Case(line(), end=3.0),
    "path": lambda folder: written(folder),
    "text": lambda folder: str(written(folder)),
}
QUESTIONS: dict[str, Callable[[Any], Any]] = {
    "operating_point": lambda x: operating_point(x).p,
    "modal": lambda x: modal(x).frequencies,
    "sensitivities": lambda x: [value for _, value in sensitivities(x).largest(1)],
    "campbell": lambda x: campbell(x).frequencies,
    "forced": lambda x: forced(x)["s.torque"],
    "phase_vectors": lambda x: phase_vectors(x).addition,
    "settled_window": lambda x: [settled_window(x).first, settled_window(x).last],
    "settled": lambda x: settled(x).angles.twists["s"].half_pp,
    "poincare": lambda x: poincare(x, ["s.twist"], count=16, tolerance=1e-6).values,
    "bifurcation": lambda x: bifurcation(x, "zeta_k", [800.0, 900.0], ["s.twist"], count=16, tolerance=1e-6).columns[0].points,
    "periodic_orbit": lambda x: periodic_orbit(x).multipliers,
}


LONG = ("settled", "poincare", "bifurcation", "periodic_orbit")  # slow for every form


@pytest.mark.parametrize("question", [pytest.param(each, marks=[pytest.mark.proof] * (each in LONG)) for each in QUESTIONS])
def test_every_question_takes_every_form_and_answers_the_same(question: str, tmp_path: Path) -> None:
    ask = QUESTIONS[question]
    expected = np.asarray(ask(FORMS["driveline"](tmp_path)))
    assert expected.size
    for make in FORMS.values():
        assert np.asarray(ask(make(tmp_path))) == pytest.approx(expected, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("question", LONG)
def test_long_questions_take_a_bound_model(question: str) -> None:
    ask = QUESTIONS[question]
    assert np.asarray(ask(bind(line()))) == pytest.approx(np.asarray(ask(Case(line(), end=3.0))), rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("question", QUESTIONS)
def test_every_question_refuses_what_is_no_model(question: str) -> None:
    for wrong in (3, None, ["m"], {"m": 1}):
        with pytest.raises(CaseError, match=r"is asked of (int|NoneType|list|dict); give a Driveline, Equations, a Compiled"):
            QUESTIONS[question](wrong)
    with pytest.raises(CaseError, match=r"'two-disk-geer'.*nearest is 'two-disk-gear'"):
        QUESTIONS[question]("two-disk-geer")


def test_longer_questions_make_their_case(tmp_path: Path) -> None:
    window = settled_window(line())
    case = Case(line(), end=window.first + 20 * window.period, record_from=window.first)
    found = lyapunov_exponents(line(), revolutions=20).exponents
    assert found == pytest.approx(lyapunov_exponents(case).exponents, rel=1e-12)
    collected = sweep(line(), {"zeta_k": [800.0, 900.0]}, ["s.torque.highest"], workers=0)
    run = simulate(Case(line(), end=window.last, record_from=window.first, options={"backend": "vm"}))
    assert collected["s.torque.highest"][1] == pytest.approx(run["s.torque"].max(), rel=1e-5)


def test_a_bound_model_is_complete_balanced_and_computes_when_asked() -> None:
    bound = bind(line(), speed="100 rpm", parameters={"d.mean": "7 N*m"})
    assert bound.parameters["speed"] == pytest.approx(100 * np.pi / 30)
    assert bound.parameters["d.mean"] == 7.0
    assert set(bound.parameters) == set(bound.model.parameters.names)
    assert bound.operating_point is bound.operating_point
    assert bound.model.evaluate(0.0, bound.operating_point.start, bound.operating_point.p)["l.torque"] == pytest.approx(-7.0)
    assert bound.linear.stiffness == pytest.approx(bound.operating_point.stiffness)
    assert bind(bound) is bound
    again = bind(bound, parameters={"zeta_k": 450.0})
    assert again.parameters["d.mean"] == 7.0
    assert modal(again).frequencies[1] == pytest.approx(modal(line()).frequencies[1] / np.sqrt(2))
    assert isinstance(again, BoundModel)
    with pytest.raises(NamingError, match="nearest is 'zeta_k'"):
        bind(line(), parameters={"zeta_q": 1.0})


def test_what_has_no_equilibrium_can_be_bound_and_run() -> None:
    parts = [*PARTS[:2], HardStop("s", "m", "n", clearance=0.1), HarmonicTorque("t", "m", mean=5.0)]
    bound = bind(Driveline("stop", elements=parts, drifts=True))
    assert simulate(Case(bound, end=0.05, start="zero"))["m.speed"][-1] == pytest.approx(0.25)
    with pytest.raises(CaseError, match="has no static equilibrium"):
        _ = bound.operating_point


def test_a_given_case_keeps_its_own_tolerance_and_values() -> None:
    case = Case(line(), end=2.0, parameters={"zeta_k": 450.0}, tolerance=1e-9)
    assert modal(case).frequencies[1] == pytest.approx(modal(line(), {"zeta_k": 450.0}).frequencies[1], rel=1e-14)
    own = poincare(case, ["s.twist"], count=16).values
    bound = bind(line(), parameters={"zeta_k": 450.0})
    assert own == pytest.approx(poincare(bound, ["s.twist"], count=16, tolerance=1e-9).values, rel=1e-12)
    assert own.tolist() != poincare(bound, ["s.twist"], count=16).values.tolist()


@pytest.mark.slow
def test_python_gives_the_numbers_of_the_commands(tmp_path: Path) -> None:
    from click.testing import CliRunner

    from modelgen.cli.commands import commands

    options = ["--speed", "1500 rpm", "--crosscheck", "none", "--out", str(tmp_path / "run")]
    assert CliRunner().invoke(commands, ["run", "fracturing-truck", *options]).exit_code == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text(encoding="utf-8"))
    found = settled(bind("fracturing-truck", speed="1500 rpm")).angles.inertias
    for name, row in summary["angles_deg"].items():
        assert np.degrees(found[name].vibration.peak) == pytest.approx(row["vibration_peak"], rel=1e-9)
    stiffer = ["--set", "coupling.stiffness=2e6 N*m/rad", "--out", str(tmp_path / "modal")]
    assert CliRunner().invoke(commands, ["modal", "fracturing-truck", *stiffer]).exit_code == 0
    told = json.loads((tmp_path / "modal" / "modal.json").read_text(encoding="utf-8"))
    mine = modal("fracturing-truck", {"coupling.stiffness": 2e6}).frequencies
    assert [mode["undamped_hz"] for mode in told["modes"]] == pytest.approx(mine.tolist(), rel=1e-12)
