"""Names and their textbook symbols: ``mesh_stiffness`` is printed as k_m, ``teeth_a`` as z_a, ``twist_rate`` as u with a dot.

Part of the grammar's printed form. A declaration whose documentation is nothing but a symbol ("xi", "k0", "omega_ref") brings it
along; else the table below counts, and a name that neither knows is printed upright. Symbols are those of gear and torsional
vibration texts (Nestorides; ISO 1122-1 and 701 for gears) and of the paper (Eq. 9-17).

GitHub removes the backslash before punctuation (``\\_``, ``\\,``, ``\\:``) and takes ``}_`` for emphasis, so neither is ever
written: an upright name has spaces where the code has underscores.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

# fmt: off
GREEK = frozenset([
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi",
    "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
])
# fmt: on
TEXTBOOK = {
    "after": "T_1",
    "angle": r"\theta",
    "approach": "s",
    "at": "t_0",
    "base": r"\omega_0",
    "base_radius": "R",
    "before": "T_0",
    "contact": r"\omega_m",
    "contact_ratio": r"\varepsilon",
    "cosine": "b",
    "cubic": "k_3",
    "damping": "c",
    "damping_coefficient": "c",
    "damping_ratio": r"\zeta",
    "deflection": r"\delta",
    "duration": r"\tau",
    "error": "e",
    "error_amplitude": "e_r",
    "error_mean": "e_0",
    "error_phase": r"\varphi_e",
    "force": "F",
    "friction_coefficient": r"\mu",
    "geometry_rows": "k",
    "half_backlash": "b",
    "inertia": "J",
    "length": "l",
    "loss_factor": r"\eta",
    "mass": "m",
    "mean": "T_0",
    "mean_stiffness": "k_0",
    "mesh_damping": "c_m",
    "mesh_stiffness": "k_m",
    "module": "m",
    "penetration": r"f(\delta)",
    "phase": r"\varphi",
    "poisson_ratio": r"\nu",
    "pressure_angle": r"\alpha",
    "radius": "r",
    "reference_frequency": r"\omega_{ref}",
    "scale": "s",
    "sine": "a",
    "speed": r"\omega",
    "stiffness": "k",
    "stiffness_cosine": "a",
    "stiffness_high": "k_{max}",
    "stiffness_low": "k_{min}",
    "stiffness_sine": "b",
    "stiffness_table": "k",
    "teeth": "z",
    "torque": "T",
    "twist": "u",
    "velocity": "v",
    "viscous_coefficient": "c",
    "young_modulus": "E",
}
_BARE = re.compile(rf"({'|'.join(sorted(GREEK))}|[A-Za-z])(?:_?(\d{{1,3}})|_([A-Za-z]\w{{0,3}}))?", re.ASCII)
_PRINTED = re.compile(r"(?P<letter>[^_(]+)(?:_\{?(?P<subscript>\w+)\}?)?(?P<argument>\(.*\))?")


@dataclass(frozen=True)
class Notation:
    """A printed symbol: a letter, its subscripts, and the argument it is a function of, such as ``(t)``."""

    letter: str
    subscripts: tuple[str, ...] = ()
    argument: str = ""

    def of(self, *names: str) -> Notation:
        """The same symbol of a named thing: with one more upright subscript for each name, and without its argument."""
        return Notation(self.letter, (*self.subscripts, *map(upright, names)))

    def dotted(self) -> Notation:
        """Its time derivative."""
        return Notation(rf"\dot{{{self.letter}}}" if len(self.letter) > 1 else rf"\dot {self.letter}", self.subscripts)

    def row(self, index: str) -> Notation:
        """One row of a series."""
        return Notation(self.letter, (*self.subscripts, index))

    def __str__(self) -> str:
        if not self.subscripts:
            return self.letter + self.argument
        joined = ",".join(self.subscripts)
        # A space before the underscore after a brace: without it, Markdown may read a pair of them as emphasis.
        space = " " if self.letter.endswith("}") else ""
        return f"{self.letter}{space}_{{{joined}}}{self.argument}"


def upright(name: str) -> str:
    """A name of the model as upright text.

    >>> upright("pump_throw_1")
    '\\\\text{pump throw 1}'
    """
    return r"\text{" + re.sub(r"[_.\[\]-]+", " ", name).strip() + "}"


def notation(name: str, doc: str = "") -> Notation:
    """The printed symbol of a declaration by its name, or by a documentation that is nothing but a symbol.

    >>> [str(notation(name)) for name in ("mesh_stiffness", "teeth_a", "deflection_rate", "oil_level")]
    ['k_{m}', 'z_{a}', '\\\\dot{\\\\delta}', '\\\\text{oil level}']
    """
    if (bare := bare_symbol(doc)) is not None:
        return bare
    if name in TEXTBOOK:
        return _printed(TEXTBOOK[name])
    if name.endswith("_rate"):
        base = notation(name.removesuffix("_rate"))
        if not base.letter.startswith(r"\text"):
            return base.dotted()
    stem, _, end = name.rpartition("_")
    if stem in TEXTBOOK and (len(end) == 1 or end.isdigit()):
        return _printed(TEXTBOOK[stem]).row(end)
    return plain_notation(name)


def plain_notation(name: str) -> Notation:
    """The printed symbol of a name that is taken as it stands: ``mu`` is Greek, ``y1`` has a subscript, a word is upright."""
    return bare_symbol(name) or Notation(upright(name))


def bare_symbol(text: str) -> Notation | None:
    """The printed symbol of a text that is nothing but one: a letter or a Greek one, perhaps with a subscript."""
    match = _BARE.fullmatch(text)
    if match is None:
        return None
    letter = f"\\{match[1]}" if match[1] in GREEK else match[1]
    subscript = match[2] or match[3]
    if subscript is None or subscript == "h":  # "a_h" names the row of a series
        return Notation(letter)
    return Notation(letter, (subscript if len(subscript) == 1 or subscript.isdigit() else upright(subscript),))


def _printed(text: str) -> Notation:
    match = _PRINTED.fullmatch(text)
    assert match is not None, text
    subscript = match["subscript"]
    upright_or_not = () if subscript is None else (subscript if len(subscript) == 1 else upright(subscript),)
    return Notation(match["letter"], upright_or_not, match["argument"] or "")
