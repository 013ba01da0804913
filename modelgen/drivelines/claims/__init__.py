"""Claims of papers about catalogued drivelines, as data: what ``modelgen run`` and ``modelgen reproduce`` set beside the model's
own figures."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class MotionClaim:
    """The ``kind`` of motion at a role (in the words of ``analysis.classification``) where the parameter has a ``value``.

    ``groups``: of points in its section; 0 where the paper gives no number.
    """

    at: str
    value: float
    kind: str
    groups: int = 0


@dataclass(frozen=True)
class MotionClaims:
    """Claims about kinds of motion over a ``parameter``, to be held against a ``driveline`` of the catalogue.

    As the parameter grows through ``range``, the motion is claimed to begin as a kind and to settle to a period (in strobes).
    """

    driveline: str
    parameter: str
    range: tuple[float, float]
    begins_as: str
    settles_to: int
    claims: tuple[MotionClaim, ...]


@dataclass(frozen=True)
class Claims:
    """Claims of one paper: ``roles`` name its places as elements of the driveline, ``largest_at`` orders roles by angle,
    ``series_order`` is that of the Fourier series with the smallest error."""

    citation: str
    standard: str
    roles: Mapping[str, str]
    largest_angle_deg: float
    largest_at: tuple[str, ...]
    multibody_difference_percent: float
    limit_deg: float
    series_order: int
    motion: MotionClaims


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
    motion = dict(data["motion"])
    each = tuple(MotionClaim(**claim) for claim in motion.pop("claims"))
    motions = MotionClaims(**{**motion, "range": tuple(motion["range"])}, claims=each)
    places = tuple(data["claims"]["largest_at"])
    return Claims(data["citation"], data["standard"], data["roles"], largest_at=places, motion=motions, **numbers)
