"""Law: what an actuator exerts, a number, a table or a function of times, positions or rates."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple, TypeAlias

import numpy as np

from ...kit.arrays import NOTHING, Array
from ...kit.checks import described, numbers
from ...kit.errors import ArgumentError, choices
from .element import Element

Given: TypeAlias = float | Array | Callable[..., Any]
"""A number; a table `(n, 2)`, n at least 2, of places that ascend and values; or a function.

A table of two things is `(n + 1, m + 1)`: below a corner that counts for nothing, places of the
first in its first column, beside it places of the second in its first row, and values between.
"""

_AT = {"time": "{:g} s", "length": "length {:g} m", "rate": "rate {:g} m/s", "speed": "{:g} rad/s"}
"""How messages tell the value of what a function takes; `position 0.5` and the like of others."""


class Law(NamedTuple):
    """A law of an element.

    Attributes:
        given: what the user gave, checked.
        of: names of what a table or function takes; empty for a number.
    """

    given: Given
    of: tuple[str, ...]

    @staticmethod
    def checked(label: str, given: object, of: object, known: Sequence[str]) -> Law:
        """Return a law after its arguments were checked.

        Args:
            label: how messages call the element and its field, as in `Actuator: effort`.
            given: see `Given`.
            of: one of the names that are known, or several for a function.
            known: of what there are laws.

        Raises:
            ArgumentError: the law is none of the three, or `of` is not known.
        """
        names = tuple(of) if isinstance(of, (tuple, list)) else (of,)
        is_known = all(isinstance(name, str) and name in known for name in names)
        if not is_known or not 0 < len(set(names)) == len(names):
            kind = label.partition(":")[0]
            raise ArgumentError(
                f"{kind}: of is {described(of)}; it is {choices(known)}, or several"
            )
        if callable(given):
            return Law(given, names)
        array = numbers(label, given)
        if not array.ndim:
            return Law(float(array), ())
        fits = array.ndim == 2 and len(names) in (1, 2)
        if fits:
            axes, _ = _parts(array, len(names))
            fits = min(map(len, axes)) > 1 and (len(names) == 2 or array.shape[1] == 2)
        if not fits:
            raise ArgumentError(
                f"{label} has shape {array.shape}, expected a number, a function, a table "
                f"(n, 2) of one of: {choices(known)}; or of two of them (n + 1, m + 1), with "
                "places of the first in its first column and of the second in its first row"
            )
        for places, line in zip(axes, ("column", "row"), strict=False):
            if not np.all(np.diff(places) > 0.0):
                raise ArgumentError(f"{label}: the first {line} of a table ascends")
        return Law(array, names)

    @property
    def limits(self) -> str:
        """See `Element.limits`."""
        if not isinstance(self.given, np.ndarray):
            return ""
        axes, _ = _parts(self.given, len(self.of))
        told = (
            f"of {name} goes from {places[0]:g} to {places[-1]:g}"
            for name, places in zip(self.of, axes, strict=True)
        )
        return f"its table {' and '.join(told)}"

    def is_potential(self, name: str) -> bool:
        """Whether it is a table of a position or length, of which the energy is known."""
        return isinstance(self.given, np.ndarray) and self.of == (name,)

    def at(self, label: str, **places: Array) -> Array:
        """Return what it is at `(N,)` times, positions and so on, by their names.

        Raises:
            ArgumentError: a function fails, or a table ends before a place.
        """
        given, at = self.given, [places[name] for name in self.of]
        if isinstance(given, float):
            return np.full(len(next(iter(places.values()))), given)
        if isinstance(given, np.ndarray):
            found = _of_table(given, at)
            ended = np.isnan(found) & np.all(np.isfinite(at), axis=0)
            if np.any(ended):
                where = [float(item[ended][0]) for item in at]
                raise ArgumentError(
                    f"{label} {self._told(where)}: {self.limits}; give it as many rows "
                    "as the motion needs"
                )
            return found
        if any(np.any(item != item[0]) for item in at if len(item) > 1):
            values = _of_arrays(given, at)
            if values is not None:
                return numbers(label, values)
            rows = zip(*(item.tolist() for item in at), strict=True)
            return np.array([self._of_function(given, row, label) for row in rows])
        count = len(at[0])
        first = [float(item[0]) for item in at] if count else []
        return np.full(count, self._of_function(given, first, label) if count else 0.0)

    def at_one(self, label: str, **places: float) -> float:
        """Return what it is at one time, position and so on; NaN where a table has ended.

        Steps of integrators that lead there are too long. Raises errors as `at` does else.
        """
        given = self.given
        if isinstance(given, float):
            return given
        if isinstance(given, np.ndarray):
            return float(_of_table(given, [np.array([places[name]]) for name in self.of])[0])
        return self._of_function(given, [places[name] for name in self.of], label)

    def energy(self, at: Array) -> Array:
        """Return the potential energy `(N,)` of a table at places, above its least.

        The law pushes in the sense of its place, so that the energy falls where it is positive.
        """
        places, values = np.asarray(self.given).T
        widths = np.diff(places)
        slopes = np.diff(values) / widths
        energies = -np.concatenate([[0.0], np.cumsum(0.5 * widths * (values[1:] + values[:-1]))])
        # Between two rows it is least where a law that falls with its place passes zero.
        passes = (values[:-1] > 0.0) & (values[1:] < 0.0)
        lowest = energies[:-1][passes] + 0.5 * values[:-1][passes] ** 2 / slopes[passes]
        index = _pieces(places, at)
        beyond = at - places[index]
        done = (values[index] + 0.5 * slopes[index] * beyond) * beyond
        return np.asarray(energies[index] - done - min(np.min(energies), *lowest, np.inf))

    def _of_function(self, function: Callable[..., Any], at: Sequence[float], label: str) -> float:
        """Return the value of a function at one place."""
        try:
            value = function(*at)
        except Exception as error:
            text = f"{label} {self._told(at)}"
            raise ArgumentError(f"{text} fails: {type(error).__name__}: {error}") from error
        if isinstance(value, float) and math.isfinite(value):
            return float(value)  # Simulations ask so often that words take their time.
        text = f"{label} {self._told(at)}"
        array = numbers(text, value)
        if array.size != 1:
            raise ArgumentError(f"{text} has shape {array.shape}, expected a number")
        return float(array.reshape(()))

    def _told(self, at: Sequence[float]) -> str:
        """Return where a law is taken, in words."""
        pairs = zip(self.of, at, strict=True)
        told = (_AT.get(name, f"{name} {{:g}}").format(value) for name, value in pairs)
        return f"at {', '.join(told)}"


class LawElement(Element):
    """An element that a law says.

    Attributes:
        along: name of the position or length of which a table stores energy.
    """

    along: ClassVar[str]

    @property
    @abstractmethod
    def law(self) -> Law:
        """The law."""

    @property
    def conserves(self) -> bool:
        """Whether its law is a table of its position or length."""
        return self.law.is_potential(self.along)

    @property
    def is_damper(self) -> bool:
        """Whether its law is one of the rate alone."""
        return self.law.of == ("rate",)

    @property
    def gives_power(self) -> bool:
        """See `Element.gives_power`."""
        return not (self.conserves or self.is_damper)

    @property
    def follows_time(self) -> bool:
        """Whether its law is a function or table of time."""
        return "time" in self.law.of

    @property
    def has_functions(self) -> bool:
        """Whether its law is a function or table."""
        return bool(self.law.of)

    @property
    def limits(self) -> str:
        """See `Element.limits`."""
        return self.law.limits


def _parts(table: Array, count: int) -> tuple[tuple[Array, ...], Array]:
    """Return the places of one thing or two of a table, and its values; see `Given`."""
    if count == 1:
        return (table[:, 0],), table[:, -1]
    return (table[1:, 0], table[0, 1:]), table[1:, 1:]


def _of_table(table: Array, at: Sequence[Array]) -> Array:
    """Return values of a table, on straight lines between its places; NaN where it has ended."""
    axes, values = _parts(table, len(at))
    is_there, before = np.ones(len(at[0]), dtype=bool), list[tuple[Array, ...]]()
    for places, place in zip(axes, at, strict=True):
        within, index = np.clip(place, places[0], places[-1]), _pieces(places, place)
        is_there &= np.abs(place - within) <= NOTHING * (places[-1] - places[0])
        before.append((index, places[index + 1] - places[index], within - places[index]))

    def between(*indices: Array) -> Array:
        if len(indices) == len(before):
            return values[indices]
        index, width, beyond = before[len(indices)]
        low, high = between(*indices, index), between(*indices, index + 1)
        return low + (high - low) / width * beyond

    return np.where(is_there, between(), np.nan)


def _pieces(places: Array, at: Array) -> Array:
    """Return between which rows of a table places are: the index of the first of both."""
    found = np.searchsorted(places, at, side="right") - 1
    return np.asarray(np.clip(found, 0, len(places) - 2))


def _of_arrays(function: Callable[..., Any], at: Sequence[Array]) -> Array | None:
    """Return the values of a function of arrays, None if it takes no arrays."""
    try:
        values = np.asarray(function(*(item.copy() for item in at)))
    except Exception:  # It was written for numbers, and fails with arrays in any way.
        return None
    return values if values.shape == at[0].shape and values.dtype.kind in "iuf" else None
