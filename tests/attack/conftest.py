"""What an attack may end in: an answer or one sentence, soon. A fault of the program is anything else."""

from __future__ import annotations

import contextlib
import signal
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

Within = Callable[[float], contextlib.AbstractContextManager[None]]
Attack = Callable[..., Counter[str]]


class HangError(BaseException):
    """A piece of work outlived its time; no handler of the program may take it for one of its own."""


@contextlib.contextmanager
def _within(seconds: float) -> Iterator[None]:
    def late(*_: Any) -> None:
        raise HangError(f"no answer within {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="session")
def within() -> Within:
    """``with within(5.0):`` raises HangError in work that takes longer, as soon as it comes back to Python."""
    if not hasattr(signal, "SIGALRM"):
        pytest.skip("this system has no alarm clock for processes")
    return _within


@pytest.fixture(scope="session")
def attack(within: Within) -> Attack:
    """``attack(strategy, count, seconds, try_one)``: the same draws at every run; how often each ending."""

    def run(strategy: st.SearchStrategy[Any], count: int, seconds: float, try_one: Callable[[Any], str]) -> Counter[str]:
        endings: Counter[str] = Counter()

        @settings(derandomize=True, database=None, deadline=None, max_examples=count, suppress_health_check=list(HealthCheck))
        @given(strategy)
        def every(drawn: Any) -> None:
            with within(seconds):
                endings[try_one(drawn)] += 1

        every()
        print(f"\n{sum(endings.values())} tried: " + ", ".join(f"{number} {ending}" for ending, number in endings.most_common()))
        return endings

    return run
