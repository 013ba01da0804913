"""How steps are sized, guards watched and events told from chatter: the numbers, for the virtual machine and for C alike.

Part of ``lowering``. ``solvers.march``, ``solvers.guards`` and ``solvers.events`` compute with them; generated and portable C get
them as macros of the same names. Source of the control: Gustafsson (1991) as in Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, II.4: with e the error in tolerances, e' that of the step before and q the power of the step in the
measured error, the next step is longer by SAFETY e^(-PRESENT/q) e'^(PAST/q).
"""

from __future__ import annotations

SAFETY = 0.9
LARGEST_GROWTH = 5.0
SMALLEST_SHRINK = 0.2
PRESENT = 0.85  # shares of the two errors; fewest evaluations on gear trains and backlash among 1/0, 0.85/0.2, 0.7/0.4
PAST = 0.2
LEAST_ERROR = 1e-10  # in tolerances: what is smaller counts as this

FIRST_MOVE = 0.01  # of a state's scale: how far the step goes by which the first one is estimated
FIRST_ERROR = 0.01  # of the tolerance: the error at which the first step aims
FIRST_GROWTH = 100.0  # of that step, at most
FIRST_SHARE = 1e-6  # of the horizon, where nothing moves

SMALLEST_STEP = 1e-13  # of the horizon, where a budget says nothing else
BOUND = 1e10  # scales from its start at which a state has diverged, where a budget says nothing else

RESOLUTION = 0.02  # of a guard's size: how far the quintic through the guard may be from it
DIP = 0.1  # of a sampled guard's size: a dip that stays further away from zero is not searched
TOUCH = 8.0  # roundings of a guard: a turn toward zero that comes closer and does not pass it is a touch
DEEPEST = 40  # halvings of a step in search of roots
MOST_PLACES = 64  # at which one guard is looked at in a step

MANY = 32  # events at one time, or one after the other without time to speak of, that are no accident
MOMENT = 1e-10  # of the horizon: no time to speak of
SHRINKING = 0.9  # of the gaps between early events: late ones below it come ever faster
ROUNDINGS = 64  # last digits of a time: gaps within so many are rounding

_PRINTED = (
    *("SAFETY", "LARGEST_GROWTH", "SMALLEST_SHRINK", "PRESENT", "PAST", "LEAST_ERROR"),
    *("FIRST_MOVE", "FIRST_ERROR", "FIRST_GROWTH", "FIRST_SHARE"),
    *("RESOLUTION", "DIP", "TOUCH", "DEEPEST", "MOST_PLACES", "MANY", "MOMENT", "SHRINKING", "ROUNDINGS"),
)


def of_method(control: int) -> dict[str, float]:
    """All of them, with the exponents of a method whose measured error grows with that power of the step, by name."""
    numbers = {name: globals()[name] for name in (*_PRINTED, "SMALLEST_STEP", "BOUND")}
    exponent = 1 / control
    return {**numbers, "EXPONENT": exponent, "PRESENT_EXPONENT": PRESENT * exponent, "PAST_EXPONENT": PAST * exponent}


def c_macros() -> str:
    """C text that defines all of them.

    >>> print(c_macros().splitlines()[0])
    #define SAFETY 0.9
    """
    return "".join(f"#define {name} {globals()[name]!r}\n" for name in _PRINTED)
