"""What Python and generated C share: the tables' columns, the endings, and the records, stated once and printed into C.

Part of the compiler; ``library`` puts ``c_records`` before ``task.h``, ``solvers.native_memory`` fills a ``Task``.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

OUTCOMES = (
    *("RUNNING", "SUCCESS", "MAX_STEPS", "STEP_TOO_SMALL", "NON_FINITE_RATE", "DIVERGED"),
    *("EVENT", "MAX_EVENTS", "ZENO", "EVENT_CHATTER"),
)
COUNTS = ("outcome", "steps", "rejected", "evaluations", "reached", "stop", "events", "last_event")
FACTS = ("time", "size", "smallest", "largest")
RULES = ("smooth", "paper", "fixed")
REDUCTIONS = ("lowest", "highest", "sum", "squares")
CROSSING = ("direction", "variable", "leave", "enter", "reset", "stops", "surface")  # of the table of crossings; -1: none
MODE = ("first_flag", "values", "first_value")  # of the table of mode variables

_DOUBLES, _COUNTS = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int64)


@dataclass(frozen=True)
class Field:
    """Fields of a record that are alike: their names with blanks between, what they are, and words about them."""

    names: str
    kind: str
    words: str = ""


_KINDS: dict[str, tuple[Any, str]] = {
    "count": (ctypes.c_int64, "int64_t "),
    "number": (ctypes.c_double, "double "),
    "counts": (_COUNTS, "int64_t *"),
    "numbers": (_DOUBLES, "double *"),
    "given counts": (_COUNTS, "const int64_t *"),
    "given numbers": (_DOUBLES, "const double *"),
}
_FUNCTIONS = {
    "parameters": "void (*parameters)(const double *p, double *c)",
    "at": "void (*at)(const V *c, const V *t, const V *x, const V *v, V *out)",
}
OBSERVER = (
    Field("values outputs", "count", "what parameters fix, and what comes out; no outputs: there is no such function"),
    Field("parameters at", "function"),
)
TASK = (
    Field("jobs samples times_stride", "count", "stride 0: all jobs share their output times"),
    Field("next", "counts", "job to take next, shared by all threads"),
    Field("p x0 scale times", "given numbers", "[jobs][NP], [jobs][NX], [jobs][NX], [jobs or 1][samples]"),
    Field("states", "numbers", "[jobs][samples][NX], counted from x0, or NULL"),
    Field("last", "numbers", "[jobs][2][NX]: where the run stands, and where a diverged step led to, from x0"),
    Field("p_now", "numbers", "[jobs][NP]: parameters with the flags of the present modes, or NULL"),
    Field("kept reduced", "numbers", "channels: [jobs][samples][outputs] or NULL, [jobs][REDUCTIONS][outputs]"),
    Field("first_modes", "counts", "[jobs][variables]: where the run began"),
    Field("happened", "counts", "[jobs][crossings]: events of each kind"),
    Field("held", "numbers", "[jobs][all mode values]: time that each held"),
    Field("counts", "counts", "[jobs][COUNTS]; the caller may set STOP"),
    Field("facts", "numbers", "[jobs][FACTS]"),
    Field("begin tolerance first_step largest_step smallest_step bound correction", "number", "first_step 0: estimated"),
    Field("fixed_step", "number"),
    Field("rule max_steps max_events log_limit", "count", "log_limit: events of each run that are logged"),
    Field("guards resets channels", "observer", "guards: values, then their rates"),
    Field("bounds rests", "observer", "of intervals: enclosures of guards and rates; sixth derivatives of what is not linear"),
    Field("guard_floor guard_zero", "given numbers", "[jobs][surfaces], [jobs][crossings]: sizes not to be resolved; zeros"),
    Field("breaks", "given numbers", "[jobs][2][break_count]: times just before and after each, INFINITY behind the last"),
    Field("crossings surfaces variables all_values reads", "count", "reads: states that guards depend on"),
    Field("break_count sampled_guards", "count", "sampled_guards: whether a guard can only be sampled"),
    Field("crossing mode read", "given counts", "[crossings][CROSSING], [variables][MODE], [reads]"),
    Field("way", "given counts", "[surfaces]: how each is counted"),
    Field("undecided", "counts", "[jobs][crossings]: whether a zero was left to samples"),
)
LOG = (
    Field("room used", "count"),
    Field("job which", "counts"),
    Field("time state", "numbers", "[room], [room][NX], before a reset"),
)


def _of_ctypes(fields: tuple[Field, ...]) -> tuple[tuple[str, Any], ...]:
    kinds = {**{kind: each for kind, (each, _) in _KINDS.items()}, "function": ctypes.c_void_p, "observer": Observer}
    return tuple((name, kinds[field.kind]) for field in fields for name in field.names.split())


class Observer(ctypes.Structure):
    """A function (t, x, v, p) -> column that is asked for within a run, from a library of its own: sizes and entry points."""


class Task(ctypes.Structure):
    """What all workers of a run share."""


class Log(ctypes.Structure):
    """The events that a worker came upon, in their order, until they are read."""


Observer._fields_ = _of_ctypes(OBSERVER)  # a record may hold another, so classes come first
Task._fields_ = _of_ctypes(TASK)
Log._fields_ = _of_ctypes(LOG)


def c_records() -> str:
    """C text of the tables' columns, the endings and the records."""
    lines = []
    for names, size in ((OUTCOMES, ""), (COUNTS, "COUNTS"), (FACTS, "FACTS"), (RULES, ""), (REDUCTIONS, "REDUCTIONS")):
        lines.append(_enumeration(names, size))
    lines += [_enumeration(CROSSING, "CROSSING"), _enumeration(MODE, "MODE")]
    for name, fields in (("Observer", OBSERVER), ("Task", TASK), ("Log", LOG)):
        lines += ["typedef struct {", *(f"  {line}" for field in fields for line in _c_fields(field)), f"}} {name};"]
    return "\n".join(lines) + "\n"


def _enumeration(names: tuple[str, ...], size: str) -> str:
    return f"enum {{ {', '.join([*(name.upper() for name in names), *([size] if size else [])])} }};"


def _c_fields(field: Field) -> list[str]:
    """Declarations of C, the words behind the first."""
    names, words = field.names.split(), f" /* {field.words} */" if field.words else ""
    if field.kind == "function":
        return [f"{_FUNCTIONS[name]};" for name in names]
    if field.kind == "observer":
        return [f"Observer {', '.join(names)};{words}"]
    kind = _KINDS[field.kind][1]
    star = "*" if kind.endswith("*") else ""
    return [f"{kind.rstrip('* ')} {', '.join(star + name for name in names)};{words}"]
