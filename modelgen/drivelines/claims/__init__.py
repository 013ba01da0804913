"""Claims of papers about catalogued drivelines, as data: what ``modelgen run`` sets beside the model's own figures."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Claims:
    """Claims of one paper: ``roles`` name its places as elements of the driveline, ``largest_at`` orders roles by angle."""

    citation: str
    standard: str
    roles: Mapping[str, str]
    largest_angle_deg: float
    largest_at: tuple[str, ...]
    multibody_difference_percent: float
    limit_deg: float


def claims_of(model: str) -> Claims | None:
    """The claims about a driveline of this name, or None.

    >>> claims_of("fracturing-truck").largest_angle_deg
    0.5863
    """
    path = FOLDER / f"{model}.toml"
    if not path.is_file():
        return None
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    numbers = {key: value for key, value in data["claims"].items() if key != "largest_at"}
    return Claims(data["citation"], data["standard"], data["roles"], largest_at=tuple(data["claims"]["largest_at"]), **numbers)
