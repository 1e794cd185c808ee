"""Wording: texts, numbers and quantities of a page, in a language and a system of units.

English texts are the keys of `german.toml`, whose German ones say the same. What the verdict says
is composed of clauses with names and quantities in them; their patterns stand in that file too, so
that the quantities within a sentence have the units and digits of the page.
"""

from __future__ import annotations

import datetime
import math
import re
import tomllib
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from ...kit.arrays import NOTHING
from ...kit.checks import described
from ...kit.errors import ArgumentError, choices
from ...kit.quantities import NONE, cleared, prefix
from ...kit.units import DIMENSIONS, FOOT, HAND, INCH, POUND, POUND_FORCE
from ...kit.units import digits as digits_of

LANGUAGES = ("en", "de")
UNITS = ("si", "imperial")
DIGITS = 4
"""Significant digits of what is computed."""
THIN = "\N{NARROW NO-BREAK SPACE}"
"""Between groups of three digits."""
SPACE = "\N{NO-BREAK SPACE}"
"""Between a number and its unit: wider, so that no digit of the one joins the other."""
MINUS = "\N{MINUS SIGN}"
_SOFT_HYPHEN = "\N{SOFT HYPHEN}"
_UNSCALED = range(-4, 7)
"""Powers of ten of the numbers that are written without one."""


class Measure(NamedTuple):
    """In what a dimension is told.

    Attributes:
        unit: its name; empty for plain numbers.
        factor: times which SI units, and radians, give it.
        decimals: of what is told to a fixed place, such as lengths in tables.
    """

    unit: str
    factor: float
    decimals: int = 3


def _measure(dimension: str, unit: str) -> Measure:
    """Return a unit of files as a measure."""
    found = next(item for item in DIMENSIONS[dimension] if unit in item.spellings)
    return Measure(unit, found.divisor / found.multiplier, 1 if unit == "mm" else 3)


_UNITS: dict[str, tuple[str | Measure, str | Measure]] = {
    "length": ("mm", "in"),
    "angle": ("°", "°"),
    "torque": ("N·m", "lbf·ft"),
    "speed": ("1/min", "rpm"),
    "angular_acceleration": ("rad/s²", "rad/s²"),
    "mass": ("kg", "lb"),
    "inertia": ("kg·m²", "lb·ft²"),
    "stiffness": ("N·m/rad", "lbf·ft/rad"),
    "density": ("kg/m³", "lb/in³"),
    "modulus": ("GPa", "Mpsi"),
    "stress": (_measure("modulus", "MPa"), _measure("modulus", "ksi")),
    "force": ("N", "lbf"),
    "rigidity": ("N/mm", "lbf/in"),
    "n_beta": ("°/min", "°/min"),
    "time": ("h", "h"),
    "power": (Measure("kW", 1e-3), Measure("hp", 1.0 / (550.0 * POUND_FORCE * FOOT))),
    "unbalance": (Measure("g·mm", 1e6), Measure("oz·in", 16.0 / (POUND * INCH))),
    "frequency": (Measure("Hz", 1.0),) * 2,
    "share": (Measure("%", 100.0),) * 2,
    "number": (Measure("", 1.0),) * 2,
    "whole": (Measure("", 1.0, 0),) * 2,
}
"""Dimensions to what tells them in both systems; units without a factor are those of files."""
BY_UNIT = {
    "1": "number",
    "rad": "angle",
    "rad/s": "speed",
    "rad^2/s": "n_beta",
    "rad/s^2": "angular_acceleration",
    "Pa": "stress",
    "m": "length",
    "s": "time",
    "kg m": "unbalance",
    "N": "force",
    "N m": "torque",
    "N m/rad": "stiffness",
    "N/m": "rigidity",
}
"""Dimensions of units as `analytic.limits` writes them."""
_IN_SENTENCES: dict[str, str] = {
    "1/min": "speed",
    "rad/s²": "angular_acceleration",
    "N·m": "torque",
    "mm": "length",
    "m": "length",
    "W": "power",
    "Hz": "frequency",
    "h": "time",
    "%": "share",
    "°": "angle",
}
"""Units in sentences of the verdict, with their dimension."""
_DECIMAL = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
_UNIT = "|".join(map(re.escape, _IN_SENTENCES))
_MEASURED = re.compile(rf"([±+]?)({_DECIMAL}) ?({_UNIT})")
_PLACES = {
    "quantity": rf"±?{_DECIMAL} ?(?:{_UNIT})(?![\w/²])",
    "number": _DECIMAL,
    "name": r"(?:(?!: ).)+?",
    "field": r"\w+",
    "clause": r".+",
}
_PLACE = re.compile(r"\{(quantity|number|name|field|clause)\}")


class Wording:
    """How a page says things.

    Args:
        language: one of `LANGUAGES`.
        units: one of `UNITS`.

    Raises:
        ArgumentError: neither of these.
    """

    def __init__(self, language: str = "en", units: str = "si") -> None:
        for name, value, known in (("language", language, LANGUAGES), ("units", units, UNITS)):
            if not isinstance(value, str) or value not in known:
                raise ArgumentError(f"{name} is {described(value)}, expected: {choices(known)}")
        self.language = language
        self.units = units

    def __call__(self, text: str, **values: str) -> str:
        """Return a text of the page in its language, with values in its braces.

        Raises:
            KeyError: the catalogue has no such text.
        """
        told = text if self.language == "en" else catalogue()["page"][text]
        return told.format(**values) if values else told

    def sentence(self, text: str) -> str:
        """Return a text of the verdict; a clause that the catalogue does not know stays."""
        return "; ".join(
            part if (told := self.clause(part)) is None else told for part in text.split("; ")
        )

    def clause(self, text: str) -> str | None:
        """Return a clause of the verdict; None if the catalogue does not know it."""
        clauses, patterns = _clauses()
        if text in clauses:
            return text if self.language == "en" else clauses[text]
        for pattern, english, german in patterns:
            if found := pattern.fullmatch(text):
                template = english if self.language == "en" else german
                kinds = _PLACE.findall(english)
                shown = [self._place(*pair) for pair in zip(kinds, found.groups(), strict=True)]
                if None not in shown:
                    plain = _PLACE.split(template)[::2]
                    pairs = zip_longest(plain, map(str, shown), fillvalue="")
                    return "".join(text for pair in pairs for text in pair)
        if ", " in text:
            parts = [self.clause(part) for part in text.split(", ")]
            if None not in parts:
                return ", ".join(map(str, parts))
        return None

    def _place(self, kind: str, text: str) -> str | None:
        """Return what stands in a place of a clause."""
        if kind == "clause":
            return self.clause(text)
        if kind == "name":
            return text
        if kind == "field":
            return self._field(text)
        if kind == "number":
            return self.number(float(text), _digits(text), sign=text[0] == "+")
        found = _MEASURED.fullmatch(text)
        if found is None:
            return None
        lead, value, unit = found.groups()
        dimension = _IN_SENTENCES[unit]
        plain = Wording().measure(dimension)
        to_si = 1.0 / plain.factor if unit == plain.unit else 1.0  # Else of the SI.
        factor = to_si * self.measure(dimension).factor
        power = math.log10(factor)
        digits = _digits(value)
        if abs(power - round(power)) > NOTHING:
            # What was rounded and is converted has one digit less, so that the last one is right.
            digits = max(digits - 1, 1)
        return lead + self.with_unit(self.number(float(value) * factor, digits), dimension)

    def _field(self, name: str) -> str:
        """Return a field of files in words, with its name for who has to give it."""
        words = catalogue()["page"].get(name.replace("_", " "))
        if self.language == "en" or words is None:
            return name
        return f"{words.replace(_SOFT_HYPHEN, '')} ({name})"

    def measure(self, dimension: str) -> Measure:
        """Return in what a dimension is told."""
        told = _UNITS[dimension][UNITS.index(self.units)]
        return told if isinstance(told, Measure) else _measure(dimension, told)

    @property
    def instead(self) -> dict[str, tuple[str, float]]:
        """Units of the SI that are told otherwise, to the others and their factors; see `view`."""
        return {
            unit.replace(" ", "·"): self.measure(dimension)[:2]
            for unit, dimension in BY_UNIT.items()
            if self.measure(dimension) != Wording().measure(dimension)
        }

    def unit(self, dimension: str) -> str:
        """Return the unit of a dimension in brackets, after a blank; empty for plain numbers."""
        name = self.measure(dimension).unit
        return f" [{name}]" if name else ""

    def number(self, value: float, digits: int = DIGITS, *, sign: bool = False) -> str:
        """Return a number to significant digits.

        Args:
            value: the number.
            digits: significant ones.
            sign: whether positive numbers have a sign too.
        """
        if math.isnan(value):
            return NONE
        if math.isinf(value):
            return f"{MINUS if value < 0.0 else ''}∞"
        if not cleared(value):
            return "0"
        mantissa, _, power = f"{abs(value):.{digits - 1}e}".partition("e")
        exponent = int(power)
        if exponent in _UNSCALED:
            rounded = float(f"{mantissa}e{power}")
            shown = self._grouped(f"{rounded:.{max(digits - 1 - exponent, 0)}f}")
        else:
            shown = f"{self._grouped(mantissa)}{THIN}×{THIN}10{_raised(exponent)}"
        return (MINUS if value < 0.0 else "+" if sign else "") + shown

    def given(self, value: float, dimension: str = "number", digits: int = HAND) -> str:
        """Return a number that is given [SI units] in its unit, without it.

        Args:
            value: the number.
            dimension: of it.
            digits: significant ones of numbers that no six digits say.
        """
        shown = value * self.measure(dimension).factor
        if not math.isfinite(shown) or not cleared(shown):
            return self.number(shown)
        written = float(f"{shown:.{HAND}g}")
        is_said = math.isclose(written, shown, rel_tol=NOTHING)
        return self.number(shown, digits_of(written) if is_said else digits)

    def fixed(self, value: float, dimension: str) -> str:
        """Return a number [SI units] in its unit without it, to the decimals of its dimension."""
        measure = self.measure(dimension)
        if math.isnan(value):
            return NONE
        text = f"{value * measure.factor:.{measure.decimals}f}"
        is_negative = text.startswith("-") and float(text) != 0.0
        return (MINUS if is_negative else "") + self._grouped(text.lstrip("-"))

    def quantity(self, value: float, dimension: str, digits: int = DIGITS) -> str:
        """Return a quantity [SI units] with its unit, to significant digits."""
        measure = self.measure(dimension)
        shown = cleared(value * measure.factor)
        scale, unit = prefix(abs(shown), measure.unit)
        return self._followed(self.number(shown / scale, digits), unit)

    def given_quantity(self, value: float, dimension: str) -> str:
        """Return a quantity [SI units] that may be given, with its unit; see `given`."""
        measure = self.measure(dimension)
        scale, unit = prefix(abs(cleared(value * measure.factor)), measure.unit)
        return self._followed(self.given(value / scale, dimension, DIGITS), unit)

    def with_unit(self, number: str, dimension: str) -> str:
        """Return a number with the unit of a dimension, which no line break parts."""
        return self._followed(number, self.measure(dimension).unit)

    @staticmethod
    def _followed(number: str, unit: str) -> str:
        return number + (unit if unit == "°" else f"{SPACE}{unit}" if unit else "")

    def day(self, day: datetime.date) -> str:
        """Return a day."""
        return f"{day:%d.%m.%Y}" if self.language == "de" else day.isoformat()

    def _grouped(self, digits: str) -> str:
        """Return digits with the decimal sign of the language, from five on in groups of three."""
        whole, _, rest = digits.partition(".")
        if len(whole) > 4:
            whole = f"{int(whole):,}".replace(",", THIN)
        sign = "," if self.language == "de" else "."
        return f"{whole}{sign}{rest}" if rest else whole


@cache
def catalogue() -> dict[str, dict[str, str]]:
    """Return English texts to German ones: those of the page, and clauses of the verdict."""
    path = Path(__file__).with_name("german.toml")
    return tomllib.loads(path.read_text(encoding="utf-8"))


@cache
def _clauses() -> tuple[dict[str, str], list[tuple[re.Pattern[str], str, str]]]:
    """Return clauses of the verdict: plain ones, and patterns, those that say most first."""
    plain: dict[str, str] = {}
    patterns = []
    for english, german in catalogue()["verdict"].items():
        if not _PLACE.search(english):
            plain[english] = german
            continue
        parts = _PLACE.split(english)
        texts = [
            f"({_PLACES[part]})" if index % 2 else re.escape(part)
            for index, part in enumerate(parts)
        ]
        patterns.append((re.compile("".join(texts)), english, german))
    return plain, sorted(patterns, key=lambda item: -len(_PLACE.sub("", item[1])))


def _digits(text: str) -> int:
    """Return how many significant digits a number has as it is written."""
    mantissa = text.lower().partition("e")[0].lstrip("+-±").replace(".", "").lstrip("0")
    return max(len(mantissa), 1)


def _raised(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
