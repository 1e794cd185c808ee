"""Implicit: linear equations whose solutions change as the equations say, however they are solved.

Of A x = b, x changes by A⁻¹ (b′ - A′ x). So an elimination itself is never differentiated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from ..mechanics.elimination import Eliminated, Found, Row, product
from ..tape import NOTHING, Differential, Factor, Scalar, Variable


class _Solution(NamedTuple):
    """What was solved.

    Attributes:
        found: unknown to its value, as what depends on it takes it.
        left: what is left of the equation of each pivot, with values that are held.
        moved: unknowns to what they change by, of what rows are off by.
        twins: what is made of the unknowns, and the same made of what is held.
    """

    found: dict[int, Scalar]
    left: list[Scalar]
    moved: Mapping[int, Scalar]
    twins: list[tuple[Scalar, Scalar]]


class Implicit(Eliminated):
    """Factors of a matrix that keep what is solved with them."""

    _rows: Sequence[Row]
    _columns: dict[int, dict[int, Scalar]]
    _off: Sequence[Variable]
    _marks: Sequence[Variable]
    _solutions: list[_Solution]
    _held: list[Scalar]

    @classmethod
    def of(
        cls,
        factors: Eliminated,
        rows: Sequence[Row],
        off: Sequence[Variable],
        marks: Sequence[Variable],
    ) -> Implicit:
        """Return those of a matrix.

        Args:
            factors: of it.
            rows: its rows.
            off: variables for what rows are off by.
            marks: two that are one, and by which nothing else is multiplied: what is found is
                marked by the first of them, what is held by the other one.
        """
        result = cls(*factors)
        result._rows, result._off, result._marks = rows, off, marks
        result._columns, result._solutions, result._held = {}, [], []
        for index, row in enumerate(rows):
            for column, entry in row.items():
                result._columns.setdefault(column, {})[index] = entry
        return result

    def solve(self, right: Sequence[Scalar]) -> dict[int, Scalar]:
        """See `Eliminated.solve`."""
        pairs = [(right[step.row], self._rows[step.row]) for step in self.steps]
        return self._kept(super().solve(right), pairs, super().solve(self._off))

    def balanced(
        self,
        found: Callable[[Mapping[int, Scalar]], Found],
        lacking: Callable[[Found], Mapping[int, Scalar]],
    ) -> Found:
        """See `Eliminated.balanced`."""
        values = self.solve_transposed(lacking(found({})))
        own, held = (_marked(values, mark) for mark in self._marks)
        result, twin = map(found, (own, held))
        lacks = lacking(twin)
        left = [lacks[step.column] for step in self.steps]
        self._held += held.values()
        numbers = zip(_numbers(result), _numbers(twin), strict=True)
        self._solutions.append(_Solution(own, left, self._back, [*numbers]))
        return result

    def dependence(self, row: int) -> dict[int, Scalar]:
        """See `Eliminated.dependence`."""
        pairs = [(0.0, self._columns[step.column]) for step in self.steps]
        return self._kept(super().dependence(row), pairs, self._back)

    def chosen(self, amounts: dict[int, Scalar]) -> dict[int, Scalar]:
        """See `Eliminated.chosen`: no number that is unique depends on how these change."""
        held = _marked(amounts, self._marks[1])
        self._held += held.values()
        return held

    @property
    def _back(self) -> dict[int, Scalar]:
        """What multipliers change by, of what columns are off by."""
        return self.solve_transposed({step.column: self._off[step.row] for step in self.steps})

    def _kept(
        self,
        values: dict[int, Scalar],
        equations: Sequence[tuple[Scalar, Row]],
        moved: Mapping[int, Scalar],
    ) -> dict[int, Scalar]:
        """Return what was found, marked."""
        found, held = (_marked(values, mark) for mark in self._marks)
        self._held += held.values()
        left = [right - product(held, row) for right, row in equations]
        self._solutions.append(_Solution(found, left, moved, []))
        return found

    def differentiated(self, differential: Differential, known: dict[Variable, int]) -> None:
        """Add how all that was found changes to what is known of changes."""
        known |= dict.fromkeys(map(_unsigned, filter(_is_variable, self._held)), NOTHING)
        for found, left, moved, twins in self._solutions:
            lines = [self._off[step.row] for step in self.steps]
            off = dict(zip(lines, differential.tangents(left, known, adds=True), strict=True))
            unknowns = {
                _unsigned(x): moved[key] if x is _unsigned(x) else -moved[key]
                for key, x in found.items()
                if _is_variable(x)
            }
            ways = differential.tangents([*unknowns.values()], off)
            changes = dict(zip(unknowns, ways, strict=True)) | known
            known |= {x: changes[x] for x in unknowns}
            # What is made of unknowns is linear in them.
            pairs = {_unsigned(x): _unsigned(twin) for x, twin in twins if _is_variable(x)}
            still = differential.tangents([*pairs.values()], known, adds=True)
            moving = differential.tangents([*pairs], {x: known[x] for x in unknowns})
            for x, *ways in zip(pairs, still, moving, strict=True):
                known.setdefault(x, differential.sum([(Factor(1.0), way) for way in ways]))


def _numbers(of: Any) -> Iterator[Scalar]:
    """Yield all scalars of what is nested."""
    if isinstance(of, (Variable, float)):  # NumPy's numbers are floats too.
        yield of
    else:
        for item in of.values() if isinstance(of, dict) else of:
            yield from _numbers(item)


def _marked(values: Mapping[int, Scalar], mark: Variable) -> dict[int, Scalar]:
    """Return values, of which those that are not numbers are told from others like them."""
    return {key: x * mark if _is_variable(x) else x for key, x in values.items()}


def _is_variable(x: Scalar) -> bool:
    return type(x) is Variable


def _unsigned(x: Variable) -> Variable:
    """Return what is marked of something: signs are written behind products."""
    return -x if x.operation == "negative" else x
