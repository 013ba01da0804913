"""A small document (headings, paragraphs, formulas, tables) and its two printed forms: Markdown for the web, LaTeX for a report.

Part of the grammar's printed form. Paragraphs and cells hold plain words, `` `names` `` and ``$formulas$``; what a user wrote
freely is ``Quoted`` and printed as it is, whatever it contains. The Markdown is GitHub's, which notebooks read too: formulas
stand between ``$$`` on lines of their own. The LaTeX is a fragment for ``\\input`` that needs amsmath and longtable.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass


class Quoted(str):
    """Free text of a user, printed as it is."""

    __slots__ = ()


@dataclass(frozen=True)
class Heading:
    """A heading of level 1, 2 or 3."""

    level: int
    text: str


@dataclass(frozen=True)
class Paragraph:
    """Words with names and formulas in the line."""

    text: str


@dataclass(frozen=True)
class Formulas:
    """Equations under each other, each with one ``&`` where they are aligned."""

    rows: tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """Rows of cells under a head; columns whose cells are all numbers stand to the right."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def numeric(self) -> list[bool]:
        """For each column, whether it holds numbers only."""
        columns = [[row[k] for row in self.rows] for k in range(len(self.head))]
        return [any(map(_DIGIT.search, column)) and all(map(_NUMBER.fullmatch, column)) for column in columns]


Block = Heading | Paragraph | Formulas | Table

_NUMBER = re.compile(r"-?[\d./]+(·10[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)?|—|")
_DIGIT = re.compile(r"\d")
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_LOWERED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def number(value: float) -> str:
    """Six digits, with a power of ten that is a multiple of three where the number is large or small.

    >>> number(10.5e6), number(0.035), number(-7.5e-5), number(26.0)
    ('10.5·10⁶', '0.035', '-75·10⁻⁶', '26')
    """
    if not math.isfinite(value) or value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{value:.6g}"
    power = 3 * math.floor(math.log10(abs(value)) / 3)
    digits = f"{value / 10.0**power:.6g}"
    if abs(float(digits)) >= 1000:
        power, digits = power + 3, f"{value / 10.0 ** (power + 3):.6g}"
    return digits + "·10" + str(power).translate(_RAISED)


def unit(text: str) -> str:
    """A unit with raised exponents: ``kg·m²``; empty for a plain number.

    >>> unit("kg*m^2"), unit("N*m*s/rad"), unit("1")
    ('kg·m²', 'N·m·s/rad', '')
    """
    if text == "1":
        return ""
    return re.sub(r"\^(-?\d+)", lambda power: power[1].translate(_RAISED), text).replace("*", "·")


def with_unit(value: float, text: str) -> str:
    """A number with its unit."""
    return f"{number(value)} {unit(text)}".rstrip()


# -- Markdown ------------------------------------------------------------------------------------------------------------------


def markdown_text(blocks: Iterable[Block]) -> str:
    """The document as GitHub Markdown."""
    return "\n\n".join(_markdown(block) for block in blocks) + "\n"


def _markdown(block: Block) -> str:
    match block:
        case Heading():
            return "#" * block.level + " " + _markdown_words(block.text)
        case Paragraph():
            return _markdown_words(block.text)
        case Formulas():
            body = " \\\\\n".join(block.rows)
            return f"$$\n\\begin{{aligned}}\n{body}\n\\end{{aligned}}\n$$"
        case Table():
            rule = ["---:" if right else "---" for right in block.numeric()]
            return "\n".join("| " + " | ".join(map(_markdown_cell, row)) + " |" for row in (block.head, rule, *block.rows))


def _markdown_words(text: str) -> str:
    if not isinstance(text, Quoted):
        return text
    words = re.sub(r"([\\`*_{}\[\]#|$~>])", r"\\\1", " ".join(text.split()))
    words = words.replace("&", "&amp;").replace("<", "&lt;")
    return re.sub(r"^([-+]|\d+[.)])(?=\s)", r"\\\1", words)


def _markdown_cell(text: str) -> str:
    return _markdown_words(text) if isinstance(text, Quoted) else text.replace("|", r"\vert ")


# -- LaTeX ---------------------------------------------------------------------------------------------------------------------

_SECTIONS = {1: "section", 2: "subsection", 3: "subsubsection"}
_SPECIAL = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", **{c: "\\" + c for c in "{}$&#_%"}}
_SIGNS = {"·": r"$\cdot$", "—": "---", "…": r"\dots{}"}
_PIECES = re.compile(r"(`[^`]*`|\$[^$]*\$)")


def latex_text(blocks: Iterable[Block]) -> str:
    """The document as a LaTeX fragment."""
    return "% needs amsmath and longtable\n" + "\n\n".join(_latex(block) for block in blocks) + "\n"


def _latex(block: Block) -> str:
    match block:
        case Heading():
            return rf"\{_SECTIONS[block.level]}*{{{_latex_words(block.text)}}}"
        case Paragraph():
            return _latex_words(block.text)
        case Formulas():
            body = " \\\\\n".join(block.rows)
            return f"\\begin{{align*}}\n{body}\n\\end{{align*}}"
        case Table():
            columns = "".join("r" if right else "l" for right in block.numeric())
            rows = [" & ".join(map(_latex_words, row)) + r" \\" for row in (block.head, *block.rows)]
            lines = [rf"\begin{{longtable}}{{{columns}}}", rows[0], r"\hline", r"\endhead", *rows[1:], r"\end{longtable}"]
            return "\n".join(lines)


def _latex_words(text: str) -> str:
    if isinstance(text, Quoted):
        return _latex_plain(" ".join(text.split()))
    pieces: Sequence[str] = _PIECES.split(text)
    shown = []
    for piece in pieces:
        if piece.startswith("$"):
            shown.append(piece)
        else:
            shown.append(rf"\texttt{{{_latex_plain(piece[1:-1])}}}" if piece.startswith("`") else _latex_plain(piece))
    return "".join(shown)


def _latex_plain(text: str) -> str:
    words = "".join(_SPECIAL.get(character, character) for character in text)
    words = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", lambda raised: f"$^{{{raised[0].translate(_LOWERED)}}}$", words)
    return "".join(_SIGNS.get(character, character) for character in words)
