"""Outcomes are distinct sentences that can be filled in with the facts that every failure has."""

from __future__ import annotations

import string

import pytest

from modelgen.solvers.outcome import Outcome

FACTS = {
    "time": 0.25,
    "state": "shaft.twist",
    "value": 0.5,
    "rate": 2.0,
    "step": 1e-9,
    "tolerance": 1e-8,
    "budget": 100.0,
    "low": -1.0,
    "high": 1.0,
    "event": "contact",
    "reason": "no start",
}


def test_every_outcome_is_named_and_different() -> None:
    assert len(Outcome) == 16
    assert len({outcome.value for outcome in Outcome}) == 16


@pytest.mark.parametrize("outcome", Outcome)
def test_every_sentence_can_be_told(outcome: Outcome) -> None:
    fields = {name for _, name, _, _ in string.Formatter().parse(outcome.value) if name}
    assert fields <= FACTS.keys()
    sentence = outcome.sentence(**FACTS)
    assert "{" not in sentence
    assert ("0.25 s" in sentence) == ("time" in fields)
    assert ("'shaft.twist'" in sentence) == ("state" in fields)
    assert outcome.is_good == (outcome in {Outcome.SUCCESS, Outcome.EVENT})


def test_a_missing_fact_is_an_error_and_not_a_gap() -> None:
    with pytest.raises(KeyError, match="state"):
        Outcome.DIVERGED.sentence(time=1.0)
