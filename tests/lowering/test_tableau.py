"""Methods as data: every coefficient is believed only by the order conditions."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from modelgen.errors import LoweringError
from modelgen.lowering.methods import FOLDER, read_tableau, tableau_from
from modelgen.lowering.rooted_trees import check_orders, density, nodes_of, rooted_trees
from modelgen.lowering.tableau import Tableau, doubled

NAMES = sorted(path.stem for path in FOLDER.glob("*.toml"))
METHODS = [*map(read_tableau, NAMES), doubled(read_tableau("rk4")), doubled(read_tableau("rk4"), extrapolate=False)]
FIELDS = ("c", "a", "b", "errors", "dense", "extra_c", "extra_a")


def test_the_methods_there_are() -> None:
    assert NAMES == ["dop853", "dopri5", "rk4", "verner65"]
    assert [(each.order, each.stages) for each in METHODS] == [(8, 12), (5, 6), (4, 4), (6, 8), (5, 11), (4, 11)]
    assert [each.control for each in METHODS if each.errors] == [8, 5, 6, 5, 5]


def test_trees_by_hand() -> None:
    bushy, tall = rooted_trees(3)  # two leaves on a root; a chain
    assert sorted([(nodes_of(tree), density(tree)) for tree in (bushy, tall)]) == [(3, 3), (3, 6)]
    assert sum(len(rooted_trees(size)) for size in range(1, 9)) == 200


@pytest.mark.parametrize("method", METHODS, ids=lambda each: each.name)
def test_all_order_conditions_hold(method: Tableau) -> None:
    check_orders(method)


@pytest.mark.parametrize("method", METHODS, ids=lambda each: each.name)
def test_no_higher_order_is_claimed_than_there_is(method: Tableau) -> None:
    for field in ("order", "dense_order"):
        if field == "order" or method.dense:
            with pytest.raises(LoweringError, match="the condition of order"):
                check_orders(replace(method, **{field: getattr(method, field) + 1}))
    if method.errors:
        with pytest.raises(LoweringError, match="errors, row 0: the condition of order"):
            check_orders(replace(method, error_orders=tuple(order + 1 for order in method.error_orders)))


def places(method: Tableau) -> list[tuple[str, int, int]]:
    """Every number of a tableau that is not zero or one by its layout: field, row, column (-1: no rows)."""
    found = []
    for field in FIELDS:
        for row, entry in enumerate(getattr(method, field)):
            if isinstance(entry, Fraction):
                found.append((field, row, -1))
            else:
                found += [(field, row, column) for column, value in enumerate(entry) if value]
    return found[1:]  # but for c_0, which is zero


@pytest.mark.parametrize("name", NAMES)
def test_a_changed_digit_is_refused(name: str) -> None:
    method = read_tableau(name)
    rng = np.random.default_rng(5)
    chosen = places(method)
    for index in rng.choice(len(chosen), min(len(chosen), 40), replace=False).tolist():
        field, row, column = chosen[index]
        values = [each if isinstance(each, Fraction) else list(each) for each in getattr(method, field)]
        if column < 0:
            values[row] += Fraction(1, 10**9)
        else:
            values[row][column] += Fraction(1, 10**9)
        with pytest.raises(LoweringError, match=r"adds up to|the condition of order"):
            check_orders(replace(method, **{field: tuple(tuple(v) if isinstance(v, list) else v for v in values)}))


def test_dense_output_ends_where_the_step_ends() -> None:
    for method in METHODS:
        if method.dense:
            ends = np.array([float(sum(row)) for row in method.dense])
            expected = np.zeros(len(ends))
            expected[: method.stages] = [float(weight) for weight in method.b]
            assert ends == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"b": ["1/2"]}, r"c has 2 entries, wanted are 1"),
        ({"a": [[], ["1/2", "0"]]}, r"a has \[0, 2\] entries, wanted are \[0, 1\]"),
        ({"a": [[], ["1/3"]]}, r"row 1 adds up to 0.3333\d+, its node is 0.5"),
        ({"errors": [["1", "-1"]], "error_orders": [1]}, r"errors has \[2\] entries"),
    ],
)
def test_a_file_out_of_shape_is_refused(change: dict[str, object], words: str) -> None:
    midpoint = {"name": "midpoint", "description": "-", "order": 2, "c": ["0", "1/2"], "a": [[], ["1/2"]], "b": ["0", "1"]}
    check_orders(tableau_from(midpoint))
    with pytest.raises(LoweringError, match=f"method 'midpoint': {words}"):
        tableau_from(midpoint | change)


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(LoweringError, match=r"none named 'dopri6'; nearest is 'dopri5'"):
        read_tableau("dopri6")
