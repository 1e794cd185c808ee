"""Columns: what the wrenches of a response are proportional to, and the order of its functions."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import NamedTuple

from ...kit.arrays import Array

AXES = ("x", "y", "z")


class Acts(Enum):
    """What a column belongs to."""

    SPEED_SQUARED = "speed²"
    ACCELERATION = "acceleration"
    JOINT_LOAD = "load"
    LINK_LOAD = "wrench"
    GRAVITY = "gravity"


class Column(NamedTuple):
    """What wrenches are proportional to.

    The kind is kept apart from the name, since a joint may be called `gravity` or `speed²`.

    Attributes:
        kind: what it belongs to.
        name: the loaded joint or link, or the axis of gravity; else empty.
    """

    kind: Acts
    name: str = ""

    @property
    def label(self) -> str:
        """Its name in messages; not unique, since a joint may have the same name."""
        if self.kind in (Acts.JOINT_LOAD, Acts.LINK_LOAD):
            return self.name
        return f"{self.kind.value} {self.name}".strip()


SPEED_SQUARED = Column(Acts.SPEED_SQUARED)
ACCELERATION = Column(Acts.ACCELERATION)
GRAVITY = tuple(Column(Acts.GRAVITY, axis) for axis in AXES)


@dataclass(frozen=True)
class Layout:
    """Order of all C functions: column by column, the same functions in each.

    These are the wrenches of the outputs, six components each, then efforts, then the moments of
    couplings.

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
    def wrenches(self) -> int:
        """Number of components of wrenches in a column: the index of its first effort."""
        return 6 * len(self.outputs)

    @cached_property
    def moments(self) -> int:
        """Index of the first moment of a coupling in a column."""
        return self.wrenches + len(self.efforts)

    @cached_property
    def size(self) -> int:
        """Number of functions of a column."""
        return self.moments + len(self.couplings)

    def row(self, column: Column, function: int) -> int:
        """Return the index of a function among all of them, by its index in its column."""
        return self.size * self.columns.index(column) + function

    def split(self, values: Array) -> tuple[Array, Array]:
        """Return wrenches `(columns, outputs, 6)` and others `(columns, ...)` of values `(C,)`."""
        each = values.reshape(len(self.columns), self.size)
        wrenches = each[:, : self.wrenches].reshape(len(each), len(self.outputs), 6)
        return wrenches, each[:, self.wrenches :]
