"""The net: every command on every catalogued driveline gives the figures that are kept, so that nothing changes unseen."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest

from modelgen.lowering.native.compiler import NoCompilerError, find_compiler

from .figures import differences, figures_of
from .questions import Question, ask, full_questions, short_questions

HERE = Path(__file__).parent
LARGEST = 2_000_000  # bytes, of everything that is kept
SHOWN = 12
RENEW = "if this is meant, renew it in a commit that says why: .venv/bin/python -m tests.net.renew"


@pytest.mark.slow
@pytest.mark.parametrize("question", short_questions(), ids=str)
def test_the_figures_are_the_kept_ones(question: Question, tmp_path: Path) -> None:
    hold(question, HERE / "short", tmp_path, "")


@pytest.mark.proof
@pytest.mark.parametrize("question", full_questions(), ids=str)
def test_the_figures_at_full_settings_are_the_kept_ones(question: Question, tmp_path: Path) -> None:
    hold(question, HERE / "full", tmp_path, " --full")


@pytest.mark.slow
def test_the_net_stays_small_and_holds_nothing_that_is_not_asked() -> None:
    assert sum(path.stat().st_size for path in HERE.glob("*/*.*")) < LARGEST
    for folder, questions in (("short", short_questions()), ("full", full_questions())):
        kept = {path.stem for path in (HERE / folder).glob("*.json")}
        assert kept <= {question.name for question in questions}


def hold(question: Question, folder: Path, tmp_path: Path, option: str) -> None:
    """Asks, and compares with what is kept."""
    if question.needs == "cc":
        try:
            find_compiler()
        except NoCompilerError as none:
            pytest.skip(str(none))
    elif question.needs:
        pytest.importorskip(question.needs)
    printed, out = ask(question, tmp_path)
    found = figures_of(printed, out, question.words)
    differing = list(islice(differences(found, folder, question.name, question.within), SHOWN))
    command = f"{RENEW}{option} {question.name}"
    assert not differing, "\n".join([f"`modelgen {question.line}` differs from the net; {command}", *differing])
