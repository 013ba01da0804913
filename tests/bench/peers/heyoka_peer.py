"""heyoka: Taylor integrators, scalar and batch ensembles, with terminal events at the flanks and a small cooldown.

A Taylor series does not see a kink, so contact is a parameter that the events switch; with the default cooldown events are lost.
"""

from __future__ import annotations

import heyoka as hy
import numpy as np

from .workload import Workload

COOLDOWN = 1e-9  # s
WRITTEN_OUT = 50  # inertias: up to here without compact mode, which is slower to build and faster to run


def _series(series, row: int):
    total = hy.expression(0.0)
    terms = []
    for h in range(series.cosine.shape[1]):
        angle = float((h + 1) * series.base) * hy.time
        if series.cosine[row, h]:
            terms.append(float(series.cosine[row, h]) * hy.cos(angle))
        if series.sine[row, h]:
            terms.append(float(series.sine[row, h]) * hy.sin(angle))
    return hy.sum(terms) if terms else total


def system(work: Workload):
    """Equations of motion and the deflections; parameters as in ``start_parameters``."""
    n, shafts = len(work.inertia), len(work.shafts)
    names = [f"x{i}" for i in range(n)] + [f"v{i}" for i in range(n)]
    variables = hy.make_vars(*names)
    x, v = variables[:n], variables[n:]
    torque = [[hy.expression(float(mean))] for mean in work.torque_mean]
    for hinges, series in work.torque_series:
        for row, hinge in enumerate(hinges):
            torque[hinge].append(_series(series, row))
    for k, (a, b, stiffness, _) in enumerate(work.shafts):
        a, b = int(a), int(b)
        T = float(stiffness) * (x[a] - x[b]) + hy.par[k] * (v[a] - v[b])
        torque[a].append(-T)
        torque[b].append(T)
    deflections = []
    for m, ((a, b, ra, rb, _, _, mean, error), series) in enumerate(zip(work.meshes, work.mesh_series, strict=True)):
        a, b, ra, rb = int(a), int(b), float(ra), float(rb)
        k = float(mean) + _series(series, 0)
        delta = ra * x[a] - rb * x[b] - (float(error) + _series(series, 1))
        rate = ra * v[a] - rb * v[b] - _series(series, 2)
        pressed = hy.par[shafts + 2 * m] * delta - hy.par[shafts + 2 * m + 1]
        force = k * pressed + hy.par[shafts + 2 * len(work.meshes) + m] * hy.sqrt(k) * rate
        torque[a].append(-ra * force)
        torque[b].append(rb * force)
        deflections.append(delta)
    ode = [(x[i], v[i]) for i in range(n)] + [(v[i], hy.sum(torque[i]) * float(1 / work.inertia[i])) for i in range(n)]
    return ode, deflections


def contact(delta: float, gap: float) -> tuple[float, float]:
    """Parameters of a mesh: pressed = contact * delta - offset."""
    return (1.0, gap) if delta > gap else ((1.0, -gap) if delta < -gap else (0.0, 0.0))


def start_parameters(work: Workload) -> np.ndarray:
    """Damping of the shafts, contact and offset of the meshes at the start, damping of the meshes."""
    values = list(work.shafts[:, 3])
    for (a, b, ra, rb, gap, _, _, error), series in zip(work.meshes, work.mesh_series, strict=True):
        delta = ra * work.start[int(a)] - rb * work.start[int(b)] - error - series.cosine[1].sum()
        values += contact(delta, gap)
    return np.array([*values, *work.meshes[:, 5]])


def events(work: Workload, deflections, batch: bool):
    """Two surfaces per mesh; passing one sets the contact of the mesh."""
    shafts, found = len(work.shafts), []
    for m, delta in enumerate(deflections):
        gap, place = float(work.meshes[m][4]), shafts + 2 * m
        for side in (1.0, -1.0):

            def passed(ta, sign, *lane, side=side, gap=gap, place=place):
                touching = sign * side > 0
                where = (place, *lane)
                ta.pars[where] = 1.0 if touching else 0.0
                ta.pars[(place + 1, *lane)] = side * gap if touching else 0.0
                return True

            kind = hy.t_event_batch if batch else hy.t_event
            found.append(kind(delta - side * gap, callback=passed, cooldown=COOLDOWN))
    return found


class Heyoka:
    tolerances = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-9)

    def __init__(self, works: list[Workload], scale: np.ndarray, with_events: bool = True) -> None:
        self.works, self.scale, self.with_events = works, scale, with_events
        self.name = "heyoka, events" if with_events else "heyoka, without events"
        self.ode, self.deflections = system(works[0])
        self.built: dict[float, tuple] = {}

    def prepare(self, tolerance: float) -> tuple:
        if tolerance not in self.built:
            work, lanes = self.works[0], hy.recommended_simd_size()
            pars = start_parameters(work)
            options = {"tol": tolerance, "compact_mode": len(work.inertia) > WRITTEN_OUT, "fast_math": True}
            scalar_events = events(work, self.deflections, False) if self.with_events else []
            scalar = hy.taylor_adaptive(self.ode, work.start, pars=pars, t_events=scalar_events, **options)
            lane_events = events(work, self.deflections, True) if self.with_events else []
            tiled = np.repeat(work.start[:, None], lanes, axis=1)
            batch = hy.taylor_adaptive_batch(
                self.ode, tiled, pars=np.repeat(pars[:, None], lanes, axis=1), t_events=lane_events, **options
            )
            self.built[tolerance] = scalar, batch
        return self.built[tolerance]

    def single(self, tolerance: float) -> np.ndarray:
        ta, work = self.prepare(tolerance)[0], self.works[0]
        ta.time = 0.0
        ta.reset_cooldowns() if self.with_events else None
        ta.state[:], ta.pars[:] = work.start, start_parameters(work)
        return np.array(ta.propagate_grid(work.times)[5])

    def sweep(self, tolerance: float) -> np.ndarray:
        ta = self.prepare(tolerance)[1]
        lanes, works = ta.batch_size, self.works
        starts, pars = np.array([w.start for w in works]), np.array([start_parameters(w) for w in works])
        groups = -(-len(works) // lanes)

        def prepared(copy, group):
            rows = np.minimum(np.arange(group * lanes, (group + 1) * lanes), len(works) - 1)
            copy.set_time(0.0)
            copy.state[:], copy.pars[:] = starts[rows].T, pars[rows].T
            return copy

        found = hy.ensemble_propagate_grid_batch(ta, works[0].times, groups, prepared)
        out = np.concatenate([np.moveaxis(np.asarray(each[-1]), 2, 0) for each in found])
        return out[: len(works)]
