"""Question: does an engine that shares no equation with modelgen see the same vibration?

The place of the multibody program in the paper is taken by MuJoCo (extra ``referee``): bodies, hinges and tendons of its own, its
own Runge-Kutta method with a fixed step, started from the same angles and speeds. Compared are twists, mesh deflections and
forces, and the angles of all inertias, each relative to half the peak-to-peak of its fluctuating part.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.referee.mujoco_model import Referee, Timed, mesh_damping, referee_of
from modelgen.drivelines import load
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point
from modelgen.solvers.case import Case
from modelgen.solvers.crosscheck import without_line
from modelgen.solvers.simulate import simulate

Array = NDArray[np.float64]
STEP = 5e-6
DIFFERENCES = (
    "modelgen integrates with error control, the referee with a fixed step: a kink falls anywhere into a step",
    "modelgen's states are one rigid angle and relative angles, the referee's are the absolute angles of all hinges",
    "the referee's tendon acts at the radius of its coefficients, both gears turning as if in one direction",
    "mesh stiffness, damping and error are set for the instant of each of the referee's four evaluations per step",
)


@dataclass(frozen=True, eq=False)
class RefereeResult:
    """Channels of both sides over ``times`` [s]; ``ours`` and ``theirs`` by channel, ``units`` likewise.

    ``difference``: largest |ours - theirs| less both best lines where an angle rolls, per half peak-to-peak of ours;
    ``peak_difference``: relative difference of half peaks-to-peaks. ``step`` [s] of the referee; ``notes`` name every difference
    in modelling; ``engine`` its name and version; ``seconds`` what the referee took.
    """

    model: str
    times: Array
    ours: Mapping[str, Array]
    theirs: Mapping[str, Array]
    units: Mapping[str, str]
    difference: Mapping[str, float]
    peak_difference: Mapping[str, float]
    step: float
    engine: str
    seconds: float
    notes: tuple[str, ...] = DIFFERENCES

    @property
    def worst(self) -> tuple[str, float]:
        """Channel with the largest difference in time."""
        name = max(self.difference, key=lambda each: self.difference[each])
        return name, self.difference[name]

    @property
    def worst_peak(self) -> tuple[str, float]:
        """Channel with the largest difference of its peaks."""
        name = max(self.peak_difference, key=lambda each: abs(self.peak_difference[each]))
        return name, self.peak_difference[name]

    def __str__(self) -> str:
        (name, size), (peak, share) = self.worst, self.worst_peak
        return (
            f"{self.model} against {self.engine} over {self.times[-1] - self.times[0]:.4g} s, {len(self.difference)} channels:\n"
            f"  largest difference in time {size:.2e} of half the peak-to-peak ({name})\n"
            f"  largest difference of a peak-to-peak {100 * share:+.2g} % ({peak}); referee: steps of {self.step:g} s, "
            f"{self.seconds:.3g} s"
        )


def referee(
    line: Driveline | str | Path,
    end: float,
    *,
    mean_stiffness: bool = False,
    step: float = STEP,
    samples: int = 2001,
    start: str = "static",
    tolerance: float = 1e-9,
    backend: str = "auto",
    progress: Callable[[float], None] | None = None,
) -> RefereeResult:
    """The same run by modelgen and by MuJoCo, from 0 to ``end`` [s].

    ``mean_stiffness``: every mesh at its mean stiffness on both sides. ``step`` [s] of the referee, made to fit the samples.
    Raises CaseError for what the referee does not have, or where the package ``mujoco`` is missing.
    """
    mujoco = _engine()
    if not isinstance(line, Driveline):
        line = load(line)
    if not (0 < step < end) or not math.isfinite(end) or samples < 2:
        raise CaseError("referee", f"end {end!r} s, step {step!r} s, {samples} samples", "give a step smaller than the end")
    if mean_stiffness:
        line = with_mean_stiffness(line)
    case = Case(lower(assemble(line)), end=end, start=start, samples=samples, tolerance=tolerance, options={"backend": backend})
    point = operating_point(case.model)
    sheet = referee_of(line, case.model, point)
    solution = simulate(case)
    if not solution.succeeded:
        raise CaseError(f"driveline {line.name!r}", solution.message, "the referee compares finished runs only")
    begin = {name: (solution[f"{name}.angle"][0], solution[f"{name}.speed"][0]) for name in sheet.places}
    theirs, step, seconds = _run(mujoco, sheet, begin, solution.times, step, progress)
    names = [name for name in theirs if name in solution.channels]
    ours = {name: solution[name] for name in names}
    difference, peaks = {}, {}
    for name in names:
        one, other = (_fluctuating(solution.times, name, each[name]) for each in (ours, theirs))
        swing = np.ptp(one) / 2
        if swing > 0:
            difference[name] = float(np.abs(one - other).max() / swing)
            peaks[name] = float(np.ptp(other) / np.ptp(one) - 1)
    if not difference:
        what = "has no channel that varies in this run: there is nothing to compare"
        raise CaseError(f"driveline {line.name!r}", what, "give it an excitation, another start, or more samples")
    return RefereeResult(
        model=line.name,
        times=solution.times,
        ours=ours,
        theirs={name: theirs[name] for name in names},
        units={name: solution.unit(name) for name in names},
        difference=difference,
        peak_difference=peaks,
        step=step,
        engine=f"MuJoCo {mujoco.__version__}",
        seconds=seconds,
    )


def with_mean_stiffness(line: Driveline) -> Driveline:
    """The driveline with every mesh at its mean stiffness."""
    model = lower(assemble(line))
    p = operating_point(model).p
    for element in line.elements:
        if element.kind == "gear_pair" and element.choices["mesh"] == "geometry":
            mean = model.parameters.value(p, f"{element.name}.geometry_rows")
            line = line.change(element.name, mesh="fourier", mean_stiffness=mean)
        elif element.kind == "gear_pair" and element.choices["mesh"] == "fourier":
            line = line.change(element.name, stiffness_cosine=(), stiffness_sine=())
    return line


def _engine() -> Any:
    try:
        import mujoco
    except ImportError:
        raise CaseError("referee", "the package mujoco is not installed", "pip install 'modelgen[referee]'") from None
    return mujoco


def _fluctuating(times: Array, name: str, values: Array) -> Array:
    return without_line(times, values) if name.endswith(".angle_deviation") else values - values.mean()


def _run(
    mujoco: Any,
    sheet: Referee,
    begin: Mapping[str, tuple[float, float]],
    times: Array,
    step: float,
    progress: Callable[[float], None] | None,
) -> tuple[dict[str, Array], float, float]:
    """Channels at the times, the step [s] that fits between them, and the seconds that it took."""
    every = max(1, math.ceil((times[1] - times[0]) / step * (1 - 1e-9)))
    step = float(times[1] - times[0]) / every
    model = mujoco.MjModel.from_xml_string(sheet.xml(step))
    data = mujoco.MjData(model)
    for name, (group, ratio) in sheet.places.items():
        data.qpos[group], data.qvel[group] = begin[name][0] / ratio, begin[name][1] / ratio
    timed = Timed(sheet)
    loads = _Loads(model, sheet, timed, step)
    positions, speeds = np.empty((len(times), model.nq)), np.empty((len(times), model.nv))
    started = time.perf_counter()
    mujoco.set_mjcb_passive(loads)
    try:
        loads.prepare(0.0)
        for sample in range(len(times)):
            positions[sample], speeds[sample] = data.qpos, data.qvel
            if sample + 1 < len(times):
                for _ in range(every):
                    mujoco.mj_step(model, data)
            if progress is not None and sample % 50 == 0:
                progress(sample / len(times))
    finally:
        mujoco.set_mjcb_passive(None)
    seconds = time.perf_counter() - started
    if not np.isfinite(positions).all():
        raise CaseError("referee", "MuJoCo's run left the numbers", "give a smaller step")
    return _channels(sheet, timed, times, positions, speeds), step, seconds


class _Loads:
    """Called in every evaluation of forces: adds what MuJoCo has no primitive for, and sets stiffness for the next evaluation.

    The springs of an evaluation are summed before this call, so what it sets is what the following one sees; of the four
    evaluations of a step the second and third stand in the middle, the fourth at the end, where the next step begins.
    """

    def __init__(self, model: Any, sheet: Referee, timed: Timed, step: float) -> None:
        self.model, self.sheet, self.timed, self.step = model, sheet, timed, step
        self.gap = np.array([sheet.links[k].gap for k in timed.meshes])
        self.radii = np.zeros((len(timed.meshes), len(sheet.torques)))
        for row, k in enumerate(timed.meshes):
            link = sheet.links[k]
            self.radii[row, list(link.ends)] = link.coefficients
        self.stage, self.begin = 0, 0.0
        self.torque, self.damping, self.rate = np.zeros(len(sheet.torques)), np.zeros(0), np.zeros(0)

    def prepare(self, t: float) -> None:
        """Set everything for an evaluation at t [s]."""
        self.torque, stiffness, error, self.rate = self.timed(t)
        self.damping = mesh_damping(self.sheet, stiffness)
        self.model.tendon_stiffness[self.timed.meshes] = stiffness
        self.model.tendon_damping[self.timed.meshes] = self.damping
        self.model.tendon_lengthspring[self.timed.meshes, 0] = error - self.gap
        self.model.tendon_lengthspring[self.timed.meshes, 1] = error + self.gap

    def __call__(self, model: Any, data: Any) -> None:
        # The tendon's damping sees the rate of its length; the error's own rate is taken out of it here.
        data.qfrc_passive[:] += self.torque + (self.damping * self.rate) @ self.radii
        if self.stage == 0:
            self.begin = data.time
        if self.stage in (0, 2):
            self.prepare(self.begin + (self.step / 2 if self.stage == 0 else self.step))
        self.stage = (self.stage + 1) % 4


def _channels(sheet: Referee, timed: Timed, times: Array, positions: Array, speeds: Array) -> dict[str, Array]:
    """Angles, twists, deflections and forces from the positions and speeds of the hinges."""
    found: dict[str, Array] = {}
    for name, (group, ratio) in sheet.places.items():
        found[f"{name}.angle_deviation"] = ratio * (positions[:, group] - sheet.mean_speed[group] * times)
    values = [timed(t) for t in times.tolist()]
    for k, link in enumerate(sheet.links):
        (a, b), (at_a, at_b) = link.ends, link.coefficients
        length = at_a * positions[:, a] + at_b * positions[:, b]
        rate = at_a * speeds[:, a] + at_b * speeds[:, b]
        if not link.waves:
            found[f"{link.name}.twist"] = length
            found[f"{link.name}.torque"] = link.stiffness * length + link.damping * rate
            continue
        row = timed.meshes.index(k)
        stiffness, error, error_rate = (np.array([each[part][row] for each in values]) for part in (1, 2, 3))
        deflection = length - error
        pressed = np.sign(deflection) * np.maximum(np.abs(deflection) - link.gap, 0.0)
        damping = np.array([mesh_damping(sheet, each[1])[row] for each in values])
        found[f"{link.name}.deflection"] = deflection
        found[f"{link.name}.force"] = stiffness * pressed + damping * (rate - error_rate)
    return found
