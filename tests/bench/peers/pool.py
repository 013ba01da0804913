"""Processes for the peers that the interpreter's lock would hold back: one per core, started before the clock runs."""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor


def warm_pool() -> ProcessPoolExecutor:
    """A pool whose processes have imported what they need; nothing is forked from a process that has threads."""
    count = len(os.sched_getaffinity(0))
    pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"), initializer=_import)
    list(pool.map(_idle, range(2 * count)))
    return pool


def _import() -> None:
    from . import casadi_peer, jitcode_peer, scipy_peer  # noqa: F401


def _idle(_: int) -> None:
    import time

    time.sleep(0.2)
