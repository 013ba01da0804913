"""CasADi: its integrators cvodes and erk on expressions written by hand, on the virtual machine or on generated C.

The manual's advice is followed: SX expressions, common subexpressions found, parameters as inputs; the sweep in processes.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import tempfile
import time

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


def integrator(work: Workload, scale: np.ndarray, plugin: str, tolerance: float, compiled: bool = False) -> ca.Function:
    """The integrator over the output times; states are scaled so that the one absolute tolerance fits all of them."""
    f = rates(work)
    t, y, c = ca.SX.sym("t"), ca.SX.sym("y", work.start.size), ca.SX.sym("c", parameters(work).size)
    dae = {"t": t, "x": y, "p": c, "ode": f(t, ca.DM(scale) * y, c) / ca.DM(scale)}
    options = {"reltol": 1e-12, "abstol": tolerance}
    options["max_num_steps"] = 10_000_000
    if compiled:  # cvodes itself has no C of its own: its right-hand side and Jacobian are compiled
        how = {"compiler": "gcc", "flags": ["-O3", "-march=native"], "cleanup": False}  # the folder goes as a whole
        options |= {"jit": True, "compiler": "shell", "jit_options": how, "jit_cleanup": False}
    return ca.integrator("run", plugin, dae, float(work.times[0]), work.times[1:].tolist(), options)


_BUILT: dict[tuple[int, float], ca.Function] = {}
_NUMBERS = itertools.count()  # of peers in this process, each with integrators of its own


def _built(arguments) -> ca.Function:
    work, scale, plugin, tolerance, path, compiled, number = arguments
    key = (number, tolerance)
    if key not in _BUILT:  # the parameters of a sweep are inputs: one integrator serves all of its runs
        with tempfile.TemporaryDirectory() as folder:  # CasADi writes its C where it stands
            here = os.getcwd()
            os.chdir(folder)
            try:
                _BUILT[key] = ca.external("run", path) if path else integrator(work, scale, plugin, tolerance, compiled)
            finally:
                os.chdir(here)
    return _BUILT[key]


def _warm(arguments) -> None:
    _built(arguments)
    time.sleep(0.1)  # so that every process gets one


def _run(arguments) -> np.ndarray:
    work, scale, *_ = arguments
    return _solve(_built(arguments), work, scale)


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
        self.compiled = generated and plugin == "cvodes"
        how = "compiled functions" if self.compiled else "generated C" if generated else "virtual machine"
        self.name = f"CasADi {plugin}, {how}"
        self.paths: dict[float, str] = {}
        self.number = next(_NUMBERS)
        self.pool = warm_pool() if len(works) > 1 else None

    def prepare(self, tolerance: float) -> None:
        """Builds the integrator, in this process and in those of the pool, before the clock runs."""
        if tolerance in self.paths:
            return
        self.paths[tolerance] = self._library(tolerance) if self.generated and not self.compiled else ""
        _built(self._job(self.works[0], tolerance))
        if self.pool:
            list(self.pool.map(_warm, [self._job(self.works[0], tolerance)] * 8, chunksize=1))

    def _library(self, tolerance: float) -> str:
        """The whole integrator as generated C."""
        folder, here = tempfile.mkdtemp(), os.getcwd()
        os.chdir(folder)
        try:
            f = integrator(self.works[0], self.scale, self.plugin, tolerance)
            f.generate("run.c", {"with_header": False})
            subprocess.run(["gcc", "-O3", "-march=native", "-fPIC", "-shared", "run.c", "-o", "run.so", "-lm"], check=True)
        finally:
            os.chdir(here)
        return f"{folder}/run.so"

    def _job(self, work: Workload, tolerance: float) -> tuple:
        return work, self.scale, self.plugin, tolerance, self.paths[tolerance], self.compiled, self.number

    def single(self, tolerance: float) -> np.ndarray:
        self.prepare(tolerance)
        return _run(self._job(self.works[0], tolerance))

    def sweep(self, tolerance: float) -> np.ndarray:
        self.prepare(tolerance)
        return np.array(list(self.pool.map(_run, [self._job(work, tolerance) for work in self.works], chunksize=4)))
