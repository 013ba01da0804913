"""Model files, lawful and spoiled, through everything from the text to a short run: an answer or one sentence."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import Case, ModelgenError, assemble, lower, operating_point, simulate
from modelgen.model.files import parse_model
from modelgen.solvers.problem import Budget
from strategies.broken import broken_texts
from strategies.drivelines import model_texts

from .conftest import Attack

ONE_FILE = 15.0  # [s]; a run may take one of them, the rest is reading and lowering on a machine that does other things too


def try_file(text: str) -> str:
    """How it ended: "parse refused", ..., or the outcome of the run; every number that comes out is finite."""
    stage = "parse"
    try:
        line = parse_model(text)
        stage = "lower"
        model = lower(assemble(line))
        stage = "run"
        try:
            point = operating_point(model)
        except ModelgenError:
            stage = "run without rest"
        else:
            assert all(np.isfinite(each).all() for each in (point.angle, point.start, point.mass, point.stiffness, point.damping))
            assert np.isfinite(point.frequencies()).all()
        options = {"backend": "vm", "budget": Budget(max_seconds=1.0)}
        solution = simulate(Case(model, end=0.05, start="zero", samples=51, options=options))
    except ModelgenError:
        return f"{stage} refused"
    assert np.isfinite(solution.states).all(), solution.outcome
    assert all(np.isfinite(values).all() for values in solution.channels.values()), solution.outcome
    return f"{stage}: {solution.outcome.name}"


@pytest.mark.slow
@pytest.mark.parametrize(("drawn", "count"), [("lawful", 60), ("spoiled", 140)])
def test_a_sample_of_model_files(attack: Attack, drawn: str, count: int) -> None:
    endings = attack(model_texts() if drawn == "lawful" else broken_texts(), count, ONE_FILE, try_file)
    assert sum(endings.values()) == count
    assert endings["run: SUCCESS"] > count // 20  # the attack reaches behind the reader
    assert endings["parse refused"] > count // 10 or drawn == "lawful"


@pytest.mark.proof
@pytest.mark.parametrize(("drawn", "count"), [("lawful", 500), ("spoiled", 1000)])
def test_every_model_file(attack: Attack, drawn: str, count: int) -> None:
    endings = attack(model_texts() if drawn == "lawful" else broken_texts(), count, ONE_FILE, try_file)
    assert sum(endings.values()) == count
    assert endings["run: SUCCESS"] > count // 20
