"""``report.md``: what was run, what came out, in which definitions, from which data.

Part of ``reports``. This file only gathers; the words and the layout stand in ``templates/report.md.jinja``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from modelgen import __version__
from modelgen.analysis.linear.mode_numbers import mode_cell
from modelgen.analysis.time_domain.settled import GIVEN, LOWEST_MODE, SAMPLES_PER_PERIOD, base_frequencies
from modelgen.model import Element, Shared
from modelgen.reports import limit
from modelgen.reports.figures import Figure
from modelgen.reports.response import Response
from modelgen.reports.summary import summary

Row = dict[str, Any]


def report_text(response: Response, figures: Sequence[Figure], command: str = "") -> str:
    """The text of ``report.md``; ``command`` is the line that a reader can run again."""
    limits = limit.judged(response)
    return (
        environment()
        .get_template("report.md.jinja")
        .render(
            version=__version__,
            command=command,
            summary=summary(response),
            line=response.line,
            equations=response.model.equations,
            fingerprint=response.model.fingerprint[:16],
            digest=response.solution.case.digest()[:16],
            request=response.request,
            window=response.window,
            given=GIVEN,
            lowest_mode=LOWEST_MODE,
            solution=response.solution,
            rate=response.rate,
            thinned=response.thinned,
            samples_per_period=SAMPLES_PER_PERIOD,
            bases=base_frequencies(response.model, response.point),
            rpm=_rpm(response),
            balanced=_balanced(response),
            modes=_modes(response),
            mode_remarks=response.modes.remarks,
            angles=_angles(response),
            twists=_twists(response),
            meshes=response.angles.meshes,
            verdict=limit.verdict(limits),
            limits=limits,
            others=[row for row in limits.rows if row.quantity != limit.ANGLE] if limits else [],
            largest=_largest_angle(response),
            crosscheck=response.crosscheck,
            crosscheck_failed=response.crosscheck_failed,
            data=_data(response),
            figures=figures,
            degrees=math.degrees,
        )
    )


def environment() -> Any:
    """Jinja's environment for the templates, with the filters ``digits`` and ``cell``."""
    import jinja2  # only texts need it

    made = jinja2.Environment(
        loader=jinja2.PackageLoader("modelgen.reports", "templates"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # it is Markdown; what comes from a model file passes through ``cell``
    )
    made.filters.update(digits=digits, cell=cell)
    return made


def digits(value: float | None, count: int = 4) -> str:
    """A number to so many significant digits; an em dash for one that does not exist.

    >>> digits(0.58962), digits(158859.006), digits(0.0), digits(None), digits(1.2e-7, 2)
    ('0.5896', '158900', '0', '—', '1.2e-07')
    """
    if value is None or not math.isfinite(value):
        return "—"
    if value == 0:
        return "0"
    places = count - 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{count - 1}e}" if places > count + 3 else f"{round(value, places):.{max(0, places)}f}"


def cell(text: object) -> str:
    r"""Text from a model file, made harmless in a Markdown table.

    >>> cell("a | b\n<c>")
    'a \\| b &lt;c&gt;'
    """
    return " ".join(str(text).split()).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("|", r"\|")


@dataclass(frozen=True)
class Mode:
    """A row of the table of modes: its number or "rigid", and the damping that the result gives it, as texts."""

    number: str
    frequency: float
    damping: str
    decay: str
    largest: str


def _modes(response: Response) -> list[Mode]:
    modes = response.modes
    rows = []
    for k, frequency in enumerate(modes.frequencies.tolist()):
        own = modes.damped(k)
        damping, decay = digits(own.ratio if own else None, 3), digits(own.decay if own else None, 3)
        if own and own.rates:
            damping = "unstable" if own.growth else "overdamped"
            decay = " and ".join(digits(rate, 3) for rate in own.rates)
        elif own and own.growth:
            damping += " (unstable)"
        largest = "whole driveline turns" if k < modes.rigid else modes.names[int(np.abs(modes.shapes[:, k]).argmax())]
        rows.append(Mode(mode_cell(k, modes.rigid), frequency, damping, decay, largest))
    return rows


def _largest_angle(response: Response) -> Row | None:
    """The inertia with the largest vibration angle, and that angle [deg]."""
    inertias = response.angles.inertias
    if not inertias:
        return None
    worst = max(inertias, key=lambda name: inertias[name].vibration.peak)
    return {"element": worst, "value": math.degrees(inertias[worst].vibration.peak)}


def _rpm(response: Response) -> float | None:
    parameters = response.model.parameters
    return parameters.value(response.point.p, "speed") * 30 / math.pi if "speed" in parameters.parameters else None


def _balanced(response: Response) -> dict[str, float]:
    """Factors that the balance of mean power gave the loads named for it, by parameter."""
    return {name: response.model.parameters.value(response.point.p, name) for name in response.model.equations.balanced}


def _angles(response: Response) -> list[Row]:
    """Angles [deg] of each inertia, physical and referred."""
    rows = []
    for name, each in response.angles.inertias.items():
        sizes = (each.vibration.peak, each.vibration.half_pp, each.elastic.peak, each.elastic.half_pp)
        physical = [math.degrees(size) for size in sizes]
        referred = [value / each.referred_ratio if each.referred_ratio else None for value in physical]
        rows.append({"name": name, "ratio": each.referred_ratio, "physical": physical, "referred": referred})
    return rows


def _twists(response: Response) -> list[Row]:
    """Twist [deg] and transmitted torque [N*m] of whatever is twisted."""
    rows = []
    for name, swing in response.angles.twists.items():
        torque = response.solution.channels.get(f"{name}.torque")
        mean = float(np.mean(response.solution[f"{name}.twist"]))
        row = {"name": name, "mean": math.degrees(mean), "half_pp": math.degrees(swing.half_pp), "peak": math.degrees(swing.peak)}
        row["torque"] = None if torque is None else (float(torque.min()), float(torque.mean()), float(torque.max()))
        rows.append(row)
    return rows


def _data(response: Response) -> list[Row]:
    """Each element's data as given, with the note on where they come from."""
    line = response.line
    rows = [(name, "parameter", _named(named), named.note) for name, named in line.parameters.items()]
    rows += [(each.name, each.kind, _given(each), each.note) for each in line.elements]
    return [dict(zip(("name", "kind", "given", "note"), row, strict=True)) for row in rows]


def _named(named: Any) -> str:
    if named.expression is not None:
        return f"= {named.expression}"
    if isinstance(named.value, tuple):
        return f"{len(named.value)} values [{named.unit}]"
    return f"{named.value:.6g} {named.unit if named.unit != '1' else ''}".strip()


def _given(element: Element) -> str:
    """What was given of an element beside its joints."""
    parts = []
    for key, value in element.given().items():
        if key in element.targets:
            continue
        shown = value.name if isinstance(value, Shared) else f"{value:.6g}" if isinstance(value, float) else str(value)
        if isinstance(value, tuple) and len(value) > 4:
            shown = f"{len(value)} values"
        unit = _unit(element, key)
        parts.append(f"{key} {shown}{f' {unit}' if unit and not isinstance(value, Shared) else ''}")
    return ", ".join(parts)


def _unit(element: Element, key: str) -> str:
    unit = getattr(type(element), key).unit if key in element.values else "1"
    return "" if unit == "1" else unit
