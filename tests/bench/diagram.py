"""The paper's Fig. 9 at one error: a bifurcation diagram over the damping ratio, by modelgen and by the fastest peers.

Columns are some of the 201 of ``modelgen reproduce paper``, denser where the motion is irregular; the truck is the one whose
excitation repeats with every turn of the pump, its mesh damping in proportion to that of the shafts. Every column starts at the
static equilibrium, waits and then keeps a strobe per turn. modelgen runs through ``solve_lanes`` like its own analysis, but the
whole wait like its peers; the analysis itself, which stops waiting when strobes stand still, is timed beside it.

Error: as everywhere, but over the kept strobes, per half the peak-to-peak within the last turn. Two tight solutions by different
codes and methods (heyoka's Taylor series with events, modelgen's dop853 with events) tell which columns can be compared point by
point: where they differ, the motion is chaotic or too sensitive. Seconds are told for the columns that are compared, at one error
of all solvers, and for all columns, at the same tolerances.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from curves import failure_text
from diagram_figure import diagram_figure
from models import repeating_truck
from peers.product import Modelgen
from peers.registry import peer_named
from peers.workload import Workload, workload
from questions import scale_of

from modelgen import assemble, lower
from modelgen.analysis import bifurcation
from modelgen.analysis.nonlinear.common_period import strobe_of
from modelgen.analysis.referee.mujoco_model import referee_of
from modelgen.solvers import Case, operating_point

LEVEL = 1e-5  # error that all are tuned to
HALVINGS = 3
SAME = LEVEL / 10  # where two tight solutions agree to this, a column is compared
GRID = 0.05 / 200  # of the paper's figure as it is reproduced
PLACES = {"engine output": "flywheel", "pump free end": "pump_free_end"}
OURS = (("rk4", "off"), ("rk4", "on"))  # as modelgen's diagrams run unless asked otherwise, and with events located
RIVALS = ("heyoka, events", "CasADi erk, generated C")  # the fastest at this error; any names of the registry
REFERENCE, CHECK = 1e-10, 1e-9
WITHIN_TURN = 200  # samples of the last turn, for its peak-to-peak


@dataclass(frozen=True)
class Extent:
    """``columns`` of the diagram; ``wait`` and ``strobes``: turns that are thrown away and kept; the best of ``repetitions``."""

    columns: int
    wait: int
    strobes: int
    repetitions: int

    @property
    def values(self) -> list[float]:
        """Damping ratios [-]: multiples of the figure's grid, their roots evenly spaced."""
        return [GRID * round(200 * (k / (self.columns - 1)) ** 2) for k in range(self.columns)]


FULL, QUICK = Extent(16, 48, 24, 2), Extent(6, 8, 16, 1)


class Exact:
    """The tight solution of some columns: channels at the kept strobes, half their peak-to-peak, and how to hold others to it."""

    def __init__(self, works: list[Workload], scale: np.ndarray, kept: int) -> None:
        self.works, self.kept = works, kept
        times = works[0].times
        within = np.linspace(times[-2], times[-1], WITHIN_TURN + 1)[1:-1]
        every = np.union1d(times, within)
        peer = peer_named("heyoka, events").make([replace(work, times=every) for work in works], scale)
        peer.prepare(REFERENCE)
        found = peer.sweep(REFERENCE)
        self.states = found[:, np.searchsorted(every, times)][:, -kept:]
        self.half = [np.ptp(w.channels(x[every >= times[-2]]), axis=0) / 2 for w, x in zip(works, found, strict=True)]

    def errors(self, found: np.ndarray, rows: list[int]) -> np.ndarray:
        """Error of each of some columns (rows, times, states); infinite for what is not finite."""
        told = []
        for k, states in zip(rows, found, strict=True):
            channels = self.works[k].channels(states[-self.kept :])
            away = np.abs(channels - self.works[k].channels(self.states[k])).max(axis=0) / self.half[k]
            told.append(float(away.max()) if np.isfinite(away).all() else np.inf)
        return np.array(told)


def tolerance_for(peer: Any, wrong: Callable[[np.ndarray], float]) -> float:
    """The loosest tolerance at which a solver stays below the level, by halving in logarithms between its own.

    Raises RuntimeError where it never stays below.
    """

    def passes(tolerance: float) -> bool:
        error = wrong(run(peer, tolerance)[1])
        print(f"    tuning {peer.name:39} {tolerance:7.1e} {'':12} {error:9.1e}", flush=True)
        return error <= LEVEL

    loose = None
    for tight in peer.tolerances:
        if passes(tight):
            break
        loose = tight
    else:
        raise RuntimeError(f"stays above an error of {LEVEL:g} at every tolerance")
    for _ in range(HALVINGS if loose else 0):
        middle = float(np.sqrt(tight * loose))
        tight, loose = (middle, loose) if passes(middle) else (tight, middle)
    return tight


def run(peer: Any, tolerance: float, repetitions: int = 1) -> tuple[float, np.ndarray]:
    """Least seconds of a sweep, and its states; what is built before is not counted."""
    if hasattr(peer, "prepare"):
        peer.prepare(tolerance)
    seconds = []
    for _ in range(repetitions):
        start = time.perf_counter()
        found = peer.sweep(tolerance)
        seconds.append(time.perf_counter() - start)
    return min(seconds), np.asarray(found)


def elastic_angles(work: Workload, states: np.ndarray, places: list[tuple[int, float]]) -> np.ndarray:
    """Angles of some places without the rolling of the whole train (times, places) [rad]: physical, as the product's channels."""
    n = len(work.inertia)
    eye = np.eye(2 * n)[:n]
    rolling = np.linalg.svd(work.channels(eye).T[: len(work.shafts) + len(work.meshes)])[2][-1]  # moves no channel
    angle = states[:, :n]
    rolled = angle @ (work.inertia * rolling) / (work.inertia @ rolling**2)
    return np.array([ratio * (angle[:, hinge] - rolling[hinge] * rolled) for hinge, ratio in places]).T


def ratios(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The fastest of ours and of the peers over the compared columns, and over all, with seconds of the peer per ours."""
    told: dict[str, Any] = {}
    for kind, suffix in (("seconds", ""), ("whole_s", "_whole")):
        timed = [row for row in rows if "failure" not in row]
        best = [
            min((row for row in timed if row["name"].startswith("modelgen") is own), key=lambda row: row[kind], default=None)
            for own in (True, False)
        ]
        told[f"ours{suffix}"], told[f"fastest_peer{suffix}"] = (row and row["name"] for row in best)
        told[f"ratio{suffix}"] = best[1][kind] / best[0][kind] if best[0] and best[1] else None
    return told


def diagram(quick: bool, out: Path) -> dict[str, Any]:
    """Entries of the summary; draws the figure."""
    extent = QUICK if quick else FULL
    line = repeating_truck()
    model = lower(assemble(line))
    values, turns = [{"zeta": zeta} for zeta in extent.values], extent.wait + extent.strobes
    point = operating_point(model, values[0])
    period = strobe_of(model, point).period
    at = referee_of(line, model, point).places
    places = [at[name] for name in PLACES.values()]
    print(f"bifurcation diagram, {extent.columns} columns, {turns} turns of {period:.6g} s", flush=True)
    works = [workload(line, turns * period, turns + 1, model, **each) for each in values]
    scale = scale_of(works[0])

    def ours(which: list[int], method: str, events: str) -> Modelgen:
        return Modelgen(model, [values[k] for k in which], turns * period, turns + 1, method, events)

    every = list(range(extent.columns))
    exact = Exact(works, scale, extent.strobes)
    apart = exact.errors(run(ours(every, "dop853", "on"), CHECK)[1], every)
    compared = [k for k in every if apart[k] <= SAME]
    print(f"  two tight solutions differ by {', '.join(f'{each:.0e}' for each in apart)}", flush=True)
    if not compared:
        raise RuntimeError("no column can be compared point by point")
    tuned = [compared[0], compared[len(compared) // 2]]  # the least damped column is the hardest

    makers: list[tuple[str, Callable[[list[int]], Any]]]
    makers = [(f"modelgen {method}", lambda which, m=method, e=events: ours(which, m, e)) for method, events in OURS]
    makers += [(name, lambda which, n=name: peer_named(n).make([works[k] for k in which], scale)) for name in RIVALS]
    rows: list[dict[str, Any]] = []
    drawn: dict[str, np.ndarray] = {}
    errors: dict[str, np.ndarray] = {}
    for name, make in makers:
        row: dict[str, Any] = {"name": name, "tolerance": None, "seconds": None, "error": None, "whole_s": None}
        rows.append(row)
        try:
            row["tolerance"] = tolerance_for(make(tuned), lambda found: float(exact.errors(found, tuned).max()))
            row["seconds"], _ = run(make(compared), row["tolerance"], extent.repetitions)
            peer = make(every)
            row["whole_s"], found = run(peer, row["tolerance"], extent.repetitions)
            row["name"] = peer.name
        except Exception as failure:
            row["failure"] = failure_text(failure)
            print(f"    {name}: {row['failure']}", flush=True)
            continue
        errors[peer.name] = exact.errors(found, every)
        row["error"] = float(errors[peer.name][compared].max())
        row["errors"] = errors[peer.name].tolist()
        kept = [elastic_angles(w, x[-extent.strobes :], places) for w, x in zip(works, found, strict=True)]
        drawn[peer.name] = np.degrees(kept)
        said = f"{row['error']:9.1e}, with all columns {row['whole_s']:.2f} s"
        print(f"    {peer.name:46} {row['tolerance']:7.1e} {row['seconds']:10.2f} s {said}", flush=True)
    start = time.perf_counter()
    bifurcation(
        Case(model, end=1.0, tolerance=rows[0]["tolerance"] or LEVEL),
        *("zeta", extent.values, [f"{name}.elastic_angle" for name in PLACES.values()]),
        count=extent.strobes, transient=extent.wait,
    )  # fmt: skip
    analysis = time.perf_counter() - start
    told = {
        "columns": extent.columns, "values": extent.values, "wait": extent.wait, "strobes": extent.strobes,
        "revolutions": turns, "period_s": period, "level": LEVEL, "rows": rows, "compared": len(compared),
        **ratios(rows),
        "not_compared": [extent.values[k] for k in every if k not in compared], "tight_solutions_differ": apart.tolist(),
        "analysis_s": analysis,
        "note": "The paper's figure as modelgen reproduces it has 201 columns, up to 200 turns of wait and 150 strobes; here are "
        f"{extent.columns} of these columns, {extent.wait} turns and {extent.strobes} strobes. analysis_s: modelgen's own "
        "bifurcation analysis, which waits no longer than it must. seconds: of the columns that are compared; whole_s: of all.",
    }  # fmt: skip
    diagram_figure(told, list(PLACES), drawn, errors, out / "diagram.png")
    return {"diagram": told}
