"""What the figures show is what the results hold."""

from __future__ import annotations

from dataclasses import replace
from math import degrees
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from modelgen.analysis import Window
from modelgen.elements import GearPair, Inertia
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.gears import Gear, GearMesh, series_errors
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.plots import backlash, fitting_errors, gear_meshes, mesh_damping, mesh_forces, mesh_stiffness, plot, responses
from modelgen.plots.style import GRAY
from modelgen.solvers import simulate


def lines(figure: Figure, panel: int = 0) -> list[np.ndarray]:
    return [np.asarray(line.get_ydata(), dtype=float) for line in figure.axes[panel].lines]


def notes(figure: Figure) -> str:
    return " | ".join(text.get_text() for axes in figure.axes for text in (*axes.texts, axes._left_title))


# -- angles ------------------------------------------------------------------------------------------------------------------


def test_bars_are_the_angles_in_degrees_physical_and_referred(results: Any) -> None:
    figure = plot(results.angles)
    for axes, referred in zip(figure.axes, (False, True), strict=True):
        heights = np.array([[bar.get_height() for bar in container] for container in axes.containers])
        for column, each in enumerate(results.angles.inertias.values()):
            ratio = each.referred_ratio if referred else 1.0
            wanted = [each.vibration.peak, each.vibration.half_pp, each.elastic.peak, each.elastic.half_pp]
            assert heights[:, column] == pytest.approx([degrees(value) / ratio for value in wanted])
    assert "r = 0.3333" in notes(figure)


def test_verdict_stands_against_the_limit(results: Any) -> None:
    peak = degrees(max(each.vibration.peak for each in results.angles.inertias.values()))
    assert "above the limit" in notes(plot(results.angles, limit=0.9 * peak))
    assert "within the limit" in notes(plot(results.angles, limit=1.1 * peak))
    assert "limit" not in notes(plot(results.angles, limit=None))


def test_unsettled_window_is_said(results: Any) -> None:
    assert "not settled" in " ".join(text.get_text() for text in plot(results.angles).texts)
    with pytest.raises(CaseError, match="there are no inertias in it"):
        plot(replace(results.angles, inertias={}))


# -- over time ---------------------------------------------------------------------------------------------------------------


def test_response_is_the_vibration_angle_of_the_window(results: Any) -> None:
    figure = responses(results.solution, results.window, ["pump", "engine"], last=None)
    for panel, name in enumerate(["pump", "engine"]):
        swing = results.angles.inertias[name].vibration
        assert np.abs(lines(figure, panel)[0]).max() == pytest.approx(degrees(swing.peak), rel=1e-6)
        assert f"peak {degrees(swing.peak):.4g}°" in notes(figure)
    part = lines(responses(results.solution, results.window, ["pump"], last=1))[0]
    assert len(part) == pytest.approx(results.window.period / 0.24 * 2400 + 1, abs=1)


@pytest.mark.parametrize(
    ("names", "window", "words"),
    [
        (["flywheel"], None, r"no output 'flywheel.angle_deviation'"),
        (["pmp"], None, r"nearest is 'pump.angle_deviation'"),
        ([], None, r"nothing to show; name at least one inertia"),
        (["pump"], Window(0.2, 0.4, 10, "firing_order", 0.02, True), r"covers 0 to 0.24 s, the window is 0.2 to 0.4 s; simulate"),
        (["pump"], Window(1.2, 1.4, 10, "firing_order", 0.02, True), r"the window is 1.2 to 1.4 s"),
    ],
)
def test_impossible_response_is_refused(names: list[str], window: Window | None, words: str, results: Any) -> None:
    with pytest.raises(CaseError, match=words):
        responses(results.solution, window or results.window, names)


def test_channels_are_shown_in_readable_units(results: Any) -> None:
    figure = plot(results.solution, names=["coupling.torque", "coupling.twist"])
    torque, twist = (lines(figure, panel)[0] for panel in (0, 1))
    assert twist == pytest.approx(np.degrees(results.solution["coupling.twist"]))
    scale = {"$T$ [N·m]": 1.0, "$T$ [kN·m]": 1e-3}[figure.axes[0].get_ylabel()]
    assert torque == pytest.approx(scale * results.solution["coupling.torque"])
    assert figure.axes[1].get_ylabel() == r"$\theta_a-\theta_b$ [°]"
    assert figure.axes[0].get_xlim() == figure.axes[1].get_xlim()


def test_too_many_and_unknown_channels_are_refused(results: Any) -> None:
    with pytest.raises(CaseError, match=r"channels are to be shown; name 1 to 12"):
        plot(results.solution)
    with pytest.raises(CaseError, match=r"nearest is 'coupling\.twist'"):
        plot(results.solution, names=["couplin.twist"])
    few = simulate(results.case.change(end=0.01, samples=11, channels=("coupling.twist",)))
    assert len(plot(few).axes) == 1


def test_contact_is_shaded_where_the_flanks_are_apart(results: Any) -> None:
    figure = mesh_forces(results.impacts)
    depth = results.impacts["mesh.penetration"]
    assert (depth == 0).any()
    free, back = (each for each in figure.axes[0].collections if isinstance(each, PolyCollection))
    step = results.impacts.times[1]
    shaded = [tuple(path.get_extents().intervalx) for path in free.get_paths()]
    for time in results.impacts.times[depth == 0]:
        assert any(low - step <= time <= high + step for low, high in shaded)
    assert bool(back.get_paths()) == bool((depth < 0).any())
    assert f"free {100 * np.mean(depth == 0):.3g} %" in notes(figure)
    gaps = [float(line.get_ydata()[0]) for line in figure.axes[1].lines if line.get_linestyle() == "--"]
    assert [abs(gap) for gap in gaps] == pytest.approx([40.0] * len(gaps))  # um, the model's half backlash
    assert gaps


def test_mesh_forces_show_the_envelope_over_the_window_and_the_largest_force_close_up(results: Any) -> None:
    """The envelope reaches from the least to the largest force that the report tells, and the close-up holds the largest."""
    figure = mesh_forces(results.solution, results.window)
    told, period = results.angles.meshes["mesh"], 60 / (1500 * 21)
    assert (results.window.last - results.window.first) / period > 40
    envelope, force, deflection = figure.axes
    (band,) = (each for each in envelope.collections if isinstance(each, PolyCollection))
    reach = band.get_paths()[0].vertices[:, 1]
    assert (reach.min(), reach.max()) == pytest.approx((told.least / 1e3, told.largest / 1e3), rel=1e-12)
    assert envelope.get_xlim() == pytest.approx((results.window.first, results.window.last))
    curve = force.lines[0]
    assert np.ptp(curve.get_xdata()) == pytest.approx(6 * period, rel=0.05)
    assert curve.get_ydata().max() == pytest.approx(told.largest / 1e3, rel=1e-12)
    assert deflection.get_xlim() == force.get_xlim()
    heading = " ".join(text.get_text() for text in figure.texts)
    assert f"Window {results.window.first:.4g} to {results.window.last:.4g} s" in heading


def test_a_physical_limit_is_drawn_among_physical_angles_only(results: Any) -> None:
    physical, referred = plot(results.angles, limit=0.5).axes
    dashed = [[line for line in axes.lines if line.get_linestyle() == "--"] for axes in (physical, referred)]
    assert [len(lines) for lines in dashed] == [1, 0]
    assert "0.5°" not in [text.get_text() for text in referred.texts]
    assert not any(axes.lines for axes in plot(results.angles).axes)  # nobody chose a limit


def test_mesh_forces_need_a_gear_pair(results: Any) -> None:
    with pytest.raises(CaseError, match="there is no gear pair 'mash'; nearest is 'mesh'"):
        mesh_forces(results.solution, names=["mash"])
    few = simulate(results.case.change(end=0.01, samples=11, channels=("coupling.twist",)))
    with pytest.raises(CaseError, match="has no gear pair; keep the channels force, deflection and penetration"):
        mesh_forces(few)


# -- gear meshes -------------------------------------------------------------------------------------------------------------


def test_curves_are_those_of_the_teeth(results: Any) -> None:
    mesh = GearMesh(Gear(21, 0.004), Gear(63, 0.004), face_width=0.030)
    pair = results.meshes["mesh"]
    assert (pair.teeth, pair.order, pair.form) == ((21, 63), 10, "corrected")
    assert pair.period == pytest.approx(60 / (1500 * 21))
    assert pair.contact_ratio == pytest.approx(mesh.transverse_contact_ratio)
    assert pair.exact == pytest.approx(mesh.stiffness(np.minimum(pair.phase, 2 - 1e-12)))
    rms_of_curves = np.sqrt(np.mean((pair.stiffness - pair.exact) ** 2)) / pair.mean_stiffness
    assert rms_of_curves == pytest.approx(pair.errors.rms[10], rel=0.02)
    series = series_errors(mesh, 12)
    maximum, rms = lines(fitting_errors(results.meshes))[:2]
    assert maximum == pytest.approx(100 * series.maximum)
    assert rms == pytest.approx(100 * series.rms)


def test_damping_forms_follow_their_equations(results: Any) -> None:
    pair = results.meshes["mesh"]
    r_a, r_b = (0.004 * teeth * np.cos(np.radians(20)) / 2 for teeth in (21, 63))
    j_a, j_b, xi = 0.05, 0.8, 0.05
    mass = j_a * j_b / (j_a * r_b**2 + j_b * r_a**2)
    printed = j_a * j_b * r_a**2 * r_b**2 / (r_a**2 * j_a + r_b**2 * j_b)
    assert pair.damping == pytest.approx(2 * xi * np.sqrt(pair.stiffness * mass))
    assert pair.forms["literal"] == pytest.approx(2 * xi * np.sqrt(pair.stiffness * printed))
    figure = mesh_damping(results.meshes)
    assert "mesh: corrected, in use" in notes(figure)
    assert [axes.get_ylabel().split("[")[1] for axes in figure.axes] == ["kN·s/m]", "N·m·s/rad]"]


def test_backlash_function_and_static_state(results: Any) -> None:
    pair = results.meshes["mesh"]
    force = 300 / (0.004 * 21 * np.cos(np.radians(20)) / 2)
    assert pair.deflection - pair.half_backlash == pytest.approx(force / pair.mean_stiffness, rel=1e-6)
    figure = backlash(results.meshes)
    line, dot = figure.axes[0].lines
    assert np.interp([-60.0, 0.0, 30.0, 60.0], line.get_xdata(), line.get_ydata()) == pytest.approx([-20.0, 0.0, 0.0, 20.0])
    assert float(dot.get_ydata()[0]) == pytest.approx(1e6 * force / pair.mean_stiffness, rel=1e-6)


def test_given_rows_and_given_damping_have_no_exact_curve() -> None:
    disks = [Inertia("one", inertia=1.0), Inertia("two", inertia=1.0)]
    pair = GearPair(
        "mesh", "one", "two", teeth_a=20, teeth_b=20, module="5 mm", mean_stiffness=1e8, stiffness_cosine=[1e7, 2e6],
        damping="value", damping_coefficient=50.0,
    )  # fmt: skip
    line = Driveline("spur", speed=100.0, reference="one", elements=[*disks, pair])
    meshes = gear_meshes(lower(assemble(line)))
    (curves,) = meshes.pairs
    assert (curves.exact, curves.errors, curves.order, curves.forms, curves.form) == (None, None, 2, {}, "value")
    angle = 2 * np.pi * curves.phase
    assert curves.stiffness == pytest.approx(1e8 + 1e7 * np.cos(angle) + 2e6 * np.cos(2 * angle))
    assert len(lines(mesh_stiffness(meshes))) == 2
    assert len(mesh_damping(meshes).axes) == 1
    assert len(backlash(meshes).axes) == 1
    with pytest.raises(CaseError, match="no pair has tooth geometry"):
        fitting_errors(meshes)


def test_gear_meshes_need_gears(results: Any) -> None:
    with pytest.raises(CaseError, match="there is no gear pair 'mush'; nearest is 'mesh'"):
        gear_meshes(results.case.model, names=["mush"])
    with pytest.raises(CaseError, match="there is no gear pair 'mush'; nearest is 'mesh'"):
        results.meshes["mush"]
    with pytest.raises(CaseError, match="has no elastic gear pair"):
        gear_meshes(lower(assemble(Driveline("lone", elements=[Inertia("disk", inertia=1.0)]))))


# -- modes and cross-check ---------------------------------------------------------------------------------------------------


def test_shapes_are_referred_and_largest_one(results: Any) -> None:
    figure = plot(results.modes, driveline=results.driveline, count=2)
    stations = [label.get_text() for label in figure.axes[0].get_xticklabels()]
    assert stations == ["fan", "engine", "alternator", "pinion", "wheel", "pump"]
    order = [results.modes.names.index(name) for name in stations]
    for panel in (0, 1):
        shape = results.modes.referred[order, results.modes.rigid + panel]
        drawn = lines(figure, panel)[-1]
        assert drawn == pytest.approx(shape / shape[np.abs(shape).argmax()])
        assert drawn.max() == pytest.approx(1.0) or drawn.min() == pytest.approx(-1.0)
    first = results.modes.frequencies[results.modes.rigid]
    assert f"mode 1: f = {first:.4g} Hz, ζ = " in notes(figure)
    assert "r = 0.333" in notes(figure)


def test_every_joint_of_the_branched_train_is_drawn(results: Any) -> None:
    figure = plot(results.modes, driveline=results.driveline, count=1)
    between = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 2 and line.get_color() != GRAY]
    joined = {tuple(sorted(int(x) for x in line.get_xdata())): line.get_linestyle() == "--" for line in between}
    # fan - engine - alternator, engine - pinion, the mesh pinion - wheel, wheel - pump
    assert joined == {(0, 1): False, (1, 2): False, (1, 3): False, (3, 4): True, (4, 5): False}


def test_modes_of_another_driveline_are_refused(results: Any) -> None:
    other = Driveline("lone", elements=[Inertia("disk", inertia=1.0)])
    with pytest.raises(CaseError, match="the driveline given has other parts"):
        plot(results.modes, driveline=other)
    with pytest.raises(CaseError, match="0 of 5 vibrating modes are to be drawn"):
        plot(results.modes, count=0)


def test_differences_fall_with_tolerance_as_drawn(results: Any) -> None:
    figure = plot(results.crosscheck)
    above, below = figure.axes
    for line, name in zip(above.lines, results.crosscheck.solvers, strict=False):
        runs = {run.tolerance: run.worst for run in results.crosscheck.runs if run.solver == name}
        assert dict(zip(line.get_xdata(), line.get_ydata(), strict=True)) == pytest.approx(runs)
    channels = [label.get_text() for label in below.get_yticklabels()]
    best = results.crosscheck.best("cvodes").differences
    assert channels == list(best)
    assert list(below.lines[1].get_xdata()) == pytest.approx([max(best[name], 1e-16) for name in channels])


def test_crosscheck_without_a_finished_run_is_refused(results: Any) -> None:
    broken = tuple(replace(run, differences={}) for run in results.crosscheck.runs)
    with pytest.raises(CaseError, match="no run reached its end"):
        plot(replace(results.crosscheck, runs=broken))
    figure = plot(replace(results.crosscheck, runs=(broken[0], *results.crosscheck.runs[1:])))
    assert "Not shown: rk4 at 1e" in " ".join(text.get_text() for text in figure.texts)
