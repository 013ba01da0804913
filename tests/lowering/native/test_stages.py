"""Staging: what moves to which stage, and that it means the same."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import LoweringError
from modelgen.lowering.native.functions import stage_functions
from modelgen.lowering.native.graph import Graph, Level
from modelgen.lowering.native.stages import Stages

T, X, P = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 4)


def staged(*rates: ca.SX) -> Stages:
    return Stages.of(ca.Function("f", [T, X, P], [ca.vertcat(*rates)]))


def count(stages: Stages, stage: str, code: int) -> int:
    return sum(stages.nodes[index].operation == code for index in getattr(stages, stage))


def test_each_value_stands_in_the_earliest_stage_that_can_compute_it() -> None:
    stages = staged(ca.exp(P[0]) * ca.tanh(P[0] * T) * ca.atan(X[0]), X[0] + P[1])
    assert [count(stages, stage, ca.OP_EXP) for stage in ("parameter", "time", "state")] == [1, 0, 0]
    assert [count(stages, stage, ca.OP_TANH) for stage in ("parameter", "time", "state")] == [0, 1, 0]
    assert [count(stages, stage, ca.OP_ATAN) for stage in ("parameter", "time", "state")] == [0, 0, 1]
    assert len(stages.time_values) == 1


def test_a_model_without_a_stage_pays_nothing_for_it() -> None:
    stages = staged(X[1], -X[0])
    assert stages.parameter == stages.time == stages.parameter_values == stages.time_values == ()
    text = stage_functions(stages, "v_")
    assert "#define NC 0" in text
    assert "#define NW 0" in text


def test_a_division_by_a_parameter_leaves_the_state_stage() -> None:
    stages = staged(X[0] / P[0], X[1] / P[0])
    assert count(stages, "parameter", ca.OP_INV) == 1
    assert count(stages, "state", ca.OP_DIV) == 0


def test_factors_of_parameters_are_gathered_before_the_state() -> None:
    assert count(staged(P[0] * (P[1] * (P[2] * X[0])), X[1]), "state", ca.OP_MUL) == 1


def test_equal_values_are_one() -> None:
    one, other = ca.sin(X[0] * X[1]), ca.sin(X[1] * X[0])
    assert count(staged(one + X[0], other + X[1]), "state", ca.OP_SIN) == 1


def test_a_row_of_phased_waves_costs_one_product_per_wave() -> None:
    angle, orders = P[0] * T, range(1, 9)
    s, c = [ca.sin(angle)], [ca.cos(angle)]
    for order in orders[1:]:  # angle addition of two halves
        a, b = order // 2 - 1, order - order // 2 - 1
        s.append(s[a] * c[b] + c[a] * s[b])
        c.append(c[a] * c[b] - s[a] * s[b])
    row = sum(P[1] * (ca.cos(k * P[2]) * c[k - 1] - ca.sin(k * P[2]) * s[k - 1]) for k in orders)
    stages = staged(row * X[0], X[1])
    products = count(stages, "time", ca.OP_MUL) + count(stages, "time", ca.OP_SQ)
    assert products <= 4 * len(orders) + 2 * len(orders)  # an angle addition makes a harmonic by four products
    assert count(stages, "time", ca.OP_SIN) == 1


def test_an_operation_without_c_is_refused_by_name() -> None:
    with pytest.raises(LoweringError, match="operation OP_ERFINV has no C; run this model on CasADi's virtual machine"):
        staged(ca.erfinv(X[0]), X[1])


def test_a_function_that_is_not_written_out_is_refused() -> None:
    t, x, p = ca.MX.sym("t"), ca.MX.sym("x"), ca.MX.sym("p")
    with pytest.raises(LoweringError, match=r"no SX function; expand\(\) it first"):
        Stages.of(ca.Function("f", [t, x, p], [x * p]))


def test_levels_follow_the_operands() -> None:
    graph = Graph.of(ca.Function("f", [T, X, P], [ca.vertcat(P[0] + P[1], P[0] + T + X[0])]))
    assert [graph.nodes[output].level for output in graph.outputs] == [Level.PARAMETER, Level.STATE]


def test_numbers_are_printed_digit_for_digit() -> None:
    value = float(np.nextafter(0.1, 1))
    assert repr(value) in stage_functions(staged(X[0] + value, X[1]), "s_")
