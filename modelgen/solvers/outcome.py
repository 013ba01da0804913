"""The ways in which a run can end, each a sentence for the person who started it.

Part of ``solvers``; every solver ends in one of these, so that a failure has a name and never hides behind NaN.
The value of an outcome is the template of its sentence; the facts (time, state, value, ...) are filled in by ``sentence``.
"""

from __future__ import annotations

import enum
from typing import NamedTuple


class Outcome(enum.Enum):
    """How a run ended; the value is the template of the sentence shown to the user.

    >>> Outcome.CANCELLED.sentence(time=0.25)
    'stopped at t = 0.25 s: cancelled on request'
    >>> Outcome.SUCCESS.is_good, Outcome.DIVERGED.is_good
    (True, False)
    """

    SUCCESS = "reached the end at t = {time:.9g} s"
    EVENT = "stopped at t = {time:.9g} s: event '{event}' asked for it"
    MAX_STEPS = (
        "stopped at t = {time:.9g} s: the budget of {budget:.9g} steps is used up; raise max_steps, loosen the tolerance, or "
        "take an implicit solver if the model is stiff (fastest moving: '{state}' = {value:.6g}, rate {rate:.3g})"
    )
    MAX_TIME = (
        "stopped at t = {time:.9g} s: the budget of {budget:.6g} s of computing time is used up; raise max_seconds or loosen the "
        "tolerance (fastest moving: '{state}' = {value:.6g}, rate {rate:.3g})"
    )
    STEP_TOO_SMALL = (
        "stopped at t = {time:.9g} s: the tolerance {tolerance:.3g} cannot be held even with steps of {step:.3g} s; loosen it, "
        "or smooth the model where '{state}' = {value:.6g}, rate {rate:.3g}"
    )
    NON_FINITE_STATE = "stopped at t = {time:.9g} s: state '{state}' became {value}; check the start and the parameters"
    NON_FINITE_RATE = (
        "stopped at t = {time:.9g} s: the right-hand side gives {rate} for the rate of '{state}' (= {value:.6g}); check the "
        "parameters and for roots, logarithms or quotients out of their range"
    )
    DIVERGED = (
        "stopped at t = {time:.9g} s: state '{state}' grew without bound to {value:.6g} (rate {rate:.3g}); check signs, damping "
        "and stiffness"
    )
    CHATTERING = (
        "stopped at t = {time:.9g} s: the rate of '{state}' (= {value:.6g}) jumps between {low:.6g} and {high:.6g} at every "
        "step, however small; smooth the law that switches there, or model sticking as an event"
    )
    MAX_EVENTS = (
        "stopped at t = {time:.9g} s: the budget of {budget:.9g} events is used up (the next is '{event}'); raise max_events, "
        "or smooth the law that switches there"
    )
    ZENO = (
        "stopped at t = {time:.9g} s: events of '{event}' follow each other ever faster and accumulate there; the model has no "
        "mode for what comes after (rest, sticking): give it one, or end the run before"
    )
    EVENT_CHATTER = (
        "stopped at t = {time:.9g} s: '{event}' switches forth and back without time passing; the modes on both sides push back "
        "to the border: model sticking as a mode of its own, or smooth the law"
    )
    NEWTON_FAILED = (
        "stopped at t = {time:.9g} s: the implicit equations could not be solved even for a step of {step:.3g} s; loosen the "
        "tolerance, or smooth the model where '{state}' = {value:.6g}, rate {rate:.3g}"
    )
    BAD_INPUT = "not started: {reason}"
    SOLVER_ERROR = "stopped at t = {time:.9g} s: the solver gave up ({reason}) where '{state}' = {value:.6g}, rate {rate:.3g}"
    CANCELLED = "stopped at t = {time:.9g} s: cancelled on request"

    @property
    def is_good(self) -> bool:
        """Whether the run did what was asked: it reached its end, or an event that was meant to stop it."""
        return self in (Outcome.SUCCESS, Outcome.EVENT)

    def sentence(self, **facts: float | str) -> str:
        """The template with its facts; facts that it does not mention are ignored."""
        return self.value.format(**facts)


class Ending(NamedTuple):
    """An outcome with its finished sentence."""

    outcome: Outcome
    message: str


class StopRunError(Exception):
    """Carries an ending out of the loop of a run."""

    def __init__(self, ending: Ending) -> None:
        self.ending = ending
