"""Error against cost beside every peer, in one run: ``make bench``. Writes out/bench: summary.json, table.md and figures.

    python tests/bench/against_peers.py [--quick] [--out DIR]

Models: the truck of the catalogue (events at the flanks), a smooth one (the truck without backlash at mean stiffness), a gear
pair. Error: largest over vibrating channels (twists, approaches along the line of action, their rates) of the difference from a
solution at 1e-12, per half the peak-to-peak of the channel, from the static start. Every peer runs as its own manual advises; all
cores for all. Seconds are the best of the repetitions; ratios at one error are read off the lines between a solver's tolerances.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from peers.product import Modelgen, VirtualMachine
from peers.workload import Workload, error, workload

from modelgen import Driveline, GearPair, HarmonicTorque, Inertia, Shaft, assemble, load, lower
from modelgen.analysis.referee.comparison import with_mean_stiffness

LEVELS = (1e-4, 1e-5, 1e-6, 1e-8)
LIMIT = 20.0  # s: a solver that took longer is not run at tighter tolerances, nor twice
PACKAGES = ("modelgen", "numpy", "scipy", "casadi", "numba", "heyoka", "jitcode", "diffrax", "jax")


@dataclass
class Curve:
    """Tolerances, seconds per trajectory and errors of one solver."""

    name: str
    tolerance: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    median: list[float] = field(default_factory=list)
    worst: list[float] = field(default_factory=list)

    def seconds_at(self, level: float, which: str) -> float | None:
        """Seconds to stay below an error, between the measured points (never beyond them)."""
        errors = np.array(getattr(self, which))
        points = sorted((e, s) for e, s in zip(errors, self.seconds, strict=True) if np.isfinite(e) and e > 0)
        if not points or points[0][0] > level:
            return None
        if points[-1][0] <= level:
            return min(s for _, s in points)
        logs = np.log([e for e, _ in points]), np.log([s for _, s in points])
        return float(np.exp(np.interp(np.log(level), *logs)))


def best(action: Callable[[], np.ndarray], repetitions: int) -> tuple[float, np.ndarray]:
    """The least seconds of some repetitions, and the last result; one only where it takes long."""
    least, result = np.inf, np.zeros(0)
    for _ in range(repetitions):
        start = time.perf_counter()
        result = action()
        least = min(least, time.perf_counter() - start)
        if least > LIMIT / 4:
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
        except Exception as failure:  # a peer that fails is shown as failing, and the others go on
            print(f"    {peer.name} at {tolerance:g}: {type(failure).__name__}: {str(failure)[:120]}", flush=True)
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
        if took > LIMIT:
            break
    return curve


def summary_of(curves: list[Curve], which: str) -> dict[str, Any]:
    """At each level of error: the fastest of ours and of the peers, and ratios."""
    told = {}
    for level in LEVELS:
        seconds = {curve.name: curve.seconds_at(level, which) for curve in curves}
        ours = {name: s for name, s in seconds.items() if s is not None and name.startswith("modelgen") and "machine" not in name}
        peers = {name: s for name, s in seconds.items() if s is not None and not name.startswith("modelgen")}
        if not ours:
            continue
        name, least = min(ours.items(), key=lambda each: each[1])
        row: dict[str, Any] = {"ours": name, "ours_s": least, "ours_all_s": ours, "peers_s": peers}
        if peers:
            row["fastest_peer"], row["fastest_peer_s"] = min(peers.items(), key=lambda each: each[1])
            row["ratio"] = row["fastest_peer_s"] / least
        for key, peer in (("ratio_cvodes_vm", "CasADi cvodes, virtual machine"), ("ratio_scipy", "SciPy DOP853, Python-called")):
            found = [s for n, s in peers.items() if n.startswith(peer)]
            row[key] = found[0] / least if found else None
        told[f"{level:g}"] = row
    return told


def smooth_truck() -> Driveline:
    """The truck without backlash, at mean mesh stiffness: nothing but sines."""
    return with_mean_stiffness(load("fracturing-truck")).change("gear_pair", half_backlash=0.0)


def gear_pair() -> Driveline:
    """Two gears whose mesh loses contact near resonance; in terms of w_n t and the backlash it is the dimensionless gear pair."""
    return Driveline(
        "gear-pair", speed="1000 rpm", reference="pinion",
        elements=[
            Inertia("pinion", inertia=0.01), Inertia("wheel", inertia=0.04),
            GearPair("mesh", "pinion", "wheel", teeth_a=20, teeth_b=40, module="4 mm", mean_stiffness="2e7 N/m",
                     stiffness_cosine=[4e6], stiffness_sine=[0.0], damping_ratio=0.05, half_backlash="20 um"),
            HarmonicTorque("drive", "pinion", mean="20 N*m", base="shake", cosine=[6.0]),
            HarmonicTorque("load", "wheel", mean="-40 N*m"),
        ],
        bases={"shake": ("pinion", 31)},
    )  # fmt: skip


def chain(count: int) -> Driveline:
    """Inertias in a row with a harmonic torque at one end."""
    disks = [Inertia(f"disk_{k}", inertia=0.5 + 0.01 * (k % 7)) for k in range(count)]
    shafts = [
        Shaft(f"shaft_{k}", f"disk_{k}", f"disk_{k + 1}", stiffness=2e5 + 1e3 * (k % 5), damping_ratio=0.02)
        for k in range(count - 1)
    ]
    drive = HarmonicTorque("drive", "disk_0", mean=0.0, sine=[100.0, 40.0, 20.0, 10.0], cosine=[0.0, 5.0, 0.0, 1.0], base="order")
    return Driveline(
        f"chain-{count}", speed="600 rpm", reference="disk_0", elements=[*disks, *shafts, drive], bases={"order": ("disk_0", 2)}
    )


def peers_for(works: list[Workload], scale: np.ndarray, slow: bool, sweep: bool) -> list[Callable[[], Any]]:
    """Makers of the peers; each is built when its turn comes. Slow ones get an eighth of a sweep."""
    from peers.casadi_peer import CasADi
    from peers.diffrax_peer import Diffrax
    from peers.heyoka_peer import Heyoka
    from peers.jitcode_peer import JiTCODE
    from peers.numba_peer import Numba
    from peers.scipy_peer import SciPy

    few = works[:: max(1, len(works) // 8)] if sweep and len(works) > 8 else works
    makers: list[Callable[[], Any]] = [
        lambda: Numba(works, scale),
        *([lambda: Heyoka(works, scale)] if (works[0].meshes[:, 4] > 0).any() else []),  # no flank without a gap
        lambda: Heyoka(works, scale, with_events=False),
        lambda: CasADi(works, scale, "erk", True),
        lambda: JiTCODE(works, scale),
        lambda: CasADi(few, scale, "erk"),
        lambda: CasADi(few, scale, "cvodes"),
        lambda: SciPy(few, scale, "DOP853", True),
        lambda: SciPy(few, scale, "LSODA", True),
        lambda: Diffrax(few, scale),
    ]
    return [*makers, lambda: SciPy(few, scale, "DOP853", False)] if slow else makers


def question(line: Driveline, end: float, zetas: list[float], sweep: bool, quick: bool, slow: bool) -> list[Curve]:
    """All curves of one model: one trajectory, or a sweep of the damping ratio."""
    from peers.numba_peer import Numba

    model = lower(assemble(line))
    values = [{"zeta": zeta} if "zeta" in line.parameters else {} for zeta in zetas]
    samples = 401
    works = [workload(line, end, samples, model, **each) for each in values]
    n = len(works[0].inertia)
    angle = max(float(np.abs(works[0].start[:n]).max()), 1e-4)
    scale = np.concatenate([np.full(n, angle / 10), np.full(n, angle * 100)])
    print(f"  reference of {len(works)} trajectories", flush=True)
    exact = [w.channels(x) for w, x in zip(works, Numba(works, scale).sweep(1e-12), strict=True)]
    curves, repetitions = [], 1 if quick else 3
    makers: list[Callable[[], Any]] = [
        lambda m=method, e=events: Modelgen(model, values, end, samples, m, e)
        for method in ("rk4", "dopri5", "dop853")
        for events in ("on", "off")
    ]
    if not sweep:
        makers.append(lambda: VirtualMachine(model, values, end, samples))
    for maker in [*makers, *peers_for(works, scale, slow, sweep)]:
        try:
            peer = maker()
        except Exception as failure:
            print(f"    not run: {type(failure).__name__}: {str(failure)[:160]}", flush=True)
            continue
        own = getattr(peer, "works", works)
        rows = [next(k for k, other in enumerate(works) if other is each) for each in own]
        curves.append(measure(peer, own, [exact[k] for k in rows], sweep, repetitions))
    return curves


def scaling(quick: bool) -> dict[str, Any]:
    """Seconds over the number of inertias: building the solver, one right-hand side's run, and CasADi's cvodes."""
    from peers.casadi_peer import CasADi
    from peers.numba_peer import Numba

    told = {}
    for count in (16, 50) if quick else (16, 50, 100, 200, 400):
        line = chain(count)
        start = time.perf_counter()
        model = lower(assemble(line))
        lowered = time.perf_counter() - start
        work = workload(line, 0.2, 101, model)
        scale = np.concatenate([np.full(count, 1e-3), np.full(count, 1.0)])
        exact = [work.channels(Numba([work], scale).single(1e-12))]
        start = time.perf_counter()
        ours = Modelgen(model, [{}], 0.2, 101, "rk4", "off")
        built = time.perf_counter() - start
        row = {"lower_s": lowered, "build_s": built}
        for peer in (ours, Numba([work], scale), CasADi([work], scale, "cvodes")):
            row[peer.name] = measure(peer, [work], exact, False, 1).seconds_at(1e-5, "median")
        told[str(count)] = row
    return told


def figure(curves: list[Curve], which: str, title: str, path: Path) -> None:
    """Seconds per trajectory over the error, one line per solver."""
    from matplotlib.figure import Figure

    from modelgen.plots.style import BLUE, GRAY, SERIES, sheet, style

    with style():
        drawn: Figure = sheet(
            title, "error against cost", f"{machine()}; {date.today().isoformat()}. Lower left is better.", height=9.0
        )
        axes = drawn.subplots()
        others = [color for color in SERIES if color != BLUE]
        for k, curve in enumerate(curves):
            own = curve.name.startswith("modelgen")
            color = BLUE if own else others[k % len(others)]
            marker = "osD^vP*X<>"[k % 10]
            axes.loglog(
                getattr(curve, which), curve.seconds, marker=marker, color=color, label=curve.name, linewidth=1.6 if own else 0.8,
                linestyle="-" if own else ("--", ":", "-.")[k % 3],
            )  # fmt: skip
        axes.axvline(1e-5, color=GRAY, linewidth=0.5)
        axes.invert_xaxis()
        axes.set_xlabel(f"error ({which} of the trajectories) per half the peak-to-peak [-]")
        axes.set_ylabel("seconds per trajectory")
        drawn.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=6)
        drawn.savefig(path)


def machine() -> str:
    """Processor and number of cores."""
    name = platform.processor()
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        name = next(line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return f"{name}, {len(os.sched_getaffinity(0))} cores"


def table(summary: dict[str, Any]) -> str:
    """The ratios as Markdown."""
    lines = [
        "| question | error | ours [s] | by | fastest peer | [s] | ratio | cvodes | SciPy |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name in ("single", "sweep_median", "sweep_worst", "smooth_single", "gear_pair_single"):
        for level, row in summary.get(name, {}).items():

            def shown(key: str, row: dict[str, Any] = row) -> str:
                value = row.get(key)
                return "-" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)

            cells = [
                shown(key)
                for key in ("ours_s", "ours", "fastest_peer", "fastest_peer_s", "ratio", "ratio_cvodes_vm", "ratio_scipy")
            ]
            lines.append(f"| {name} | {level} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="short runs, to see that everything works")
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--only", nargs="*", metavar="PART", help="single, sweep, smooth_single, ... scaling")
    options = parser.parse_args()
    quick, out = options.quick, options.out
    wanted = options.only or ["single", "sweep", "smooth_single", "gear_pair_single", "diagram", "scaling"]
    logging.disable(logging.DEBUG)  # a peer turns on everybody's
    out.mkdir(parents=True, exist_ok=True)
    end, count = (0.05, 8) if quick else (2.0, 64)
    zetas = [float(z) for z in np.linspace(0.01, 0.08, count)]
    summary: dict[str, Any] = {
        "machine": machine(), "date": date.today().isoformat(), "end_s": end, "sweep": count,
        "versions": {name: version(name) for name in PACKAGES},
    }  # fmt: skip
    started = time.perf_counter()
    questions = [
        ("single", "fracturing-truck, one trajectory", load("fracturing-truck"), [0.035], False, ("median",), end, True),
        (
            "sweep",
            "fracturing-truck, sweep of the damping ratio",
            load("fracturing-truck"),
            zetas,
            True,
            ("median", "worst"),
            end,
            True,
        ),
        ("smooth_single", "smooth truck, one trajectory", smooth_truck(), [0.035], False, ("median",), end / 2, False),
        ("gear_pair_single", "gear pair, one trajectory", gear_pair(), [0.0], False, ("median",), 2 * end, False),
    ]
    for key, title, line, values, sweep, kinds, horizon, slow in questions:
        if key not in wanted:
            continue
        print(f"{title}, {horizon:g} s", flush=True)
        curves = question(line, horizon, values, sweep, quick, slow)
        for which in kinds:
            name = f"{key}_{which}" if sweep else key
            summary[name] = summary_of(curves, which)
            figure(curves, which, title, out / f"{name}.png")
        summary.setdefault("curves", {})[key] = [vars(curve) for curve in curves]
    if "scaling" in wanted:
        print("scaling", flush=True)
        summary["scaling"] = scaling(quick)
    summary["minutes"] = (time.perf_counter() - started) / 60
    text = json.dumps(summary, indent=2, default=float)
    (out / "summary.json").write_text(text + "\n", encoding="utf-8")
    (out / "table.md").write_text(table(summary), encoding="utf-8")
    print(table(summary))
    print(f"{summary['minutes']:.1f} minutes; {out}/summary.json")


if __name__ == "__main__":
    main()
