"""Fields: what each field of the data of a drive line may hold, stated once.

Dataclasses declare their fields with `quantity`, `positive`, `point`, `text`, `day`, `flag`, `part`
and `parts`, and say what they mean in their docstrings. The checks, the reader and writer of files
and the schema all go by these statements.
"""

from __future__ import annotations

import dataclasses
import datetime
import inspect
import math
import operator
import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ....kit.checks import described, shortened
from ....kit.errors import CardanError, ModelError, choices
from ....kit.units import Unit, si

PLAUSIBLE: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "length": (1e-3, 30.0),
        "torque": (1e-3, 1e8),
        "speed": (1e-3, 1e4),
        "angular_acceleration": (1e-3, 1e6),
        "mass": (1e-6, 1e6),
        "inertia": (1e-12, 1e7),
        "stiffness": (1e-2, 1e12),
        "rigidity": (1e2, 1e13),
        "force": (1e-2, 1e9),
        "density": (1e2, 3e4),
        "modulus": (1e5, 1e12),
        "n_beta": (1e-4, 1e6),
        "time": (1.0, 1e11),
    }
)
"""Sizes of a dimension that lines have from the least to the greatest; a unit is wrong beyond."""
_LIMITS = {
    "least": ("at least", "minimum", operator.ge),
    "above": ("greater than", "exclusiveMinimum", operator.gt),
    "most": ("at most", "maximum", operator.le),
    "below": ("less than", "exclusiveMaximum", operator.lt),
}
"""Limits of an entry to their words, their keys in schemas, and how values keep to them."""
_DAY = re.compile(r"\d{4}-\d\d-\d\d", re.ASCII)


class Entry(NamedTuple):
    """What a field holds.

    Attributes:
        kind: `quantity`, `point`, `text`, `day`, `flag`, `part` or `parts`.
        dimension: of quantities and points, a key of `units.DIMENSIONS`.
        least: smallest valid value, in SI units.
        above: value that valid ones exceed.
        most: greatest valid value.
        below: value that valid ones stay under.
        type: the dataclass of parts.
        plausible: sizes that lines have besides 0; those of the dimension unless given.
        known: the texts that are valid; any if empty.
    """

    kind: str
    dimension: str = "number"
    least: float | None = None
    above: float | None = None
    most: float | None = None
    below: float | None = None
    type: Any = None
    plausible: tuple[float, float] | None = None
    known: tuple[str, ...] = ()

    def allowed(self, unit: Unit | None = None) -> str:
        """Return valid values in words, in a unit; in SI units unless given."""
        limits = " and ".join(f"{words} {limit:.6g}" for words, *_, limit in self.limits(unit))
        measure = unit.spellings[0] if unit else si(self.dimension)
        text = " ".join(filter(None, ["a finite number", limits]))
        return text if self.dimension == "number" else f"{text} [{measure}]"

    def holds(self, value: float) -> bool:
        """Return whether a number is finite and within the limits."""
        return math.isfinite(value) and all(keeps(value, most) for *_, keeps, most in self.limits())

    def limits(self, unit: Unit | None = None) -> list[tuple[str, str, Any, float]]:
        """Return what `_LIMITS` says of each limit, and its value in a unit or else in SI units."""
        factor = unit.divisor / unit.multiplier if unit else 1.0
        return [
            (*told, getattr(self, name) * factor)
            for name, told in _LIMITS.items()
            if getattr(self, name) is not None
        ]


def implausible(value: float, dimension: str, plausible: tuple[float, float] | None = None) -> str:
    """Return in words what lines have instead of a value; empty if they have it.

    Args:
        value: in SI units; NaN if it is not known.
        dimension: of it.
        plausible: the least and greatest size of it; that of the dimension, if it has one, without.
    """
    found = plausible or PLAUSIBLE.get(dimension)
    if found is None or not value or math.isnan(value) or found[0] <= abs(value) <= found[1]:
        return ""
    low, high, unit = *found, si(dimension)
    is_meant = dimension == "length" and low <= abs(value) / 1e3 <= high
    meant = f"; {value:.6g} mm are {value / 1e3:.6g} m" if is_meant else "; is its unit right?"
    return f"{value:.6g} {unit}, but lines have {low:g} to {high:g} {unit}{meant}"


def _field(entry: Entry, default: Any) -> Any:
    if default is dataclasses.MISSING:
        return dataclasses.field(metadata={"entry": entry})
    return dataclasses.field(default=default, metadata={"entry": entry})


def quantity(dimension: str, default: Any = dataclasses.MISSING, **limits: Any) -> Any:
    """Return a field that holds a number of a dimension; None as its default makes it optional."""
    return _field(Entry("quantity", dimension, **limits), default)


def positive(dimension: str, **limits: Any) -> Any:
    """Return an optional field that holds a number greater than 0, of a dimension."""
    return quantity(dimension, None, above=0.0, **limits)


def point() -> Any:
    """Return an optional field that holds three coordinates."""
    return _field(Entry("point", "length", plausible=(0.0, math.inf)), None)


def text(default: str = "", known: tuple[str, ...] = ()) -> Any:
    """Return a field that holds a text, one of those that are known unless any is valid."""
    return _field(Entry("text", known=known), default)


def day() -> Any:
    """Return a field that holds a day as YYYY-MM-DD, or nothing."""
    return _field(Entry("day"), "")


def flag(default: bool | None = None) -> Any:
    """Return a field that holds True or False."""
    return _field(Entry("flag"), default)


def part(kind: type) -> Any:
    """Return an optional field that holds another dataclass."""
    return _field(Entry("part", type=kind), None)


def parts(kind: type, default: Any = ()) -> Any:
    """Return a field that holds any number of dataclasses of a kind, as a tuple."""
    return _field(Entry("parts", type=kind), default)


def meanings(kind: type) -> dict[str, str]:
    """Return what the docstring of a dataclass says of its fields, without units."""
    section = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")[2]
    found = re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", section.partition("\n\n")[0], re.M)
    return {
        name: re.sub(r" ?\[[^]]*\]", "", " ".join(words.split())).rstrip(".")
        for name, words in found
    }


def entries(kind: Any) -> dict[str, tuple[dataclasses.Field[Any], Entry]]:
    """Return the fields of a dataclass with what they hold."""
    return {item.name: (item, item.metadata["entry"]) for item in dataclasses.fields(kind)}


def settle(instance: Any) -> None:
    """Check all fields of a new dataclass, and make their values plain: floats, tuples.

    Raises:
        ModelError: the field, its value and what is valid.
    """
    kind = type(instance).__name__
    for name, (item, entry) in entries(instance).items():
        value = getattr(instance, name)
        if value is None and item.default is None:
            continue
        at = f"{name} of a {kind}"
        object.__setattr__(instance, name, _settled(value, entry, at))


def refuse(instance: Any, name: str, problem: str) -> ModelError:
    """Return the error of a field that does not go with others."""
    value = getattr(instance, name)
    shown = f" = {value:.12g}" if isinstance(value, float) else ""
    return ModelError(f"{name}{shown} of a {type(instance).__name__} {problem}")


def number(value: object, entry: Entry, at: str, error: type[CardanError] = ModelError) -> float:
    """Return a plain number that an entry allows.

    Raises:
        CardanError: it is none, not finite or out of its limits.
    """
    is_number = isinstance(value, (int, float, np.integer, np.floating))
    # NumPy's durations are a subclass of its integers.
    if not is_number or isinstance(value, (bool, np.timedelta64)):
        raise error(f"{at} is {described(value)}, expected {entry.allowed()}")
    try:
        plain = float(value)  # type: ignore[arg-type]
    except OverflowError:
        plain = math.inf
    if not entry.holds(plain):
        shown = shortened(repr(value) if isinstance(value, int) else repr(plain))
        raise error(f"{at} is {shown}, expected {entry.allowed()}")
    if wrong := implausible(plain, entry.dimension, entry.plausible):
        raise error(f"{at} is {wrong}")
    return plain


def items(value: object, at: str, expected: str) -> list[Any]:
    """Return the items of a sequence.

    Raises:
        ModelError: it is a text, a mapping, or nothing that can be iterated.
    """
    if isinstance(value, (str, bytes, dict)) or not isinstance(value, Iterable):
        raise ModelError(f"{at} is {described(value)}, expected {expected}")
    return list(value)


def _settled(value: object, entry: Entry, at: str) -> object:
    if entry.kind == "quantity":
        return number(value, entry, at)
    if entry.kind == "point":
        listed = items(value, at, "three numbers [m]")
        if len(listed) != 3:
            raise ModelError(f"{at} has {len(listed)} numbers, expected three [m]")
        return tuple(number(item, entry, f"{at}[{axis}]") for axis, item in enumerate(listed))
    if entry.kind == "text":
        if not isinstance(value, str):
            raise ModelError(f"{at} is {described(value)}, expected a text")
        if not value.isprintable():
            raise ModelError(f"{at} is {value!r}, expected a text of one line that can be printed")
        if entry.known and value not in entry.known:
            valid = choices(filter(None, entry.known), value)
            raise ModelError(f"{at} is {value!r}; it can be: {valid}")
        return str(value)
    if entry.kind == "day":
        return _day(value, at)
    if entry.kind == "flag":
        if not isinstance(value, (bool, np.bool_)):
            raise ModelError(f"{at} is {described(value)}, expected True or False")
        return bool(value)
    expected = entry.type.__name__
    if entry.kind == "part":
        if not isinstance(value, entry.type):
            raise ModelError(f"{at} is {described(value)}, expected a {expected}")
        return value
    listed = items(value, at, f"a sequence of {expected}")
    for index, item in enumerate(listed):
        if not isinstance(item, entry.type):
            raise ModelError(f"{at}[{index}] is {described(item)}, expected a {expected}")
    return tuple(listed)


def _day(value: object, at: str) -> str:
    """Return a day as YYYY-MM-DD; an empty text is none."""
    # A moment is a day too by its class, but says more than one.
    if isinstance(value, datetime.date) and not isinstance(value, datetime.datetime):
        return value.isoformat()
    if value == "":
        return ""
    if isinstance(value, str) and _DAY.fullmatch(value):
        try:
            return datetime.date.fromisoformat(value).isoformat()
        except ValueError:
            pass
    raise ModelError(f"{at} is {described(value)}, expected a day such as 2026-01-31")
