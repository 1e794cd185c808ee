"""Elimination: sparse linear equations of scalars, in an order chosen at samples seen before.

Rows are mappings of columns to entries; what is missing is zero. Where the pivots stand is decided
once, at some samples; at any other sample the growth of the elimination tells whether they serve
there as well.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np

from ...kit.arrays import NOTHING, Array
from ..tape import absolute, greater, is_zero
from .vectors import Scalar

Found = TypeVar("Found")
Row = Mapping[int, Scalar]
"""Column to entry of a row of a sparse matrix."""
Blocks: TypeAlias = Sequence[tuple[Collection[int], Collection[int]]]
"""Rows and columns to be eliminated together, each block after those whose columns are in its rows;
redundant rows are those of each block by itself."""

THRESHOLD = 0.1
"""Part of the greatest entry of its column that a pivot has at least, at all samples at which the
order is chosen, each entry beside the greatest of its row: the usual compromise of threshold
pivoting (Davis 2006, chapter 6). Its reciprocal is the growth of an elimination up to which its
order serves: what is allowed where it is chosen."""

_LEAST_ROW = 1e5
"""Times nothing up to which rows count as if that were their greatest entry: 1e-4 unless somebody
says otherwise. Closed to rounding, 1e-12, they tell their columns worse than to 1e-8, which is
proven. Axes that are parallel but for digits have such rows, of which others tell all."""


def product(first: Row, second: Row) -> Scalar:
    """Return the sum of products of entries that both have."""
    return sum((entry * second[key] for key, entry in first.items() if key in second), 0.0)


def combined(rows: Sequence[Row], factors: Sequence[Scalar]) -> dict[int, Scalar]:
    """Return the sum of rows, each times its factor."""
    result: dict[int, Scalar] = {}
    for row, factor in zip(rows, factors, strict=True):
        if not is_zero(factor):
            for column, entry in row.items():
                result[column] = result.get(column, 0.0) + entry * factor
    return result


class Pivot(NamedTuple):
    """A pivot of an order.

    Attributes:
        row, column: where it stands.
        size: its greatest magnitude at the samples at which it was chosen.
    """

    row: int
    column: int
    size: float


class Order(NamedTuple):
    """An order of elimination.

    Attributes:
        pivots: in their order.
        sizes: greatest magnitude in each row at the samples at which it was chosen, one where there
            is nothing, and not less than `_LEAST_ROW`; none where rows are of one size.
    """

    pivots: Sequence[Pivot]
    sizes: Sequence[float] = ()

    @property
    def places(self) -> list[tuple[int, int]]:
        """Where the pivots stand."""
        return [pivot[:2] for pivot in self.pivots]


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
        growth: greatest factor by which rows were taken from others, each in units of its size:
            errors are those of rounding the entries while it is small (Golub and Van Loan 2013,
            section 3.4).
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

    def balanced(
        self,
        found: Callable[[Mapping[int, Scalar]], Found],
        lacking: Callable[[Found], Mapping[int, Scalar]],
    ) -> Found:
        """Return what is found with y, by which Aᵀ y makes up for all that is lacking.

        Args:
            found: returns what is found with some y, which is zero where it is missing.
            lacking: returns b - Aᵀ y by columns, of what is found.
        """
        return found(self.solve_transposed(lacking(found({}))))

    def dependence(self, row: int) -> dict[int, Scalar]:
        """Return y with Aᵀ y = 0 that is one in a redundant row, zero in the other ones."""
        result: dict[int, Scalar] = {row: 1.0}
        self._taken_back(result)
        return {index: value for index, value in result.items() if not is_zero(value)}

    def chosen(self, amounts: dict[int, Scalar]) -> dict[int, Scalar]:
        """Return amounts of dependences that something else than the rows decides."""
        return amounts

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


def chosen(
    rows: Sequence[Mapping[int, Array]], blocks: Blocks | None = None, nothing: float = NOTHING
) -> Order:
    """Choose an order of elimination at S samples, by Markowitz's count among large enough pivots.

    Where no pivot is large enough at all samples, the one that is largest on the average is taken:
    samples at which it is small show it by their growth. At the first sample it is large enough in
    any case, if one is: that is where lines begin.

    Args:
        rows: column to entries `(S,)`.
        blocks: see `Blocks`; all in one if None.
        nothing: entry, in units of the length and of one, that counts as none.

    Raises:
        UnsuitableError: a column vanishes at all samples.
    """
    left = _Left.of(rows, blocks, nothing, nothing)
    judged: dict[int, list[tuple[int, float, float, float]]] = {}
    while columns := left.undone():
        # At the first sample, the least, and the mean over all.
        for column, (owners, parts) in left.parts(columns.difference(judged)).items():
            if not owners:
                judged[column] = []
                continue
            told = parts[:, 0].tolist(), parts.min(axis=1).tolist(), parts.mean(axis=1).tolist()
            judged[column] = list(zip(owners, *told, strict=True))
        best: tuple[bool, bool, float, float, int, int] | None = None
        for column in columns:
            for row, first, least, mean in judged[column]:
                is_small = least < THRESHOLD
                worth = -mean if is_small else float(left.cost(row, column))
                key = first < THRESHOLD, is_small, worth, -least, row, column
                if best is None or key < best:
                    best = key
        if best is None or (best[1] and best[2] == 0.0):
            raise UnsuitableError
        for column in left.take(*best[-2:]):
            judged.pop(column, None)
    return left.order()


def chosen_at_each(
    rows: Sequence[Mapping[int, Array]], blocks: Blocks | None, nothing: float
) -> tuple[list[tuple[Order, Array]], Array]:
    """Choose an order at each of S samples, which does not depend on the others.

    It is the cheapest by Markowitz's count among large enough pivots there. Of equally cheap ones,
    those come first that are as large beside the others of their column without regard to the sizes
    of rows: rows of a loop are rounded alike, however small what one of them tells. Arguments as of
    `chosen`.

    Returns:
        Orders and the samples (index) that they are chosen at; and samples that have none.
    """
    left = _Left.of(rows, blocks, nothing, max(nothing, NOTHING))
    undone, done, without = [(left, np.arange(left.count))], [], [np.zeros(0, dtype=int)]
    while undone:
        left, samples = undone.pop()
        columns = left.undone()
        if not columns:
            done.append((left.order(), samples))
            continue
        parts = left.parts(columns)
        places = sorted(
            (left.cost(row, column), row, column)
            for column, (owners, _) in parts.items()
            for row in owners
        )
        of = {
            (row, column): own
            for column, (owners, every) in parts.items()
            for row, own in zip(owners, every, strict=True)
        }
        sizes = np.array([of[place[1:]] for place in places]).reshape(len(places), left.count)
        is_large = sizes >= THRESHOLD
        costs = np.array([place[0] for place in places]).reshape(-1, 1)
        ranked = np.where(is_large, costs - 0.5 * left.stand_out(places), np.inf)
        best = ranked.argmin(axis=0) if len(places) else np.zeros(left.count, dtype=int)
        is_any = is_large.any(axis=0)
        without.append(samples[~is_any])
        for index in np.unique(best[is_any]):
            (own,) = (is_any & (best == index)).nonzero()
            part = left if len(own) == left.count else left.at(own)
            part.take(*places[index][1:])
            undone.append((part, samples[own]))
    return done, np.sort(np.concatenate(without))


class _Left:
    """What is left of a matrix at some samples while it is eliminated.

    Attributes:
        count: of the samples.
    """

    def __init__(
        self,
        rows: list[dict[int, Array]],
        sizes: Array,
        owners: dict[int, set[int]],
        blocks: list[tuple[set[int], set[int]]],
        nothing: float,
    ) -> None:
        """Begin with rows of entries `(S,)`, their sizes `(rows, S)`, and the rows of columns."""
        self._rows, self._sizes, self._owners, self._blocks = rows, sizes, owners, blocks
        self._nothing, self.count = nothing, sizes.shape[1]
        self._pivots: list[Pivot] = []
        self._known: dict[int, tuple[list[int], Array]] = {}  # Of columns, see `parts`.

    @staticmethod
    def of(
        rows: Sequence[Mapping[int, Array]], blocks: Blocks | None, nothing: float, unit: float
    ) -> _Left:
        """Return all of a matrix; arguments as of `chosen`, and nothing for rows."""
        shape = max((np.shape(x) for entries in rows for x in entries.values()), default=()) or (1,)
        own = [
            {c: x if np.shape(x) == shape else np.full(shape, x) for c, x in entries.items()}
            for entries in rows
        ]
        sizes = np.ones((len(own), *shape))
        for size, entries in zip(sizes, own, strict=True):
            if entries:
                np.abs(list(entries.values())).max(axis=0, out=size)
        sizes[~(sizes > nothing)] = 1.0
        np.maximum(sizes, _LEAST_ROW * unit, out=sizes)
        owners: dict[int, set[int]] = {}
        for index, entries in enumerate(own):
            for column in entries:
                owners.setdefault(column, set()).add(index)
        every = blocks or [(range(len(rows)), list(owners))]
        return _Left(own, sizes, owners, [(set(of[0]), set(of[1])) for of in every], nothing)

    def at(self, samples: Array) -> _Left:
        """Return a copy at some of the samples."""
        result = _Left(
            [{c: x[samples] for c, x in entries.items()} for entries in self._rows],
            self._sizes[:, samples],
            {column: set(rows) for column, rows in self._owners.items()},
            [(set(rows), set(columns)) for rows, columns in self._blocks],
            self._nothing,
        )
        result._pivots = list(self._pivots)
        result._known = {
            column: (owners, part[:, samples]) for column, (owners, part) in self._known.items()
        }
        return result

    def undone(self) -> set[int]:
        """Return the columns that are to be eliminated next."""
        while self._blocks and not self._blocks[0][1]:
            del self._blocks[0]
        return self._blocks[0][1] if self._blocks else set()

    def parts(self, columns: Collection[int]) -> dict[int, tuple[list[int], Array]]:
        """Return rows of columns, and what part of the greatest entry theirs are `(rows, S)`.

        Each entry counts beside the size of its row.
        """
        free = self._blocks[0][0]
        own = {
            c: sorted(self._owners.get(c, set()) & free) for c in columns if c not in self._known
        }
        places = [(row, column) for column, owners in own.items() for row in owners]
        sizes = np.abs([self._rows[row][column] for row, column in places])
        sizes = sizes.reshape(len(places), self.count)
        # Samples at which an earlier pivot vanished, or the whole column does, tell nothing.
        sizes[~(np.isfinite(sizes) & (sizes > self._nothing))] = 0.0
        sizes /= self._sizes[[row for row, _ in places]]
        first = 0
        for column, owners in own.items():
            part = sizes[first : first + len(owners)]
            first += len(owners)
            most = part.max(axis=0, initial=0.0)
            most[most == 0.0] = np.inf
            self._known[column] = owners, part / most
        return {column: self._known[column] for column in columns}

    def stand_out(self, places: Sequence[tuple[int, int, int]]) -> Array:
        """Return whether entries are large beside all of their columns `(places, S)`.

        Args:
            places: of each the cost, the row and the column.
        """
        entries = np.abs([self._rows[row][column] for _, row, column in places])
        most: dict[int, Array] = {}
        for (_, _, column), entry in zip(places, entries, strict=True):
            most[column] = np.fmax(most.get(column, 0.0), entry)
        greatest = np.array([most[column] for _, _, column in places])
        return np.asarray(entries >= THRESHOLD * greatest).reshape(len(places), self.count)

    def cost(self, row: int, column: int) -> int:
        """Return how many entries a pivot may add, by Markowitz."""
        return (len(self._rows[row]) - 1) * (len(self._owners[column]) - 1)

    def take(self, row: int, column: int) -> list[int]:
        """Eliminate a column by one of its rows; return the columns that this changes."""
        rows, (free, undone) = self._rows, self._blocks[0]
        free.discard(row)
        undone.discard(column)
        pivot = rows[row].pop(column)
        self._pivots.append(Pivot(row, column, float(np.abs(pivot).max())))
        below = self._owners.pop(column) - {row}
        for other in rows[row]:
            self._owners[other].discard(row)
        right = np.array(list(rows[row].values())).reshape(-1, self.count)
        with np.errstate(all="ignore"):  # A pivot may vanish at a sample.
            for own in (rows[owner] for owner in below):
                taken = own.pop(column) / pivot * right
                for other, entry in zip(rows[row], taken, strict=True):
                    own[other] = own.get(other, 0.0) - entry
        for other in rows[row]:
            self._owners[other] |= below
            self._known.pop(other, None)
        return list(rows[row])

    def order(self) -> Order:
        """Return the order in which columns were eliminated."""
        return Order(self._pivots, self._sizes.max(axis=1).tolist())


def eliminated(rows: Sequence[Row], order: Order) -> Eliminated:
    """Factorise a matrix in an order that was chosen before."""
    left = [{c: value for c, value in entries.items() if not is_zero(value)} for entries in rows]
    columns: dict[int, set[int]] = {}
    for index, entries in enumerate(left):
        for column in entries:
            columns.setdefault(column, set()).add(index)
    steps: list[_Step] = []
    growth: Scalar = 0.0
    narrowness: Scalar = 0.0
    sizes = order.sizes or [1.0] * len(rows)
    for row, column, size in order.pivots:
        pivot = left[row].pop(column)
        inverse = 1.0 / pivot
        narrowness = greater(narrowness, absolute(inverse) * size)
        right = sorted(left[row].items())  # Sums do not depend on which zeros are known.
        owners = columns.pop(column)
        owners.discard(row)
        for other, _ in right:
            columns[other].discard(row)
        below: list[tuple[int, Scalar]] = []
        for owner in sorted(owners):
            factor = left[owner].pop(column) * inverse
            below.append((owner, factor))
            growth = greater(growth, absolute(factor) * (sizes[row] / sizes[owner]))
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
