"""What ``modelgen generate`` writes: equations, C, and a manifest that says where they come from.

Part of ``cli``. The numbers of a folder (the default case and the probes) stand in its manifest, so that the same folder comes
out byte for byte on a machine whose linear algebra rounds otherwise: ``generate_check`` holds the numbers against the model by
their size, and the text by its bytes.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from modelgen import __version__
from modelgen.drivelines import catalogue
from modelgen.equations import assemble
from modelgen.errors import LoweringError
from modelgen.lowering import Compiled, lower
from modelgen.lowering.native.portable_files import DefaultCase, portable_files
from modelgen.model import Driveline
from modelgen.model.writing import model_text
from modelgen.solvers import Case, operating_point
from modelgen.solvers.simulate import initial_value_problem

FORMAT = 1
MANIFEST = "manifest.json"
PERIODS, SHORTEST, WITHOUT_MODES = 2, 0.02, 1.0  # horizon: periods of the lowest vibrating mode, and at least so many s,
MOST_PERIODS = 2000  # but not more than these of the highest
SAMPLES = 201
TOLERANCE = 1e-11  # so tight that rounding, which tips decisions of the step control at kinks, costs less than 1e-9
PROBES = 5
TOOLS = ("casadi", "sympy", "numpy")


@dataclass(frozen=True)
class Probe:
    """A place at random, and what the model gives there for the parameters of the default case."""

    time: float
    state: tuple[float, ...]
    rates: tuple[float, ...]
    outputs: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Subject:
    """A model as it is generated: compiled, with the digest of its text and where it was read from."""

    model: Compiled
    digest: str
    source: str

    @classmethod
    def of(cls, line: Driveline, source: str) -> Subject:
        """A driveline, assembled and compiled."""
        text = model_text(replace(line, limits=()))  # what it is held against changes no equation
        return cls(lower(assemble(line)), hashlib.sha256(text.encode()).hexdigest(), source)


def source_of(model: str, folder: Path) -> str:
    """How a manifest names a model: by its catalogue name, or by the path of its file as seen from the folder."""
    return model if model in catalogue() else Path(os.path.relpath(model, folder)).as_posix()


def located(source: str, folder: Path) -> str:
    """The other way: a catalogue name, or the path of a model file as seen from here."""
    return source if source in catalogue() else os.path.normpath(folder / source)


def default_case(model: Compiled) -> DefaultCase:
    """The default case: a short run from the static state. Raises LoweringError for a law that jumps, and what a run raises."""
    point = operating_point(model)
    frequencies = point.frequencies()
    vibrating = frequencies[frequencies > 0]  # a rigid rotation is at zero
    end = WITHOUT_MODES
    if len(vibrating):
        end = float(f"{min(max(SHORTEST, PERIODS / vibrating[0]), MOST_PERIODS / vibrating[-1]):.1g}")
    case = Case(model, end=end, samples=SAMPLES, tolerance=TOLERANCE)
    problem, offset = initial_value_problem(case, point)
    if problem.switching is not None:
        problem_words = "has laws that jump, and generated C locates no events yet"
        raise LoweringError(f"driveline {model.name!r}", problem_words, "simulate it in Python")
    start, parameters, scale = (tuple(each.tolist()) for each in (problem.x0 + offset, problem.p, problem.scale))
    return DefaultCase(parameters, start, scale, end, SAMPLES, TOLERANCE)


def as_case(model: Compiled, case: DefaultCase) -> Case:
    """The same case for ``simulate``: what the C program's trajectory is compared with."""
    return Case(model, end=case.end, samples=case.samples, tolerance=case.tolerance)


def probes(model: Compiled, case: DefaultCase) -> tuple[Probe, ...]:
    """Probes about the start of the default case, a scale away from it."""
    random = np.random.default_rng(5)
    places = [
        (
            float(random.uniform(0, case.end)),
            np.array(case.start) + np.array(case.scale) * random.standard_normal(len(case.start)),
        )
        for _ in range(PROBES)
    ]
    return tuple(Probe(time, tuple(state.tolist()), *evaluated(model, case, time, state)) for time, state in places)


def evaluated(model: Compiled, case: DefaultCase, time: float, state: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Rates and outputs of the model at one place."""
    values = model.evaluate(time, state, case.parameters)
    return tuple(model.rhs(time, state, case.parameters).tolist()), tuple(values.values())


def contents(subject: Subject, case: DefaultCase, places: tuple[Probe, ...]) -> dict[str, bytes]:
    """The files of a folder by name, the manifest last. Raises LoweringError for what C cannot hold."""
    texts = {"equations.md": subject.model.equations.markdown(), **portable_files(subject.model, case)}
    files = {name: text.encode() for name, text in texts.items()}
    manifest = {
        "format": FORMAT,
        "model": subject.model.name,
        "source": subject.source,
        "model_sha256": subject.digest,
        "tools": tools(),
        "files": {name: digest(content) for name, content in files.items()},
        "case": asdict(case),
        "probes": [asdict(each) for each in places],
    }
    return {**files, MANIFEST: _json_text(manifest).encode()}


def digest(content: bytes) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(content).hexdigest()


def tools() -> dict[str, str]:
    """Versions of what decides the bytes of a folder."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"modelgen": __version__, "python": python, **{name: importlib.metadata.version(name) for name in TOOLS}}


def _json_text(data: Mapping[str, Any]) -> str:
    """JSON with a line for each entry of the second level."""
    lines = []
    for key, value in data.items():
        if isinstance(value, dict):
            inner = [f"    {json.dumps(name)}: {json.dumps(each)}" for name, each in value.items()]
            text = "{\n" + ",\n".join(inner) + "\n  }"
        elif isinstance(value, list):
            text = "[\n" + ",\n".join(f"    {json.dumps(each)}" for each in value) + "\n  ]"
        else:
            text = json.dumps(value)
        lines.append(f"  {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"
