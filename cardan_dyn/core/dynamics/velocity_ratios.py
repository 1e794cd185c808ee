"""Velocity ratios: joint velocities per unit speed of each drive, without those that are zero.

In a mechanism of many drives each of them moves few joints: the ratios of all samples that can
differ from zero are kept, in rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.frozen import read_only


class VelocityRatios(NamedTuple):
    """Velocity ratios of N samples.

    Attributes:
        values: `(N, k)`.
        moved: `(nv, d)` index in a row of `values` by velocity coordinate and drive, -1 where the
            ratio is always zero.
    """

    values: Array
    moved: Array

    @staticmethod
    def of(dense: Array, depends: Array | None = None) -> VelocityRatios:
        """Return velocity ratios of an array.

        Args:
            dense: `(N, nv, d)`.
            depends: `(nv, d)` which of them may differ from zero; all if None.
        """
        count, *shape = dense.shape
        if depends is None:
            return VelocityRatios(read_only(dense.reshape(count, -1)), _all_moved(*shape))
        own, moved = _moved(depends.tobytes(), *shape)
        return VelocityRatios(read_only(dense.reshape(count, -1).take(own, 1)), moved)

    def __reduce__(self) -> tuple[object, ...]:
        # Through a function, which closes the arrays of a copy to writing as well.
        return _restored, tuple(self)

    @property
    def drives(self) -> int:
        """Number of drives."""
        return int(self.moved.shape[1])

    def of_coordinates(self, columns: slice, drive: int) -> Array:
        """Return `(N, k)` ratios of some velocity coordinates to one drive."""
        indices = self.moved[columns, drive]
        result = np.zeros((len(self.values), len(indices)))
        result[:, indices >= 0] = self.values[:, indices[indices >= 0]]
        return result

    def without(self, columns: Sequence[int]) -> VelocityRatios:
        """Return the same with ratios of some velocity coordinates that are not numbers."""
        unknown, moved = self.values.shape[1], self.moved.copy()
        moved[list(columns)] = unknown
        nothing = np.full((len(self.values), 1), np.nan)
        values = np.concatenate([self.values, nothing], axis=1)
        return VelocityRatios(read_only(values), read_only(moved))

    @staticmethod
    def joined(blocks: Sequence[VelocityRatios]) -> VelocityRatios:
        """Return the ratios of all samples of several blocks."""
        values = np.concatenate([block.values for block in blocks])
        return VelocityRatios(read_only(values), blocks[0].moved)


@lru_cache
def _all_moved(coordinates: int, drives: int) -> Array:
    """Return `VelocityRatios.moved` where no ratio is always zero."""
    return read_only(np.arange(coordinates * drives).reshape(coordinates, drives))


@lru_cache
def _moved(depends: bytes, coordinates: int, drives: int) -> tuple[Array, Array]:
    """Return which of all ratios may differ from zero, and `VelocityRatios.moved`, from flags."""
    flags = np.frombuffer(depends, dtype=bool)
    moved = np.where(flags, np.cumsum(flags) - 1, -1).reshape(coordinates, drives)
    return np.flatnonzero(flags), read_only(moved)


def _restored(values: Array, moved: Array) -> VelocityRatios:
    return VelocityRatios(read_only(values), read_only(moved))
