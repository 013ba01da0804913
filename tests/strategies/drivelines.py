"""Drivelines as model files: inertias joined to a random tree, with loops, constraints over three flanges, ground and loads."""

from __future__ import annotations

from typing import Any

import tomli_w
from hypothesis import assume
from hypothesis import strategies as st

from modelgen import Driveline, ModelgenError
from modelgen.model.files import parse_model
from strategies.elements import element_tables, kinds

LARGEST = 6


@st.composite
def topologies(
    draw: st.DrawFn, largest: int = LARGEST
) -> tuple[int, tuple[tuple[int, int], ...], tuple[tuple[int, int, int], ...]]:
    """A count of inertias, pairs that join them (a tree and up to two loops), and triples for joints of three flanges."""
    count = draw(st.integers(1, largest))
    pairs = [(draw(st.integers(0, node - 1)), node) for node in range(1, count)]
    other = st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)).filter(lambda pair: pair[0] != pair[1])
    if count > 1:
        pairs += draw(st.lists(other, max_size=2) if draw(st.booleans()) else st.just([]))
    triples: list[tuple[int, ...]] = []
    if count > 2 and draw(st.booleans()):
        triples = draw(st.lists(st.permutations(range(count)).map(lambda row: tuple(row[:3])), min_size=1, max_size=2))
    return count, tuple(pairs), tuple(triples)  # type: ignore[return-value]  # three of each


@st.composite
def model_tables(draw: st.DrawFn, largest: int = LARGEST) -> dict[str, Any]:
    """The tables of a model file. Each value is lawful by its declaration; together they need not be (locked gears)."""
    count, pairs, triples = draw(topologies(largest))
    disks = [f"disk_{number}" for number in range(1, count + 1)]
    data: dict[str, Any] = {"format": 1, "name": "drawn", "operation": draw(_operations(disks, bool(triples)))}
    bases = ("firing",) if "speed" in data["operation"] else ()
    if bases:
        order = draw(st.sampled_from([1, 2, "1/2", "5/3"]))
        data["bases"] = {"firing": {"order": order, "shaft": draw(st.sampled_from(disks))}}
    elements: dict[str, Any] = {}
    joined: list[tuple[str, ...]] = [(disk,) for disk in disks]
    for disk in joined:
        elements[disk[0]] = {key: value for key, value in draw(element_tables("inertia", disk)).items() if key != "flange"}
    one_flange = tuple(kind for kind in kinds(1) if kind != "inertia")
    lone = draw(st.lists(st.integers(0, count - 1), max_size=3))
    tree, loops = pairs[: count - 1], pairs[count - 1 :]
    elastic = tuple(kind for kind in kinds(2) if "gear" not in kind) * 4 + kinds(2)  # gears that close a loop seldom agree
    groups = ((tree, kinds(2)), (loops, elastic), (triples, kinds(3)), ([(node,) for node in lone], one_flange))
    for flanges, choices in groups:
        for nodes in flanges:
            kind = draw(st.sampled_from(choices))
            elements[f"{kind}_{len(elements)}"] = draw(element_tables(kind, tuple(disks[node] for node in nodes), bases))
    order = draw(st.permutations(list(elements)))
    data["elements"] = {name: elements[name] for name in order}
    loads = [name for name, table in elements.items() if table["kind"] == "harmonic_torque"]
    if loads and draw(st.booleans()):
        data["operation"]["balance"] = [draw(st.sampled_from(loads))]
    return data


@st.composite
def _operations(draw: st.DrawFn, disks: list[str], joint: bool) -> dict[str, Any]:
    """The operating point: mostly one that need not balance, with one speed, several, or none."""
    operation: dict[str, Any] = {"drifts": draw(st.sampled_from([True, True, True, False]))}
    form = draw(st.sampled_from(["one", "one", "none", *(["several"] * 2 if joint else [])]))
    if form != "none":
        operation.update(speed=f"{draw(st.integers(100, 6000))} rpm", reference=draw(st.sampled_from(disks)))
    if form == "several":
        operation["speeds"] = {draw(st.sampled_from(disks)): draw(st.sampled_from([0, "300 rpm", "-20 rad/s"]))}
    return operation


def model_texts(largest: int = LARGEST) -> st.SearchStrategy[str]:
    """Model files as text."""
    return model_tables(largest).map(tomli_w.dumps)


@st.composite
def drivelines(draw: st.DrawFn, largest: int = LARGEST) -> Driveline:
    """Drivelines that can be read."""
    try:
        return parse_model(draw(model_texts(largest)))
    except ModelgenError:
        assume(False)
        raise
