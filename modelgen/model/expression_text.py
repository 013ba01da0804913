"""The words of an expression: which functions it may use, how it is cut into tokens, and how it is refused.

Stands in ``model``, below ``expressions``. Whatever is no token of the language is refused here, before Python's parser sees it.
"""

from __future__ import annotations

import ast
import keyword
import math
import re
import unicodedata
from collections.abc import Callable
from typing import Any, NoReturn, TypeAlias

import sympy

from modelgen.errors import ModelFileError

LONGEST_TEXT = 2000
DEEPEST = 50

Numeric: TypeAlias = Callable[..., Any]
FUNCTIONS: dict[str, tuple[Any, Numeric]] = {
    "sqrt": (sympy.sqrt, math.sqrt),
    "exp": (sympy.exp, math.exp),
    "log": (sympy.log, math.log),
    "abs": (sympy.Abs, abs),
    "sin": (sympy.sin, math.sin),
    "cos": (sympy.cos, math.cos),
    "tan": (sympy.tan, math.tan),
    "asin": (sympy.asin, math.asin),
    "acos": (sympy.acos, math.acos),
    "atan": (sympy.atan, math.atan),
    "atan2": (sympy.atan2, math.atan2),
    "sinh": (sympy.sinh, math.sinh),
    "cosh": (sympy.cosh, math.cosh),
    "tanh": (sympy.tanh, math.tanh),
    "min": (sympy.Min, min),
    "max": (sympy.Max, max),
}
WRITTEN = {function: name for name, (function, _) in FUNCTIONS.items() if isinstance(function, type)}
ALLOWED = "write numbers, names, + - * / **, parentheses, pi and " + ", ".join(FUNCTIONS)

NAME = re.compile(r"[A-Za-z]\w*(?:\.[A-Za-z]\w*)*", re.ASCII)
# Possessive quantifiers keep the time linear on a long row of digits.
_TOKEN = re.compile(
    rf"(?!0\d)(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+(?![\w.])|(?P<name>{NAME.pattern}(?![\w.]))|[-+*/(),]", re.ASCII
)
_WORD = re.compile(r"[\w.]+", re.ASCII)
# The cross, the dot, the division sign, the minus sign, and raised 2 and 3, as a text editor may put them.
_INSTEAD = {"\u00d7": "*", "\u00b7": "*", "\u00f7": "/", "\u2212": "-", "\u00b2": "**2", "\u00b3": "**3"}
_INSTEAD |= {"^": "**", "[": "(", "]": ")"}


class ExpressionText:
    """A text that claims to be an expression; ``where`` opens every refusal."""

    def __init__(self, text: object, where: str) -> None:
        self.where = where
        if not isinstance(text, str):
            self.refuse(f"{text!r:.60} is not a text", 'write the expression in quotes, such as "2*pi*ratio"')
        if len(text) > LONGEST_TEXT:
            self.refuse(f"the expression has {len(text)} characters, {LONGEST_TEXT} are allowed", "name its parts as parameters")
        self.text = " ".join(text.split())

    def refuse(self, problem: str, remedy: str) -> NoReturn:
        raise ModelFileError(self.where, problem, remedy)

    def refuse_depth(self) -> NoReturn:
        self.refuse(f"{self.text[:40]!r}... is nested more than {DEEPEST} deep", "name its inner parts as parameters")

    def scan(self) -> None:
        """Refuses whatever is no token of the language before Python's parser sees it."""
        if not self.text:
            self.refuse("the expression is empty", ALLOWED)
        position, opened = 0, []
        while position < len(self.text):
            if self.text[position] == " ":
                position += 1
                continue
            token = _TOKEN.match(self.text, position)
            if token is None:
                self.refuse_character(position)
            if token["name"] and (words := [word for word in token["name"].split(".") if keyword.iskeyword(word)]):
                self.refuse(f"the word {words[0]!r} has no place in an expression", ALLOWED)
            if token[0] == "(":
                opened.append(position)
            elif token[0] == ")":
                if not opened:
                    self.refuse(f"the parenthesis ')' at character {position + 1} closes nothing", "remove it or open one before")
                opened.pop()
            if len(opened) > DEEPEST:
                self.refuse_depth()
            position = token.end()
        if opened:
            self.refuse(f"the parenthesis '(' at character {opened[-1] + 1} is never closed", "close it")

    def refuse_character(self, position: int) -> NoReturn:
        word, character = _WORD.match(self.text, position), self.text[position]
        if word is not None and word[0] != ".":
            number = word[0].lstrip(".")[:1].isdigit()
            good = "write it like 1000, 0.5 or 1.5e-3" if number else "write a declared name, such as shaft.stiffness"
            self.refuse(f"{word[0][:40]!r} is no {'number' if number else 'name'}", good)
        named = unicodedata.name(character, "") or f"U+{ord(character):04X}"
        remedy = f"write {_INSTEAD[character]}" if character in _INSTEAD else ALLOWED
        self.refuse(f"{character!r} ({named}) at character {position + 1} has no place in an expression", remedy)

    def source(self, node: ast.expr) -> str:
        return self.text[node.col_offset : node.end_col_offset]

    def piece(self, node: ast.expr) -> str:
        text = self.source(node)
        return repr(text if len(text) <= 60 else text[:57] + "...")
