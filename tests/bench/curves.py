"""Measuring: seconds and errors of one solver over its tolerances, and ratios of solvers at one error.

Seconds at an error are read off the lines between a solver's points, in logarithms, and never beyond its tightest tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from peers.workload import Workload, error

LEVELS = (1e-4, 1e-5, 1e-6, 1e-8)
SHORT = 0.1  # s: what is over sooner is repeated for so long
LIMIT = 20.0  # s: a solver that took longer is not run at tighter tolerances, unless it has a patience of its own
ONCE = 1.0  # s: what takes longer is not repeated


@dataclass
class Curve:
    """Tolerances, seconds per trajectory and errors of one solver; ``failures``: what it could not do, in words."""

    name: str
    tolerance: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    median: list[float] = field(default_factory=list)
    worst: list[float] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    def points(self, which: str) -> list[tuple[float, float]]:
        """Pairs of error and seconds, of runs that ended; by rising error."""
        return sorted((e, s) for e, s in zip(getattr(self, which), self.seconds, strict=True) if np.isfinite(e) and e > 0)

    def seconds_at(self, level: float, which: str) -> float | None:
        """Seconds to stay below an error, between the measured points (never beyond them)."""
        points = self.points(which)
        if not points or points[0][0] > level:
            return None
        if points[-1][0] <= level:
            return min(s for _, s in points)
        logs = np.log([e for e, _ in points]), np.log([s for _, s in points])
        return float(np.exp(np.interp(np.log(level), *logs)))


def failure_text(failure: Exception) -> str:
    """An exception in one line."""
    return f"{type(failure).__name__}: {' '.join(str(failure).split())[:160]}"


def best(action: Callable[[], np.ndarray], repetitions: int) -> tuple[float, np.ndarray]:
    """The least seconds of some repetitions, and the last result; one only where it takes long, more where it is over at once."""
    least, result, count, begun = np.inf, np.zeros(0), 0, time.perf_counter()
    while count < repetitions or time.perf_counter() - begun < SHORT:
        start = time.perf_counter()
        result = action()
        least, count = min(least, time.perf_counter() - start), count + 1
        if least > ONCE:
            break
    return least, result


def measure(peer: Any, works: list[Workload], exact: list[np.ndarray], sweep: bool, repetitions: int) -> Curve:
    """Seconds per trajectory and errors of one solver over its tolerances."""
    curve = Curve(peer.name)
    for tolerance in peer.tolerances:
        try:
            if hasattr(peer, "prepare"):
                peer.prepare(tolerance)
            took, found = best(lambda t=tolerance: peer.sweep(t) if sweep else peer.single(t), repetitions)
        except Exception as failure:  # shown as failing, and the others go on
            curve.failures.append(f"at {tolerance:g}: {failure_text(failure)}")
            print(f"    {peer.name} {curve.failures[-1]}", flush=True)
            continue
        runs = found if sweep else [found]
        count = len(runs)
        errors = [error(w.channels(x), e) for w, x, e in zip(works[:count], runs, exact[:count], strict=True)]
        for row, value in (
            (curve.tolerance, tolerance),
            (curve.seconds, took / count),
            (curve.median, float(np.median(errors))),
            (curve.worst, max(errors)),
        ):
            row.append(value)
        print(
            f"    {peer.name:46} {tolerance:7.0e} {took / count:10.5f} s {np.median(errors):9.1e} {max(errors):9.1e}", flush=True
        )
        if took > getattr(peer, "patience", LIMIT):
            break
    return curve


def summary_of(curves: list[Curve], which: str) -> dict[str, Any]:
    """At each level of error: the fastest of ours and of the peers, and ratios."""
    told = {}
    entered = [curve.name for curve in curves if not curve.name.startswith("modelgen")]
    for level in LEVELS:
        seconds = {curve.name: curve.seconds_at(level, which) for curve in curves}
        ours = {name: s for name, s in seconds.items() if s is not None and name.startswith("modelgen") and "machine" not in name}
        peers = {name: s for name, s in seconds.items() if s is not None and not name.startswith("modelgen")}
        if not ours:
            continue
        name, least = min(ours.items(), key=lambda each: each[1])
        row: dict[str, Any] = {"ours": name, "ours_s": least, "ours_all_s": ours, "peers_s": peers}
        row["reached_by"] = f"{len(peers)} of {len(entered)}"
        if peers:
            row["fastest_peer"], row["fastest_peer_s"] = min(peers.items(), key=lambda each: each[1])
            row["ratio"] = row["fastest_peer_s"] / least
        for key, peer in (("ratio_cvodes_vm", "CasADi cvodes, virtual machine"), ("ratio_scipy", "SciPy DOP853, Python-called")):
            found = [s for n, s in peers.items() if n.startswith(peer)]
            row[key] = found[0] / least if found else None
        told[f"{level:g}"] = row
    return told
