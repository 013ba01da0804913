"""The questions with one curve per solver: one trajectory of a driveline, or a sweep of its damping ratio.

The reference is numba's loop at 1e-12, whose right-hand side shares nothing with modelgen's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from curves import Curve, failure_text, measure, summary_of
from models import gear_pair, smooth_truck
from peers.product import Modelgen, VirtualMachine
from peers.registry import PEERS, peer_named
from peers.workload import Workload, workload
from report import figure

from modelgen import Driveline, assemble, load, lower
from modelgen.solvers.registry import SOLVERS

SAMPLES = 401
END, COLUMNS = 2.0, 64  # s, and damping ratios of the sweep
QUICK_END, QUICK_COLUMNS = 0.05, 8


@dataclass(frozen=True)
class Question:
    """``horizon``: of the common end; ``sweep``: over the damping ratio; ``truck``: the slowest peers are asked too."""

    key: str
    title: str
    line: Callable[[], Driveline]
    horizon: float = 1.0
    sweep: bool = False
    truck: bool = False

    def run(self, quick: bool, out: Path) -> dict[str, Any]:
        """Entries of the summary; draws the figures."""
        end = self.horizon * (QUICK_END if quick else END)
        print(f"{self.title}, {end:g} s", flush=True)
        found = curves(self, end, quick)
        told: dict[str, Any] = {"curves": {self.key: [vars(curve) for curve in found]}}
        for which in ("median", "worst") if self.sweep else ("median",):
            name = f"{self.key}_{which}" if self.sweep else self.key
            told[name] = summary_of(found, which)
            shown = f", {which} of the trajectories" if self.sweep else ""
            figure(found, which, f"{self.title}, {end:g} s", shown, out / f"{name}.png")
        return told


QUESTIONS = (
    Question("single", "fracturing-truck, one trajectory", lambda: load("fracturing-truck"), truck=True),
    Question("sweep", "fracturing-truck, sweep of the damping ratio", lambda: load("fracturing-truck"), sweep=True, truck=True),
    Question("smooth_single", "smooth truck, one trajectory", smooth_truck, horizon=0.5),
    Question("gear_pair_single", "gear pair, one trajectory", gear_pair, horizon=2.0),
)


def scale_of(work: Workload) -> np.ndarray:
    """What absolute tolerances of the peers refer to: a tenth of the static angle, and that at 1000 rad/s."""
    n = len(work.inertia)
    angle = max(float(np.abs(work.start[:n]).max()), 1e-4)
    return np.concatenate([np.full(n, angle / 10), np.full(n, angle * 100)])


def curves(asked: Question, end: float, quick: bool) -> list[Curve]:
    """All curves of one question."""
    line, sweep = asked.line(), asked.sweep
    model = lower(assemble(line))
    zetas = np.linspace(0.01, 0.08, QUICK_COLUMNS if quick else COLUMNS).tolist() if sweep else [0.035]
    values = [{"zeta": zeta} if "zeta" in line.parameters else {} for zeta in zetas]
    works = [workload(line, end, SAMPLES, model, **each) for each in values]
    few = works[:: max(1, len(works) // 8)] if sweep else works
    scale = scale_of(works[0])
    print(f"  reference of {len(works)} trajectories", flush=True)
    reference = peer_named("numba, Dormand-Prince loop").make(works, scale).sweep(1e-12)
    exact = {id(w): w.channels(x) for w, x in zip(works, reference, strict=True)}
    makers: list[tuple[str, list[Workload], Callable[[], Any]]] = [
        (f"modelgen {method}", works, lambda m=method, e=events: Modelgen(model, values, end, SAMPLES, m, e))
        for method in ("rk4", "dopri5", "verner65", "dop853")
        for events in ("on", "off")
        if events == "off" or SOLVERS[method].locates_events
    ]
    if not sweep:
        makers.append(("modelgen rk4, virtual machine", works, lambda: VirtualMachine(model, values, end, SAMPLES)))
    for peer in PEERS:
        if peer.fits(works[0]) and (asked.truck or not peer.slowest):
            own = few[::2] if peer.slowest else few if peer.slow else works
            makers.append((peer.name, own, lambda p=peer, w=own: p.make(w, scale)))
    found = []
    for name, own, make in makers:
        try:
            made = make()
        except Exception as failure:
            found.append(Curve(name, failures=[f"not built: {failure_text(failure)}"]))
            print(f"    {name} {found[-1].failures[0]}", flush=True)
            continue
        found.append(measure(made, own, [exact[id(work)] for work in own], sweep, 1 if quick else 3))
    return found
