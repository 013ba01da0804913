"""What ``modelgen reproduce paper`` computes: the settled response, the diagrams over damping, the evidence on motions.

Part of ``cli``. The response is that of the paper's driveline; for kinds of motion its variant stands in whose excitation repeats
with every turn of the slowest shaft, under both readings of the mesh damping.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from modelgen.analysis import BifurcationResult, bifurcation
from modelgen.analysis.classification.motion_evidence import MotionEvidence, motion_evidence
from modelgen.cli.progress import Progress
from modelgen.drivelines import load
from modelgen.drivelines.claims import Claims
from modelgen.equations import assemble
from modelgen.lowering import Compiled, lower
from modelgen.model import Driveline
from modelgen.reports.paper import Reading, in_degrees, readings
from modelgen.reports.response import Request, Response, respond
from modelgen.reports.settings import common_ratio, common_switch, settle
from modelgen.solvers import Case

MESH_READINGS = ("fixed", "scaled")
STARTS = ("static", "zero")
Also = Callable[[float], dict[str, float]]


@dataclass(frozen=True)
class Extent:
    """How much is computed: ``values`` of the parameter with ``strobes`` after at most ``transient``.

    For the kinds of motion ``points`` after at most ``wait`` strobes, exponents over ``revolutions`` common periods. ``window``
    [s] of the response (None: settled); ``readings``: whether the response is run under every reading of the damping.
    """

    name: str = "full"
    values: int = 201
    strobes: int = 150
    transient: int = 200
    points: int = 200
    wait: int = 100
    revolutions: int = 40
    window: tuple[float, float] | None = None
    readings: bool = True
    response_tolerance: float = 1e-6
    diagram_tolerance: float = 1e-5
    motion_tolerance: float = 1e-6


FULL = Extent()
QUICK = Extent("quick", 5, 16, 8, 16, 8, 6, (0.0, 0.1), False, 1e-4, 1e-4, 1e-5)


@dataclass(frozen=True, eq=False)
class Reproduction:
    """What was computed.

    ``diagrams`` by mesh reading; ``motions`` by mesh reading and value, ``xi`` the mesh damping ratio there; ``channels``, that
    are strobed, by role. ``diagram_seconds``: what the diagrams took.
    """

    claims: Claims
    extent: Extent
    response: Response
    runs: list[Reading]
    stand_in: Driveline
    channels: Mapping[str, str]
    diagrams: Mapping[str, BifurcationResult]
    motions: Mapping[tuple[str, float], MotionEvidence]
    xi: Mapping[tuple[str, float], float]
    diagram_seconds: float


def reproduce_all(line: Driveline, claims: Claims, extent: Extent, progress: Progress) -> Reproduction:
    """Computes everything. Raises what each step raises."""
    response = respond(line, Request(window=extent.window, tolerance=extent.response_tolerance), progress)
    if extent.readings:
        runs = readings(response, progress)
    else:
        shaft, mesh = (common_switch(line, kind) or "" for kind in ("shaft", "gear_pair"))
        runs = [Reading(shaft, mesh, in_degrees(response.angles))]
    progress.stage(f"assemble and compile {claims.motion.driveline}")
    stand_in = load(claims.motion.driveline)
    model, also = _mesh_readings(stand_in, claims.motion.parameter)
    channels = {role: f"{element}.elastic_angle" for role, element in claims.roles.items()}
    begun = time.perf_counter()
    diagrams = {name: _diagram(model, claims, tuple(channels.values()), also[name], name, extent, progress) for name in also}
    spent = time.perf_counter() - begun
    values = sorted({each.value for each in claims.motion.claims})
    xi = {(name, value): next(iter(also[name](value).values())) for name in also for value in values}
    motions = _motions(model, claims.motion.parameter, values, also, tuple(channels.values()), extent, progress)
    return Reproduction(claims, extent, response, runs, stand_in, channels, diagrams, motions, xi, spent)


def _mesh_readings(line: Driveline, parameter: str) -> tuple[Compiled, dict[str, Also]]:
    """The model, and what follows the parameter under each reading of the mesh damping."""
    compiled = {name: lower(assemble(settle(line, mesh_reading=name))) for name in MESH_READINGS}
    ratio = str(common_ratio(line, "gear_pair"))

    def follower(model: Compiled) -> Also:
        return lambda value: {ratio: float(model.parameters.value(model.parameters.unbalanced({parameter: value}), ratio))}

    return compiled["fixed"], {name: follower(model) for name, model in compiled.items()}


def _diagram(
    model: Compiled, claims: Claims, channels: tuple[str, ...], also: Also, name: str, extent: Extent, progress: Progress
) -> BifurcationResult:
    low, high = claims.motion.range
    values = [low + (high - low) * k / (extent.values - 1) for k in range(extent.values)]
    progress.stage(f"strobe {extent.values} values of {claims.motion.parameter}, mesh reading {name}", measured=True)
    return bifurcation(
        Case(model, end=1.0, tolerance=extent.diagram_tolerance),
        *(claims.motion.parameter, values, channels),
        also=also,
        count=extent.strobes,
        transient=extent.transient,
        progress=progress.fraction,
    )


def _motions(
    model: Compiled,
    parameter: str,
    values: list[float],
    also: Mapping[str, Also],
    channels: tuple[str, ...],
    extent: Extent,
    progress: Progress,
) -> dict[tuple[str, float], MotionEvidence]:
    """Evidence at every value under every reading; where readings are the same there, it is gathered once."""
    wanted = {(name, value): {parameter: value, **follow(value)} for name, follow in also.items() for value in values}
    settings: list[dict[str, float]] = []
    for each in wanted.values():
        if each not in settings:
            settings.append(each)
    found = motion_evidence(
        Case(model, end=1.0, tolerance=extent.motion_tolerance),
        *(settings, channels),
        starts=STARTS,
        count=extent.points,
        transient=extent.wait,
        revolutions=extent.revolutions,
        stage=lambda text: progress.stage(f"motions: {text}", measured=text == "strobe"),
        progress=progress.fraction,
    )
    return {key: found[settings.index(each)] for key, each in wanted.items()}
