"""SciPy: solve_ivp with DOP853 and LSODA, the right-hand side in NumPy (called from Python) or compiled by numba."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp

from .pool import warm_pool
from .workload import Workload


class PythonRates:
    """The right-hand side as a careful user of NumPy writes it: matrices for the shafts and series, one sine per order."""

    def __init__(self, work: Workload) -> None:
        n = len(work.inertia)
        self.n, self.inertia, self.work = n, work.inertia, work
        self.stiffness, self.damping = np.zeros((n, n)), np.zeros((n, n))
        for a, b, k, c in work.shafts:
            a, b = int(a), int(b)
            for matrix, value in ((self.stiffness, k), (self.damping, c)):
                matrix[[a, b], [a, b]] += value
                matrix[[a, b], [b, a]] -= value
        self.series = []
        for hinges, series in work.torque_series:
            place = np.zeros((n, len(hinges)))
            place[hinges, range(len(hinges))] = 1.0
            orders = np.arange(1, series.cosine.shape[1] + 1) * series.base
            self.series.append((orders, place @ series.cosine, place @ series.sine))
        self.mesh_orders = [np.arange(1, s.cosine.shape[1] + 1) * s.base for s in work.mesh_series]
        self.arms = np.zeros((len(work.meshes), n))
        for row, (a, b, ra, rb, *_) in enumerate(work.meshes):
            self.arms[row, int(a)], self.arms[row, int(b)] = ra, -rb

    def __call__(self, t: float, x: np.ndarray) -> np.ndarray:
        n, work = self.n, self.work
        torque = work.torque_mean - self.stiffness @ x[:n] - self.damping @ x[n:]
        for orders, cosine, sine in self.series:
            torque += cosine @ np.cos(orders * t) + sine @ np.sin(orders * t)
        for arm, (_, _, _, _, gap, damping, mean, error), series, orders in zip(
            self.arms, work.meshes, work.mesh_series, self.mesh_orders, strict=True
        ):
            k, e, rate = series.cosine @ np.cos(orders * t) + series.sine @ np.sin(orders * t)
            delta = arm @ x[:n] - error - e
            pressed = delta - min(max(delta, -gap), gap)
            torque -= arm * ((mean + k) * pressed + damping * np.sqrt(mean + k) * (arm @ x[n:] - rate))
        return np.concatenate([x[n:], torque / self.inertia])


class CompiledRates:
    """The same by numba, called from SciPy's loop."""

    def __init__(self, work: Workload) -> None:
        self.work = work

    @cached_property
    def parts(self):
        from . import numba_peer

        n = len(self.work.inertia)
        memory = np.zeros(n), np.zeros(max(3, n)), np.zeros(256)
        return numba_peer.rates, numba_peer.numbers_of(self.work), memory

    def __call__(self, t: float, x: np.ndarray) -> np.ndarray:
        rates, numbers, memory = self.parts
        dx = np.empty_like(x)
        rates(t, x, dx, numbers, self.work.shafts, self.work.meshes, *memory)
        return dx


def _run(arguments) -> np.ndarray:
    rates, work, method, tolerance, scale = arguments
    found = solve_ivp(
        rates(work), (work.times[0], work.times[-1]), work.start, method, work.times, rtol=1e-13, atol=tolerance * scale
    )
    return found.y.T if found.success else np.full((work.times.size, work.start.size), np.nan)


def _compile(arguments) -> None:
    rates, work = arguments
    rates(work)(0.0, work.start)


class SciPy:
    """``compiled``: by numba. The sweep runs in one process per core."""

    tolerances: tuple[float, ...] = (1e-4, 1e-6, 1e-8)
    patience = 100.0  # s

    def __init__(self, works: list[Workload], scale: np.ndarray, method: str, compiled: bool) -> None:
        if not compiled:
            self.tolerances = (1e-5, 1e-8)  # errors on both sides of 1e-5, for the slowest of all
        self.works, self.scale, self.method = works, scale, method
        self.rates = CompiledRates if compiled else PythonRates
        self.name = f"SciPy {method}, {'numba' if compiled else 'Python-called'} right-hand side"
        self.pool = warm_pool()
        self.rates(works[0])(0.0, works[0].start)  # compiled before the clock runs
        list(self.pool.map(_compile, [(self.rates, works[0])] * 8, chunksize=1))

    def single(self, tolerance: float) -> np.ndarray:
        return _run((self.rates, self.works[0], self.method, tolerance, self.scale))

    def sweep(self, tolerance: float) -> np.ndarray:
        jobs = [(self.rates, work, self.method, tolerance, self.scale) for work in self.works]
        return np.array(list(self.pool.map(_run, jobs)))
