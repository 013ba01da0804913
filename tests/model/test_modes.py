"""Modes as declared: their flags, their names, and what is refused."""

from __future__ import annotations

import pytest
import sympy

from modelgen.errors import ModelError, NamingError, UnitError
from modelgen.model import Guard, Modes, Multiplier


def named(modes):
    modes.__set_name__(object, "flank")
    return modes


def test_flags_are_symbols_by_the_name_of_their_mode():
    flank = named(Modes("free", "drive", "coast")).symbols
    assert flank.drive == sympy.Symbol("flank.drive", real=True)
    assert list(flank) == [flank.free, flank.drive, flank.coast]
    with pytest.raises(ModelError, match="modes 'flank': have no mode 'drve'; nearest is 'drive'"):
        _ = flank.drve
    assert not hasattr(flank, "__array__")


def test_a_run_starts_in_the_first_mode_or_in_the_named_one():
    assert Modes("free", "drive").start == "free"
    assert Modes("free", "drive", start="drive").start == "drive"


def test_continuity_may_depend_on_a_switch():
    assert Modes("free", "drive").continuous({})
    assert not Modes("free", "drive", continuous=False).continuous({})
    modes = Modes("free", "drive", continuous={"viscous": ("always", "never")})
    assert [modes.continuous({"viscous": each}) for each in ("always", "never", "in contact")] == [True, True, False]


@pytest.mark.parametrize(
    ("values", "given", "error", "words"),
    [
        (("alone",), {}, ModelError, r"two or more different names; write Modes\(\"free\""),
        (("twice", "twice"), {}, ModelError, "two or more different names"),
        (("free", "two words"), {}, NamingError, "mode 'two words'"),
        (("free", "while"), {}, NamingError, "keyword"),
        (("free", 3), {}, NamingError, "mode"),
        (("free", "drive"), {"start": "driv"}, ModelError, "start in 'driv'; nearest is 'drive'"),
    ],
)
def test_wrong_modes_are_refused(values, given, error, words):
    with pytest.raises(error, match=words):
        Modes(*values, **given)


def test_a_multiplier_has_a_unit():
    with pytest.raises(UnitError, match="furlong"):
        Multiplier("furlong*N")


def test_resets_come_as_a_mapping_or_as_pairs():
    x = sympy.Symbol("x")
    assert Guard("bounce", x, reset={x: -x}).resets() == ((x, -x),) == Guard("bounce", x, reset=((x, -x),)).resets()
    assert Guard("seen", x).resets() == ()
