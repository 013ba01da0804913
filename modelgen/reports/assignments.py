"""``NAME=VALUE``, as a command line and a report write it. Part of ``reports``."""

from __future__ import annotations

from modelgen.errors import CaseError


def pair(text: str, option: str, form: str) -> tuple[str, str]:
    """Name and value of ``NAME=VALUE``. Raises CaseError for anything else; ``form`` says what to write."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise CaseError(f"{option} {text!r}", "is no assignment", f"write {form}")
    return name, value
