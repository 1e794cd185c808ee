"""Variable: values of a table with names for their dimensions, and units."""

from __future__ import annotations

from typing import NamedTuple

from ..arrays import Array


class Variable(NamedTuple):
    """Values with names for their dimensions.

    Attributes:
        dims: names of the dimensions.
        values: an array of these.
        units: one for all values, or one per entry of the last dimension.
        long_name: what they are.
        is_coordinate: whether they were given, as drive positions and loads are, and not solved.
    """

    dims: tuple[str, ...]
    values: Array
    units: str | tuple[str, ...]
    long_name: str
    is_coordinate: bool = False

    @property
    def unit(self) -> str:
        """All units that occur, in one text."""
        units = (self.units,) if isinstance(self.units, str) else self.units
        return " or ".join(dict.fromkeys(units))
