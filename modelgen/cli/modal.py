"""``modelgen modal``: natural frequencies, damping, shapes, energy shares and sensitivities.

Part of ``cli``; asks ``modal`` and ``sensitivity`` of ``analysis.linear`` and puts their answers into tables, figures and files.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis import ModalResult, SensitivityResult
    from modelgen.analysis.linear.modal import DampedMode
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
BEFORE = 5  # entries of a mode, without its number, that stand before its shapes
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
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

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


def modal_text(modes: ModalResult) -> str:
    """The table of modes for the terminal."""
    from modelgen.analysis.linear.mode_numbers import mode_cell
    from modelgen.lowering.mean_turn import averaged_words
    from modelgen.reports.report import digits
    from modelgen.reports.tables import aligned

    rows = []
    for k, frequency in enumerate(modes.frequencies.tolist()):
        held = [_largest(modes, shares, k) for shares in (modes.kinetic, modes.potential)]
        own = modes.damped(k)
        damped = (_damped_cell(own), digits(own.ratio)) if own else ("—", "—")
        numbers = [digits(frequency, 6), digits(60 * frequency, 6), *damped, str(modes.nodes[k])]
        rows.append([mode_cell(k, modes.rigid), *numbers, held[0], "rigid" if k < modes.rigid else held[1]])
    kind = "all" if modes.complete else "the lowest"
    head = f"modes of {modes.model!r}: {kind} {len(modes.frequencies)}, {modes.rigid} rigid"
    columns = ["mode", "undamped [Hz]", "[vib/min]", "damped [Hz]", "damping ratio", "nodes"]
    table = aligned([*columns, "most kinetic energy", "most potential energy"], rows)
    averaged = [averaged_words(modes.averaged)] if modes.averaged else []
    return "\n".join([head, table, *overdamped_remarks(modes), *averaged, *modes.remarks])


def _damped_cell(own: DampedMode) -> str:
    from modelgen.reports.report import digits

    if own.rates is None:
        return digits(own.frequency, 6)
    return "unstable" if own.growth else "overdamped"


def overdamped_remarks(modes: ModalResult) -> list[str]:
    """A sentence for each mode that does not oscillate, or is unstable."""
    said = []
    for k in range(modes.rigid, len(modes.frequencies)):
        own = modes.damped(k)
        if own and own.growth:
            how = "oscillates while it grows" if own.rates is None else "does not oscillate: it departs"
            said.append(f"{modes.name(k)} is unstable, it {how} with the rate {own.growth:.6g} 1/s")
        elif own and own.rates:
            slow, fast = own.rates
            said.append(f"{modes.name(k)} does not oscillate: it decays with the two rates {slow:.6g} and {fast:.6g} 1/s")
    return said


def _largest(modes: ModalResult, shares: Any, mode: int) -> str:
    if not modes.elements:
        return "none"
    element = int(shares[:, mode].argmax())
    return f"{modes.elements[element]} {shares[element, mode]:.0%}"


def _write(modes: ModalResult, slopes: SensitivityResult, compiled: Compiled, folder: Path) -> None:
    import numpy as np

    from modelgen.analysis.linear.mode_numbers import mode_cell
    from modelgen.plots import energy_shares, plot, save
    from modelgen.reports.tables import write_data, write_table

    names = list(modes.names)
    header = ["mode", "undamped [Hz]", "damped [Hz]", "damping ratio [1]", "decay rate [1/s]", "modal inertia [kg*m^2]"]
    header += [f"{name} {kind} [1]" for kind in ("physical", "referred") for name in names]
    header += ["undamped [vib/min]", "nodes", "slow rate [1/s]", "fast rate [1/s]"]
    shapes = np.vstack([modes.shapes, modes.referred]).T.tolist()
    rows = [
        [mode_cell(k, modes.rigid), *list(each.values())[1 : BEFORE + 1], *shape, *list(each.values())[BEFORE + 1 :]]
        for k, (each, shape) in enumerate(zip(_modes(modes), shapes, strict=True))
    ]
    write_table(folder / "modal.csv", header, rows)
    energy = [
        [mode_cell(k, modes.rigid), float(frequency), element, float(modes.kinetic[e, k]), float(modes.potential[e, k])]
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

    from modelgen.analysis.linear.mode_numbers import mode_cell

    relative = slopes.relative
    told = list(zip(slopes.parameters, slopes.values.tolist(), slopes.units, strict=True))
    rows = []
    for mode in range(slopes.rigid, len(slopes.frequencies)):
        for k in np.flatnonzero(slopes.slopes[mode]):
            found = [float(slopes.slopes[mode, k]), float(relative[mode, k]), slopes.methods[k]]
            rows.append([mode_cell(mode, slopes.rigid), float(slopes.frequencies[mode]), *told[k], *found])
    return rows


def _modes(modes: ModalResult) -> list[dict[str, Any]]:
    """What is told of each mode as a whole, in the order of the columns of its table: ``BEFORE`` the shapes and after them."""
    found = []
    for k, frequency in enumerate(modes.frequencies.tolist()):
        own = modes.damped(k)
        rates = own.rates if own else None
        found.append(
            {
                "mode": modes.number(k),
                "undamped_hz": frequency,
                "damped_hz": own.frequency if own else None,
                "damping_ratio": own.ratio if own else None,
                "decay_rate_per_s": own.decay if own else None,
                "modal_inertia_kg_m2": float(modes.modal_inertia[k]),
                "undamped_vibrations_per_min": 60 * frequency,
                "nodes": int(modes.nodes[k]),
                "slow_rate_per_s": rates[0] if rates else None,
                "fast_rate_per_s": rates[1] if rates else None,
            }
        )
    return found


def modal_data(modes: ModalResult, slopes: SensitivityResult) -> dict[str, Any]:
    """The modes as plain data; vibrating modes count from 1, rigid ones have no number.

    A relative sensitivity is (change of f / f) / (change of p / p).
    """
    shares = {"kinetic_energy_shares": modes.kinetic, "potential_energy_shares": modes.potential}
    damped = zip(modes.damped_frequencies.tolist(), modes.damping_ratios.tolist(), modes.decay_rates.tolist(), strict=True)
    return {
        "model": modes.model,
        "rigid_modes": modes.rigid,
        "complete": modes.complete,
        "repeated_modes": [[modes.number(mode) for mode in cluster] for cluster in modes.repeated],
        "speed_ratios": dict(zip(modes.names, modes.ratio.tolist(), strict=True)),
        "modes": [
            {
                **each,
                "name": modes.name(k),
                **{key: dict(zip(modes.elements, of[:, k].tolist(), strict=True)) for key, of in shares.items()},
                "largest_relative_sensitivities": dict(slopes.largest(k, NAMED)),
            }
            for k, each in enumerate(_modes(modes))
        ],
        "remarks": [*overdamped_remarks(modes), *modes.remarks],
        "damped_modes": [{"damped_hz": f, "damping_ratio": ratio, "decay_rate_per_s": rate} for f, ratio, rate in damped],
    }
