"""Whether generated folders still say what their models say: untouched, equal in meaning, equal in bytes.

Part of ``cli``, the work behind ``modelgen generate --check``. Three steps: the files are what was written (hashes), the model of
today gives the manifest's numbers (to 1e-12 of the largest of their kind), and where the tools are the same the folder comes out
again byte for byte.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.cli.generate_folder import (
    FORMAT,
    MANIFEST,
    Probe,
    Subject,
    contents,
    default_case,
    digest,
    evaluated,
    located,
    tools,
)
from modelgen.drivelines import load
from modelgen.errors import CaseError, ModelgenError
from modelgen.lowering.native.portable_files import DefaultCase

LARGEST_MANIFEST = 16 * 2**20
EXACT = 1e-12  # functions and values of parameters
ITERATED = 1e-9  # start and scales, which an iteration found


@dataclass(frozen=True)
class Manifest:
    """A manifest as it was read."""

    source: str
    model_digest: str
    tools: dict[str, str]
    files: dict[str, str]
    case: DefaultCase
    probes: tuple[Probe, ...]


@dataclass(frozen=True)
class Freshness:
    """What was found wrong with a folder, what could not be compared, and the command that repairs it."""

    folder: Path
    problems: tuple[str, ...]
    remark: str
    repair: str


def check_folder(folder: Path) -> Freshness:
    """All that is wrong with a generated folder. Raises CaseError where there is no manifest that can be read."""
    manifest = read_manifest(folder)
    model = located(manifest.source, folder)
    repair = shlex.join(["modelgen", "generate", model, "--out", str(folder), "--replace"])
    problems = list(_touched(folder, manifest))
    differing = {name: (then, tools().get(name)) for name, then in manifest.tools.items() if then != tools().get(name)}
    remark = ", ".join(f"{name} {then} then, {now} now" for name, (then, now) in differing.items())
    try:
        subject = Subject.of(load(model), manifest.source)
        problems += _meaning(subject, manifest)
        if not differing and not problems:
            problems += _bytes(folder, contents(subject, manifest.case, manifest.probes))
    except ModelgenError as error:
        problems.append(f"the model cannot be generated: {error}")
    return Freshness(folder, tuple(problems), remark and f"bytes not compared ({remark})", repair)


def read_manifest(folder: Path) -> Manifest:
    """The manifest of a folder. Raises CaseError."""
    where = f"generated folder {str(folder)!r}"
    remedy = "generate it: modelgen generate MODEL --out DIR"
    try:
        if (folder / MANIFEST).stat().st_size > LARGEST_MANIFEST:
            raise CaseError(where, f"has a {MANIFEST} of more than {LARGEST_MANIFEST} bytes", remedy)
        data = json.loads((folder / MANIFEST).read_bytes())
        if data["format"] != FORMAT:
            raise CaseError(where, f"has format {data['format']!r}, known is {FORMAT}", remedy)
        case = data["case"]
        return Manifest(
            source=_text(data["source"]),
            model_digest=_text(data["model_sha256"]),
            tools={_text(name): _text(version) for name, version in data["tools"].items()},
            files={_text(name): _text(value) for name, value in data["files"].items()},
            case=DefaultCase(
                parameters=_numbers(case["parameters"]),
                start=_numbers(case["start"]),
                scale=_numbers(case["scale"]),
                end=_number(case["end"]),
                samples=int(_number(case["samples"])),
                tolerance=_number(case["tolerance"]),
            ),
            probes=tuple(
                Probe(_number(each["time"]), _numbers(each["state"]), _numbers(each["rates"]), _numbers(each["outputs"]))
                for each in data["probes"]
            ),
        )
    except FileNotFoundError:
        raise CaseError(where, f"has no {MANIFEST}", remedy) from None
    except OSError as error:
        raise CaseError(where, f"cannot be read: {error.strerror}", "check the path and its permissions") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise CaseError(where, f"has a {MANIFEST} that is not one of ours", remedy) from None


def _touched(folder: Path, manifest: Manifest) -> Iterator[str]:
    """Files that are not as they were written."""
    for name, expected in manifest.files.items():
        path = folder / name
        if Path(name).name != name or not path.is_file():
            yield f"{name!r} is missing"
        elif digest(path.read_bytes()) != expected:
            yield f"{name!r} was edited after it was written"
    for path in sorted(chain(folder.glob("*.c"), folder.glob("*.h"))):
        if path.name not in manifest.files:
            yield f"{path.name!r} was not written by modelgen"


def _meaning(subject: Subject, manifest: Manifest) -> Iterator[str]:
    """Where the model of today says something else than the manifest."""
    model, then = subject.model, manifest.case
    now = default_case(model)
    if subject.digest != manifest.model_digest:
        yield "the text of the model has changed"
    sizes = (len(model.states), len(model.parameters.labels()), len(model.outputs))
    if sizes != (len(then.start), len(then.parameters), len(manifest.probes[0].outputs) if manifest.probes else -1):
        yield f"the model has now {sizes[0]} states, {sizes[1]} parameters and {sizes[2]} outputs"
        return
    states = [state.unit for state in model.equations.states]
    series = [label.partition("[")[0] for label in model.parameters.labels()]
    yield from _differing("parameter", model.parameters.labels(), series, then.parameters, now.parameters, EXACT)
    yield from _differing("start of", model.states, states, then.start, now.start, ITERATED)
    yield from _differing("scale of", model.states, states, then.scale, now.scale, ITERATED)
    if (then.end, then.samples, then.tolerance) != (now.end, now.samples, now.tolerance):
        yield f"the default case runs now to {now.end:g} s with {now.samples} samples at tolerance {now.tolerance:g}"
    for number, probe in enumerate(manifest.probes, 1):
        rates, outputs = evaluated(model, then, probe.time, probe.state)
        rate_units = [f"{unit}/s" for unit in states]
        yield from _differing(f"probe {number}, rate of", model.states, rate_units, probe.rates, rates, EXACT)
        yield from _differing(f"probe {number},", model.outputs, model.units, probe.outputs, outputs, EXACT)


def _differing(
    what: str, names: Sequence[str], kinds: Sequence[str], then: Sequence[float], now: Sequence[float], share: float
) -> Iterator[str]:
    """The entry that differs most, if any differs by more than a share of the largest of its kind."""
    old, new = np.array(then), np.array(now)
    if old.shape != new.shape:
        yield f"{what} {names[0]!r} and others: {old.size} numbers in the manifest, {new.size} now"
        return
    size = np.ones_like(old)
    for kind in set(kinds):
        members = np.array([each == kind for each in kinds])
        size[members] = np.abs(old[members]).max() or 1.0
    error = np.abs(new - old) / size
    if not error.max(initial=0.0) <= share:
        worst = int(np.argmax(error))
        yield f"{what} {names[worst]!r} was {then[worst]:.15g} and is now {now[worst]:.15g}"


def _bytes(folder: Path, files: dict[str, bytes]) -> Iterator[str]:
    """Files that come out otherwise with the same tools."""
    for name, content in files.items():
        path = folder / name
        found = path.read_bytes() if path.is_file() else b""
        if found != content:
            lines = zip(found.splitlines(), content.splitlines(), strict=False)
            line = next((f"from line {number} on" for number, (one, other) in enumerate(lines, 1) if one != other), "at its end")
            yield f"{name!r} comes out otherwise, {line}"


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    return value


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
        raise TypeError
    return float(value)


def _numbers(values: Any) -> tuple[float, ...]:
    return tuple(map(_number, values))
