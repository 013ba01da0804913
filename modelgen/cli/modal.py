"""``modelgen modal``: natural frequencies, damping, shapes, energy shares and sensitivities.

Part of ``cli``; asks ``modal`` and ``sensitivity`` of ``analysis.linear`` and puts their answers into tables, figures and files.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis import ModalResult, SensitivityResult
    from modelgen.lowering import Compiled

EXAMPLES = """
\b
Examples:
  modelgen modal fracturing-truck --out out/modes
  modelgen modal my_driveline.toml --out out/stiff --set coupling.stiffness="400 kN*m/rad"
  modelgen modal my_driveline.toml --out out/lowest --count 20 --speed "1500 rpm"

\b
Ends with 0 when done, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
NAMED = 5  # parameters that the summary names for each mode


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--count", type=click.IntRange(min=1), help="The lowest modes only.  [default: all]")
def modal(model: str, assignments: tuple[str, ...], speed: str | None, out: Path, replace: bool, count: int | None) -> None:
    """Modes of MODEL about its operating point: frequencies, damping, shapes, energy shares, sensitivities.

    The folder gets modal.csv (frequencies, damping and shapes, physical and referred to the reference shaft), energy.csv
    (shares of every element), sensitivities.csv (of every mode to every parameter that it depends on), modal.json and figures.
    """
    from modelgen.cli.folder import output_folder
    from modelgen.cli.progress import Progress

    with output_folder(out, replace) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis import modal as modes_of
        from modelgen.analysis import sensitivities
        from modelgen.cli.question import opened

        _, compiled = opened(model, assignments, speed)
        progress.stage("find the modes")
        modes = modes_of(compiled, count=count)
        progress.stage("find their sensitivities")
        slopes = sensitivities(compiled, count=len(modes.frequencies))
        progress.stage("write tables and figures")
        _write(modes, slopes, compiled, folder)
    click.echo(modal_text(modes))
    click.echo(f"tables, figures and modal.json: {out}")


def damped_of(modes: ModalResult) -> list[int | None]:
    """For every mode the number of its damped one; None for rigid modes, and for all where one does not oscillate any more.

    In the order of |s|, which proportional damping leaves at the undamped frequency.
    """
    elastic = len(modes.frequencies) - modes.rigid
    if len(modes.damped_frequencies) != elastic:
        return [None] * len(modes.frequencies)
    size = [math.hypot(2 * math.pi * f, rate) for f, rate in zip(modes.damped_frequencies, modes.decay_rates, strict=True)]
    return [None] * modes.rigid + sorted(range(elastic), key=size.__getitem__)


def modal_text(modes: ModalResult) -> str:
    """The table of modes for the terminal."""
    from modelgen.cli.report import digits
    from modelgen.cli.tables import aligned

    rows = []
    for k, (frequency, own) in enumerate(zip(modes.frequencies, damped_of(modes), strict=True)):
        held = [_largest(modes, shares, k) for shares in (modes.kinetic, modes.potential)]
        damped = [None if own is None else float(values[own]) for values in (modes.damped_frequencies, modes.damping_ratios)]
        numbers = [digits(float(frequency), 6), digits(damped[0], 6), digits(damped[1])]
        rows.append([str(k + 1), *numbers, held[0], "rigid" if k < modes.rigid else held[1]])
    kind = "all" if modes.complete else "the lowest"
    head = f"modes of {modes.model!r}: {kind} {len(modes.frequencies)}, {modes.rigid} rigid"
    columns = ["mode", "undamped [Hz]", "damped [Hz]", "damping ratio", "most kinetic energy", "most potential energy"]
    return f"{head}\n{aligned(columns, rows)}"


def _largest(modes: ModalResult, shares: Any, mode: int) -> str:
    if not modes.elements:
        return "none"
    element = int(shares[:, mode].argmax())
    return f"{modes.elements[element]} {shares[element, mode]:.0%}"


def _write(modes: ModalResult, slopes: SensitivityResult, compiled: Compiled, folder: Path) -> None:
    import numpy as np

    from modelgen.cli.tables import write_data, write_table
    from modelgen.plots import energy_shares, plot, save

    names = list(modes.names)
    header = ["mode", "undamped [Hz]", "damped [Hz]", "damping ratio [1]", "decay rate [1/s]", "modal inertia [kg*m^2]"]
    header += [f"{name} {kind} [1]" for kind in ("physical", "referred") for name in names]
    shapes = np.vstack([modes.shapes, modes.referred]).T.tolist()
    rows = [[*each.values(), *shape] for each, shape in zip(_modes(modes), shapes, strict=True)]
    write_table(folder / "modal.csv", header, rows)
    energy = [
        [k + 1, float(frequency), element, float(modes.kinetic[e, k]), float(modes.potential[e, k])]
        for k, frequency in enumerate(modes.frequencies)
        for e, element in enumerate(modes.elements)
    ]
    write_table(folder / "energy.csv", ["mode", "undamped [Hz]", "element", "kinetic share [1]", "potential share [1]"], energy)
    columns = ["mode", "undamped [Hz]", "parameter", "value [unit]", "unit", "slope [Hz/unit]", "relative slope [1]", "method"]
    write_table(folder / "sensitivities.csv", columns, _sensitivity_rows(slopes))
    write_data(folder / "modal.json", modal_data(modes, slopes))
    if len(modes.frequencies) > modes.rigid:
        save(plot(modes, driveline=compiled.equations), folder / "modes.png")
        save(energy_shares(modes), folder / "energy.png")
        save(plot(slopes), folder / "sensitivities.png")


def _sensitivity_rows(slopes: SensitivityResult) -> list[list[Any]]:
    import numpy as np

    relative = slopes.relative
    told = list(zip(slopes.parameters, slopes.values.tolist(), slopes.units, strict=True))
    rows = []
    for mode in range(slopes.rigid, len(slopes.frequencies)):
        for k in np.flatnonzero(slopes.slopes[mode]):
            found = [float(slopes.slopes[mode, k]), float(relative[mode, k]), slopes.methods[k]]
            rows.append([mode + 1, float(slopes.frequencies[mode]), *told[k], *found])
    return rows


def _modes(modes: ModalResult) -> list[dict[str, Any]]:
    """What is told of each mode as a whole, in the order of the columns of its table."""
    damped = {
        "damped_hz": modes.damped_frequencies,
        "damping_ratio": modes.damping_ratios,
        "decay_rate_per_s": modes.decay_rates,
    }
    return [
        {
            "mode": k + 1,
            "undamped_hz": float(modes.frequencies[k]),
            **{key: None if own is None else float(values[own]) for key, values in damped.items()},
            "modal_inertia_kg_m2": float(modes.modal_inertia[k]),
        }
        for k, own in enumerate(damped_of(modes))
    ]


def modal_data(modes: ModalResult, slopes: SensitivityResult) -> dict[str, Any]:
    """The modes as plain data; modes count from 1. A relative sensitivity is (change of f / f) / (change of p / p)."""
    shares = {"kinetic_energy_shares": modes.kinetic, "potential_energy_shares": modes.potential}
    damped = zip(modes.damped_frequencies.tolist(), modes.damping_ratios.tolist(), modes.decay_rates.tolist(), strict=True)
    return {
        "model": modes.model,
        "rigid_modes": modes.rigid,
        "complete": modes.complete,
        "repeated_modes": [[mode + 1 for mode in cluster] for cluster in modes.repeated],
        "speed_ratios": dict(zip(modes.names, modes.ratio.tolist(), strict=True)),
        "modes": [
            {
                **each,
                **{key: dict(zip(modes.elements, of[:, k].tolist(), strict=True)) for key, of in shares.items()},
                "largest_relative_sensitivities": dict(slopes.largest(k, NAMED)),
            }
            for k, each in enumerate(_modes(modes))
        ],
        "damped_modes": [{"damped_hz": f, "damping_ratio": ratio, "decay_rate_per_s": rate} for f, ratio, rate in damped],
    }
