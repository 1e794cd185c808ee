"""Columns: what the wrenches of a response are proportional to, and the order of its functions."""

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
    """What wrenches are proportional to.

    The kind is kept apart from the name, since a joint may be called `gravity` or `speed²`.

    Attributes:
        kind: what it belongs to.
        name: the loaded joint or link, or the axis of gravity; else empty.
    """

    kind: Kind
    name: str = ""

    @property
    def label(self) -> str:
        """Its name in messages; not unique, since a joint may have the same name."""
        if self.kind in (Kind.JOINT_LOAD, Kind.LINK_LOAD):
            return self.name
        return f"{self.kind.value} {self.name}".strip()


SPEED_SQUARED = Column(Kind.SPEED_SQUARED)
ACCELERATION = Column(Kind.ACCELERATION)
GRAVITY = tuple(Column(Kind.GRAVITY, axis) for axis in AXES)


@dataclass(frozen=True)
class Layout:
    """Order of all C functions in one list: the wrenches of all columns, then the scalars.

    The scalars of a column are the efforts, then the moments of the couplings.

    Attributes:
        columns: what wrenches are proportional to.
        outputs: joints whose wrenches are kept.
        efforts: the driven joint, then the held ones.
        couplings: couplings whose moments are kept.
    """

    columns: tuple[Column, ...]
    outputs: tuple[str, ...]
    efforts: tuple[str, ...]
    couplings: tuple[str, ...]

    @cached_property
    def count(self) -> int:
        """Number of functions C."""
        return self._wrench_count + len(self.columns) * self._scalars_per_column

    @cached_property
    def _wrench_count(self) -> int:
        """Number of functions that are components of wrenches."""
        return 6 * len(self.outputs) * len(self.columns)

    @cached_property
    def _scalars_per_column(self) -> int:
        return len(self.efforts) + len(self.couplings)

    @cached_property
    def _indices(self) -> dict[Column, int]:
        return {column: index for index, column in enumerate(self.columns)}

    def wrench(self, column: Column, output: int) -> range:
        """Return the indices of the six components of a wrench, by the index of its output."""
        first = 6 * (len(self.outputs) * self._indices[column] + output)
        return range(first, first + 6)

    def effort(self, column: Column, index: int) -> int:
        """Return the index of an effort, by its index in `efforts`."""
        return self._wrench_count + self._scalars_per_column * self._indices[column] + index

    def coupling(self, column: Column, index: int) -> int:
        """Return the index of a coupling's moment, by its index in `couplings`."""
        return self.effort(column, len(self.efforts) + index)

    def joined(self, wrenches: Array, scalars: Array) -> Array:
        """Return one list `(C, ...)` of all functions.

        Args:
            wrenches: `(columns, outputs, 6, ...)`.
            scalars: `(columns, efforts and couplings, ...)`.
        """
        lists = (
            wrenches.reshape(self._wrench_count, *wrenches.shape[3:]),
            scalars.reshape(self._scalars_per_column * len(self.columns), *scalars.shape[2:]),
        )
        return np.concatenate(lists)

    def split(self, values: Array) -> tuple[Array, Array]:
        """Return the wrenches and scalars of one list `(C, ...)`: the inverse of `joined`."""
        wrenches, scalars = values[: self._wrench_count], values[self._wrench_count :]
        return (
            wrenches.reshape(len(self.columns), len(self.outputs), 6, *values.shape[1:]),
            scalars.reshape(len(self.columns), self._scalars_per_column, *values.shape[1:]),
        )

    def spread(self, values: Array) -> Array:
        """Return one value per column `(columns,)` as one per function `(C,)`."""
        count = len(self.columns)
        wrenches = np.broadcast_to(values[:, None, None], (count, len(self.outputs), 6))
        scalars = np.broadcast_to(values[:, None], (count, self._scalars_per_column))
        return self.joined(wrenches, scalars)
