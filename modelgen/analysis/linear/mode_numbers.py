"""How modes are counted and named, wherever they are told: vibrating modes from 1, what turns or moves without stiffness by name.

Below every linear question. Rows of a result count from 0, rigid modes first; only what is printed goes through here.
"""

from __future__ import annotations


def mode_number(mode: int, rigid: int) -> int | None:
    """Number of the mode in a row (from 0, the first ``rigid`` of them rigid); None for a rigid one.

    >>> [mode_number(mode, 1) for mode in range(3)]
    [None, 1, 2]
    """
    return None if mode < rigid else mode - rigid + 1


def mode_cell(mode: int, rigid: int) -> str:
    """The same in a column of a table.

    >>> [mode_cell(mode, 1) for mode in range(3)]
    ['rigid', '1', '2']
    """
    return "rigid" if mode < rigid else str(mode - rigid + 1)


def mode_name(mode: int, rigid: int) -> str:
    """The same in a sentence; several rigid modes are told apart by letters.

    >>> [mode_name(mode, 1) for mode in range(3)], [mode_name(mode, 2) for mode in range(3)]
    (['rigid', 'mode 1', 'mode 2'], ['rigid a', 'rigid b', 'mode 1'])
    """
    if mode < rigid:
        return "rigid" if rigid == 1 else f"rigid {_letters(mode)}"
    return f"mode {mode - rigid + 1}"


def _letters(number: int) -> str:
    """a, b, ..., z, ba, bb, ..."""
    rest, last = divmod(number, 26)
    return (_letters(rest) if rest else "") + chr(ord("a") + last)
