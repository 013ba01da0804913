"""diffrax: Dopri5 with a proportional-integral controller, in double precision; the sweep by ``vmap``, as its manual says."""

from __future__ import annotations

import jax
import numpy as np

from .workload import Workload

jax.config.update("jax_enable_x64", True)


def rates(work: Workload):
    """(t, x, damping) -> dx/dt by matrices; all orders of a series from one vector of angles."""
    import jax.numpy as jnp

    n = len(work.inertia)
    ends = work.shafts[:, :2].astype(int)
    incidence = np.zeros((len(ends), n))
    incidence[range(len(ends)), ends[:, 0]], incidence[range(len(ends)), ends[:, 1]] = 1.0, -1.0
    arms = np.zeros((len(work.meshes), n))
    for row, (a, b, ra, rb, *_) in enumerate(work.meshes):
        arms[row, int(a)], arms[row, int(b)] = ra, -rb
    series = []
    for hinges, each in work.torque_series:
        place = np.zeros((n, len(hinges)))
        place[hinges, range(len(hinges))] = 1.0
        series.append((np.arange(1, each.cosine.shape[1] + 1) * each.base, place @ each.cosine, place @ each.sine))
    meshes = [(np.arange(1, s.cosine.shape[1] + 1) * s.base, s.cosine, s.sine) for s in work.mesh_series]
    gap, damping, mean, error = (work.meshes[:, column] for column in (4, 5, 6, 7))

    def rate(t, x, c):
        angle, speed = x[:n], x[n:]
        torque = jnp.asarray(work.torque_mean)
        for orders, cosine, sine in series:
            torque = torque + cosine @ jnp.cos(orders * t) + sine @ jnp.sin(orders * t)
        torque = torque - incidence.T @ (work.shafts[:, 2] * (incidence @ angle) + c * (incidence @ speed))
        rows = jnp.array([cosine @ jnp.cos(orders * t) + sine @ jnp.sin(orders * t) for orders, cosine, sine in meshes])
        k, delta = mean + rows[:, 0], arms @ angle - error - rows[:, 1]
        force = k * (delta - jnp.clip(delta, -gap, gap)) + damping * jnp.sqrt(k) * (arms @ speed - rows[:, 2])
        return jnp.concatenate([speed, (torque - arms.T @ force) / work.inertia])

    return rate


class Diffrax:
    name = "diffrax, Dopri5"
    tolerances = (1e-4, 1e-5, 1e-6)

    def __init__(self, works: list[Workload], scale: np.ndarray) -> None:
        import diffrax as dfx
        import jax.numpy as jnp

        self.works, work = works, works[0]
        rate = rates(work)
        term = dfx.ODETerm(lambda t, y, c: rate(t, y * scale, c) / scale)
        save = dfx.SaveAt(ts=jnp.asarray(work.times))

        def solve(start, c, tolerance):
            controller = dfx.PIDController(rtol=1e-13, atol=tolerance, pcoeff=0.2, icoeff=0.4)
            found = dfx.diffeqsolve(
                term, dfx.Dopri5(), work.times[0], work.times[-1], 1e-5, start / scale, c, saveat=save,
                stepsize_controller=controller, max_steps=10_000_000, adjoint=dfx.ForwardMode(),
            )  # fmt: skip
            return found.ys * scale

        self.one = jax.jit(solve)
        self.many = jax.jit(jax.vmap(solve, in_axes=(0, 0, None)))
        self.single(1e-3)
        self.sweep(1e-3)

    def single(self, tolerance: float) -> np.ndarray:
        work = self.works[0]
        return np.asarray(self.one(work.start, work.shafts[:, 3], tolerance))

    def sweep(self, tolerance: float) -> np.ndarray:
        starts, damping = np.array([w.start for w in self.works]), np.array([w.shafts[:, 3] for w in self.works])
        return np.asarray(self.many(starts, damping, tolerance))
