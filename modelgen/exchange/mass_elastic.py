"""Mass-elastic tables, as engine and coupling makers hand them over: one row per inertia, read as a driveline.

Part of ``exchange``. ``equivalent_system`` writes such tables. Source of the
form: W. Ker Wilson, Practical Solution of Torsional Vibration Problems, vol. 1 (equivalent systems).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

from modelgen.elements import GroundDamper, GroundSpring, Inertia, RigidGear, Shaft
from modelgen.errors import ModelFileError, ModelgenError, nearest
from modelgen.exchange.delimited_text import DelimitedText, Row, find_columns, further_columns, read_delimited
from modelgen.model import Driveline, Element, NamedParameter
from modelgen.model.names import identifier

COLUMNS = {
    "name": ("part", "mass", "description"),
    "J": ("inertia", "moment of inertia"),
    "J referred": ("J ref",),
    "k": ("stiffness", "torsional stiffness"),
    "k referred": ("k ref",),
    "diameter": ("d", "shaft diameter"),
    "ratio": ("speed ratio", "r"),
    "damping": ("c",),
    "damping referred": ("c referred", "c ref"),
    "to": ("joined to",),
    "shaft": ("shaft name",),
}
UNITS = {"J": "kg*m^2", "k": "N*m/rad", "damping": "N*m*s/rad", "diameter": "m"}
GROUND = "ground"
LARGEST_DENOMINATOR = 20  # of a ratio written as a decimal: 1.25 is 5/4, but 1.769 is a rounded 23/13
LARGEST_TEETH = 10**6


@dataclass(frozen=True)
class Entry:
    """One inertia of the table [kg*m^2, on its own shaft], its speed per speed of the reference shaft, and where it stands."""

    name: str
    title: str
    row: Row
    inertia: float
    ratio: Fraction


@dataclass(frozen=True)
class Connection:
    """What joins an entry to another one, or to ground (``end`` None): stiffness [N*m/rad] and damping on the start's shaft."""

    start: Entry
    end: Entry | None
    row: Row
    name: str
    stiffness: float | None
    damping: float | None


def read_mass_elastic(path: str | Path, name: str) -> Driveline:
    """The driveline in a mass-elastic table. Raises ModelFileError or UnitError with file, line and column.

    Columns: ``name``, ``J [kg*m^2]``, ``k [N*m/rad]`` (stiffness from this row to the next, on this row's shaft; empty in the
    last row). Optional: ``ratio`` (speed per speed of the reference shaft, as a fraction of tooth numbers such as 26/46),
    ``diameter [mm]`` (kept as parameter SHAFT_diameter), ``damping [N*m*s/rad]`` (or ``damping [1]``, the ratio of the local
    two-disk mode), ``shaft`` (its name), ``to`` (the row that this one joins, or ``ground``; with this column a row joins
    something only if it has ``to`` or ``k``, and a repeated name without J adds a connection).

    J, k and damping are those of each shaft. As ``J_referred`` and ``k_referred`` (both, then) they are referred to the
    reference shaft and are divided by ratio^2. Where the ratio changes between joined rows a rigid gear follows the shaft; with
    k empty, the two rows are its wheels. Further columns, such as remarks, are left out; the driveline's description names them.
    Every ratio counts as positive: angles count forward on each shaft.
    """
    reader = _Reader(read_delimited(path))
    try:
        return reader.driveline(name)
    except ModelgenError as error:
        if error.where.startswith(reader.table.source):
            raise
        raise ModelFileError(f"{reader.table.source}, {error.where}", error.problem, error.remedy) from None


class _Reader:
    def __init__(self, table: DelimitedText) -> None:
        self.table = table
        found = find_columns(table, COLUMNS)
        self.further = further_columns(table, found)
        self.referred = "J referred" in found
        for key in ("J", "k", "damping"):
            wanted, other = (f"{key} referred", key) if self.referred else (key, f"{key} referred")
            if other in found and not (key == "damping" and found[other].unit in ("", "1")):
                what = f"stands beside {'referred' if self.referred else 'physical'} inertias"
                raise ModelFileError(table.at(None, found[other]), what, "refer J, k and damping to one shaft, or none of them")
            if wanted in found:
                found[key] = found[wanted]
        for key, form in (("name", "name"), ("J", "J [kg*m^2]"), ("k", "k [N*m/rad]")):
            if key not in found:
                held = ", ".join(repr(column.name) for column in table.columns)
                raise ModelFileError(table.at(None), f"has no column {key!r}, it has {held}", f"write {form} in the header")
        self.columns = found
        self.damps_by_ratio = "damping" in found and found["damping"].unit in ("", "1")
        units = {key: "1" if key == "damping" and self.damps_by_ratio else unit for key, unit in UNITS.items()}
        self.factors = {key: table.factor(found[key], unit) for key, unit in units.items() if key in found}
        self.entries = self._entries()

    def refuse(self, row: Row, key: str, problem: str, remedy: str) -> ModelFileError:
        return ModelFileError(self.table.at(row, self.columns.get(key)), problem, remedy)

    def text(self, row: Row, key: str) -> str:
        return self.table.cell(row, self.columns[key]) if key in self.columns else ""

    def number(self, row: Row, key: str, zero: bool = False) -> float | None:
        """SI value of a cell, None for an empty one; refused when it is negative, or zero unless that is lawful."""
        if not self.text(row, key):
            return None
        value = self.table.number(row, self.columns[key])
        if value < 0 or (value == 0 and not zero):
            remedy = "give zero or a positive value" if zero else "give a positive value"
            raise self.refuse(row, key, f"is {self.text(row, key)}", remedy)
        return value * self.factors[key]

    def lawful(self, row: Row, key: str) -> str:
        """The name in a cell as elements may have it: what is no letter, digit or underscore becomes an underscore."""
        text = self.text(row, key)
        words = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_")
        if not words:
            what = f"{text!r} cannot be a name" if text else "is empty"
            raise self.refuse(row, key, what, "write a name of letters and digits")
        words = f"n{words}" if words[0].isdigit() else words
        return identifier(words[:63].rstrip("_"), self.table.at(row, self.columns[key]))

    # -- rows ------------------------------------------------------------------------------------------------------------------

    def _entries(self) -> dict[str, Entry]:
        found: dict[str, Entry] = {}
        for row in self.table.rows:
            name, title = self.lawful(row, "name"), self.text(row, "name")
            inertia = self.number(row, "J")
            if name.lower() == GROUND:
                raise self.refuse(row, "name", f"is {title!r}, which is where no shaft turns", "choose another name")
            if name in found:
                if inertia is not None or not self.text(row, "to"):
                    what = f"{title!r} is taken by line {found[name].row.line}"
                    raise self.refuse(row, "name", what, "rename one of them; a further connection of a row has no J, and 'to'")
                continue
            if inertia is None:
                raise self.refuse(row, "J", "is empty", "give the moment of inertia")
            ratio = self.ratio(row)
            found[name] = Entry(name, title, row, inertia / float(ratio) ** 2 if self.referred else inertia, ratio)
        return found

    def ratio(self, row: Row) -> Fraction:
        """Speed per speed of the reference shaft, exactly."""
        text = self.text(row, "ratio")
        if "ratio" not in self.columns:
            return Fraction(1)
        if not text:
            raise self.refuse(row, "ratio", "is empty", "give the speed per speed of the reference shaft, which has 1")
        parts = re.fullmatch(r"(\d{1,9})\s*[/:]\s*(\d{1,9})", text, re.ASCII)
        if parts and int(parts[1]) and int(parts[2]):
            return Fraction(int(parts[1]), int(parts[2]))
        if parts or self.table.number(row, self.columns["ratio"]) <= 0:
            advice = "give a positive ratio such as 26/46: angles count forward on every shaft"
            raise self.refuse(row, "ratio", f"is {text}", advice)
        exact = Fraction(text.replace(",", "."))
        if exact.denominator > LARGEST_DENOMINATOR:
            advice = f"write it as a fraction of tooth numbers, perhaps {exact.limit_denominator(120)}"
            raise self.refuse(row, "ratio", f"{text} is a decimal, but teeth are whole numbers", advice)
        return exact

    def connections(self) -> Iterator[Connection]:
        own = list(self.entries.values())
        after = {entry.row.line: following for entry, following in pairwise(own)}
        for row in self.table.rows:
            start, target, k = self.entries[self.lawful(row, "name")], self.text(row, "to"), self.text(row, "k")
            end = after.get(row.line)
            if target:
                end = None if target.lower() == GROUND else self.entries.get(self.lawful(row, "to"))
                if end is None and target.lower() != GROUND:
                    known = [*(each.title for each in own), GROUND]
                    raise self.refuse(row, "to", f"there is no row {target!r}", nearest(target, known))
                if end is start:
                    raise self.refuse(row, "to", f"joins {target!r} to itself", "name another row")
            elif end is None or ("to" in self.columns and not k):
                for key in ("k", "damping", "diameter"):
                    if self.text(row, key):
                        what = "no row follows" if end is None else "this row joins nothing"
                        what = f"is {self.text(row, key)}, but {what}"
                        raise self.refuse(row, key, what, "leave it empty, or add what it leads to")
                continue
            yield self.connection(start, end, row)

    def connection(self, start: Entry, end: Entry | None, row: Row) -> Connection:
        k, c = self.number(row, "k"), self.number(row, "damping", zero=True)
        if k is None and end is None and c is None:
            raise self.refuse(row, "k", "is empty on the way to ground", "give a stiffness, a damping coefficient, or both")
        if k is None and end is not None and end.ratio == start.ratio:
            raise self.refuse(row, "k", "is empty between rows of the same speed", f"give the stiffness to {end.title!r}")
        if end is None and c is not None and self.damps_by_ratio:
            raise self.refuse(row, "damping", "is a ratio on the way to ground", "give a coefficient, damping [N*m*s/rad]")
        for key in ("damping", "diameter"):
            if k is None and end is not None and self.text(row, key):
                raise self.refuse(row, key, "is given without a stiffness", "give k too, or leave it empty")
        if self.referred:
            square = float(start.ratio) ** 2
            k = None if k is None else k / square
            c = c if c is None or self.damps_by_ratio else c / square
        name = self.lawful(row, "shaft") if self.text(row, "shaft") else f"{start.name}_to_{end.name if end else GROUND}"
        return Connection(start, end, row, name[:63].rstrip("_"), k, c)

    # -- driveline -------------------------------------------------------------------------------------------------------------

    def driveline(self, name: str) -> Driveline:
        entries, connections = list(self.entries.values()), list(self.connections())
        reference = next((entry.name for entry in entries if entry.ratio == 1), None)
        if reference is None:
            where = self.table.at(None, self.columns["ratio"])
            raise ModelFileError(where, "no row has 1", "ratios count from the reference shaft, which has 1")
        self.check_joined(entries, connections)
        elements: list[Element] = [Inertia(e.name, inertia=e.inertia, note=e.title if e.title != e.name else "") for e in entries]
        diameters = {}
        for each in connections:
            elements += self.elements_of(each)
            diameter = self.number(each.row, "diameter")
            if diameter is not None:
                diameters[f"{each.name}_diameter"] = NamedParameter(diameter, "m", note=f"outside diameter of {each.name}")
        source = f"Mass-elastic table {Path(self.table.source).name}."
        if self.further:
            source += f" Columns that were not read: {', '.join(self.further)}."
        return Driveline(name, tuple(elements), parameters=diameters, reference=reference, description=source)

    def elements_of(self, each: Connection) -> Iterator[Element]:
        """Shaft and gear of a connection, or what ties it to ground."""
        start, end, k, c = each.start, each.end, each.stiffness, each.damping
        if end is None:
            if k is None:
                yield GroundDamper(each.name, start.name, damping=c)
            else:
                yield GroundSpring(each.name, start.name, stiffness=k, damping=c or 0.0)
            return
        step = end.ratio / start.ratio
        if k is not None:
            law: dict[str, Any] = {} if c is None else {"damping_ratio": c}
            if c is not None and not self.damps_by_ratio:
                law = {"damping": "value", "damping_coefficient": c}
            yield Shaft(each.name, start.name, *([end.name] if step == 1 else []), stiffness=k, **law)
        if step != 1:
            if max(step.numerator, step.denominator) > LARGEST_TEETH:
                what = f"leads to {end.title!r} by {step}, more than {LARGEST_TEETH} teeth"
                raise self.refuse(each.row, "ratio", what, "write both ratios with the tooth numbers of the gears between them")
            # teeth_a angle_a = teeth_b angle_b, so the speed of b per speed of a is teeth_a / teeth_b.
            wheel = start.name if k is None else f"{each.name}.b"
            yield RigidGear(f"{each.name[:58]}_gear", wheel, end.name, teeth_a=step.numerator, teeth_b=step.denominator)

    def check_joined(self, entries: list[Entry], connections: list[Connection]) -> None:
        """Refuses a table that falls into parts."""
        part = {entry.name: {entry.name} for entry in entries}
        for each in connections:
            if each.end is not None:
                whole = part[each.start.name] | part[each.end.name]
                part.update(dict.fromkeys(whole, whole))
        for entry in entries:
            if entry.name not in part[entries[0].name]:
                what = f"nothing joins {entry.title!r} to {entries[0].title!r}"
                raise self.refuse(entry.row, "to", what, "give k in the row before, or name what it joins under 'to'")
