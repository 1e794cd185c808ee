"""Units: what numbers in files and on the command line are measured in, never guessed.

A quantity `length` is written as `length_mm = 900` or as `length = "900 mm"` in a file, where a
bare number is refused, and as `--length "900 mm"` on the command line, where the help says what a
bare number is measured in. Python attributes are in SI units and radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from .errors import ModelError, choices

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_DIGITS = 17
"""Decimal digits that tell any two doubles apart."""


class Unit(NamedTuple):
    """A unit of one dimension.

    Attributes:
        suffix: what follows the name of a field, after an underscore.
        multiplier: times which a number gives SI units, before the division.
        divisor: by which it is divided; decimal fractions of a unit stay exact to rounding so.
        spellings: how texts write it, the first one in messages; blanks and dots do not count.
    """

    suffix: str
    multiplier: float
    divisor: float
    spellings: tuple[str, ...]

    def to_si(self, number: float) -> float:
        """Return a number of this unit in SI units."""
        return number * self.multiplier / self.divisor

    def from_si(self, value: float) -> float | None:
        """Return the shortest number that `to_si` takes to a value; None if no number does."""
        quotient = value * self.divisor / self.multiplier
        if not math.isfinite(quotient):
            return None
        for digits in range(1, _DIGITS + 1):
            number = float(f"{quotient:.{digits}g}")
            if self.to_si(number) == value:
                return number
        return None


_TURN_PER_MINUTE = 2.0 * math.pi / 60.0
INCH, FOOT, POUND, POUND_FORCE, HOUR = 0.0254, 0.3048, 0.45359237, 4.4482216152605, 3600.0
"""Units of the USA, and the hour, in SI units, exact by definition."""

DIMENSIONS: dict[str, tuple[Unit, ...]] = {
    "length": (
        Unit("mm", 1.0, 1e3, ("mm",)),
        Unit("m", 1.0, 1.0, ("m",)),
        Unit("cm", 1.0, 1e2, ("cm",)),
        Unit("in", INCH, 1.0, ("in", "inch", '"')),
        Unit("ft", FOOT, 1.0, ("ft",)),
    ),
    "angle": (
        # The factor of `math.radians`, so that 15 degrees are the same double everywhere.
        Unit("deg", math.pi / 180.0, 1.0, ("deg", "°")),
        Unit("rad", 1.0, 1.0, ("rad",)),
    ),
    "torque": (
        Unit("nm", 1.0, 1.0, ("N·m",)),
        Unit("knm", 1e3, 1.0, ("kN·m",)),
        Unit("lbft", POUND_FORCE * FOOT, 1.0, ("lbf·ft", "lb·ft", "ft·lbf", "ft·lb")),
        Unit("lbin", POUND_FORCE * INCH, 1.0, ("lbf·in", "lb·in", "in·lbf", "in·lb")),
    ),
    "speed": (
        Unit("rpm", _TURN_PER_MINUTE, 1.0, ("rpm", "1/min", "rev/min")),
        Unit("rad_s", 1.0, 1.0, ("rad/s",)),
        Unit("deg_s", math.pi / 180.0, 1.0, ("deg/s", "°/s")),
    ),
    "angular_acceleration": (
        Unit("rad_s2", 1.0, 1.0, ("rad/s²",)),
        Unit("rpm_s", _TURN_PER_MINUTE, 1.0, ("rpm/s",)),
    ),
    "mass": (
        Unit("kg", 1.0, 1.0, ("kg",)),
        Unit("g", 1.0, 1e3, ("g",)),
        Unit("lb", POUND, 1.0, ("lb",)),
    ),
    "inertia": (
        Unit("kgm2", 1.0, 1.0, ("kg·m²",)),
        Unit("kgcm2", 1.0, 1e4, ("kg·cm²",)),
        Unit("kgmm2", 1.0, 1e6, ("kg·mm²",)),
        Unit("lbin2", POUND * INCH**2, 1.0, ("lb·in²",)),
        Unit("lbft2", POUND * FOOT**2, 1.0, ("lb·ft²",)),
    ),
    "stiffness": (
        Unit("nm_rad", 1.0, 1.0, ("N·m/rad",)),
        Unit("knm_rad", 1e3, 1.0, ("kN·m/rad",)),
        Unit("nm_deg", 180.0 / math.pi, 1.0, ("N·m/deg", "N·m/°")),
        Unit("lbft_rad", POUND_FORCE * FOOT, 1.0, ("lbf·ft/rad", "lb·ft/rad")),
        Unit("lbin_rad", POUND_FORCE * INCH, 1.0, ("lbf·in/rad", "lb·in/rad")),
    ),
    "density": (
        Unit("kg_m3", 1.0, 1.0, ("kg/m³",)),
        Unit("g_cm3", 1e3, 1.0, ("g/cm³",)),
        Unit("lb_in3", POUND / INCH**3, 1.0, ("lb/in³",)),
    ),
    "modulus": (
        Unit("gpa", 1e9, 1.0, ("GPa",)),
        Unit("mpa", 1e6, 1.0, ("MPa", "N/mm²")),
        Unit("pa", 1.0, 1.0, ("Pa", "N/m²")),
        Unit("mpsi", 1e6 * POUND_FORCE / INCH**2, 1.0, ("Mpsi",)),
        Unit("ksi", 1e3 * POUND_FORCE / INCH**2, 1.0, ("ksi",)),
        Unit("psi", POUND_FORCE / INCH**2, 1.0, ("psi",)),
    ),
    "force": (
        Unit("n", 1.0, 1.0, ("N",)),
        Unit("kn", 1e3, 1.0, ("kN",)),
        Unit("lbf", POUND_FORCE, 1.0, ("lbf",)),
    ),
    "rigidity": (
        Unit("n_mm", 1e3, 1.0, ("N/mm",)),
        Unit("kn_mm", 1e6, 1.0, ("kN/mm",)),
        Unit("n_m", 1.0, 1.0, ("N/m",)),
        Unit("lbf_in", POUND_FORCE / INCH, 1.0, ("lbf/in", "lb/in")),
    ),
    "speed_length": (Unit("rad_m_s", 1.0, 1.0, ("rad·m/s",)),),
    "n_beta": (
        Unit("rpm_deg", _TURN_PER_MINUTE * (math.pi / 180.0), 1.0, ("rpm·deg", "°/min")),
        Unit("rad2_s", 1.0, 1.0, ("rad²/s",)),
    ),
    "velocity": (
        Unit("mm_s", 1.0, 1e3, ("mm/s",)),
        Unit("m_s", 1.0, 1.0, ("m/s",)),
        Unit("in_s", INCH, 1.0, ("in/s",)),
        Unit("ft_s", FOOT, 1.0, ("ft/s",)),
    ),
    "acceleration": (
        Unit("m_s2", 1.0, 1.0, ("m/s²",)),
        Unit("mm_s2", 1.0, 1e3, ("mm/s²",)),
        Unit("in_s2", INCH, 1.0, ("in/s²",)),
        Unit("ft_s2", FOOT, 1.0, ("ft/s²",)),
    ),
    "time": (
        Unit("h", HOUR, 1.0, ("h",)),
        Unit("s", 1.0, 1.0, ("s",)),
    ),
    "number": (),
}
"""Dimension to its units, the one that files are written in first."""


def is_of_usa(unit: Unit) -> bool:
    """Return whether a unit is one of the customary ones of the USA."""
    return re.match("in|ft|lb|m?psi|ksi", unit.suffix) is not None


def si(dimension: str) -> str:
    """Return the unit of a dimension's Python attributes."""
    of_one = (unit for unit in DIMENSIONS[dimension] if unit.multiplier == unit.divisor == 1.0)
    return next((unit.spellings[0] for unit in of_one), "1")


def plain(unit: str) -> str:
    """Return a unit as it is compared, without what separates factors."""
    return unit.translate(_PLAIN)


_PLAIN = str.maketrans({**dict.fromkeys(" ·*^-", ""), "²": "2", "³": "3"})


def keys(name: str, dimension: str) -> dict[str, Unit]:
    """Return the keys under which a file may give a quantity as a number, with their units."""
    return {f"{name}_{unit.suffix}": unit for unit in DIMENSIONS[dimension]}


def spellings(dimension: str) -> list[str]:
    """Return how texts may write the units of a dimension."""
    return [spelling for unit in DIMENSIONS[dimension] for spelling in unit.spellings]


def read(text: str, dimension: str, at: str, bare: str = "") -> float:
    """Return what a text like "900 mm" or "400 N·m" means, in SI units.

    Args:
        text: a decimal number and a unit; blanks, dots, stars and hyphens between factors do not
            count.
        dimension: a key of `DIMENSIONS` that has units.
        at: how messages name the place.
        bare: spelling of the unit of a number without one; such numbers are refused if empty.

    Raises:
        ModelError: it is no number with a unit of this dimension.

    >>> read("900 mm", "length", "length")
    0.9
    """
    match = _NUMBER.fullmatch(text)
    valid = f'a text like "1.5 {spellings(dimension)[0]}"; units: {choices(spellings(dimension))}'
    if match is None:
        raise ModelError(f"{at} is {text!r}, not a number with a unit; write {valid}")
    number, name = match.groups()
    if name.startswith(","):
        where = "decimals stand behind a point, and blanks between several numbers"
        raise ModelError(f"{at} is {text!r}: {where}; write {valid}")
    name = name or bare
    for unit in DIMENSIONS[dimension]:
        if plain(name) in map(plain, unit.spellings):
            return unit.to_si(float(number))
    what = f"has the unit {name!r}, which is none of {dimension}" if name else "has no unit"
    raise ModelError(f"{at} = {text!r} {what}; write {valid}")


def read_any(text: str, at: str) -> tuple[float, str]:
    """Return what a text with a unit of any dimension means in SI units, and that SI unit.

    Args:
        text: see `read`.
        at: how messages name the place.

    Raises:
        ModelError: it is no number with a unit that is known.
    """
    match = _NUMBER.fullmatch(text)
    number, name = match.groups() if match else ("", "")
    for dimension, of_one in DIMENSIONS.items():
        for unit in of_one:
            if plain(name) in map(plain, unit.spellings):
                return unit.to_si(float(number)), si(dimension)
    raise ModelError(
        f'{at} = {text!r} is no number with a unit; write a text like "20 deg", '
        '"-100 N·m" or "1500 rpm"'
    )


def written(
    name: str, values: Sequence[float], dimension: str, *, of_usa: bool = False
) -> tuple[str, list[float]]:
    """Return the key and the numbers that a file gives a quantity as, which read back exactly.

    Args:
        name: of the field.
        values: of it, all in one unit.
        dimension: a key of `DIMENSIONS`.
        of_usa: whether units of the USA come first. Units of the other system are taken where they
            say the numbers with fewer digits, unless both do with as few as people write. Units
            come first in which no number is below 1.
    """
    exact = [
        (unit, [float(number) for number in numbers if number is not None])
        for unit in DIMENSIONS[dimension]
        if None not in (numbers := [unit.from_si(value) for value in values])
    ]
    if not exact:  # A dimension without units.
        return name, list(values)

    def awkward(item: tuple[Unit, list[float]]) -> tuple[int, bool, bool]:
        unit, numbers = item
        is_small = any(0.0 < abs(number) < 1.0 for number in numbers)
        return max(HAND, *map(digits, numbers)), is_of_usa(unit) != of_usa, is_small

    found, shown = min(exact, key=awkward)
    return f"{name}_{found.suffix}", shown


HAND = 6
"""Digits up to which people write numbers."""


def digits(number: float) -> int:
    """Return how many significant decimal digits tell a number from all others."""
    mantissa = repr(abs(float(number))).partition("e")[0].replace(".", "")
    return max(len(mantissa.strip("0")), 1)


def is_shorter_in_usa(value: float, dimension: str) -> int:
    """Return 1 if units of the USA say a value with fewer digits, -1 if others do, else 0."""
    found = {False: math.inf, True: math.inf}
    for unit in DIMENSIONS[dimension]:
        if (number := unit.from_si(value)) is not None:
            found[is_of_usa(unit)] = min(found[is_of_usa(unit)], digits(number))
    return (
        0
        if math.inf in found.values()
        else (found[False] > found[True]) - (found[False] < found[True])
    )
