"""Command lines drawn from what the commands themselves declare: arguments, options, their types and choices, lawful and not."""

from __future__ import annotations

import click
from hypothesis import strategies as st

from modelgen.cli.commands import commands

HOSTILE = (
    "",
    " ",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "-1",
    "0",
    "5e-324",
    "1e308",
    "99999999999999999999",
    "1e9 rpm",
    "-3 rpm",
    "0 rpm",
    "ü",
    "零",
    "a" * 4000,
    "a=b",
    "=",
    "x=",
    "coupling.stiffness=1e308 N*m/rad",
    "coupling.stiffness=5e-324 N*m/rad",
    "motor.inertia=nan",
    "coupling.stiffness=-1 N*m/rad",
    "zeta=1e300",
    "speed=0:1:2",
    "zeta=0:0.05:99999999999",
    "zeta=a:b:c",
    "zeta=",
    "zeta=::",
    "../..",
    "/dev/null",
    "/",
    ".",
    "\t",
    "\n",
    "--",
    "-h",
    "__import__('os')",
    "$(true)",
    "%s%n",
    "no.such.channel",
    "motor.speed",
    "a\x7fb",
)
LAWFUL = {
    "speed": ("1500 rpm", "100 rad/s"),
    "assignments": ("zeta=0.1", "coupling.stiffness=21 kN*m/rad", "motor.inertia=0.4 kg*m^2"),
    "tolerance": ("1e-4", "1e-6"),
    "tolerances": ("1e-4", "1e-5"),
    "max_seconds": ("1", "2"),
    "channels": ("coupling.torque", "motor.speed"),
    "channel": ("coupling.torque", "coupling.twist"),
    "collect": ("coupling.torque.highest", "steps"),
    "count": ("3", "4"),
    "workers": ("0",),
    "solver": ("rk4", "dopri5", "cvodes"),
    "solvers": ("rk4,dopri5", "cvodes"),
    "crosscheck": ("none",),
    "damping": ("per_shaft", "modal"),
    "mesh_damping": ("corrected", "literal"),
    "base": ("motor_order",),
    "shaft": ("motor",),
    "mesh": ("mesh",),
    "surface": ("coupling.torque",),
    "end": ("0.02 s", "0.05 s"),
    "step": ("1e-4 s",),
    "misfire": ("drive",),
    "kind": ("shaft", "gear_pair"),
    "name": ("drawn",),
    "diameter": ("coupling=40 mm",),
}
"""Values that a small model takes, by the name of the parameter; others are drawn from their type."""

PAIRS = {
    "window": ("0 s", "0.02 s"),
    "over": ("zeta", "0.05", "0.1"),
    "ranges": ("zeta=0.05:0.1:2",),
    "first": ("zeta", "0.05", "0.1"),
    "second": ("speed", "1400 rpm", "1500 rpm"),
    "speeds": ("1000 rpm", "1500 rpm"),
    "operating": ("1200 rpm", "1500 rpm"),
}
"""Ranges, by the name of the parameter."""

LONG = ("reproduce",)  # takes minutes whatever it is asked: its lawful lines stand in tests of their own


def of_type(parameter: click.Parameter, words: tuple[str, ...] = ()) -> st.SearchStrategy[str]:
    """Texts that the type of an argument or option takes, mostly lawful."""
    kind = parameter.type
    if words:
        return st.sampled_from(words)
    if isinstance(kind, click.Choice):
        return st.sampled_from([str(each) for each in kind.choices])
    if isinstance(kind, click.IntRange):
        least = int(kind.min or 0)
        return st.integers(least, least + 2).map(str)
    if isinstance(kind, click.types.IntParamType):
        return st.integers(0, 3).map(str)
    if isinstance(kind, (click.FloatRange, click.types.FloatParamType)):
        return st.sampled_from(["0.5", "1e-3", "1"])
    return st.sampled_from(["0.1", "0.01 s", "0.05 s", "1500 rpm", "zeta"])


@st.composite
def command_lines(draw: st.DrawFn, models: tuple[str, ...], folder: str) -> list[str]:
    """A command with arguments and options; ``models`` are paths of model files, ``folder`` is where it may write.

    A run that is lawful is a short one. About two lines in three hold something hostile.
    """
    name = draw(st.sampled_from([each for each in commands.commands if each not in LONG] * 8 + list(LONG)))
    odds = draw(st.sampled_from([0, 8, 4])) if name not in LONG else 1
    line = [name]
    for parameter in commands.commands[name].params:
        line += draw(_given(parameter, models, folder, odds))
    form = draw(st.sampled_from(["as it is"] * 6 + (["unknown", "twice", "short"] if odds else [])))
    if form == "unknown":
        line.insert(draw(st.integers(0, len(line))), draw(st.sampled_from(["--no-such", "--sett", "-x", "--help=3", "extra"])))
    if form == "twice":
        line += line[-2:]
    if form == "short":
        line = line[: draw(st.integers(0, len(line)))]
    return line


@st.composite
def _given(draw: st.DrawFn, parameter: click.Parameter, models: tuple[str, ...], folder: str, odds: int) -> list[str]:
    """The words of one argument or option; one in ``odds`` is hostile, none where that is zero."""
    assert parameter.name is not None
    if isinstance(parameter, click.Argument) and parameter.name not in LAWFUL:
        values = draw(st.lists(st.sampled_from(models), min_size=1, max_size=1))
    elif not (parameter.required or parameter.name in ("max_seconds", "crosscheck", "window") or not draw(st.integers(0, 3))):
        return []
    elif getattr(parameter, "is_flag", False):
        return [parameter.opts[0]]
    elif parameter.name == "out":
        values = [folder]
    elif parameter.name in PAIRS:
        values = list(PAIRS[parameter.name])
    else:
        texts = of_type(parameter, LAWFUL.get(parameter.name, ()))
        values = draw(st.lists(texts, min_size=max(parameter.nargs, 1), max_size=max(parameter.nargs, 1)))
    values = [draw(st.sampled_from(HOSTILE)) if odds and not draw(st.integers(0, odds)) else value for value in values]
    return values if isinstance(parameter, click.Argument) else [parameter.opts[0], *values]
