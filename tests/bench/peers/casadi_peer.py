"""CasADi: its integrators cvodes and erk on expressions written by hand, on the virtual machine or on generated C.

The manual's advice is followed: SX expressions, common subexpressions found, parameters as inputs; the sweep in processes.
"""

from __future__ import annotations

import os
import subprocess
import tempfile

import casadi as ca
import numpy as np

from .pool import warm_pool
from .workload import Workload


def parameters(work: Workload) -> np.ndarray:
    """What differs within a sweep: damping of the shafts and of the meshes."""
    return np.concatenate([work.shafts[:, 3], work.meshes[:, 5]])


def rates(work: Workload) -> ca.Function:
    """(t, x, c) -> dx/dt with the orders of each base by the recurrence of the angle sums."""
    n = len(work.inertia)
    t, x, c = ca.SX.sym("t"), ca.SX.sym("x", 2 * n), ca.SX.sym("c", len(work.shafts) + len(work.meshes))
    torque = [ca.SX(float(mean)) for mean in work.torque_mean]
    for hinges, series in work.torque_series:
        for hinge, value in zip(hinges, _rows(series, t), strict=True):
            torque[hinge] += value
    for k, (a, b, stiffness, _) in enumerate(work.shafts):
        a, b = int(a), int(b)
        T = stiffness * (x[a] - x[b]) + c[k] * (x[n + a] - x[n + b])
        torque[a] -= T
        torque[b] += T
    for m, ((a, b, ra, rb, gap, _, mean, error), series) in enumerate(zip(work.meshes, work.mesh_series, strict=True)):
        a, b = int(a), int(b)
        varying, e, rate = _rows(series, t)
        k, delta = mean + varying, ra * x[a] - rb * x[b] - error - e
        pressed = ca.if_else(delta > gap, delta - gap, ca.if_else(delta < -gap, delta + gap, 0))
        force = k * pressed + c[len(work.shafts) + m] * ca.sqrt(k) * (ra * x[n + a] - rb * x[n + b] - rate)
        torque[a] -= ra * force
        torque[b] += rb * force
    ode = ca.cse(ca.vertcat(x[n:], *(value / inertia for value, inertia in zip(torque, work.inertia, strict=True))))
    return ca.Function("rates", [t, x, c], [ode])


def _rows(series, t: ca.SX) -> list[ca.SX]:
    c1, s1 = ca.cos(series.base * t), ca.sin(series.base * t)
    c, s, rows = c1, s1, [ca.SX(0)] * len(series.cosine)
    for h in range(series.cosine.shape[1]):
        for r in range(len(rows)):
            if series.cosine[r, h] or series.sine[r, h]:
                rows[r] += float(series.cosine[r, h]) * c + float(series.sine[r, h]) * s
        c, s = c * c1 - s * s1, s * c1 + c * s1
    return rows


def integrator(work: Workload, scale: np.ndarray, plugin: str, tolerance: float) -> ca.Function:
    """The integrator over the output times; states are scaled so that the one absolute tolerance fits all of them."""
    f = rates(work)
    t, y, c = ca.SX.sym("t"), ca.SX.sym("y", work.start.size), ca.SX.sym("c", parameters(work).size)
    dae = {"t": t, "x": y, "p": c, "ode": f(t, ca.DM(scale) * y, c) / ca.DM(scale)}
    options = {"reltol": 1e-12, "abstol": tolerance}
    options["max_num_steps"] = 10_000_000
    return ca.integrator("run", plugin, dae, float(work.times[0]), work.times[1:].tolist(), options)


_BUILT: dict[tuple[str, str, float], ca.Function] = {}


def _run(arguments) -> np.ndarray:
    work, scale, plugin, tolerance, path = arguments
    key = (path, plugin, tolerance)
    if key not in _BUILT:  # the parameters of a sweep are inputs: one integrator serves all of its runs
        _BUILT[key] = ca.external("run", path) if path else integrator(work, scale, plugin, tolerance)
    return _solve(_BUILT[key], work, scale)


def _solve(f: ca.Function, work: Workload, scale: np.ndarray) -> np.ndarray:
    try:
        found = np.asarray(f(x0=work.start / scale, p=parameters(work))["xf"]).T * scale
    except RuntimeError:
        return np.full((work.times.size, work.start.size), np.nan)
    return np.vstack([work.start, found])


class CasADi:
    tolerances = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)

    def __init__(self, works: list[Workload], scale: np.ndarray, plugin: str, generated: bool = False) -> None:
        self.works, self.scale, self.plugin, self.generated = works, scale, plugin, generated
        self.name = f"CasADi {plugin}, {'generated C' if generated else 'virtual machine'}"
        self.built: dict[float, tuple[ca.Function, str]] = {}
        self.pool = warm_pool() if len(works) > 1 else None

    def prepare(self, tolerance: float) -> tuple[ca.Function, str]:
        """The integrator, built before the clock runs, and the library it stands in."""
        if tolerance not in self.built:
            f, path = integrator(self.works[0], self.scale, self.plugin, tolerance), ""
            if self.generated:
                folder = tempfile.mkdtemp()
                here = os.getcwd()
                os.chdir(folder)
                try:
                    f.generate("run.c", {"with_header": False})
                    subprocess.run(
                        ["gcc", "-O3", "-march=native", "-fPIC", "-shared", "run.c", "-o", "run.so", "-lm"], check=True
                    )
                finally:
                    os.chdir(here)
                path = f"{folder}/run.so"
                f = ca.external("run", path)
            self.built[tolerance] = f, path
        return self.built[tolerance]

    def single(self, tolerance: float) -> np.ndarray:
        return _solve(self.prepare(tolerance)[0], self.works[0], self.scale)

    def sweep(self, tolerance: float) -> np.ndarray:
        path = self.prepare(tolerance)[1]
        jobs = [(work, self.scale, self.plugin, tolerance, path) for work in self.works]
        return np.array(list(self.pool.map(_run, jobs, chunksize=4)))
