"""Lawful names: one rule for everything that a driveline names.

Stands at the top of ``model``. A name passes unchanged into channels, files, tables and comments of generated C, so it must be
harmless in all of them: a short ASCII identifier that is no keyword of C, C++ or Python and no device of Windows. Keywords are
those of ISO/IEC 9899:2024 (C23), ISO/IEC 14882:2024 (C++23) and the running Python; the device names are Microsoft's
("Naming Files, Paths, and Namespaces").
"""

from __future__ import annotations

import keyword
import re
import unicodedata

from modelgen.errors import NamingError

_LONGEST = 63
_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)

_C_KEYWORDS = """
alignas alignof auto bool break case char const constexpr continue default do double else enum extern false float for goto if
inline int long nullptr register restrict return short signed sizeof static static_assert struct switch thread_local true typedef
typeof typeof_unqual union unsigned void volatile while
"""
_CPP_KEYWORDS = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class co_await co_return
co_yield compl concept const const_cast consteval constexpr constinit continue decltype default delete do double dynamic_cast else
enum explicit export extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr
operator or or_eq private protected public register reinterpret_cast requires return short signed sizeof static static_assert
static_cast struct switch template this thread_local throw true try typedef typeid typename union unsigned using virtual void
volatile wchar_t while xor xor_eq
"""
_KEYWORDS = {
    "C": frozenset(_C_KEYWORDS.split()),
    "C++": frozenset(_CPP_KEYWORDS.split()),
    "Python": frozenset(keyword.kwlist),
}
_DEVICES = frozenset(["con", "prn", "aux", "nul", *(port + digit for port in ("com", "lpt") for digit in "123456789")])
# Words that would mean something else where the name is used, each with that meaning. Names of the C library such as ``sin`` or
# ``time`` stay free: generated C reads ``x[i]`` and ``p[i]``, never a name.
_RESERVED = {
    "main": "where a C program starts",
    "pi": "the circle constant of expressions",
    "inf": "how infinity is written",
    "nan": "how a missing number is written",
}
# Generated C shares its file with the functions of CasADi and with those that modelgen adds.
_RESERVED_PREFIXES = ("casadi_", "mg_")


def identifier(name: object, where: str, kind: str = "name") -> str:
    """The name itself if it is lawful: ``[A-Za-z][A-Za-z0-9_]{0,62}`` and no keyword, device or reserved word.

    Raises NamingError, which proposes a lawful name where one is near.

    >>> identifier("shaft_1", "driveline 'truck'")
    'shaft_1'
    >>> identifier("shaft 1", "driveline 'truck'")
    Traceback (most recent call last):
    ...
    modelgen.errors.NamingError: driveline 'truck': name 'shaft 1' holds ' ' (SPACE) at character 6; write 'shaft_1'
    """
    return _lawful(name, where, kind, hyphens=False)


def model_name(name: object, where: str) -> str:
    """The name itself if it is an identifier in which hyphens may stand for underscores (they become underscores in C).

    Raises NamingError.

    >>> model_name("truck-16dof", "model file")
    'truck-16dof'
    """
    return _lawful(name, where, "model name", hyphens=True)


def _lawful(name: object, where: str, kind: str, hyphens: bool) -> str:
    # A subclass of str may compare and print as it likes, so only the plain type counts.
    if type(name) is not str:
        raise NamingError(where, f"{kind} {repr(name)[:80]} is not a text but {type(name).__name__}", "write it as a plain text")
    problem = _problem(name, hyphens)
    if problem is None:
        return name
    shown = repr(name) if len(name) <= _LONGEST else f"{name[:24]!r}..."
    proposal = _proposal(name[: 2 * _LONGEST], hyphens)
    remedy = f"write {proposal!r}" if proposal else "write an ASCII letter, then letters, digits or underscores"
    raise NamingError(where, f"{kind} {shown} {problem}", remedy)


def _problem(name: str, hyphens: bool) -> str | None:
    """What is wrong with the name, as the end of a sentence."""
    if not name:
        return "is empty"
    if len(name) > _LONGEST:
        return f"has {len(name)} characters, {_LONGEST} are allowed"
    in_c = name.replace("-", "_") if hyphens and name[-1] != "-" else name
    if not _IDENTIFIER.fullmatch(in_c):
        # Only the start can be at fault when every single character would do after a letter.
        place = next((i for i, character in enumerate(in_c) if not _IDENTIFIER.fullmatch("a" + character)), 0)
        character = name[place]
        plain = re.fullmatch("[A-Za-z0-9]", character)
        named = "" if plain else f" ({unicodedata.name(character, f'U+{ord(character):04X}')})"
        verb = "starts with" if place == 0 else "holds"
        return f"{verb} {character!r}{named}" + (f" at character {place + 1}" if place else ", not with a letter")
    languages = [language for language, words in _KEYWORDS.items() if in_c in words]
    if languages:
        return f"is a keyword of {' and '.join(languages)}"
    if in_c.lower() in _DEVICES:
        return "is a device on Windows, where no file can have that name"
    if in_c.lower() in _RESERVED:
        return f"is reserved: {_RESERVED[in_c.lower()]}"
    for prefix in _RESERVED_PREFIXES:
        if in_c.lower().startswith(prefix):
            return f"begins with {prefix!r}, which is kept for generated C"
    if "__" in in_c:
        return "has two underscores in a row, which C++ reserves"
    return None


def _proposal(name: str, hyphens: bool) -> str | None:
    """A lawful name near this one, or None when nothing of it is left."""
    # Compatibility forms turn accents, full-width letters and raised digits into ASCII; what has no ASCII form separates words.
    plain = "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    kept = "A-Za-z0-9-" if hyphens else "A-Za-z0-9"
    words = re.sub(f"[^{kept}]+", "_", plain)
    words = re.sub(r"[_-]*_[_-]*|--+", "_", words).strip("_-")
    words = re.sub(rf"^(?:{'|'.join(prefix.rstrip('_') for prefix in _RESERVED_PREFIXES)})[_-]", "", words, flags=re.IGNORECASE)
    if not re.search("[A-Za-z]", words):
        return None
    if words[0].isdigit():
        words = "n" + words
    for candidate in (words[:_LONGEST].rstrip("_-"), words[: _LONGEST - 2].rstrip("_-") + "_1"):
        if _problem(candidate, hyphens) is None:
            return candidate
    return None
