"""Columns: what the wrenches of a response are proportional to, and where its functions stand."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from ..arrays import Array

AXES = ("x", "y", "z")


class Kind(Enum):
    """What a column belongs to."""

    SPEED_SQUARED = "speed²"
    ACCELERATION = "acceleration"
    JOINT_LOAD = "load"
    LINK_LOAD = "wrench"
    GRAVITY = "gravity"


@dataclass(frozen=True)
class Column:
    """What wrenches are proportional to. A kind apart from the name, since joints have any name.

    Attributes:
        kind: what it belongs to.
        name: the loaded joint or link, or the axis of gravity; else empty.
    """

    kind: Kind
    name: str = ""

    @property
    def label(self) -> str:
        """How people call it; a joint may have the same name."""
        if self.kind in (Kind.JOINT_LOAD, Kind.LINK_LOAD):
            return self.name
        return f"{self.kind.value} {self.name}".strip()


SPEED_SQUARED = Column(Kind.SPEED_SQUARED)
ACCELERATION = Column(Kind.ACCELERATION)
GRAVITY = tuple(Column(Kind.GRAVITY, axis) for axis in AXES)


@dataclass(frozen=True)
class Layout:
    """Places of functions in one list: wrenches of all columns first, single efforts after them.

    Attributes:
        columns: what wrenches are proportional to.
        outputs: joints whose wrenches are kept.
        efforts: the driven joint, then the held ones.
        couplings: gears whose moments are kept.
    """

    columns: tuple[Column, ...]
    outputs: tuple[str, ...]
    efforts: tuple[str, ...]
    couplings: tuple[str, ...]

    @cached_property
    def count(self) -> int:
        """Number of functions."""
        return len(self.columns) * (6 * len(self.outputs) + self._singles)

    @cached_property
    def _numbers(self) -> dict[Column, int]:
        return {column: number for number, column in enumerate(self.columns)}

    @cached_property
    def _singles(self) -> int:
        return len(self.efforts) + len(self.couplings)

    def wrench(self, column: Column, output: int) -> range:
        """Return the places of the six components of an output's wrench, by its number."""
        first = 6 * (len(self.outputs) * self._numbers[column] + output)
        return range(first, first + 6)

    def effort(self, column: Column, number: int) -> int:
        """Return the place of an effort: 0 of the drive, then those of the held joints."""
        before = 6 * len(self.outputs) * len(self.columns)
        return before + self._singles * self._numbers[column] + number

    def coupling(self, column: Column, number: int) -> int:
        """Return the place of a coupling's moment, by its number."""
        return self.effort(column, len(self.efforts) + number)

    def joined(self, wrenches: Array, singles: Array) -> Array:
        """Return one list `(C, ...)` of all functions.

        Args:
            wrenches: `(columns, outputs, 6, ...)`.
            singles: `(columns, efforts and couplings, ...)`.
        """
        parts = (
            wrenches.reshape(6 * len(self.outputs) * len(self.columns), *wrenches.shape[3:]),
            singles.reshape(self._singles * len(self.columns), *singles.shape[2:]),
        )
        return np.concatenate(parts)

    def parted(self, values: Array) -> tuple[Array, Array]:
        """Return wrenches and singles, see `joined`, of one list `(C, ...)`."""
        before = 6 * len(self.outputs) * len(self.columns)
        wrenches, singles = values[:before], values[before:]
        return (
            wrenches.reshape(len(self.columns), len(self.outputs), 6, *values.shape[1:]),
            singles.reshape(len(self.columns), self._singles, *values.shape[1:]),
        )

    def spread(self, values: Array) -> Array:
        """Return one value per column `(columns,)` as one per function `(C,)`."""
        count = len(self.columns)
        wrenches = np.broadcast_to(values[:, None, None], (count, len(self.outputs), 6))
        singles = np.broadcast_to(values[:, None], (count, self._singles))
        return self.joined(wrenches, singles)
