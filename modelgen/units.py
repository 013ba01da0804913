"""Units at the border, dimensions inside.

Stands above ``model``. Inside modelgen every number is SI. At the border a text such as ``"35 kN*m/deg"`` is read with
pint. Inside, the dimension of a torque law is checked with a small table of exponents of kilogram, meter and second: pint is
not needed there, and the radian counts as dimensionless, as in SI.
"""

from __future__ import annotations

import functools
import math
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from modelgen.errors import UnitError, nearest


@dataclass(frozen=True)
class Dimension:
    """Exponents of kilogram, meter and second.

    >>> dimension_of("N*m/rad") == dimension_of("J")
    True
    >>> print(dimension_of("N/m") * dimension_of("m"))
    kg*m/s^2
    """

    mass: Fraction = Fraction(0)
    length: Fraction = Fraction(0)
    time: Fraction = Fraction(0)

    def __mul__(self, other: Dimension) -> Dimension:
        return Dimension(self.mass + other.mass, self.length + other.length, self.time + other.time)

    def __pow__(self, exponent: Fraction | int) -> Dimension:
        power = Fraction(exponent)
        return Dimension(self.mass * power, self.length * power, self.time * power)

    def __truediv__(self, other: Dimension) -> Dimension:
        return self * other**-1

    @property
    def is_number(self) -> bool:
        return self == NUMBER

    def __str__(self) -> str:
        above: list[str] = []
        below: list[str] = []
        for symbol, power in (("kg", self.mass), ("m", self.length), ("s", self.time)):
            if power:
                text = symbol if abs(power) == 1 else f"{symbol}^{abs(power)}"
                (above if power > 0 else below).append(text)
        return ("*".join(above) or "1") + "".join(f"/{part}" for part in below)


NUMBER = Dimension()
_KG, _M, _S = Dimension(mass=Fraction(1)), Dimension(length=Fraction(1)), Dimension(time=Fraction(1))
_N = _KG * _M / _S**2
_TABLE = {
    "1": NUMBER,
    "rad": NUMBER,
    "kg": _KG,
    "m": _M,
    "s": _S,
    "N": _N,
    "J": _N * _M,
    "W": _N * _M / _S,
    "Pa": _N / _M**2,
    "Hz": _S**-1,
}
_SIGNS = str.maketrans(
    {"·": "*", "⋅": "*", "•": "*", "∙": "*", "×": "*", "µ": "u", "μ": "u", "−": "-", "°": " deg ", "Ω": " ohm "}
)
_HIGH, _PLAIN = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-"
# What engineers write in one word: N m, also with a second, and kg m^2. pint takes "Nm" for a textile count.
_JOINED = re.compile(r"(?<![A-Za-z_])((?:[dcmukMG]?N)|k?g|t)(mm|cm|m)(s?)((?:\^|\*\*)\d)?(?![A-Za-z_])")
_TURNS = re.compile(r"(?<![A-Za-z_])(?:U|r|tr|rev)\s*/\s*min(?![A-Za-z_])|(?<![A-Za-z_])RPM(?![A-Za-z_])")
_PER_MINUTE = re.compile(r"(?:1\s*/\s*)min|/\s*min|min\s*(?:\^|\*\*)?-1")


@functools.lru_cache(maxsize=1024)
def written_out(unit: str) -> str:
    """A unit as engineers write it, in the signs that pint reads: ``Nm``, ``kgm²``, ``kg·m^2``, ``U/min``, both micro signs.

    >>> written_out("MNm/rad"), written_out("kg·m²"), written_out("Nms/rad"), written_out("U/min")
    ('MN*m/rad', 'kg*m^2', 'N*m*s/rad', 'rpm')
    """
    text = unit.translate(_SIGNS).strip()
    text = re.sub(f"[{_HIGH}]+", lambda high: "^" + high[0].translate(str.maketrans(_HIGH, _PLAIN)), text)
    text = re.sub(r"(?<=[A-Za-z])(?=\d)", "^", text)  # kgm2, m2, s2
    text = _TURNS.sub("rpm", text)
    return _JOINED.sub(_joined, text)


def _joined(found: re.Match[str]) -> str:
    """The factors of a word; in brackets where the text divides by it, and so by all of them."""
    first, length, second, power = found.groups()
    factors = f"{first}*{length}{'*s' if second else ''}{power or ''}"
    return f"({factors})" if found.string[: found.start()].rstrip().endswith("/") else factors


_FACTOR = re.compile(r"([*/]?)\s*(1|[A-Za-z]+)(?:\^(-?\d+))?\s*")


@functools.cache
def dimension_of(unit: str) -> Dimension:
    """Dimension of an SI unit text made of ``1 rad kg m s N J W Pa Hz`` with ``* / ^``.

    Raises UnitError for any other symbol. Declared units of parameters and outputs are written in this form.

    >>> str(dimension_of("N*m*s/rad"))
    'kg*m^2/s'
    """
    position, result = 0, NUMBER
    while position < len(unit):
        match = _FACTOR.match(unit, position)
        if match is None or (match[1] == "") != (position == 0) or match[2] not in _TABLE:
            raise UnitError(f"unit {unit!r}", "is not an SI unit text", "write it with " + " ".join(_TABLE) + " and * / ^")
        power = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        result = result * _TABLE[match[2]] ** power
        position = match.end()
    if position == 0:
        raise UnitError("unit ''", "is empty", 'write "1" for a plain number')
    return result


_NUMBER_TEXT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.ASCII)


def split_quantity(text: str, where: str) -> tuple[float, str]:
    """Number and unit text of ``"35 kN*m/deg"``; the unit is empty for a plain number."""
    match = _NUMBER_TEXT.fullmatch(text) if len(text) <= 120 else None
    if match is None:
        raise UnitError(where, f"{text[:120]!r} is not a number with a unit", 'write for example "35 kN*m/deg"')
    if re.match(r",\d", match[2]):
        remedy = 'write a decimal point, and nothing between thousands, such as "1.5 N*m" or "3000 rpm"'
        raise UnitError(where, f"{text!r} has a comma in its number", remedy)
    return float(match[1]), match[2]


def to_si(value: float, unit: str, declared: str, where: str) -> float:
    """Value in the declared SI unit, of a value given in any unit of the same dimension.

    A unit written exactly as declared costs no conversion and no rounding. Raises UnitError.

    >>> round(to_si(1.0, "kN*m/deg", "N*m/rad", "shaft 's'"), 6)
    57295.779513
    """
    if unit.replace(" ", "") == declared.replace(" ", ""):
        return finite(value, where)
    if declared == "rad/s" and _PER_MINUTE.fullmatch(written_out(unit)):
        unit = "rpm"  # so makers write it; as an angular speed 1/min would be a factor of 2 pi away
    if not unit:
        if dimension_of(declared) == NUMBER and declared == "1":
            return finite(value, where)
        raise UnitError(where, f"{value!r} has no unit", f'write "{value!r} {declared}" or another unit of that dimension')
    parsed = _pint_unit(unit, where)
    target = _pint_unit(declared, where)
    if parsed.dimensionality != target.dimensionality:
        raise UnitError(
            where, f"{unit!r} has the dimension {_shown(parsed)}", f"{declared!r} ({dimension_of(declared)}) is asked for"
        )
    # pint takes hertz for 1/s = rad/s: a factor of 2 pi that nobody asked for.
    if declared == "rad/s" and re.search(r"hertz|Hz", unit):
        raise UnitError(where, f"{unit!r} is ambiguous for an angular speed", "write rad/s, rpm or turn/s")
    return finite(float((value * parsed).to(target).magnitude), where)


def read_quantity(text: str, declared: str, where: str) -> float:
    """SI value of a text with a unit, such as ``"1900 rpm"`` for ``rad/s``. Raises UnitError."""
    value, unit = split_quantity(text, where)
    return to_si(value, unit, declared, where)


def read_any(text: str, where: str) -> tuple[float, str]:
    """SI value and SI unit text of a quantity of whatever dimension. Raises UnitError.

    >>> read_any("2 kN*m", "torque")
    (2000.0, 'kg*m^2/s^2')
    """
    value, unit = split_quantity(text, where)
    if not unit:
        return finite(value, where), "1"
    try:
        dimension_of(unit.replace(" ", ""))
    except UnitError:
        parsed = _pint_unit(unit, where)
        powers = {str(key): Fraction(power).limit_denominator(100) for key, power in parsed.dimensionality.items()}
        known = {"[mass]": "kg", "[length]": "m", "[time]": "s"}
        if set(powers) - set(known):
            raise UnitError(where, f"{unit!r} has the dimension {_shown(parsed)}", "use units of mass, length and time") from None
        rate = "rad/" if str(parsed.dimensionality) == "1 / [time]" else ""
        si = "rad/s" if rate else str(Dimension(*(powers.get(key, Fraction(0)) for key in known)))
        return to_si(value, unit, si, where), si
    return finite(value, where), unit.replace(" ", "")


def finite(value: float, where: str) -> float:
    """The value itself, refused when it is not finite."""
    if not math.isfinite(value):
        raise UnitError(where, f"{value!r} is not a finite number", "give a finite value")
    return value


@functools.lru_cache(maxsize=1)
def _registry() -> Any:
    import pint  # slow to import, and only text with foreign units needs it

    return pint.UnitRegistry(cache_folder=None)


# A product of named units with small powers: pint would evaluate any arithmetic, also 9^9^9^9.
_UNIT_FACTOR = r"\(?(?:1|[A-Za-z_]+)\)?(?:(?:\^|\*\*)-?\d{1,2})?\)?"
_ALLOWED_UNIT = re.compile(rf"{_UNIT_FACTOR}(?:\s*[*/ ]\s*\(?{_UNIT_FACTOR})*", re.ASCII)
LONGEST_UNIT = 60


@functools.lru_cache(maxsize=1024)
def _pint_unit(unit: str, where: str) -> Any:
    registry = _registry()
    text = written_out(unit) if len(unit) <= LONGEST_UNIT else unit
    if len(unit) <= LONGEST_UNIT and _ALLOWED_UNIT.fullmatch(text):
        try:
            parsed = registry.parse_expression(text)
            if getattr(parsed, "magnitude", None) == 1 or (isinstance(parsed, (int, float)) and parsed == 1):
                return registry.Unit(text)
        except Exception:  # pint raises many kinds of error for a bad text; all mean the same here
            pass
    raise UnitError(where, f"{unit!r} is not a known unit", nearest(unit, ["N*m/rad", "kN*m/deg", "kg*m^2", "rpm", "mm", "N*m"]))


def _shown(unit: Any) -> str:
    return str(unit.dimensionality)
