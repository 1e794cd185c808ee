"""Elimination: sparse linear equations of scalars, in an order chosen at samples seen before.

Rows are mappings of columns to entries; what is missing is zero. Where the pivots stand is decided
once, at some samples; at any other sample the growth of the elimination tells whether they serve
there as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..tape import absolute, greater, is_zero
from .vectors import Scalar

Row = Mapping[int, Scalar]
"""Column to entry of a row of a sparse matrix."""

THRESHOLD = 0.1
"""Part of the greatest entry of its column that a pivot has at least, at all samples at which the
order is chosen: the usual compromise of threshold pivoting (Davis 2006, section 6.3)."""
_REDUNDANT = 1e-9
"""Greatest entry, in units of the length and of one, of a row that counts as none: the rank
tolerance of the kinematics."""


class Pivot(NamedTuple):
    """A pivot of an order.

    Attributes:
        row, column: where it stands.
        size: its greatest magnitude at the samples at which it was chosen.
    """

    row: int
    column: int
    size: float


class _Step(NamedTuple):
    """One step of the elimination.

    Attributes:
        row, column: of the pivot.
        inverse: of it.
        below: rows that are still to be eliminated, with the factors taken from them.
        right: entries beside the pivot.
    """

    row: int
    column: int
    inverse: Scalar
    below: list[tuple[int, Scalar]]
    right: list[tuple[int, Scalar]]


class Eliminated(NamedTuple):
    """Factors of a matrix A with at least as many rows as columns.

    Attributes:
        steps: of the elimination.
        redundant: rows that the others imply, ascending.
        growth: greatest factor, and greatest ratio of a pivot's size at the samples at which the
            order was chosen to its own; each costs digits. NaN and infinity where one vanishes.
        determinant: product of all pivots.
    """

    steps: list[_Step]
    redundant: list[int]
    growth: Scalar
    determinant: Scalar

    def solve(self, right: Sequence[Scalar]) -> dict[int, Scalar]:
        """Return x with A x = b, as far as rows that are not redundant tell."""
        left = list(right)
        result: dict[int, Scalar] = {}
        for step in self.steps:
            for row, factor in step.below:
                left[row] = left[row] - factor * left[step.row]
        for step in reversed(self.steps):
            value = left[step.row]
            for column, entry in step.right:
                value = value - entry * result[column]
            result[step.column] = value * step.inverse
        return result

    def solve_transposed(self, right: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Return y with Aᵀ y = b, zero in redundant rows."""
        left = dict(right)
        result: dict[int, Scalar] = {}
        for step in self.steps:
            value = left[step.column] * step.inverse
            result[step.row] = value
            for column, entry in step.right:
                left[column] = left[column] - entry * value
        self._taken_back(result)
        return result

    def dependence(self, row: int) -> dict[int, Scalar]:
        """Return y with Aᵀ y = 0 that is one in a redundant row, zero in the other ones."""
        result: dict[int, Scalar] = {row: 1.0}
        self._taken_back(result)
        return {index: value for index, value in result.items() if not is_zero(value)}

    def _taken_back(self, result: dict[int, Scalar]) -> None:
        """Turn combinations of eliminated rows into those of the rows as they were."""
        for step in reversed(self.steps):
            value = result.get(step.row, 0.0)
            for row, factor in step.below:
                if row in result:
                    value = value - factor * result[row]
            result[step.row] = value


class Unsuitable(Exception):
    """No order suits all samples."""


def pivots(rows: Sequence[Mapping[int, Array]]) -> list[Pivot]:
    """Choose an order of elimination at S samples, by Markowitz's count among large enough pivots.

    Args:
        rows: column to entries `(S,)`.

    Raises:
        Unsuitable: a column has no entry that is large enough at all samples.
    """
    left = {index: dict(row) for index, row in enumerate(rows)}
    columns: dict[int, set[int]] = {}
    for index, row in left.items():
        for column in row:
            columns.setdefault(column, set()).add(index)
    order: list[Pivot] = []
    judged: dict[int, list[tuple[int, float]]] = {}
    while columns:
        best: tuple[int, float, int, int] | None = None
        for column, owners in columns.items():
            if column not in judged:
                judged[column] = _suitable(column, owners, left)
            for row, part in judged[column]:
                cost = (len(left[row]) - 1) * (len(owners) - 1)
                if best is None or (cost, -part) < best[:2]:
                    best = cost, -part, row, column
        if best is None:
            raise Unsuitable
        _, _, row, column = best
        pivot_row = left.pop(row)
        pivot = pivot_row.pop(column)
        order.append(Pivot(row, column, float(np.abs(pivot).max())))
        owners = columns.pop(column)
        owners.discard(row)
        judged.pop(column, None)
        for other in pivot_row:
            columns[other].discard(row)
            judged.pop(other, None)
        for owner in owners:
            target = left[owner]
            factor = target.pop(column) / pivot
            for other, entry in pivot_row.items():
                target[other] = target[other] - factor * entry if other in target else -factor * entry
                columns[other].add(owner)
    rest = max((np.abs(entry).max() for row in left.values() for entry in row.values()), default=0.0)
    if rest > _REDUNDANT:
        raise Unsuitable
    return order


def _suitable(
    column: int, owners: set[int], left: Mapping[int, Mapping[int, Array]]
) -> list[tuple[int, float]]:
    """Return the rows whose entries in a column can be pivots, with their least share."""
    rows = sorted(owners)
    if not rows:
        return []
    sizes = np.abs(np.array(np.broadcast_arrays(*(left[row][column] for row in rows))))
    sizes = sizes.reshape(len(rows), -1)
    most = sizes.max(axis=0)
    if most.min() <= _REDUNDANT:
        return []
    shares = (sizes / most).min(axis=1)
    return [(row, share) for row, share in zip(rows, shares.tolist(), strict=True) if share >= THRESHOLD]


def eliminated(rows: Sequence[Row], order: Sequence[Pivot]) -> Eliminated:
    """Factorise a matrix in an order that was chosen before."""
    left = [{c: value for c, value in row.items() if not is_zero(value)} for row in rows]
    columns: dict[int, set[int]] = {}
    for index, row in enumerate(left):
        for column in row:
            columns.setdefault(column, set()).add(index)
    steps: list[_Step] = []
    growth: Scalar = 0.0
    determinant: Scalar = 1.0
    for row, column, size in order:
        pivot = left[row].pop(column)
        inverse = 1.0 / pivot
        determinant = determinant * pivot
        growth = greater(growth, absolute(inverse) * size)
        right = list(left[row].items())
        owners = columns.pop(column)
        owners.discard(row)
        for other, _ in right:
            columns[other].discard(row)
        below: list[tuple[int, Scalar]] = []
        for owner in sorted(owners):
            factor = left[owner].pop(column) * inverse
            below.append((owner, factor))
            growth = greater(growth, absolute(factor))
            for other, entry in right:
                value = left[owner].get(other, 0.0) - factor * entry
                if is_zero(value):
                    left[owner].pop(other, None)
                    columns[other].discard(owner)
                else:
                    left[owner][other] = value
                    columns[other].add(owner)
        steps.append(_Step(row, column, inverse, below, right))
    done = {step.row for step in steps}
    redundant = [index for index in range(len(rows)) if index not in done]
    return Eliminated(steps, redundant, growth, determinant)
