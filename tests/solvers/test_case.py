"""What may stand in a case, and that a case answers for its own values."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
import pytest

import modelgen
from modelgen import Case, Driveline, HarmonicTorque, Inertia, Shaft, assemble, forced, lower, modal, operating_point, simulate
from modelgen.errors import ModelgenError

LINE = Driveline(
    "pair",
    speed=100.0,
    reference="m",
    bases={"turn": 1},
    elements=[
        Inertia("m", inertia=2.0),
        Inertia("n", inertia=3.0),
        Shaft("s", "m", "n", stiffness=2e4, damping_ratio=0.02),
        HarmonicTorque("drive", "m", base="turn", mean=10.0, cosine=[5.0]),
        HarmonicTorque("load", "n", mean=-10.0),
    ],
).balance("load")
MODEL = lower(assemble(LINE))
ODD: list[Any] = [
    *(1, 1.5, -1, "1", "x", None, [1], (), {}, {"a": 1}, {1: 2}, float("nan"), float("inf"), np.float64(2.0), np.int64(3)),
    *(np.array([1.0]), np.array(2.0), True, b"x", object(), 10**400, 1j),
]
ARGUMENTS = (
    *("model", "end", "begin", "record_from", "samples", "channels", "solver", "tolerance", "options", "seed", "sections"),
    *("parameters", "start", "inputs"),
)


@pytest.mark.parametrize("argument", ARGUMENTS)
def test_every_odd_value_is_taken_or_refused_in_one_sentence(argument: str) -> None:
    for value in ODD:
        with contextlib.suppress(ModelgenError):  # whatever else is raised is a fault
            assert len(Case(**{"model": MODEL, "end": 1.0, argument: value}).digest()) == 64


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"solver": "rk5"}, "solver: there is none named 'rk5'; nearest is 'rk4'"),
        ({"parameters": {"s.stifness": 1.0}}, "nearest is 's.stiffness'"),
        ({"parameters": {"s.stiffness": -1.0}}, "give a positive value"),
        ({"parameters": [1]}, "case, parameters: are list; give a mapping"),
        ({"options": {"backend": "x"}}, "backend: is 'x'; known are vm, c, auto"),
        ({"options": {"bakend": "c"}}, "nearest is 'backend'"),
        ({"solver": "cvodes", "options": {"backend": "c"}}, "has no use for backend = 'c'"),
        ({"end": "1 Nm"}, r"case, end: 'Nm' has the dimension"),
        ({"end": [1]}, r"case, end: is \[1\]; give a number, or a text such as \"1 s\""),
        ({"samples": 2.5}, "case, samples: is 2.5; give a whole number"),
        ({"channels": "s.torque"}, "case, channels: are 's.torque'; give a sequence"),
        ({"channels": [3]}, "case, channels: hold 3"),
        ({"start": 3}, "case, start: is 3; give"),
        ({"start": {"s.twist": [1]}}, r"case, start of 's.twist': is \[1\]"),
        ({"tolerance": 0}, "case, tolerance: is 0; give a positive number"),
        ({"seed": 1.5}, "case, seed: is 1.5; give a whole number"),
    ],
)
def test_a_wrong_case_is_refused_when_it_is_made(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelgenError, match=words):
        Case(**{"model": MODEL, "end": 1.0, **changes})


def test_a_misspelt_field_is_refused_with_the_nearest() -> None:
    with pytest.raises(ModelgenError, match=r"Case: has no 'tolerence'; nearest is 'tolerance'"):
        Case(MODEL, end=1.0, tolerence=1e-6)  # type: ignore[call-arg]
    with pytest.raises(ModelgenError, match=r"Case.change: has no 'solvr'; nearest is 'solver'"):
        Case(MODEL, end=1.0).change(solvr="rk4")
    with pytest.raises(ModelgenError, match=r"parameter 's.stiffness': True is not a number; give a number in N\*m/rad"):
        Case(MODEL, end=1.0, parameters={"s.stiffness": True})


def test_texts_with_units_and_numbers_of_numpy() -> None:
    case = Case(MODEL, end="20 ms", begin=np.float32(0.0), record_from="10 ms", samples=np.int64(11), tolerance=np.float64(1e-7))
    assert (case.end, case.record_from, case.samples, case.tolerance) == (0.02, 0.01, 11, 1e-7)
    assert type(case.samples) is int


def test_a_case_answers_for_its_own_values() -> None:
    """sqrt(k (1/m + 1/n)) / (2 pi) with four times the stiffness is twice the frequency."""
    case = Case(MODEL, end=1.0, parameters={"s.stiffness": 8e4})
    own = np.sqrt(8e4 * (1 / 2 + 1 / 3)) / (2 * np.pi)
    for asked in (case, case.model):
        assert modal(asked).frequencies[1] == pytest.approx(own, rel=1e-12)
        assert operating_point(asked).frequencies()[1] == pytest.approx(own, rel=1e-12)
    assert modal(MODEL).frequencies[1] == pytest.approx(own / 2, rel=1e-12)
    assert forced(case)["s.torque"] == pytest.approx(forced(MODEL, None, {"s.stiffness": 8e4})["s.torque"], rel=1e-14)
    assert case.model.rhs_function is MODEL.rhs_function  # nothing is built anew


def test_changed_parameters_take_the_place_of_the_cases_own() -> None:
    case = Case(MODEL, end=1.0, parameters={"s.stiffness": 8e4})
    other = case.change(parameters={"m.inertia": 4.0})
    assert modal(other).frequencies[1] == pytest.approx(np.sqrt(2e4 * (1 / 4 + 1 / 3)) / (2 * np.pi), rel=1e-12)
    both = Case(case.model, end=1.0, parameters={"m.inertia": 4.0})
    assert modal(both).frequencies[1] == pytest.approx(np.sqrt(8e4 * (1 / 4 + 1 / 3)) / (2 * np.pi), rel=1e-12)


def test_a_load_that_is_set_by_hand_stays_so_in_the_model_of_the_case() -> None:
    heavy = Case(MODEL, end=1.0, parameters={"load.scale": 1.0, "drive.mean": 10.0})
    assert operating_point(heavy).p.tolist() == operating_point(MODEL, heavy.parameters).p.tolist()


BOUND = (
    *("modal", "campbell", "forced", "sensitivities", "phase_vectors", "operating_point", "settled_window", "settled", "bind"),
    *("crosscheck", "lyapunov_exponents", "periodic_orbit", "poincare"),
)
OTHERS = {
    "simulate": Case, "assemble": Driveline, "lower": modelgen.Equations, "gear_hammer": modelgen.analysis.ForcedResult,
    "load": str,
}


@pytest.mark.parametrize("question", BOUND)
def test_a_question_refuses_what_is_no_model_in_one_sentence(question: str) -> None:
    for given in (3, None, [LINE], {"line": LINE}):
        with pytest.raises(ModelgenError, match=rf"is asked of {type(given).__name__}; give a Driveline, Equations, a Compiled"):
            getattr(modelgen, question)(given)
    with pytest.raises(ModelgenError, match=r"model 'truck': is neither in the catalogue nor a model file; "):
        getattr(modelgen, question)("truck")


@pytest.mark.parametrize("question", OTHERS)
def test_what_a_question_cannot_take_it_refuses_in_one_sentence(question: str) -> None:
    for given in (LINE, assemble(LINE), 3, None, "truck"):
        if not isinstance(given, OTHERS[question]):
            with pytest.raises(ModelgenError, match=rf"(is asked of|is given|asked of a) .*{type(given).__name__}.*; give "):
                getattr(modelgen, question)(given)


def test_the_way_from_what_was_given_is_said() -> None:
    with pytest.raises(ModelgenError, match=r"simulate: is asked of Driveline, not of Case; give Case\(line, end=1.0\)"):
        simulate(LINE)  # type: ignore[arg-type]
