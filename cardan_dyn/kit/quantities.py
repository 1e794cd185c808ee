"""Quantities: numbers in SI units as engineers write them, 140.2 kN or 0.26 mm."""

from __future__ import annotations

import math
from collections.abc import Iterable

from .arrays import NOTHING

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
_PREFIXED = ("N", "m", "Pa", "W", "J", "s", "Hz")
"""Units that may begin with a prefix; a kilogram has one, and turns are counted as they are."""
_LEAST_MILLIMETRES = 1e-5
"""Length [m] from which lengths below a metre are told in millimetres."""
_LONGEST = 6
"""Digits before the point, and zeros behind it, of a number that is written without a power."""
NONE = "–"
"""What stands for a number that is not known."""


def prefix(size: float, unit: str) -> tuple[float, str]:
    """Return by what numbers up to a size are divided, and the unit of what comes out.

    The greatest of them then is from 1 to below 1000, as far as there are prefixes for the unit;
    tenths have none, but of lengths, which are in millimetres then, as on drawings.

    Args:
        size: greatest absolute value, in `unit`.
        unit: of the SI, without a prefix, such as N·m/rad.

    >>> prefix(140_200.0, "N·m")
    (1000.0, 'kN·m')
    """
    first = unit.replace("·", "/").partition("/")[0]
    if first not in _PREFIXED or not size > 0.0 or not math.isfinite(size):
        return 1.0, unit
    # The size as it will be written: 999.99 N are 1 kN.
    power = _exponent(size, 4)
    exponent = 3 * (power // 3) if power != -1 else 0
    if not min(_PREFIXES) <= exponent <= max(_PREFIXES) + 2:
        return 1.0, unit
    # Milli goes with what is measured, and not with a quotient: 0.18 N/mm.
    least = 0 if "/" in unit and first != "m" else min(_PREFIXES)
    exponent = min(max(exponent, least), max(_PREFIXES))
    if first == "m" and size < 1.0 and size >= _LEAST_MILLIMETRES:
        exponent = -3
    return 10.0**exponent, _PREFIXES[exponent] + unit


def cleared(value: float, size: float = 1.0) -> float:
    """Return a number, and 0 for what is rounding beside a size.

    >>> cleared(-3e-17), cleared(-3e-17, size=1e-12)
    (0.0, -3e-17)
    """
    return 0.0 if abs(value) <= NOTHING * size else value


def column(values: Iterable[float], unit: str = "", digits: int = 4) -> tuple[list[str], str]:
    """Return numbers of one kind as texts with as many decimals, and the unit of all of them.

    Args:
        values: in `unit`, those that are not finite unknown.
        unit: see `prefix`.
        digits: of the greatest.

    >>> column([140_200.0, -2.5, 0.0], "N")
    (['140.2', '0.0', '0'], 'kN')
    """
    every = list(values)
    size = max((abs(value) for value in every if math.isfinite(value)), default=0.0)
    scale, unit = prefix(size, unit)
    decimals = max(digits - 1 - _exponent(size / scale, digits), 0) if size else 0
    return [_fixed(value / scale, decimals, size / scale) for value in every], unit


def number(value: float, digits: int = 4) -> str:
    """Return a number with so many digits, an integer with all of those before the point."""
    if abs(value) >= 10.0**_LONGEST or 0.0 < abs(value) < 10.0**-_LONGEST:
        return f"{value:.{digits}g}" if math.isfinite(value) else NONE
    (text,), _ = column([value], digits=digits)
    return text.rstrip("0").rstrip(".") if "." in text else text


def amount(value: float, unit: str, digits: int = 4, size: float = 0.0) -> str:
    """Return a number with its unit.

    Args:
        value: the number.
        unit: see `prefix`.
        digits: of the number.
        size: of the greatest that it stands beside, whose unit it has, and beside which rounding is
            nothing.

    >>> amount(-71.6e9, "Pa")
    '-71.6 GPa'
    >>> amount(4e-12, "m", size=0.9)
    '0 mm'
    """
    scale, shown = prefix(max(abs(value), size), unit)
    text = number(cleared(value, size) / scale, digits)
    return f"{text}{'' if shown == '°' else ' '}{shown}".rstrip()


def span(low: float, high: float, unit: str = "", words: str = " … ") -> str:
    """Return two numbers in one unit, or one with its unit if they are the same.

    >>> span(0.0, 8e-5, "m")
    '0 … 0.08 mm'
    """
    if low == high:
        return amount(low, unit)
    size = max(abs(low), abs(high))
    scale, shown = prefix(size, unit)
    ends = [number(cleared(end, size) / scale) for end in (low, high)]
    if shown == "°":
        return words.join(f"{end}°" for end in ends)
    return f"{words.join(ends)} {shown}".rstrip()


def unit_of(label: str) -> tuple[str, str]:
    """Return the words of a label, and its unit; empty if it has none."""
    words, bracket, unit = label.removesuffix("]").rpartition("[")
    return (words.rstrip(), unit) if bracket and label.endswith("]") else (label, "")


def _exponent(size: float, digits: int) -> int:
    """Return the power of ten of the first digit of a number that is written with so many."""
    return int(f"{size:.{digits - 1}e}".partition("e")[2])


def _fixed(value: float, decimals: int, greatest: float) -> str:
    """Return a number with so many decimals; what is nothing beside the greatest is 0."""
    if not math.isfinite(value):
        return NONE
    if not cleared(value, greatest):
        return "0"
    text = f"{value:.{decimals}f}"
    return text if float(text) else text.removeprefix("-")
