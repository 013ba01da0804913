"""numba: a Dormand-Prince 5(4) loop compiled whole, with its own dense output; the sweep in parallel threads."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numba as nb
import numpy as np

from .workload import Series, Workload

A = np.array([
    [0, 0, 0, 0, 0, 0], [1 / 5, 0, 0, 0, 0, 0], [3 / 40, 9 / 40, 0, 0, 0, 0], [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
])  # fmt: skip
B = np.array([35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0])
C = np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1])
E = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
D = np.array([
    -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072, 701980252875 / 199316789632,
    -1453857185 / 822651844, 69997945 / 29380423,
])  # fmt: skip


@nb.njit(fastmath=True, error_model="numpy")
def harmonics(base, t, table, waves, rows):
    """Rows of one series at t: the orders by the recurrence of the angle sums, then a product of small matrices."""
    orders = table.shape[1] // 2
    c1, s1 = math.cos(base * t), math.sin(base * t)
    c, s = c1, s1
    for h in range(orders):
        waves[h], waves[orders + h] = c, s
        c, s = c * c1 - s * s1, s * c1 + c * s1
    for r in range(table.shape[0]):
        total = 0.0
        for h in range(2 * orders):
            total += table[r, h] * waves[h]
        rows[r] = total


@nb.njit(fastmath=True, error_model="numpy")
def rates(t, x, dx, numbers, shafts, meshes, torque, rows, waves):
    inertia, mean, bases, tables, hinges, mesh_bases, mesh_tables = numbers
    n = inertia.shape[0]
    torque[:] = mean
    for k in nb.literal_unroll((0, 1)):
        harmonics(bases[k], t, tables[k], waves, rows)
        for r in range(hinges[k].shape[0]):
            torque[hinges[k][r]] += rows[r]
    for s in range(shafts.shape[0]):
        a, b = int(shafts[s, 0]), int(shafts[s, 1])
        T = shafts[s, 2] * (x[a] - x[b]) + shafts[s, 3] * (x[n + a] - x[n + b])
        torque[a] -= T
        torque[b] += T
    for m in range(meshes.shape[0]):
        a, b, ra, rb = int(meshes[m, 0]), int(meshes[m, 1]), meshes[m, 2], meshes[m, 3]
        harmonics(mesh_bases[m], t, mesh_tables[m], waves, rows)
        k, gap = meshes[m, 6] + rows[0], meshes[m, 4]
        delta = ra * x[a] - rb * x[b] - meshes[m, 7] - rows[1]
        rate = ra * x[n + a] - rb * x[n + b] - rows[2]
        pressed = delta - gap if delta > gap else (delta + gap if delta < -gap else 0.0)
        F = k * pressed + meshes[m, 5] * math.sqrt(k) * rate
        torque[a] -= ra * F
        torque[b] += rb * F
    for i in range(n):
        dx[i] = x[n + i]
        dx[n + i] = torque[i] / inertia[i]


@nb.njit(fastmath=True, error_model="numpy", nogil=True)
def integrate(
    tolerance, scale, start, times, out,
    numbers, shafts, meshes,
):  # fmt: skip
    n = start.shape[0]
    y, x, y_new, k = start.copy(), start.copy(), start.copy(), np.zeros((7, n))
    torque, rows, waves = np.zeros(n // 2), np.zeros(max(3, n // 2)), np.zeros(256)
    t, end, h, sample = times[0], times[-1], 1e-5, 0
    while sample < times.shape[0] and times[sample] <= t:
        out[sample] = y
        sample += 1
    rates(t, y, k[0], numbers, shafts, meshes, torque, rows, waves)
    before = 1e-4
    while t < end:
        h = min(h, end - t)
        for s in range(1, 6):
            for i in range(n):
                gain = 0.0
                for j in range(s):
                    gain += A[s, j] * k[j, i]
                x[i] = y[i] + h * gain
            rates(t + C[s] * h, x, k[s], numbers, shafts, meshes, torque, rows, waves)
        for i in range(n):
            gain = 0.0
            for j in range(6):
                gain += B[j] * k[j, i]
            y_new[i] = y[i] + h * gain
        rates(t + h, y_new, k[6], numbers, shafts, meshes, torque, rows, waves)
        worst = 0.0
        for i in range(n):
            e = 0.0
            for j in range(7):
                e += E[j] * k[j, i]
            worst = max(worst, abs(h * e) / scale[i])
        error = worst / tolerance
        if error <= 1.0:
            while sample < times.shape[0] and times[sample] <= t + h:
                q = (times[sample] - t) / h
                for i in range(n):
                    whole = y_new[i] - y[i]
                    bend = h * k[0, i] - whole
                    d = 0.0
                    for j in range(7):
                        d += D[j] * k[j, i]
                    out[sample, i] = y[i] + q * (whole + (1 - q) * (bend + q * (whole - h * k[6, i] - bend + (1 - q) * h * d)))
                sample += 1
            t += h
            y[:] = y_new
            k[0, :] = k[6]
            factor = 0.9 * max(error, 1e-10) ** -0.17 * before**0.04
            h *= min(5.0, max(0.2, factor))
            before = max(error, 1e-4)
        else:
            h *= max(0.2, 0.9 * error**-0.2)


def numbers_of(work: Workload):
    """The numbers as arrays and tuples; orders run along the second axis so that a row is a vector."""
    nothing = (np.zeros(1, dtype=np.int64), Series(1.0, np.zeros((1, 1)), np.zeros((1, 1))))
    torque_series = (*work.torque_series, nothing, nothing)[:2]  # the loop below is unrolled for two bases
    assert len(work.torque_series) <= 2
    tables = tuple(np.hstack([series.cosine, series.sine]) for _, series in torque_series)
    mesh_tables = np.array([np.hstack([series.cosine, series.sine]) for series in work.mesh_series] or np.zeros((0, 3, 2)))
    return (
        work.inertia,
        work.torque_mean,
        np.array([series.base for _, series in torque_series]),
        tables,
        tuple(hinges.astype(np.int64) for hinges, _ in torque_series),
        np.array([series.base for series in work.mesh_series]),
        mesh_tables,
    )


class Numba:
    name = "numba, Dormand-Prince loop"
    tolerances = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)

    def __init__(self, works: list[Workload], scale: np.ndarray) -> None:
        self.scale, self.numbers = scale, numbers_of(works[0])
        self.works = [replace(each, times=each.times[:2]) for each in works]
        self.single(1e-3)  # compiled before the clock runs
        self.sweep(1e-3)
        self.works = works

    def single(self, tolerance: float) -> np.ndarray:
        work = self.works[0]
        out = np.zeros((work.times.size, work.start.size))
        integrate(tolerance, self.scale, work.start, work.times, out, self.numbers, work.shafts, work.meshes)
        return out

    def sweep(self, tolerance: float) -> np.ndarray:
        work = self.works[0]
        starts = np.array([each.start for each in self.works])
        outs = np.zeros((len(self.works), work.times.size, work.start.size))

        def run(k: int) -> None:
            each = self.works[k]
            integrate(tolerance, self.scale, starts[k], work.times, outs[k], self.numbers, each.shafts, each.meshes)

        with ThreadPoolExecutor() as pool:
            list(pool.map(run, range(len(self.works))))
        return outs
