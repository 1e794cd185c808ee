"""Element: what all force elements have in common, and checks of their numbers."""

from __future__ import annotations

import math

from ..checks import number, positive, text
from ..description.description import Record
from ..errors import ArgumentError


class Element(Record):
    """A force element: frozen data, checked when it is made and by the scene that it is given to.

    Two elements are equal where all their values are.

    Attributes:
        name: by which results show it, beside its index; may be empty.
    """

    name: str

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the coordinates along which it exerts an effort."""
        return ()

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links on which it exerts a wrench."""
        return ()

    def _set(self, **values: object) -> None:
        """Set fields to what was checked; only constructors call it."""
        for field, value in values.items():
            object.__setattr__(self, field, value)

    def _number(self, field: str, least: float = -math.inf) -> float:
        """Return a field as a finite number.

        Args:
            field: its name.
            least: the smallest number that it may be.

        Raises:
            ArgumentError: it is no number, not finite, or less.
        """
        return number(f"{type(self).__name__}: {field}", getattr(self, field), least)

    def _positive(self, field: str) -> float:
        """Return a field as a finite number greater than zero.

        Raises:
            ArgumentError: it is anything else.
        """
        return positive(f"{type(self).__name__}: {field}", getattr(self, field))

    def _text(self, field: str) -> str:
        """Return a field as a string.

        Raises:
            ArgumentError: it is anything else.
        """
        return text(f"{type(self).__name__}: {field}", getattr(self, field))

    def _two_links(self) -> tuple[str, str]:
        """Return the fields `link_a` and `link_b`.

        Raises:
            ArgumentError: they are no strings, or the same.
        """
        first, second = self._text("link_a"), self._text("link_b")
        if first == second:
            raise ArgumentError(
                f"{type(self).__name__}: both ends are on link {first!r}; it connects two links"
            )
        return first, second
