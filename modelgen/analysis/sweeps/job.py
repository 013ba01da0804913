"""A sweep as plain text, for those who compute its points elsewhere: model, case, engine, names. No object travels, no code.

Part of ``sweeps``, between the process that asked and its workers. The model goes as the text of a model file, so whoever has
modelgen can rebuild it; that it is the same model is checked by the digest of the case.
"""

from __future__ import annotations

import dataclasses
import functools
import json
from collections.abc import Mapping
from typing import Any

import modelgen.elements  # noqa: F401 - defining the elements makes their kinds known to model texts
from modelgen.analysis.sweeps.batch import Runner
from modelgen.equations import assemble
from modelgen.errors import CaseError, ModelgenError
from modelgen.lowering import Section, lower
from modelgen.model.files import model_text, parse_model
from modelgen.solvers.case import Case
from modelgen.solvers.problem import Budget

FIELDS = ("end", "begin", "record_from", "samples", "solver", "tolerance", "seed")
OWN_ELEMENTS = "modelgen."


def portable(case: Case) -> bool:
    """Whether a model text says all about the case's model: not of equations given directly, nor of elements of one's own."""
    line = case.model.equations.source
    if line is None or not all(type(element).__module__.startswith(OWN_ELEMENTS) for element in line.elements):
        return False
    try:
        return bool(model_text(line))
    except (ModelgenError, TypeError):
        return False


def job_text(case: Case, engine: Mapping[str, Any], names: tuple[str, ...], collect: tuple[str, ...], plan: str) -> str:
    """The sweep as JSON. The case must be portable."""
    line = case.model.equations.source
    assert line is not None
    options = {name: value for name, value in case.options.items() if name != "budget"}
    budget = case.options.get("budget")
    return json.dumps(
        {
            "model": model_text(line),
            "case": {name: getattr(case, name) for name in FIELDS},
            "parameters": case.data()["parameters"],
            "start": case.data()["start"],
            "sections": [dataclasses.asdict(section) for section in case.sections],
            "options": options,
            "budget": None if budget is None else dataclasses.asdict(budget),
            "digest": case.digest(),
            "engine": dict(engine),
            "names": names,
            "collect": collect,
            "plan": plan,
        }
    )


@functools.lru_cache(maxsize=2)
def runner_of(job: str) -> Runner:
    """Who runs the points of a job; built once per process. Raises CaseError unless the case comes out as it was sent."""
    data = json.loads(job)
    options = data["options"] | ({} if data["budget"] is None else {"budget": Budget(**data["budget"])})
    model = lower(assemble(parse_model(data["model"], "model of the sweep")))
    sections = tuple(Section(**section) for section in data["sections"])
    case = Case(model, parameters=data["parameters"], start=data["start"], options=options, sections=sections, **data["case"])
    if case.digest() != data["digest"]:
        raise CaseError(
            "sweep",
            f"a worker makes another model of {model.name!r} than was sent",
            "give all the same version of modelgen",
        )
    return Runner(case, data["engine"], tuple(data["names"]), tuple(data["collect"]), data["plan"])
