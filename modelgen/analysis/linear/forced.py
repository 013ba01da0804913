"""Question: how does the driveline answer its harmonic torques, order by order and over the cycle, at every speed?

The linear model about the operating point (``model``) under everything that varies with time (``excitation``), order by
order in complex amplitudes, so phases of sources (firing order, misfire, mesh phases) count. Loss factors are complex
stiffness. A mesh stiffness that varies with time counts only by the force that it changes at rest; ``parametric`` says by how
much it varies.
Sources: W. Ker Wilson, Practical Solution of Torsional Vibration Problems, vol. 2 (1963); M. I. Friswell et al., Dynamics of
Rotating Machines (2010), ch. 9.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.excitation import Excitation, excitation, parametric
from modelgen.analysis.linear.frequency_response import frequency_response
from modelgen.analysis.linear.linear_remarks import linear_remarks
from modelgen.analysis.linear.orders import order_name
from modelgen.analysis.linear.resonances import resonance_speeds
from modelgen.analysis.linear.shear_stress import Diameter, shear_stress_factor
from modelgen.analysis.linear.speed_ratios import gears_between_speeds, referred_ratios
from modelgen.analysis.linear.speeds import Parameters, point_at, read_speeds
from modelgen.analysis.linear.synthesis import common_cycle, extremes, synthesize
from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.lowering.mean_turn import averaged_words, turned_elements
from modelgen.solvers.bound_model import compiled_of
from modelgen.solvers.linear_model import LinearModel, linearize, mapped, seen, stated_frequencies

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
CHANNELS = (".angle_deviation", ".elastic_angle", ".twist", ".torque", ".force", ".deflection")
LOST = ".dissipated_power"
CURVE = 10  # speeds from which on a response over speed is a curve, of which peaks are read


@dataclass(frozen=True, eq=False)
class ForcedResult:
    """Steady vibration by speed, channel and order.

    A channel is mean + Re sum_h amplitude_h e^(i order_h phi), phi the angle of the reference shaft, zero at t = 0; amplitudes
    are 0-to-peak and physical (``referred_ratio`` of an inertia refers its angles). ``speeds`` [rad/s]; ``orders`` per turn of
    the reference shaft, exact, with the ``bases`` that each comes from, as their multiples ``harmonics``; ``channels`` with
    ``units``; ``mean`` (speeds, channels); ``amplitudes`` (speeds, channels, orders). ``dampers`` and ``power`` (speeds, dampers,
    orders) [W]: mean power that each turns into heat by vibration. ``gears``: channels that carry the load of a gear.
    ``parametric``: elements whose stiffness varies with time, and by what share; what that adds to the response is not in here.
    ``added``: which of the speeds were put between those asked for, at resonances.
    ``averaged``: elements whose laws depend on the angle of a shaft. ``remarks``: what is to be known of the matrices.
    """

    model: str
    speeds: Array
    orders: tuple[Fraction, ...]
    bases: tuple[tuple[str, ...], ...]
    channels: tuple[str, ...]
    units: tuple[str, ...]
    mean: Array
    amplitudes: Complex
    dampers: tuple[str, ...]
    power: Array
    gears: tuple[str, ...]
    referred_ratio: Mapping[str, float]
    parametric: Mapping[str, float]
    complex_stiffness: bool
    harmonics: tuple[tuple[int, ...], ...] = ()
    added: tuple[float, ...] = ()
    averaged: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    def sources(self, order: int) -> tuple[tuple[str, int], ...]:
        """Base frequencies of an order (a place in ``orders``), with their multiples."""
        return tuple(zip(self.bases[order], self.harmonics[order], strict=True))

    def order_name(self, order: int) -> str:
        """An order (a place in ``orders``) in words, such as ``order 3 (engine_half_order x 6)``."""
        return order_name(self.orders[order], self.sources(order))

    def _row(self, channel: str) -> int:
        if channel not in self.channels:
            raise CaseError(f"forced response of {self.model!r}", f"no channel {channel!r}", nearest(channel, self.channels))
        return self.channels.index(channel)

    def __getitem__(self, channel: str) -> Complex:
        """Complex amplitudes (speeds, orders) of a channel. Raises CaseError with the nearest name."""
        return self.amplitudes[:, self._row(channel)]

    def unit(self, channel: str) -> str:
        """Unit of a channel."""
        return self.units[self._row(channel)]

    def mean_of(self, channel: str) -> Array:
        """Mean (speeds,) of a channel."""
        return self.mean[:, self._row(channel)]

    @property
    def cycle(self) -> Fraction:
        """Turns of the reference shaft after which everything repeats."""
        return common_cycle(self.orders)

    def over_cycle(self, channel: str, bases: Sequence[str] | None = None, points: int = 64) -> tuple[Array, Array]:
        """Turns of the reference shaft (samples,) and the channel (speeds, samples) over the common cycle, mean included.

        ``bases``: only the orders of these base frequencies. Raises CaseError where the cycle is too long.
        """
        chosen = [k for k, names in enumerate(self.bases) if bases is None or set(names) & set(bases)]
        turns, values = synthesize(tuple(self.orders[k] for k in chosen), self[channel][:, chosen], points)
        return turns, self.mean_of(channel)[:, None] + values

    def swing(self, channel: str) -> Swings:
        """Least and largest value over the cycle."""
        low, high, exact = extremes(self.orders, self.bases, self[channel])
        mean = self.mean_of(channel)
        return Swings(mean, mean + low, mean + high, exact)

    def __str__(self) -> str:
        turns, asked = self.speeds * 30 / np.pi, len(self.speeds) - len(self.added)
        return (
            f"forced response of {self.model!r}: {asked} speeds from {turns[0]:.6g} to {turns[-1]:.6g} rpm, "
            f"{len(self.orders)} orders, {len(self.channels)} channels; all repeats after {self.cycle} turns"
            + (f"; {len(self.added)} speeds added at resonances" if self.added else "")
            + "".join(f"; {each}" for each in (averaged_words(self.averaged), *self.remarks) if each)
        )

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class Swings:
    """Mean, least and largest value (speeds,) of a channel over the cycle; ``exact``, or bounds where it is too long."""

    mean: Array
    least: Array
    largest: Array
    exact: bool

    @property
    def peak(self) -> Array:
        """Largest departure from the mean."""
        return np.maximum(self.largest - self.mean, self.mean - self.least)

    @property
    def half_pp(self) -> Array:
        """Half peak to peak."""
        return np.asarray((self.largest - self.least) / 2)


def forced(
    model: Any,
    speeds: Any = None,
    parameters: Parameters = None,
    *,
    channels: Sequence[str] | None = None,
    diameters: Mapping[str, Diameter] | None = None,
    complex_stiffness: bool = True,
    highest_order: float | None = None,
    refine: bool | None = None,
) -> ForcedResult:
    """Forced response at ``speeds`` (numbers in rad/s or texts with units; by default the operating speed).

    ``parameters``: values by name that differ from the model's own, or a function of the speed [rad/s] that returns them; a
    misfire is ``{"firing_3.scale": 0}``. ``channels``: by default angles, twists, torques, forces and mesh deflections.
    ``diameters``: the outer diameter, or outer and inner one, of shafts by name [m]; it adds their ``.shear_stress`` [Pa].
    ``complex_stiffness=False`` takes loss factors as viscous. ``refine``: between the speeds given, speeds are added at every
    resonance of a vibrating mode with an order that stands out, so that peaks are read to 0.5 %; by default where ten speeds or
    more are given. Raises CaseError for names and speeds that are not lawful and where an order meets a mode without damping,
    BalanceError where mean torques do not balance.

    >>> from modelgen import Driveline, HarmonicTorque, Inertia, Shaft, assemble, lower
    >>> line = Driveline("two_disks", speed="1200 rpm", reference="engine", bases={"turn": 1}, elements=[
    ...     Inertia("engine", inertia=3.0), Inertia("load", inertia=1.0), Shaft("shaft", "engine", "load", stiffness=3e4),
    ...     HarmonicTorque("firing", "engine", cosine=[40.0], base="turn")])
    >>> result = forced(lower(assemble(line)))
    >>> result["shaft.torque"].real.round(6).tolist()  # (T / J) k / (k / J_a + k / J_b - w^2)
    [[16.523031]]
    """
    model = compiled_of(model, "forced")
    chosen = tuple(channels) if channels is not None else tuple(name for name in model.outputs if name.endswith(CHANNELS))
    stressed = _stress_rows(model, diameters or {})
    asked = tuple(dict.fromkeys([*chosen, *(torque for torque, _ in stressed.values())]))
    dampers = tuple(name for name in model.outputs if name.endswith(LOST))
    listed = read_speeds(model, speeds)

    def answer_at(speed: float) -> _Answer:
        point = point_at(model, speed, parameters)
        linear = linearize(model, point, asked, complex_stiffness)
        shaking = excitation(model, point, asked, highest_order)
        return _Answer(linear, shaking, *_answer(linear, shaking, speed, dampers))

    known = {float(speed): answer_at(float(speed)) for speed in listed}
    added: list[float] = []
    refine = len(listed) >= CURVE if refine is None else refine
    for low, high in pairwise(list(known) if refine else []):
        near = known[low]
        added += resonance_speeds(near.linear, near.shaking, near.response, low, high).tolist()
    known |= {speed: answer_at(speed) for speed in added}
    first = known[float(listed[0])].linear.point
    listed = np.array(sorted(known))
    answers = [known[speed] for speed in listed.tolist()]
    found = {order: sources for each in answers for order, sources in zip(each.shaking.orders, each.shaking.sources, strict=True)}
    orders = tuple(sorted(found))
    place = {order: k for k, order in enumerate(orders)}
    amplitudes = np.zeros((len(listed), len(asked), len(orders)), dtype=complex)
    power = np.zeros((len(listed), len(dampers), len(orders)))
    for k, each in enumerate(answers):
        at = [place[order] for order in each.shaking.orders]
        amplitudes[k][:, at], power[k][:, at] = each.response, each.lost
    mean = np.array([each.linear.rest for each in answers])
    rows = [asked.index(name) for name in chosen] + [asked.index(torque) for torque, _ in stressed.values()]
    factor = np.array([1.0] * len(chosen) + [each for _, each in stressed.values()])
    vibrating = [k for k, name in enumerate(dampers) if not name.startswith("total.")]
    names = tuple(dampers[k].removesuffix(LOST) for k in vibrating)
    # What the sum over all elements has beside them is modal damping, which belongs to no element.
    parts = power[:, vibrating]
    if model.equations.modal_ratio is not None:
        parts = np.concatenate([parts, power[:, [dampers.index("total" + LOST)]] - parts.sum(axis=1, keepdims=True)], axis=1)
        names = (*names, "modal_damping")
    between = gears_between_speeds(model, first.p)
    gears = [f"{name}.{kind}" for name in between for kind in ("torque", "force") if f"{name}.{kind}" in chosen]
    return ForcedResult(
        model=model.name,
        speeds=listed,
        orders=orders,
        bases=tuple(tuple(base for base, _ in found[order]) for order in orders),
        harmonics=tuple(tuple(multiple for _, multiple in found[order]) for order in orders),
        channels=(*chosen, *stressed),
        units=(*(model.unit(name) for name in chosen), *("Pa" for _ in stressed)),
        mean=mean[:, rows] * factor,
        amplitudes=amplitudes[:, rows] * factor[:, None],
        dampers=names,
        power=parts,
        gears=tuple(gears),
        referred_ratio=referred_ratios(model, first),
        parametric=parametric(model, first),
        complex_stiffness=complex_stiffness,
        added=tuple(added),
        averaged=turned_elements(model.equations),
        remarks=linear_remarks(model, first),
    )


@dataclass(frozen=True, eq=False)
class _Answer:
    """What is known at one speed: amplitudes (channels, orders) and power lost (dampers, orders)."""

    linear: LinearModel
    shaking: Excitation
    response: Complex
    lost: Array


def _answer(linear: LinearModel, shaking: Excitation, speed: float, dampers: tuple[str, ...]) -> tuple[Complex, Array]:
    """Amplitudes (channels, orders) and power lost (dampers, orders) at one speed."""
    n = len(linear.mass)
    omega = np.array([float(order) * speed for order in shaking.orders])
    force = shaking.amplitudes[:n]
    try:
        motion = frequency_response(linear.mass, linear.damping, linear.stiffness, omega, force, linear.hysteresis)
    except CaseError as error:
        raise CaseError(f"driveline {linear.model.name!r} at {speed * 30 / np.pi:.6g} rpm", error.problem, error.remedy) from None
    gain = linear.by_angle @ motion + 1j * (linear.by_speed @ (omega * motion) + linear.by_hysteresis @ motion)
    return gain + shaking.amplitudes[n:], _lost_power(linear, shaking, motion, omega, dampers)


def _lost_power(linear: LinearModel, shaking: Excitation, motion: Complex, omega: Array, dampers: tuple[str, ...]) -> Array:
    """Mean of each damper's power over a period, above what it turns into heat at rest; four phases suffice for a square."""
    model, point = linear.model, linear.point
    rows = tuple(model.output_index(name) for name in dampers)
    n, count = len(point.angle), len(omega)
    total = np.zeros((len(dampers), count))
    if not count or not rows:
        return total
    power = mapped(seen(model, rows), count)
    own = model.mean_model.own_start
    p = np.repeat(point.p[:, None], count, axis=1)
    if np.any(linear.hysteresis):
        p[stated_frequencies(model)] = omega
    for phase in (1, 1j, -1, -1j):
        angle = point.angle[:, None] + (motion[:n] * phase).real
        rate = (1j * omega * motion[:n] * phase).real
        state = own[:, None] + (motion[n:] * phase).real
        varying = point.mean[:, None] + (shaking.varying * phase).real
        total += np.asarray(power(angle, rate, state, p, varying))[-len(rows) :] / 4
    rest = np.asarray(seen(model, rows)(point.angle, np.zeros(n), own, point.p, point.mean))[-len(rows) :]
    return np.asarray(total - rest)


def _stress_rows(model: Compiled, diameters: Mapping[str, Diameter]) -> dict[str, tuple[str, float]]:
    """Stress channel -> torque channel and factor."""
    found = {}
    for name, diameter in diameters.items():
        model.output_index(f"{name}.torque")
        found[f"{name}.shear_stress"] = (f"{name}.torque", shear_stress_factor(diameter, f"shaft {name!r}, diameter"))
    return found
