"""Figures of the gear meshes: fitting error, stiffness, damping, backlash. The paper's Fig. 1 to 4.

All four draw ``GearMeshes`` (``mesh_curves``); ``plot`` shows the stiffness.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.mesh_curves import GearMeshes, MeshCurves
from modelgen.plots.quantities import MINUS, display, words
from modelgen.plots.style import BLUE, FAINT, GRAY, INK, SERIES, SMALL, VERMILION, name_panel, panels, sheet, styled

PERIODS = "phase in mesh periods [-], 0 where a tooth pair enters contact"


def _teeth(pair: MeshCurves) -> str:
    return f"{words(pair.name)}, z {pair.teeth[0]}/{pair.teeth[1]}"


@styled
def fitting_errors(meshes: GearMeshes) -> Figure:
    """Error of the truncated Fourier series of the mesh stiffness against its order: rms and largest, in percent of the mean.

    Raises CaseError where no pair's stiffness follows from its teeth.
    """
    drawn = [pair for pair in meshes.pairs if pair.errors is not None]
    if not drawn:
        where = f"gear meshes of {meshes.model!r}"
        raise CaseError(where, "no pair has tooth geometry to fit a series to", 'set mesh="geometry"')
    detail = (
        "Stiffness from tooth geometry less its least-squares series of order n, over one mesh period, in percent of the mean "
        "stiffness. The rms falls with every order; the largest error stays at half the jump (Gibbs)."
    )
    figure = sheet(meshes.model, "fitting error of the mesh stiffness", detail, height=6.6)
    axes = panels(figure, 1)[0][0]
    for index, pair in enumerate(drawn):
        assert pair.errors is not None
        color, order = SERIES[index % len(SERIES)], pair.errors.order
        # The rms errors of ordinary teeth nearly coincide: later lines are finer, so that the first stay visible.
        width, size = max(0.8, 2.0 - 1.1 * index), max(2.0, 4.5 - 2.0 * index)
        fine: dict[str, Any] = {"color": color, "linewidth": width, "markersize": size}
        axes.plot(order, 100 * pair.errors.maximum, linestyle="--", marker="s", label=f"{_teeth(pair)}: maximum", **fine)
        axes.plot(order, 100 * pair.errors.rms, marker="o", label=f"{_teeth(pair)}: rms", **fine)
        if pair.order is not None and pair.order < len(order):
            for values in (pair.errors.rms, pair.errors.maximum):
                axes.plot(pair.order, 100 * values[pair.order], marker="o", markersize=8, color=color, fillstyle="none")
    axes.set(xlabel="order n of the series [-]  (ring: order in the model)", ylabel="error / mean stiffness [%]", ylim=(0, None))
    axes.set_xlim(-0.5, max(len(pair.errors.order) for pair in drawn if pair.errors is not None) - 0.5)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


@styled
def mesh_stiffness(meshes: GearMeshes) -> Figure:
    """Mesh stiffness over two mesh periods: from the teeth, as the model's series has it, and its mean."""
    detail = "kₘ is the stiffness along the line of action, the sum over the tooth pairs in contact."
    figure = sheet(meshes.model, "mesh stiffness", detail, height=0.9 + 4.6 * len(meshes.pairs))
    for pair, (axes,) in zip(meshes.pairs, panels(figure, len(meshes.pairs)), strict=True):
        shown = display("N/m", float(np.max(pair.stiffness)))
        if pair.exact is not None:
            axes.plot(pair.phase, shown(pair.exact), color=GRAY, linewidth=1.6, label="from tooth geometry")
        series = "in the model" if pair.order is None else f"Fourier series of {pair.order} orders (model)"
        axes.plot(pair.phase, shown(pair.stiffness), color=BLUE, label=series)
        axes.axhline(float(shown(pair.mean_stiffness)), color=VERMILION, linestyle="--", linewidth=0.9, label="mean")
        ratio = "" if pair.contact_ratio is None else f", contact ratio {pair.contact_ratio:.3f}"
        name_panel(axes, _teeth(pair), f"mean {float(shown(pair.mean_stiffness)):.4g} {shown.unit}{ratio}")
        axes.set_ylabel(rf"mesh stiffness $k_m$ [{shown.unit}]")
        axes.set_xlim(0, 2)
    axes.set_xlabel(PERIODS)
    handles = {label: handle for row in figure.axes for handle, label in zip(*row.get_legend_handles_labels(), strict=True)}
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=3)
    return figure


plot.register(GearMeshes)(mesh_stiffness)


@styled
def mesh_damping(meshes: GearMeshes) -> Figure:
    """Mesh damping over two mesh periods: corrected, and as printed in the paper; the form that the model uses is marked."""
    detail = (
        "Corrected: 2 ξ √(kₘ mₑ) with mₑ = J₁J₂/(J₁r₂² + J₂r₁²), a force per velocity. Literal: Eq. 10 as printed, with the "
        "inertias at the other radii and in the unit of a torque per speed; its number alone can be compared."
    )
    figure = sheet(meshes.model, "mesh damping", detail, height=0.8 + 4.8 * len(meshes.pairs))
    columns = 2 if any(pair.forms for pair in meshes.pairs) else 1
    rows = panels(figure, len(meshes.pairs), columns)
    for pair, row in zip(meshes.pairs, rows, strict=True):
        drawn = pair.forms or {"given": pair.damping}
        for (form, values), axes in zip(drawn.items(), row, strict=False):
            unit = "N*m*s/rad" if form == "literal" else "N*s/m"
            shown = display(unit, float(np.max(values)))
            used = form in (pair.form, "given")
            mean = float(np.mean(shown(values)))
            axes.plot(pair.phase, shown(values), color=BLUE if used else GRAY, linewidth=1.3 if used else 1.1)
            axes.axhline(mean, color=VERMILION, linestyle="--", linewidth=0.9)
            ratio = "" if pair.damping_ratio is None else f", ξ = {pair.damping_ratio:g}"
            name_panel(axes, f"{words(pair.name)}: {form}{', in use' if used else ''}", f"mean {mean:.3g} {shown.unit}{ratio}")
            axes.set_ylabel(rf"mesh damping $c_m$ [{shown.unit}]")
            axes.set_xlim(0, 2)
        for axes in row[len(drawn) :]:
            axes.set_axis_off()
    for axes in rows[-1]:
        axes.set_xlabel("phase in mesh periods [-]")
    return figure


@styled
def backlash(meshes: GearMeshes) -> Figure:
    """Backlash function f(delta) of every pair, with the static state under the mean torques."""
    detail = (
        f"f is the penetration of the flanks: δ {MINUS} b on the driving flank, 0 within the gap, δ + b on the back flank; "
        f"δ = r₁θ₁ {MINUS} r₂θ₂ {MINUS} e. Dot: equilibrium under the mean torques."
    )
    columns = min(2, len(meshes.pairs))
    count = -(-len(meshes.pairs) // columns)
    figure = sheet(meshes.model, "backlash function", detail, height=0.4 + 6.0 * count)
    spots = [axes for row in panels(figure, count, columns, share_x=False) for axes in row]
    for pair, axes in zip(meshes.pairs, spots, strict=False):
        _backlash_panel(axes, pair)
    for axes in spots[len(meshes.pairs) :]:
        axes.set_axis_off()
    return figure


def _backlash_panel(axes: Axes, pair: MeshCurves) -> None:
    gap = pair.half_backlash
    reach = max(2.2 * gap, 1.3 * abs(pair.deflection)) or 1e-6
    shown = display("m", reach)
    x = np.array([-reach, -gap, gap, reach])
    axes.axvspan(*(float(shown(end)) for end in (-gap, gap)), color=FAINT, zorder=0)
    axes.plot(shown(x), shown(np.array([gap - reach, 0.0, 0.0, reach - gap])), color=BLUE, linewidth=1.5)
    penetration = np.sign(pair.deflection) * max(abs(pair.deflection) - gap, 0.0)
    axes.plot(shown(pair.deflection), shown(penetration), marker="o", markersize=5, color=VERMILION, zorder=5)
    top = float(shown(reach - gap))
    within = f"free\n±b = ±{float(shown(gap)):.3g} {shown.unit}" if gap else ""
    flank = float(shown((reach + gap) / 2))
    for middle, height, text in ((-flank, 0.92, "back\nflank"), (0.0, 0.92, within), (flank, -0.92, "driving\nflank")):
        side = "top" if height > 0 else "bottom"
        axes.text(middle, height * top, text, ha="center", va=side, fontsize=SMALL, color=INK)
    name_panel(axes, _teeth(pair))
    axes.set(xlabel=rf"mesh deflection $\delta$ [{shown.unit}]", ylabel=rf"penetration $f(\delta)$ [{shown.unit}]")
    axes.set(xlim=shown(np.array([-reach, reach])), ylim=(-1.05 * top, 1.05 * top))
