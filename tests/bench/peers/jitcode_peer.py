"""JiTCODE: symbolic right-hand side compiled to C, integrated by dopri5; the sweep in one process per core."""

from __future__ import annotations

import os
import tempfile

import numpy as np

from .pool import warm_pool
from .workload import Workload


def system(work: Workload):
    """The equations in SymEngine, a control parameter for the damping of each shaft."""
    import symengine as se
    from jitcode import t, y

    n = len(work.inertia)
    parameters = se.symbols(f"c0:{len(work.shafts)}")
    torque = [float(mean) for mean in work.torque_mean]

    helpers = []

    def named(expression, label: str):
        symbol = se.Symbol(label)
        helpers.append((symbol, expression))
        return symbol

    def rows(series, label: str):
        c1, s1 = named(se.cos(series.base * t), f"{label}c1"), named(se.sin(series.base * t), f"{label}s1")
        c, s, found = c1, s1, [0] * len(series.cosine)
        for h in range(series.cosine.shape[1]):
            for r in range(len(found)):
                found[r] += float(series.cosine[r, h]) * c + float(series.sine[r, h]) * s
            if h + 1 < series.cosine.shape[1]:
                c, s = named(c * c1 - s * s1, f"{label}c{h + 2}"), named(s * c1 + c * s1, f"{label}s{h + 2}")
        return found

    for k, (hinges, series) in enumerate(work.torque_series):
        for hinge, value in zip(hinges, rows(series, f"torque{k}_"), strict=True):
            torque[hinge] += value
    for k, (a, b, stiffness, _) in enumerate(work.shafts):
        a, b = int(a), int(b)
        T = named(float(stiffness) * (y(a) - y(b)) + parameters[k] * (y(n + a) - y(n + b)), f"shaft{k}")
        torque[a] -= T
        torque[b] += T
    for m, ((a, b, ra, rb, gap, damping, mean, error), series) in enumerate(zip(work.meshes, work.mesh_series, strict=True)):
        a, b = int(a), int(b)
        varying, e, rate = rows(series, f"mesh{m}_")
        k = named(mean + varying, f"k{m}")
        delta = named(ra * y(a) - rb * y(b) - error - e, f"delta{m}")
        pressed = delta - (abs(delta + gap) - abs(delta - gap)) / 2  # the dead band without a branch
        force = named(k * pressed + damping * se.sqrt(k) * (ra * y(n + a) - rb * y(n + b) - rate), f"force{m}")
        torque[a] -= ra * force
        torque[b] += rb * force
    ode = [y(n + i) for i in range(n)] + [torque[i] / work.inertia[i] for i in range(n)]
    return ode, helpers, parameters


def _run(arguments) -> np.ndarray:
    import symengine as se
    from jitcode import jitcode

    module, work, scale, tolerance = arguments
    parameters = list(se.symbols(f"c0:{len(work.shafts)}"))
    ode = jitcode(module_location=module, n=work.start.size, control_pars=parameters, verbose=False)
    return _solve(ode, work, scale, tolerance)


def _solve(ode, work: Workload, scale: np.ndarray, tolerance: float) -> np.ndarray:
    ode.set_parameters(*work.shafts[:, 3])
    ode.set_integrator("dopri5", rtol=1e-13, atol=tolerance * float(scale[0]), nsteps=10_000_000)
    ode.set_initial_value(work.start, work.times[0])
    found = [work.start]
    for time in work.times[1:]:
        found.append(ode.integrate(time))
    return np.array(found)


class JiTCODE:
    name = "JiTCODE, dopri5"
    tolerances = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)

    def __init__(self, works: list[Workload], scale: np.ndarray) -> None:
        from jitcode import jitcode

        self.works, self.scale = works, scale
        ode, helpers, parameters = system(works[0])
        self.ode = jitcode(ode, helpers=helpers, control_pars=list(parameters), verbose=False)
        folder, here = tempfile.mkdtemp(), os.getcwd()
        os.chdir(folder)  # setuptools would read the project file of the folder it is called in
        try:
            self.ode.compile_C(verbose=False, extra_compile_args=["-O3", "-march=native", "-ffast-math"])
            # the name must be another one for each model: an interpreter imports a name once
            self.module = self.ode.save_compiled(f"{folder}/model_{os.path.basename(folder)}.so", overwrite=True)
        finally:
            os.chdir(here)
        self.pool = warm_pool()

    def single(self, tolerance: float) -> np.ndarray:
        return _solve(self.ode, self.works[0], self.scale, tolerance)

    def sweep(self, tolerance: float) -> np.ndarray:
        jobs = [(self.module, work, self.scale, tolerance) for work in self.works]
        return np.array(list(self.pool.map(_run, jobs, chunksize=4)))
