"""Elimination: sparse linear equations of scalars, in an order chosen at samples seen before.

Rows are mappings of columns to entries; what is missing is zero. Where the pivots stand is decided
once, at some samples; at any other sample the growth of the elimination tells whether they serve
there as well.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import chain, islice
from typing import NamedTuple, TypeAlias

import numpy as np

from ..arrays import Array
from ..tape import absolute, greater, is_zero
from .vectors import Scalar

Row = Mapping[int, Scalar]
"""Column to entry of a row of a sparse matrix."""
_Candidate: TypeAlias = tuple[int, float, float, float]
"""An entry that may be the pivot of its column: its row, and what part of the greatest entry of the
column it is: at the first sample, the least, and the mean over all samples."""

THRESHOLD = 0.1
"""Part of the greatest entry of its column that a pivot has at least, at all samples at which the
order is chosen: the usual compromise of threshold pivoting (Davis 2006, chapter 6)."""
MOST_GROWTH = 1.0 / THRESHOLD
"""Growth of an elimination up to which its order serves: what is allowed where it is chosen."""
_NOTHING = 1e-9
"""Entry, in units of the length and of one, that counts as none unless somebody says otherwise: the
rank tolerance of the kinematics."""


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
        growth: greatest factor by which rows were taken from others: errors are those of rounding
            the entries while it is small (Golub and Van Loan 2013, section 3.4).
        narrowness: greatest ratio of a pivot's size at the samples at which the order was chosen to
            its own; it is great near singular positions, and infinite or NaN there.
    """

    steps: list[_Step]
    redundant: list[int]
    growth: Scalar
    narrowness: Scalar

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


class UnsuitableError(Exception):
    """No order suits all samples."""


def pivots(
    rows: Sequence[Mapping[int, Array]],
    blocks: Sequence[tuple[Collection[int], Collection[int]]] | None = None,
    nothing: float = _NOTHING,
) -> list[Pivot]:
    """Choose an order of elimination at S samples, by Markowitz's count among large enough pivots.

    Where no pivot is large enough at all samples, the one that is largest on the average is taken:
    samples at which it is small show it by their growth. At the first sample it is large enough in
    any case, if one is: that is where lines begin.

    Args:
        rows: column to entries `(S,)`.
        blocks: rows and columns to be eliminated together, each block after those whose columns are
            in its rows; redundant rows are those of each block by itself. All in one if None.
        nothing: entry that counts as none.

    Raises:
        UnsuitableError: a column vanishes at all samples.
    """
    shape = max((np.shape(x) for entries in rows for x in entries.values()), default=()) or (1,)
    left = [
        {c: x if np.shape(x) == shape else np.full(shape, x) for c, x in entries.items()}
        for entries in rows
    ]
    columns: dict[int, set[int]] = {}
    for index, entries in enumerate(left):
        for column in entries:
            columns.setdefault(column, set()).add(index)
    order: list[Pivot] = []
    for own_rows, own_columns in blocks or [(range(len(rows)), list(columns))]:
        free, undone = set(own_rows), set(own_columns)
        judged: dict[int, list[_Candidate]] = {}
        while undone:
            judged |= _candidates(
                {c: sorted(columns.get(c, set()) & free) for c in undone.difference(judged)},
                left,
                nothing,
            )
            best: tuple[bool, bool, float, float, int, int] | None = None
            for column in undone:
                for row, first, least, mean in judged[column]:
                    is_small = least < THRESHOLD
                    cost = (len(left[row]) - 1) * (len(columns[column]) - 1)
                    worth = -mean if is_small else float(cost)
                    key = first < THRESHOLD, is_small, worth, -least, row, column
                    if best is None or key < best:
                        best = key
            if best is None or (best[1] and best[2] == 0.0):
                raise UnsuitableError
            *_, row, column = best
            free.discard(row)
            undone.discard(column)
            pivot = left[row].pop(column)
            order.append(Pivot(row, column, float(np.abs(pivot).max())))
            below = columns.pop(column) - {row}
            for other in left[row]:
                columns[other].discard(row)
                judged.pop(other, None)
            right = np.array(list(left[row].values())).reshape(-1, *shape)
            with np.errstate(all="ignore"):  # A pivot may vanish at a sample.
                for own in (left[owner] for owner in below):
                    taken = own.pop(column) / pivot * right
                    for other, entry in zip(left[row], taken, strict=True):
                        own[other] = own.get(other, 0.0) - entry
            for other in left[row]:
                columns[other] |= below
    return order


def _candidates(
    owners: Mapping[int, Sequence[int]], left: Sequence[Mapping[int, Array]], nothing: float
) -> dict[int, list[_Candidate]]:
    """Return the entries of columns, in rows each."""
    counts = [len(rows) for rows in owners.values() if rows]
    if not counts:
        return {column: [] for column in owners}
    sizes = np.abs([left[row][column] for column, rows in owners.items() for row in rows])
    # Samples at which an earlier pivot vanished, or the whole column does, tell nothing.
    sizes[~np.isfinite(sizes)] = 0.0
    most = np.maximum.reduceat(sizes, np.cumsum([0, *counts[:-1]]))
    most[most <= nothing] = np.inf
    sizes /= np.repeat(most, counts, axis=0)
    parts = map(np.ndarray.tolist, (sizes[:, 0], sizes.min(axis=1), sizes.mean(axis=1)))
    entries = zip(chain.from_iterable(owners.values()), *parts, strict=True)
    return {column: list(islice(entries, len(rows))) for column, rows in owners.items()}


def eliminated(rows: Sequence[Row], order: Sequence[Pivot]) -> Eliminated:
    """Factorise a matrix in an order that was chosen before."""
    left = [{c: value for c, value in entries.items() if not is_zero(value)} for entries in rows]
    columns: dict[int, set[int]] = {}
    for index, entries in enumerate(left):
        for column in entries:
            columns.setdefault(column, set()).add(index)
    steps: list[_Step] = []
    growth: Scalar = 0.0
    narrowness: Scalar = 0.0
    for row, column, size in order:
        pivot = left[row].pop(column)
        inverse = 1.0 / pivot
        narrowness = greater(narrowness, absolute(inverse) * size)
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
    return Eliminated(steps, redundant, growth, narrowness)
