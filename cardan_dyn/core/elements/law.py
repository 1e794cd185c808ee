"""Law: what an actuator exerts, a number, a table or a function of times, positions or rates."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple, TypeAlias

import numpy as np

from ...kit.arrays import NOTHING, Array
from ...kit.checks import described, numbers
from ...kit.errors import ArgumentError, choices
from .element import Element

Given: TypeAlias = float | Array | Callable[..., Any]
"""A number; a table `(n, 2)`, n at least 2, of places that ascend and values; or a function."""

_AT = {"time": "{:g} s", "length": "length {:g} m", "rate": "rate {:g} m/s"}
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
        if not names or not all(isinstance(name, str) and name in known for name in names):
            kind = label.partition(":")[0]
            raise ArgumentError(f"{kind}: of is {described(of)}; it is {choices(known)}")
        if callable(given):
            return Law(given, names)
        array = numbers(label, given)
        if not array.ndim:
            return Law(float(array), ())
        if array.ndim != 2 or array.shape[1] != 2 or len(array) < 2 or len(names) > 1:
            raise ArgumentError(
                f"{label} has shape {array.shape}, expected a number, a function, or a table "
                f"(n, 2) of one of: {choices(known)}"
            )
        if not np.all(np.diff(array[:, 0]) > 0.0):
            raise ArgumentError(f"{label}: the first column of a table ascends")
        return Law(array, names)

    @property
    def limits(self) -> str:
        """See `Element.limits`."""
        if not isinstance(self.given, np.ndarray):
            return ""
        first, last = self.given[[0, -1], 0]
        return f"its table of {self.of[0]} goes from {first:g} to {last:g}"

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
            found = _of_table(given, at[0])
            ended = np.isnan(found) & np.isfinite(at[0])
            if np.any(ended):
                raise ArgumentError(
                    f"{label} {self._told([at[0][ended][0]])}: {self.limits}; give it as many rows "
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
            return float(_of_table(given, np.array([places[self.of[0]]]))[0])
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
        text = f"{label} {self._told(at)}"
        try:
            value = function(*at)
        except Exception as error:
            raise ArgumentError(f"{text} fails: {type(error).__name__}: {error}") from error
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


def _of_table(table: Array, at: Array) -> Array:
    """Return values of a table, on straight lines between its rows; NaN where it has ended."""
    places, values = table.T
    within, index = np.clip(at, places[0], places[-1]), _pieces(places, at)
    slopes = np.diff(values) / np.diff(places)
    found = values[index] + slopes[index] * (within - places[index])
    is_there = np.abs(at - within) <= NOTHING * (places[-1] - places[0])
    return np.where(is_there, found, np.nan)


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
