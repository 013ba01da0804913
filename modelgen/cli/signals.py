"""Signals that end a command: what is half done is put away first.

Part of ``cli``. CasADi drops an exception that is raised in Python code that it calls from C++ (it asks arguments for their
shape, and converts them), so that a signal which arrives inside a call of CasADi waits for its end, half a second at most.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

TERMINATED = 143
PAUSE, MOST_PAUSES = 1e-3, 500  # s, and how often it waits: then the call is a long one, which hears signals by itself
CASADI = os.path.join("casadi", "casadi.py")


def end_by_signals() -> None:
    """From here on SIGINT raises KeyboardInterrupt and SIGTERM SystemExit, but not where it would be dropped."""
    waiting, pauses = [int(signal.SIGINT)], [0]

    def handle(number: int, frame: FrameType | None) -> None:
        alarm = getattr(signal, "SIGALRM", None)
        if number != alarm:
            waiting[0], pauses[0] = number, 0
        if alarm is not None and pauses[0] < MOST_PAUSES and _inside_casadi(frame):
            pauses[0] += 1
            signal.setitimer(signal.ITIMER_REAL, PAUSE)
        elif waiting[0] == signal.SIGTERM:
            sys.exit(TERMINATED)
        else:
            raise KeyboardInterrupt

    for name in ("SIGINT", "SIGTERM", "SIGALRM"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), handle)


def _inside_casadi(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.endswith(CASADI):
            return True
        frame = frame.f_back
    return False
