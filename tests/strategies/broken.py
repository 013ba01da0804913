"""Model files that are spoiled: values, keys and tables of a lawful one changed, then perhaps its text."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import tomli_w
from hypothesis import strategies as st

from strategies.drivelines import model_tables

LAWFUL_EXTREMES = (5e-324, 1e-308, 1e-160, 1e-30, 1e-12, 1e12, 1e18, 1e30, 1e160, 1e300, 1e308, 1.7976931348623157e308)
EXTREMES = (
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    1e-308,
    1e-160,
    1e18,
    1e160,
    1e300,
    1e308,
    -1e308,
    float("nan"),
    float("inf"),
    -float("inf"),
)
WHOLE = (0, 1, -1, 2**31, 2**63, -(2**63), 10**40, 10**400)
TEXTS = (
    "",
    " ",
    "ü",
    "µ",
    "零",
    "a" * 5000,
    "\u202e",
    "disk_1",
    "disk_1.flange",
    "disk_99",
    "nan",
    "inf N*m",
    "1e400 N*m",
    "1 banana",
    "1e308 kg*m^2",
    "5e-324 kg*m^2",
    "1e18 N*m/rad",
    "-3 N*m/rad",
    "0 N*m/rad",
    "1 N*m/rad/rad/rad",
    "1 N*m/",
    "1 **",
    "((",
    "1e5e5 s",
    "__import__('os').system('true')",
    "1/0",
    "9**9**9",
    "zeta",
    "90 deg",
    "0 rpm",
    "-100 rpm",
    "1e300 rpm",
    "1 degC",
    "1e-320 rad",
)
SHAPES: tuple[Any, ...] = (True, False, [], {}, [[]], [{}], {"value": 1.0}, {"unit": "N*m", "values": []}, {"values": [1.0, "x"]})
NAMES = (
    "kind",
    "name",
    "format",
    "stifness",
    "speed",
    "total",
    "time",
    "int",
    "a b",
    "ü",
    "",
    "a" * 300,
    "con",
    "_x",
    "x.y",
    "modal",
)
TAILS = (
    '[elements.disk_1]\nkind = "inertia"\ninertia = "1 kg*m^2"\n',
    "\n[[[",
    "x = {",
    "= 1",
    "\x00",
    "\ufeff",
    "x = nan",
    "a" + ".a" * 3000 + " = 1",
    "x = " + "[" * 500 + "]" * 500,
    "x = " + "{a = " * 40 + "1" + "}" * 40,
    "x = 1979-05-27",
    "x = " + "9" * 5000,
    "[limits]\n",
    '[parameters]\np = { expression = "1/0" }\n',
    '[parameters]\np = { expression = "9**9**9" }\n',
    '[parameters]\np = { expression = "p" }\n',
    '[parameters]\na = { expression = "b" }\nb = { expression = "a" }\n',
    '[parameters]\np = { expression = "sqrt(-1)" }\n',
    '[parameters]\np = { expression = "exp(1e9)" }\n',
    "[defaults.shaft]\nzeta = 3\n",
    '[[limits]]\nrule = "none"\n',
    '[assemblies]\nx = ["disk_77"]\n',
)

hostile_values = st.one_of(
    *(st.sampled_from(each) for each in (EXTREMES, WHOLE, TEXTS)),
    st.sampled_from(SHAPES).map(copy.deepcopy),  # the tables are changed further
    st.text(max_size=20),
)


def places(table: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The paths of all entries of nested tables and lists."""
    entries = table.items() if isinstance(table, dict) else enumerate(table) if isinstance(table, list) else ()
    for key, value in entries:
        yield (*path, key)
        yield from places(value, (*path, key))


def _at(data: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        data = data[key]
    return data


def _is_quantity(value: Any) -> bool:
    return isinstance(value, float) or (isinstance(value, str) and value[:1] in "-0123456789" and " " in value)


def _extreme(draw: st.DrawFn, value: Any) -> Any:
    """The same quantity, unit kept, of a size that no machine has; anything for what is none."""
    sizes = st.sampled_from(LAWFUL_EXTREMES if draw(st.integers(0, 3)) else EXTREMES)
    if isinstance(value, str) and " " in value:
        return f"{draw(sizes)!r} {value.split(' ', 1)[1]}"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return draw(st.one_of(sizes, st.sampled_from(WHOLE[:-1])))
    return draw(hostile_values)


@st.composite
def spoiled_tables(draw: st.DrawFn, largest: int = 4) -> dict[str, Any]:
    """The tables of a model file after one to three changes: a value, a key, a missing entry, a swapped pair."""
    data = copy.deepcopy(draw(model_tables(largest)))
    for _ in range(draw(st.sampled_from([1, 1, 1, 2, 3]))):
        change = draw(st.sampled_from(["extreme"] * 8 + ["value", "drop", "rename", "copy", "swap"]))
        paths = list(places(data))
        if change == "extreme":  # of a quantity
            paths = [path for path in paths if _is_quantity(_at(data, path))] or paths
        if not paths:
            break
        path = draw(st.sampled_from(paths))
        owner, key = _at(data, path[:-1]), path[-1]
        if change == "extreme":
            owner[key] = _extreme(draw, owner[key])
        elif change == "value":
            owner[key] = draw(hostile_values)
        elif change == "drop":
            del owner[key]
        elif change == "rename" and isinstance(owner, dict):
            owner[draw(st.sampled_from(NAMES))] = owner.pop(key)
        elif change == "copy" and isinstance(owner, dict):
            owner[draw(st.sampled_from(NAMES))] = copy.deepcopy(owner[key])
        else:
            owner[key] = copy.deepcopy(_at(data, draw(st.sampled_from(paths))))
    return data


@st.composite
def broken_texts(draw: st.DrawFn, largest: int = 4) -> str:
    """The text of a spoiled model file: mostly of changed tables, at times cut, doubled, or with a tail that does not belong."""
    text = tomli_w.dumps(draw(spoiled_tables(largest)))
    form = draw(st.sampled_from(["as it is"] * 7 + ["tail", "head", "cut", "line twice", "line away"]))
    lines = text.splitlines(keepends=True)
    if form == "tail":
        return text + draw(st.sampled_from(TAILS))
    if form == "head":
        return draw(st.sampled_from(TAILS)) + "\n" + text
    if form == "cut":
        return text[: draw(st.integers(0, len(text)))]
    if form in ("line twice", "line away"):
        number = draw(st.integers(0, len(lines) - 1)) if lines else 0
        lines[number : number + 1] = lines[number : number + 1] * 2 if form == "line twice" else []
        return "".join(lines)
    return text
