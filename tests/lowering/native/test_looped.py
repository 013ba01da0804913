"""Stages in loops: what is alike stands in one loop, and everything means what it means line by line."""

from __future__ import annotations

import ctypes
import random
import re
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from modelgen import Driveline, GearPair, HarmonicTorque, Inertia, Shaft, assemble, lower
from modelgen.lowering import native
from modelgen.lowering.native import looped
from modelgen.lowering.native.compiler import find_compiler
from modelgen.lowering.native.emission import StagePrinter
from modelgen.lowering.native.functions import observer_functions, stage_functions
from modelgen.lowering.native.graph import Level
from modelgen.lowering.native.stages import Stages
from modelgen.lowering.native.statements import LARGEST, scheduled, statements_of

T = ca.SX.sym("t")
DOUBLES = ctypes.POINTER(ctypes.c_double)
SINGLE = """
typedef double S;
#define LANE_0(a) (a)
#define TIME_VALUE double
#define TIME_STRIDE WIDTH
#define TIME_PARAMETER(a) v_all(a)
"""
LANES = """
typedef V S;
#define LANE_0(a) (a)[0]
#define TIME_VALUE V
#define TIME_STRIDE 4
#define TIME_PARAMETER(a) (a)
"""
RATES = """
void rates(double t, const double *x, const double *p, double *k) {
  double first[NC + 1];
  S c[NC + 1], now[NX], rate[NX];
  V w[4 * NW + 4], times[4] = {v_all(t - 1), v_all(t + 1), v_all(t), v_all(t - 2)};
  parameter_stage(p, first);
  for (int i = 0; i < NC; ++i) c[i] = first[i] - (S){0};
  for (int i = 0; i < NX; ++i) now[i] = x[i] - (S){0};
  time_stage(c, %s, (const V *)0, w);
  state_stage(c, (const TIME_VALUE *)w + 2, now, rate);
  for (int i = 0; i < NX; ++i) k[i] = LANE_0(rate[i]);
}
"""


def in_c(stages: Stages, lanes: bool, folder: Path) -> Callable[[float, np.ndarray, np.ndarray], np.ndarray]:
    """The right-hand side as C computes it, by the text of the stages."""
    headers = [(Path(native.__file__).parent / name).read_text(encoding="utf-8") for name in ("scalar.h", "lanes.h")]
    head, call = (LANES, "times") if lanes else ("", "times[2]")
    text = [*([] if lanes else ["#define SINGLE"]), *headers, head or SINGLE, stage_functions(stages, "v_" if lanes else "s_")]
    folder.mkdir(exist_ok=True)
    (folder / "stages.c").write_text("\n".join([*text, RATES % call]), encoding="utf-8")
    find_compiler().build(folder / "stages.c", folder / "stages.so")
    function = ctypes.CDLL(str(folder / "stages.so")).rates
    function.argtypes, function.restype = [ctypes.c_double, DOUBLES, DOUBLES, DOUBLES], None

    def rates(t: float, x: np.ndarray, p: np.ndarray) -> np.ndarray:
        found, x, p = np.full(stages.sizes[0], np.nan), np.ascontiguousarray(x, float), np.ascontiguousarray(p, float)
        function(t, *(each.ctypes.data_as(DOUBLES) for each in (x, p, found)))
        return found

    return rates


@pytest.fixture
def all_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(looped, "LARGE", 0)


def chain(count: int) -> Driveline:
    disks = [Inertia(f"disk_{k}", inertia=1 + 0.01 * k) for k in range(count)]
    shafts = [Shaft(f"shaft_{k}", f"disk_{k}", f"disk_{k + 1}", stiffness=1e5 + 100 * k) for k in range(count - 1)]
    return Driveline("chain", elements=[*disks, *shafts, *_load(f"disk_{count - 1}", "disk_0")], **SPEED)


def branched(count: int) -> Driveline:
    """A tree with shafts of every kind of damping, and torques of one to three harmonics here and there."""
    draw = random.Random(3)
    kinds = (
        {},
        {"damping_ratio": 0.02},
        {"damping": "value", "damping_coefficient": 3.0},
        {"damping": "loss_factor", "loss_factor": 0.01, "reference_frequency": 100.0},
    )
    elements = [Inertia(f"disk_{k}", inertia=1 + 0.01 * k) for k in range(count)]
    for k in range(1, count):
        place = f"disk_{draw.randrange(max(0, k - 6), k)}"
        elements.append(Shaft(f"shaft_{k}", place, f"disk_{k}", stiffness=1e5 + 100 * k, **draw.choice(kinds)))
    for k in range(0, count, 3):
        rows = [100.0, 20.0, 5.0][: 1 + k % 3]
        elements.append(HarmonicTorque(f"firing_{k}", f"disk_{k}", mean=10.0, cosine=rows, base="firing"))
    elements.append(HarmonicTorque("load", f"disk_{count - 1}", mean=-10.0 * len(range(0, count, 3))))
    return Driveline("branched", elements=elements, bases={"firing": ("disk_0", 2)}, speed="1500 rpm", reference="disk_0")


def gears(count: int) -> Driveline:
    """Gear pairs, each with a mesh frequency of its own, and shafts by turns."""
    elements = [Inertia(f"disk_{k}", inertia=0.02 + 0.0001 * k) for k in range(count)]
    for k in range(count - 1):
        ends = f"disk_{k}", f"disk_{k + 1}"
        if k % 2:
            elements.append(Shaft(f"shaft_{k}", *ends, stiffness=1e5 + 100 * k, damping_ratio=0.02))
        else:
            mesh = {"mean_stiffness": 8e8, "stiffness_cosine": [1e8, 3e7], "damping_ratio": 0.05, "half_backlash": 5e-5}
            teeth = {"teeth_a": 21 + k % 3, "teeth_b": 23 + k % 5, "module": 0.004}
            elements.append(GearPair(f"mesh_{k}", *ends, **teeth, **mesh, error_amplitude=5e-6))
    return Driveline("gears", elements=[*elements, HarmonicTorque("drive", "disk_0", cosine=[50.0], base="firing")], **SPEED)


SPEED = {"bases": {"firing": ("disk_0", 2)}, "speed": "1500 rpm", "reference": "disk_0"}


def _load(last: str, first: str) -> list[HarmonicTorque]:
    return [
        HarmonicTorque("drive", first, mean=10.0, cosine=[100.0, 20.0, 5.0], base="firing"),
        HarmonicTorque("load", last, mean=-10.0),
    ]


def stages_of(line: Driveline) -> Stages:
    return Stages.of(lower(assemble(line)).rhs_function)


def of_column(states: int, parameters: int, rates: Callable[[ca.SX, ca.SX], list[ca.SX]]) -> ca.Function:
    x, p = ca.SX.sym("x", states), ca.SX.sym("p", parameters)
    return ca.Function("f", [T, x, p], [ca.densify(ca.vertcat(*rates(x, p)))])


def assorted(x: ca.SX, p: ca.SX) -> list[ca.SX]:
    """Instances of masks, selections, clocks, numbers and functions; every value is used at two places or more."""
    n = x.numel()
    beyond = [x[k] > p[k] * 0.1 for k in range(n)]
    waves = [p[k] * ca.cos(p[k] * T) + ca.sin(p[k] * T) if k % 2 else ca.cos(p[k] * T) for k in range(n)]
    laws = [ca.atan2(x[k], p[k]) + (1 + 0.1 * k) * ca.if_else(beyond[k], x[k] ** 2, -ca.sqrt(p[k])) for k in range(n)]
    return [laws[k] - laws[k - 1] * waves[k] + ca.logic_and(beyond[k], beyond[k - 1]) * ca.exp(waves[k - 1]) for k in range(n)]


def long_sum(x: ca.SX, p: ca.SX) -> list[ca.SX]:
    total = ca.sum1(ca.vertcat(*(p[k] * ca.sin(x[k]) * x[k - 1] for k in range(x.numel()))))
    return [total * x[k] for k in range(x.numel())]


def recursion(x: ca.SX, p: ca.SX) -> list[ca.SX]:
    """Each value takes the one before it, and is a rate besides."""
    values = [x[0]]
    for k in range(1, x.numel()):
        values.append(ca.tanh(values[-1] * p[k]) + x[k])
    return values


@pytest.mark.usefixtures("compiled_here", "all_loops")
@pytest.mark.parametrize("lanes", [False, True])
def test_loops_compute_what_the_function_says(lanes: bool, tmp_path: Path) -> None:
    groups = assorted, long_sum, recursion
    function = of_column(120, 40, lambda x, p: [rate for k, of in enumerate(groups) for rate in of(x[40 * k : 40 * k + 40], p)])
    computed, rng = in_c(Stages.of(function), lanes, tmp_path), np.random.default_rng(1)
    for _ in range(20):
        t, x, p = rng.uniform(0, 1), rng.standard_normal(120), rng.uniform(0.5, 1.5, 40)
        expected, found = np.asarray(function(t, x, p)).reshape(3, 40), computed(t, x, p).reshape(3, 40)
        assert np.all(np.abs(found - expected).max(axis=1) <= 1e-13 * np.abs(expected).max(axis=1))


@pytest.mark.usefixtures("compiled_here", "all_loops")
@pytest.mark.parametrize("line", [branched(24), gears(16)], ids=lambda line: line.name)
@pytest.mark.parametrize("lanes", [False, True])
def test_drivelines_in_loops_are_those_of_the_virtual_machine(line: Driveline, lanes: bool, tmp_path: Path) -> None:
    model = lower(assemble(line))
    p, rng, n = model.parameters.vector(), np.random.default_rng(1), len(model.states) // 2
    computed = in_c(Stages.of(model.rhs_function), lanes, tmp_path)
    for _ in range(20):
        t, x = rng.uniform(0, 0.02), 1e-2 * rng.standard_normal(2 * n)
        expected, found = model.rhs(t, x, p).reshape(2, n), computed(t, x, p).reshape(2, n)
        assert np.all(np.abs(found - expected).max(axis=1) <= 1e-13 * np.abs(expected).max(axis=1))


@pytest.mark.usefixtures("all_loops")
@pytest.mark.parametrize("of", [chain, gears])
def test_more_instances_are_longer_tables_only(of: Callable[[int], Driveline]) -> None:
    """But for the ratios of a chain of gear pairs, which are products of all teeth before them: these stay in the parameters."""
    texts = [stage_functions(stages_of(of(count)), "v_").split("#define C(i)", 1)[1] for count in (30, 60)]
    assert texts[0].count("\n") == texts[1].count("\n")
    assert re.search(r"i < 2\d;", texts[0]) or re.search(r"i < 1[45];", texts[0])


@pytest.mark.usefixtures("all_loops")
def test_values_are_handed_over_in_the_order_in_which_loops_take_them() -> None:
    stages = stages_of(branched(60))
    placed = looped.arranged(stages)
    assert placed.parameter_values != stages.parameter_values
    assert sorted(placed.parameter_values) == sorted(stages.parameter_values)
    assert sorted(placed.time_values) == sorted(stages.time_values)
    text = stage_functions(stages, "s_").split("void state_stage(")[1]
    assert len(re.findall(r"\bC\([^()]*\bi\)", text)) > 5
    assert not re.search(r"\b[CW]\([^()]*\[i\]\)", text)


def test_what_is_small_is_printed_line_by_line() -> None:
    stages = stages_of(chain(5))
    printer = StagePrinter(stages, "v_", "V", Level.TIME, times=4)
    lines = looped.stage_function(printer, "stage", "const S *c, const V *t, V *w", stages.time, stages.time_values, "w")
    assert lines[0] == "static __attribute__((noinline, unused)) void stage(const S *c, const V *t, V *w) {"
    assert lines[2:-1] == [*printer.lines(stages.time), *printer.results(stages.time_values, "w")]


@pytest.mark.usefixtures("all_loops")
def test_a_function_is_of_bounded_length_where_nothing_is_alike() -> None:
    draw = random.Random(1)
    operations = (ca.sin, ca.exp, ca.tanh, ca.sqrt, ca.atan, ca.fabs)

    def rates(x: ca.SX, p: ca.SX) -> list[ca.SX]:
        values = []
        for k in range(300):
            value = x[k]
            for _ in range(8):
                value = draw.choice(operations)(value) * p[draw.randrange(300)]
            values.append(value)
        return values

    text = stage_functions(Stages.of(of_column(300, 300, rates)), "s_")
    lengths = [len(body.splitlines()) for body in text.split("static __attribute__")]
    assert max(lengths) <= looped.LONGEST_FUNCTION + 10
    assert len(re.findall(r"void state_stage_\d+\(", text)) >= 9


@pytest.mark.parametrize("rates", [assorted, long_sum, recursion])
def test_every_statement_comes_after_those_that_it_takes(rates: Callable[[ca.SX, ca.SX], list[ca.SX]]) -> None:
    stages = Stages.of(of_column(40, 40, rates))
    statements = statements_of(stages, stages.state, stages.outputs)
    order = [statement for run in scheduled(statements) for statement in run]
    assert sorted(order) == sorted(statements)
    kept, done = {value for statement in statements for value in statement.kept}, set()
    for statement in order:
        assert kept.isdisjoint(set(statement.leaves) - done)
        done.update(statement.kept)
    assert {statement.result for statement in order if statement.result is not None} == set(range(40))


def test_statements_are_of_bounded_size() -> None:
    stages = Stages.of(of_column(400, 400, long_sum))
    sizes = [len(statement.inner) for statement in statements_of(stages, stages.state, stages.outputs)]
    assert sum(sizes) == len([value for value in stages.state if not isinstance(stages.nodes[value].operation, str)])
    assert max(sizes) <= 2 * LARGEST


def test_a_recursion_is_one_loop() -> None:
    stages = Stages.of(of_column(40, 40, recursion))
    runs = scheduled(statements_of(stages, stages.state, stages.outputs))
    assert max(len(run) for run in runs) >= 38


def test_a_shape_waits_for_its_last_statements() -> None:
    def rates(x: ca.SX, p: ca.SX) -> list[ca.SX]:
        sources = [*(ca.exp(x[k]) for k in range(12)), *(ca.sin(ca.atan(x[k])) for k in range(12, 20))]
        return [*sources, *map(ca.tanh, sources)]  # twelve of these could be computed before the other eight

    stages = Stages.of(of_column(40, 1, rates))
    assert sorted(len(run) for run in scheduled(statements_of(stages, stages.state, stages.outputs))) == [8, 12, 20, 20]


def test_the_age_of_factors_does_not_tell_statements_apart() -> None:
    def rates(x: ca.SX, p: ca.SX) -> list[ca.SX]:
        sines = [ca.sin(x[k]) for k in range(20)]
        return [sines[k] * ca.exp(x[19 - k]) if k % 2 else ca.exp(x[19 - k]) * sines[k] for k in range(20)]

    stages = Stages.of(of_column(20, 1, rates))
    assert [len(run) for run in scheduled(statements_of(stages, stages.state, stages.outputs))] == [20]


def test_what_no_result_needs_is_left_out() -> None:
    stages = Stages.of(of_column(20, 20, assorted))
    statements = statements_of(stages, stages.state, stages.outputs[3:4])
    assert [statement.result for statement in statements if statement.result is not None] == [0]
    assert len({value for statement in statements for value, _ in statement.inner}) < len(stages.state) / 5


@pytest.mark.usefixtures("all_loops")
def test_observers_read_rates_too() -> None:
    x, v, p = ca.SX.sym("x", 20), ca.SX.sym("v", 20), ca.SX.sym("p", 20)
    text = observer_functions(Stages.of(ca.Function("f", [T, x, v, p], [p * x * v])))
    loop = re.search(r"for \(int i = 0; i < 20; \+\+i\) \{([^}]*)out\[i\] = ", text)
    assert loop
    assert all(leaf in loop[1] for leaf in ("x[i]", "v[i]", "C(i)"))
