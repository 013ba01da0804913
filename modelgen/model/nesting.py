"""How deep the text of a model file nests, before a reader of TOML is let loose on it.

Part of ``model``, below ``files``. A reader recurses on nested brackets, and takes quadratic time for long dotted keys.
"""

from __future__ import annotations

import re

DEEPEST = 32
_DOTTED = re.compile(rf"(?<![\w-])(?:(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{DEEPEST},}}")


def nesting(text: str) -> int:
    """An upper bound of the nesting of arrays, inline tables and dotted keys, for which a reader of TOML takes quadratic time."""
    depth = deepest = 0
    for character in text:
        depth = max(0, depth + (character in "[{") - (character in "]}"))
        deepest = max(deepest, depth)
    return DEEPEST + 1 if _DOTTED.search(text) else deepest
