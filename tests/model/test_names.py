"""Names: what is lawful, what is not, and whether every refusal names its reason and proposes something lawful."""

from __future__ import annotations

import keyword
import random
import re
import string

import pytest

from modelgen.errors import NamingError
from modelgen.model.names import identifier, model_name

ENGINEERING = ["engine", "damper_front", "speed", "time", "J13", "x", "i", "sin", "case_", "module", "final", "Torque_Nm"]


@pytest.mark.parametrize("name", [*ENGINEERING, "a" * 63, "com10", "console", "lpt", "Switch", "casadi", "mgx", "pit"])
def test_ordinary_words_are_lawful(name: str) -> None:
    assert identifier(name, "here") is name


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("", "is empty"),
        ("shaft 1", r"'shaft 1' holds ' ' \(SPACE\) at character 6; write 'shaft_1'"),
        ("1st", r"starts with '1', not with a letter; write 'n1st'"),
        ("_x", r"starts with '_' \(LOW LINE\), not with a letter; write 'x'"),
        ("a-b", r"holds '-' \(HYPHEN-MINUS\) at character 2; write 'a_b'"),
        ("x\n", r"holds '\\n' \(U\+000A\) at character 2; write 'x'"),
        ("a\0b", r"holds '\\x00' \(U\+0000\) at character 2; write 'a_b'"),
        ("x²", r"SUPERSCRIPT TWO\) at character 2; write 'x2'"),
        ("größe", r"holds 'ö' \(LATIN SMALL LETTER O WITH DIAERESIS\) at character 3; write 'gro_e'"),
        ("sp\u0435ed", r"CYRILLIC SMALL LETTER IE\) at character 3; write 'sp_ed'"),
        ("damper\u200b", r"ZERO WIDTH SPACE\) at character 7; write 'damper'"),
        ("\u0432\u0430\u043b", r"CYRILLIC SMALL LETTER VE\), not with a letter; write an ASCII letter"),
        ("\ud800", r"U\+D800"),
        ("f;system('x')", r"holds ';' \(SEMICOLON\) at character 2; write 'f_system_x'"),
        ("a" * 64, rf"'{'a' * 24}'\.\.\. has 64 characters, 63 are allowed; write '{'a' * 63}'"),
        ("a b" * 400_000, "has 1200000 characters"),
        ("switch", r"is a keyword of C and C\+\+; write 'switch_1'"),
        ("restrict", "is a keyword of C; "),
        ("typeof_unqual", "is a keyword of C; "),
        ("constexpr", r"is a keyword of C and C\+\+; "),
        ("requires", r"is a keyword of C\+\+; "),
        ("xor_eq", r"is a keyword of C\+\+; "),
        ("lambda", "is a keyword of Python; "),
        ("None", "is a keyword of Python; write 'None_1'"),
        ("while", r"is a keyword of C and C\+\+ and Python; "),
        ("Con", "is a device on Windows, where no file can have that name; write 'Con_1'"),
        ("NUL", "is a device on Windows"),
        ("lpt9", "is a device on Windows"),
        ("COM1", "is a device on Windows"),
        ("casadi_f", "begins with 'casadi_', which is kept for generated C; write 'f'"),
        ("CASADI_INT", "begins with 'casadi_', which is kept for generated C; write 'INT'"),
        ("mg_step", "begins with 'mg_', which is kept for generated C; write 'step'"),
        ("a__b", r"has two underscores in a row, which C\+\+ reserves; write 'a_b'"),
        ("pi", "is reserved: the circle constant of expressions; write 'pi_1'"),
        ("NaN", "is reserved: how a missing number is written; write 'NaN_1'"),
        ("main", "is reserved: where a C program starts"),
    ],
)
def test_refusal_says_why_and_what_to_write(name: str, said: str) -> None:
    with pytest.raises(NamingError, match=r"^driveline 'truck': inertia .*" + said):
        identifier(name, "driveline 'truck'", "inertia")


class _Disguise(str):
    """Would pass as the text it equals, and print as another."""

    def __str__(self) -> str:
        return "1; exit"


@pytest.mark.parametrize(
    ("value", "said"),
    [(3, "3 is not a text but int"), (None, "NoneType"), (True, "bool"), (b"x", "bytes"), (_Disguise("x"), "but _Disguise")],
)
def test_only_plain_text_is_a_name(value: object, said: str) -> None:
    with pytest.raises(NamingError, match=said):
        identifier(value, "here")


@pytest.mark.parametrize("word", keyword.kwlist)
def test_every_python_keyword_is_refused(word: str) -> None:
    with pytest.raises(NamingError, match="is a keyword of"):
        identifier(word, "here")


@pytest.mark.parametrize("name", ["truck-16dof", "truck_16dof", "a-b-c", "T"])
def test_model_names_may_have_hyphens_inside(name: str) -> None:
    assert model_name(name, "here") is name


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("truck-", r"model name 'truck-' holds '-' \(HYPHEN-MINUS\) at character 6; write 'truck'"),
        ("-truck", r"starts with '-' \(HYPHEN-MINUS\), not with a letter; write 'truck'"),
        ("a--b", r"two underscores in a row, which C\+\+ reserves; write 'a_b'"),
        ("a-_b", "two underscores in a row"),
        ("static-assert", r"is a keyword of C and C\+\+; write 'static-assert_1'"),
        ("casadi-f", "begins with 'casadi_', which is kept for generated C; write 'f'"),
        ("../etc", r"starts with '\.' \(FULL STOP\), not with a letter; write 'etc'"),
        ("con", "is a device on Windows"),
        ("heavy truck-2", "write 'heavy_truck-2'"),
    ],
)
def test_unlawful_model_names(name: str, said: str) -> None:
    with pytest.raises(NamingError, match=said):
        model_name(name, "here")


@pytest.mark.parametrize("check", [identifier, model_name])
def test_proposals_are_lawful(check) -> None:
    """Whatever is refused, the name proposed instead is accepted, and what is accepted has the form promised."""
    random_source = random.Random(16)
    parts = [*string.printable, "ä", "ß", "²", "\u0435", "\u200b", "\ud800", "\U0001f600"]
    parts += ["casadi_", "mg_", "__", "con", "int", "a" * 40]
    proposed = accepted = 0
    for _ in range(3000):
        name = "".join(random_source.choices(parts, k=random_source.randint(0, 6)))
        try:
            assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,62}", check(name, "here"), re.ASCII)
            accepted += 1
        except NamingError as refusal:
            if proposal := re.search(r"; write '([^']*)'$", str(refusal)):
                assert check(proposal[1], "here") == proposal[1]
                proposed += 1
    assert accepted > 100
    assert proposed > 1000
