"""The records that Python and generated C share: field by field those of ``task.h``."""

from __future__ import annotations

import ctypes

OUTCOMES = (
    *("RUNNING", "SUCCESS", "MAX_STEPS", "STEP_TOO_SMALL", "NON_FINITE_RATE", "DIVERGED"),
    *("EVENT", "MAX_EVENTS", "ZENO", "EVENT_CHATTER"),
)
COUNTS = ("outcome", "steps", "rejected", "evaluations", "reached", "stop", "events", "last_event")
FACTS = ("time", "size", "smallest", "largest")
RULES = ("smooth", "paper", "fixed")
REDUCTIONS = ("lowest", "highest", "sum", "squares")

_DOUBLES = ctypes.POINTER(ctypes.c_double)
_COUNTS = ctypes.POINTER(ctypes.c_int64)


class Observer(ctypes.Structure):
    """A function that is asked for within a run: sizes and entry points; without outputs there is none."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("values", "outputs")),
        *((name, ctypes.c_void_p) for name in ("parameters", "at")),
    )


class Task(ctypes.Structure):
    """What all workers of a run share."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("jobs", "samples", "times_stride")),
        ("next", _COUNTS),
        *((name, _DOUBLES) for name in ("p", "x0", "scale", "times", "states", "last", "p_now", "kept", "reduced")),
        *((name, _COUNTS) for name in ("first_modes", "happened")),
        ("held", _DOUBLES),
        ("counts", _COUNTS),
        ("facts", _DOUBLES),
        *(
            (name, ctypes.c_double)
            for name in ("begin", "tolerance", "first_step", "largest_step", "smallest_step", "bound", "correction", "fixed_step")
        ),
        *((name, ctypes.c_int64) for name in ("rule", "max_steps", "max_events", "log_limit")),
        *((name, Observer) for name in ("guards", "resets", "channels", "bounds", "rests")),
        *((name, _DOUBLES) for name in ("guard_floor", "guard_zero", "breaks")),
        *(
            (name, ctypes.c_int64)
            for name in ("crossings", "surfaces", "variables", "all_values", "reads", "break_count", "sampled_guards")
        ),
        *((name, _COUNTS) for name in ("crossing", "mode", "read", "way", "undecided")),
    )


class Log(ctypes.Structure):
    """The events that a worker came upon, until they are read."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("room", "used")),
        *((name, _COUNTS) for name in ("job", "which")),
        *((name, _DOUBLES) for name in ("time", "state")),
    )
