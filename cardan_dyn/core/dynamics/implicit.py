"""Implicit: linear equations whose solutions change as the equations say, however they are solved.

Of A x = b, x changes by A⁻¹ (b′ - A′ x). So an elimination itself is never differentiated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..mechanics.elimination import Eliminated, Row, product
from ..tape import NOTHING, Differential, Factor, Scalar, Variable


class _Solution(NamedTuple):
    """What was solved.

    Attributes:
        found: unknown to its value, as what depends on it takes it.
        held: the same values, as they stand in the equations.
        left: pivot to what is left of its equation.
        steps: pivots' rows or columns to how much unknowns change with each such error.
    """

    found: dict[int, Scalar]
    held: list[Scalar]
    left: list[Scalar]
    moved: Mapping[int, Scalar]


class Implicit(Eliminated):
    """Factors of a matrix that keep what is solved with them."""

    _rows: Sequence[Row]
    _columns: dict[int, dict[int, Scalar]]
    _off: Sequence[Variable]
    _marks: Sequence[Variable]
    _solutions: list[_Solution]

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
        result._columns, result._solutions = {}, []
        for index, row in enumerate(rows):
            for column, entry in row.items():
                result._columns.setdefault(column, {})[index] = entry
        return result

    def solve(self, right: Sequence[Scalar]) -> dict[int, Scalar]:
        """See `Eliminated.solve`."""
        pairs = [(right[step.row], self._rows[step.row]) for step in self.steps]
        return self._kept(super().solve(right), pairs, super().solve(self._off))

    def solve_transposed(self, right: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """See `Eliminated.solve_transposed`."""
        pairs = [(right[step.column], self._columns[step.column]) for step in self.steps]
        return self._kept(super().solve_transposed(right), pairs, self._back)

    def dependence(self, row: int) -> dict[int, Scalar]:
        """See `Eliminated.dependence`."""
        pairs = [(0.0, self._columns[step.column]) for step in self.steps]
        return self._kept(super().dependence(row), pairs, self._back)

    @property
    def _back(self) -> dict[int, Scalar]:
        """What multipliers change by, of what columns are off by."""
        return super().solve_transposed({step.column: self._off[step.row] for step in self.steps})

    def _kept(
        self,
        values: dict[int, Scalar],
        equations: Sequence[tuple[Scalar, Row]],
        moved: Mapping[int, Scalar],
    ) -> dict[int, Scalar]:
        """Return what was found, marked."""
        found, held = (
            {key: x * mark if type(x) is Variable else x for key, x in values.items()}
            for mark in self._marks
        )
        left = [right - product(held, row) for right, row in equations]
        self._solutions.append(_Solution(found, [*held.values()], left, moved))
        return found

    def differentiated(self, differential: Differential, known: dict[Variable, int]) -> None:
        """Add how all that was found changes to what is known of changes."""
        for found, held, left, moved in self._solutions:
            known |= dict.fromkeys(map(_unsigned, filter(_is_variable, held)), NOTHING)
            lines = [self._off[step.row] for step in self.steps]
            off = dict(zip(lines, differential.tangents(left, known, adds=True), strict=True))
            keys = [key for key, x in found.items() if _is_variable(x)]
            ways = differential.tangents([moved[key] for key in keys], off)
            for key, way in zip(keys, ways, strict=True):
                x = _unsigned(found[key])
                sign = Factor(1.0 if x is found[key] else -1.0)
                known.setdefault(x, differential.sum([(sign, way)]))


def _is_variable(x: Scalar) -> bool:
    return type(x) is Variable


def _unsigned(x: Variable) -> Variable:
    """Return what is marked of something: signs are written behind products."""
    return -x if x.operation == "negative" else x
