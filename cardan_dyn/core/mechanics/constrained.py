"""Constrained: what a closed chain does that forces move, as equations of one sample.

Some coordinates are independent: closure rows J, turned until they are a triangle in the dependent
ones, tell how all of them move. Of rates with J T = 0 and accelerations a with J a = -drift it asks
Tᵀ M T u = Tᵀ (τ - h - M a), what inertia forces of one motion do along another (Kane's equations;
García de Jalón and Bayo 1994, chapter 5). T u + a are then the accelerations. Turning rows rounds
alike wherever axes point: only where other coordinates should be independent are ratios T great.

Where joints carry what makes other coordinates move as told, forces balance along motions W in
which those joints rest, and the others need not: Wᵀ M T u = Wᵀ (τ - h - M a).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..tape import absolute, greater, is_zero, select, sqrt
from . import closure
from .bodies import Tree
from .elimination import Eliminated, Order, Pivot, Row, UnsuitableError, eliminated, product
from .placements import Placed, moving, placed
from .reactions import Share, shares, work
from .vectors import ZERO, Scalar, Vector, times

_LEAST = float(np.sqrt(np.finfo(float).tiny))
"""Moved away from zero by this is what a rotation turns by: nothing beside numbers that occur, and
so two zeros have a rotation, too. Its square is the least double that has all digits."""
_DRIFT, _ERROR, _OPENING = range(-3, 0)
"""Columns beside those of velocity coordinates: what is on the other side of equations."""


def triangle(rows: Sequence[Row], columns: Sequence[int]) -> list[tuple[int, Row]]:
    """Return a column and a row for each of some columns, in which those before are zero.

    Rows are turned among each other (Givens; Golub and Van Loan 2013, section 5.1.8), so that what
    solves them stays the same; what is left of them in the end belongs to rows that are redundant.

    Raises:
        UnsuitableError: nothing of a column is left.
    """
    left = [{key: entry for key, entry in row.items() if not is_zero(entry)} for row in rows]
    result: list[tuple[int, Row]] = []
    for column in columns:
        own = sorted((row for row in left if column in row), key=len)
        if not own:
            raise UnsuitableError
        first, *others = own
        left = [row for row in left if column not in row]
        for other in others:
            first, rest = _turned(first, other, column)
            left.append(rest)
        result.append((column, first))
    return result


def _turned(first: Row, second: Row, column: int) -> tuple[dict[int, Scalar], dict[int, Scalar]]:
    """Return two rows after the rotation that leaves nothing of a column in the second one."""
    # Away from zero: what a rotation by itself has left of zeros may be its negative.
    a, b = first[column] + select(first[column], _LEAST, -_LEAST), second[column]
    size = sqrt(a * a + b * b)
    inverse = 1.0 / size
    cosine, sine = a * inverse, b * inverse
    upper, lower = {column: size}, {}
    for key in sorted({*first, *second} - {column}):
        u, w = first.get(key, 0.0), second.get(key, 0.0)
        upper[key], lower[key] = cosine * u + sine * w, cosine * w - sine * u
    return upper, {key: entry for key, entry in lower.items() if not is_zero(entry)}


class Carried(NamedTuple):
    """What carries coordinates that move as told.

    Attributes:
        resting: velocity coordinates that rest while forces balance: those that carry, and those
            that are held.
        dependent: those that the others decide then, in the order of elimination.
    """

    resting: Sequence[int]
    dependent: Sequence[int]


class Free(NamedTuple):
    """What is free at a state of a closed chain, and how it resists.

    Attributes:
        tree, v, told: see `of`.
        at: where the bodies are.
        rows: of the triangle, with what is on their other side.
        ways: per independent coordinate, velocity coordinate to its rate while that moves alone.
        along: motions along which forces balance: the ways, unless joints carry what is told.
        moved: how masses move, along each of these.
        factors: of the inertia Wᵀ M T.
        error: greatest one of the closure rows.
        narrowness: greatest ratio of a pivot's size elsewhere to its own.
        growth: greatest of the ratios T.
        lightness: greatest part of what a way moves, over what is left of it beside others.
    """

    tree: Tree
    at: Placed
    v: Mapping[int, Scalar]
    told: Mapping[int, Scalar]
    rows: list[tuple[int, Row]]
    ways: list[dict[int, Scalar]]
    along: list[dict[int, Scalar]]
    moved: list[list[Share]]
    factors: Eliminated
    error: Scalar
    narrowness: Scalar
    growth: Scalar
    lightness: Scalar

    @staticmethod
    def of(
        tree: Tree,
        x: Mapping[int, Scalar],
        v: Mapping[int, Scalar],
        told: Mapping[int, Scalar],
        dependent: Sequence[int],
        sizes: Sequence[Scalar],
        carried: Carried | None = None,
    ) -> Free:
        """Return what is free.

        Args:
            tree: the chain.
            x: column to coordinate, closed up to a drift.
            v: velocity coordinate to velocity.
            told: likewise to acceleration, of those that are prescribed.
            dependent: velocity coordinates that the others decide, in the order of elimination.
            sizes: of their pivots elsewhere, those of `carried` after them.
            carried: by which joints what is told is carried; None if by itself.

        Raises:
            UnsuitableError: the closure rows do not decide these, or a way moves no mass.
        """
        at = placed(tree, x)
        errors, error = closure.errors(tree, at, [c.offset for c in tree.couplings])
        rows = closure.rows(tree, at, v)
        drifts = closure.drifts(tree, at, moving(tree, at, v, told, ZERO))
        drifts += [
            product(row, told) + bend
            for row, bend in zip(rows[len(drifts) :], closure.bends(tree, at, v), strict=True)
        ]
        turned = triangle(
            [
                {rate: entry for rate, entry in row.items() if rate not in told}
                | {_DRIFT: drift, _ERROR: off, _OPENING: product(row, v)}
                for row, drift, off in zip(rows, drifts, errors, strict=True)
            ],
            dependent,
        )
        independent = [rate for rate in v if rate not in told and rate not in dependent]
        ways = _ways(turned, independent)
        inertias = [shares(tree, moving(tree, at, {}, way, ZERO), {}) for way in ways]
        turning = [tree.of_rotors(way) for way in ways]
        along, moved, pivots = ways, inertias, turned
        if carried:
            resting = [
                {rate: entry for rate, entry in row.items() if rate not in carried.resting}
                for row in rows
            ]
            of_others = triangle(resting, carried.dependent)
            decided = {*carried.resting, *carried.dependent}
            along = _ways(of_others, [rate for rate in v if rate not in decided])
            moved = [shares(tree, moving(tree, at, {}, way, ZERO), {}) for way in along]
            pivots = [*turned, *of_others]
        narrowness: Scalar = 0.0
        for (column, row), size in zip(pivots, sizes, strict=True):
            narrowness = greater(narrowness, absolute(size * (1.0 / row[column])))
        growth: Scalar = 0.0
        for way in [*ways, *along[: len(along) if carried else 0]]:
            for ratio in way.values():
                growth = greater(growth, absolute(ratio))
        count = range(len(ways))

        def inertia(k: int, c: int) -> Scalar:
            return work(inertias[c], moved[k]) + product(along[k], turning[c])

        if carried:
            full = [{c: inertia(k, c) for c in count} for k in count]
            turned_along = [tree.of_rotors(way) for way in along]
            alone = [
                sqrt(
                    (work(inertias[k], inertias[k]) + product(ways[k], turning[k]))
                    * (work(moved[k], moved[k]) + product(along[k], turned_along[k]))
                )
                for k in count
            ]
        else:
            lower = [[inertia(k, c) for c in range(k + 1)] for k in count]
            full = [{c: lower[max(k, c)][min(k, c)] for c in count} for k in count]
            alone = [lower[k][k] for k in count]
        if any(is_zero(full[k][k]) for k in count):
            raise UnsuitableError
        factors = eliminated(full, Order([Pivot(k, k, 1.0) for k in reversed(count)]))
        lightness: Scalar = 0.0
        for step in factors.steps:
            lightness = greater(lightness, absolute(alone[step.row] * step.inverse))
        judged = error, narrowness, growth, lightness
        return Free(tree, at, v, told, turned, ways, along, moved, factors, *judged)

    def accelerations(self, gravity: Vector, efforts: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Return accelerations by velocity coordinates.

        Args:
            gravity: acceleration of free fall.
            efforts: velocity coordinate to what acts there.
        """
        decided = {**self.told, **_decided(self.rows, _DRIFT)}
        return self._least(self.v, decided, times(gravity, -1.0), efforts)

    def displacement(self) -> dict[int, Scalar]:
        """Return the displacement that closes loops by Newton's method, the least one by M."""
        return self._least({}, _decided(self.rows, _ERROR), ZERO, {})

    def slowing(self) -> dict[int, Scalar]:
        """Return the least change of velocities after which loops stay closed, likewise."""
        return self._least({}, _decided(self.rows, _OPENING), ZERO, {})

    def _least(
        self,
        v: Mapping[int, Scalar],
        decided: Mapping[int, Scalar],
        base: Vector,
        efforts: Mapping[int, Scalar],
    ) -> dict[int, Scalar]:
        """Return accelerations with those along ways that forces give."""
        motion = moving(self.tree, self.at, v, decided, base)
        resisting = shares(self.tree, motion, {})
        efforts = self.tree.beside_rotors(efforts, decided)
        left = [
            product(way, efforts) - work(resisting, own)
            for way, own in zip(self.along, self.moved, strict=True)
        ]
        result = dict(decided)
        for index, amount in self.factors.solve(left).items():
            for rate, ratio in self.ways[index].items():
                result[rate] = result.get(rate, 0.0) + ratio * amount
        return result


def _ways(rows: Sequence[tuple[int, Row]], independent: Sequence[int]) -> list[dict[int, Scalar]]:
    """Return for each independent column how all move while that one has the rate 1."""
    return [{rate: 1.0, **_decided(rows, rate)} for rate in independent]


def _decided(rows: Sequence[tuple[int, Row]], column: int) -> dict[int, Scalar]:
    """Return values of dependent columns with which rows vanish, a column being one."""
    result: dict[int, Scalar] = {}
    for pivot, row in reversed(rows):
        value = -row.get(column, 0.0)
        for other, entry in row.items():
            if other in result:
                value = value - entry * result[other]
        if not is_zero(value):
            result[pivot] = value * (1.0 / row[pivot])
    return result
