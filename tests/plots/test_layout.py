from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from modelgen.drivelines import load
from modelgen.elements import Inertia, RigidGear, Shaft
from modelgen.equations import Equations, assemble
from modelgen.model import Driveline, Element
from modelgen.plots.layout import LONGEST, layout


def names(equations: Equations, nodes: tuple[int, ...]) -> list[str]:
    return [equations.nodes[node].name for node in nodes]


def test_truck_lines_hang_below_each_other_at_their_gears() -> None:
    equations = assemble(load("fracturing-truck"))
    found = layout(equations)
    assert [len(row.nodes) for row in found.rows] == [9, 2, 5]
    at = {equations.nodes[node].name: place for node, place in found.place.items()}
    assert at["damper"] == (0, 0)
    assert at["flywheel"] == (7, 0)
    for driving, driven in (("converter_gear", "output_gear"), ("pump_pinion", "bull_gear")):
        assert at[driving][0] == at[driven][0]
        assert at[driven][1] == at[driving][1] + 1
    assert names(equations, found.rows[2].nodes) == ["bull_gear", "pump_throw_1", "pump_throw_2", "pump_throw_3", "pump_free_end"]
    assert found.columns == 9


def test_branch_gets_a_row_of_its_own(results: Any) -> None:
    equations = results.case.model.equations
    found = layout(equations)
    assert [(names(equations, row.nodes), row.kind) for row in found.rows] == [
        (["fan", "engine", "alternator"], ""),
        (["pinion"], "shaft"),
        (["wheel", "pump"], "gear"),
    ]


def test_long_line_is_folded_and_goes_on_below() -> None:
    count = 2 * LONGEST + 3
    disks = [Inertia(f"disk_{k}", inertia=1.0) for k in range(count)]
    shafts = [Shaft(f"shaft_{k}", f"disk_{k}", f"disk_{k + 1}", stiffness=1e4) for k in range(count - 1)]
    found = layout(assemble(Driveline("chain", elements=[*disks, *shafts])))
    assert [row.kind for row in found.rows] == ["", "fold", "fold"]
    assert found.columns == LONGEST
    for row in found.rows[1:]:
        assert row.hangs_from is not None
        column, level = found.place[row.hangs_from]
        assert found.place[row.nodes[0]] == (column, level + 1)


def random_tree(rng: np.random.Generator, count: int) -> Driveline:
    """Disks joined at random by shafts and rigid gears, without a loop."""
    elements: list[Element] = [Inertia("disk_0", inertia=1.0)]
    for k in range(1, count):
        elements.append(Inertia(f"disk_{k}", inertia=float(rng.uniform(0.1, 9))))
        other = f"disk_{rng.integers(max(0, k - 6), k)}"
        ends = [f"disk_{k}", other] if rng.random() < 0.5 else [other, f"disk_{k}"]
        if rng.random() < 0.3:
            elements.append(RigidGear(f"gear_{k}", *ends, teeth_a=int(rng.integers(18, 90)), teeth_b=int(rng.integers(18, 90))))
        else:
            elements.append(Shaft(f"shaft_{k}", *ends, stiffness=1e4))
    return Driveline("tree", elements=elements)


@pytest.mark.parametrize("count", [1, 2, 5, 9, 17, 30])
def test_every_node_has_a_place_of_its_own(count: int, rng: np.random.Generator) -> None:
    equations = assemble(random_tree(rng, count))
    found = layout(equations)
    assert sorted(found.place) == list(range(len(equations.nodes)))
    assert len(set(found.place.values())) == len(found.place)
    assert min(column for column, _ in found.place.values()) == 0
    assert min(level for _, level in found.place.values()) == 0
    assert sorted(node for row in found.rows for node in row.nodes) == sorted(found.place)
    assert layout(equations) == found
