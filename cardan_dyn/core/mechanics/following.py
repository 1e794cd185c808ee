"""Following: steps along a line on which drives move steadily while loops stay closed.

What is at a place of a line is known with its first two derivatives with respect to the way, which
is 1 from end to end. A step predicts by a Taylor polynomial of second order, takes one step of
Newton's method, and is taken only where that shows the same branch: predictions agree both ways,
and no determinant has changed its sign (Allgower and Georg 2003, chapters 2 and 6).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS
from ..tape import absolute, greater, select, smaller, sqrt
from .bodies import Tree
from .elimination import Order
from .placements import stepped
from .sample import Position, Roles
from .vectors import Scalar

ALLOWED = 0.1
"""Error [rad, or lengths] of a prediction up to which a step is taken: small against the distance
between branches where nothing singular is near. Nearer by, the sign of the determinant decides."""

SHORTEST = float(np.sqrt(EPS))
"""Step, as a part of the way, below which a line leads no farther."""
NEAR = 1e-5
"""Newton step [rad, or lengths] that counts as the last one: what it leaves is its square, far
below what tells configurations apart, and one more step makes it rounding."""


class Place(NamedTuple):
    """A place on a line.

    Attributes:
        x: column of a passive coordinate to its value, closed but for the square of what the last
            step left.
        v, a: velocity coordinate of a passive to its derivatives with respect to the way.
        sides: per block, a number that changes its sign where the closure equations are singular.
    """

    x: Mapping[int, Scalar]
    v: Mapping[int, Scalar]
    a: Mapping[int, Scalar]
    sides: Sequence[Scalar]

    def longest(self) -> Scalar:
        """Return the longest part of the way that a step may go from here."""
        fastest: Scalar = 0.0
        most_bent: Scalar = 0.0
        for rate, value in self.v.items():
            fastest = greater(fastest, absolute(value))
            most_bent = greater(most_bent, absolute(self.a[rate]))
        return longest(fastest, most_bent)


class Step(NamedTuple):
    """What is left of a line after a step, or one that was not taken.

    Attributes:
        place: where the line is.
        rest: part of the way that is left; exactly zero at its end.
        length: of the step that is to be tried next, as a part of the way.
        left: the rest, but zero as well where steps have become tiny.
    """

    place: Place
    rest: Scalar
    length: Scalar
    left: Scalar


class Line(NamedTuple):
    """A scene's equations on lines.

    Attributes:
        tree: the mechanism.
        roles: of its coordinates.
        order: of the elimination.
        ends: column of each drive to its position at the end of the line.
        ways: likewise to how far it moves.
        still: column of each other coordinate that is not passive to its position.
    """

    tree: Tree
    roles: Roles
    order: Order
    ends: Mapping[int, Scalar]
    ways: Mapping[int, Scalar]
    still: Mapping[int, Scalar]

    def begun(self, x: Mapping[int, Scalar]) -> Place:
        """Return the place at which a line begins, from its closed passive coordinates."""
        return self._place(self._at(x, 1.0), x)

    def advanced(self, place: Place, rest: Scalar, length: Scalar) -> Step:
        """Try a step; its length follows from what the last one was off by.

        Args:
            place: where the line is.
            rest: part of the way that is left.
            length: of the step, as a part of the way.
        """
        length = smaller(length, place.longest())
        is_last = length - rest
        length = select(is_last, rest, length)
        left = select(is_last, 0.0, rest - length)
        position = self._at(self._predicted(place, length), left)
        closed, error = position.corrected(self.tree, self.roles)
        new = self._place(position, closed)
        for column, value in self._predicted(new, -length).items():
            error = greater(error, absolute(value - place.x[column]))
        taken = ALLOWED - error
        for side, before in zip(new.sides, place.sides, strict=True):
            taken = smaller(taken, side * before)
        # Lines stay where they end, whatever others do; and where steps have become tiny.
        taken = smaller(taken, smaller(rest, length - SHORTEST))
        rest, length = select(taken, left, rest), next_length(length, error, taken)
        return Step(_chosen(taken, new, place), rest, length, select(length - SHORTEST, rest, 0.0))

    def corrected(
        self, x: Mapping[int, Scalar], before: Scalar
    ) -> tuple[dict[int, Scalar], Scalar]:
        """Return passive coordinates at the end of the line after a step of Newton's method.

        With the greatest part of the step. Where the step before was the last one, none is taken.

        Args:
            x: passive coordinates that may be off.
            before: greatest part of the step before.
        """
        closed, step = self._at(x, 0.0).corrected(self.tree, self.roles)
        goes_on = before - NEAR
        moved = {column: select(goes_on, closed[column], value) for column, value in x.items()}
        return moved, select(goes_on, step, before)

    def _at(self, x: Mapping[int, Scalar], rest: Scalar) -> Position:
        """Return the position at passive coordinates that may be off."""
        drives = {column: end - rest * self.ways[column] for column, end in self.ends.items()}
        offsets = [coupling.offset for coupling in self.tree.couplings]
        return Position.of(
            self.tree,
            self.roles,
            {**self.still, **drives, **x},
            offsets,
            self.order,
            settles=False,
        )

    def _place(self, position: Position, x: Mapping[int, Scalar]) -> Place:
        """Return a place at passive coordinates, by the equations at a position near them."""
        speeds = {
            rate: self.ways[body.column]
            for body in self.tree.bodies
            for rate in body.rates
            if rate in self.roles.drives
        }
        v = position.velocities(speeds)
        a = position.accelerations(self.tree, v, {})
        passives = self.roles.passives
        return Place(
            {column: x[column] for column in self.roles.columns(self.tree)},
            {rate: v[rate] for rate in passives},
            {rate: a[rate] for rate in passives},
            [self._side(position, block.rows) for block in self.roles.blocks],
        )

    def _predicted(self, place: Place, length: Scalar) -> dict[int, Scalar]:
        """Return passive coordinates after a part of the way, by a Taylor polynomial."""
        step = {
            rate: length * (value + 0.5 * length * place.a[rate]) for rate, value in place.v.items()
        }
        result: dict[int, Scalar] = {}
        passives = set(self.roles.passives)
        for body in self.tree.bodies:
            if passives.issuperset(body.rates):
                result |= stepped(body, place.x, step)
        return result

    def _side(self, position: Position, rows: Sequence[int]) -> Scalar:
        """Return the reciprocal determinant of a block, in units of the pivots of its order."""
        own, result = set(rows), 1.0
        for step, pivot in zip(position.factors.steps, self.order.pivots, strict=True):
            if step.row in own:
                result = result * (step.inverse * pivot.size)
        return result


def longest(fastest: Scalar, most_bent: Scalar) -> Scalar:
    """Return the longest part of the way that a step may go.

    By each of its derivatives a coordinate moves by one radian, or length, at most: of longer steps
    some end by accident near other solutions, often whole turns of a joint away.

    Args:
        fastest: greatest first derivative with respect to the way [rad, or lengths].
        most_bent: likewise the second.
    """
    return smaller(1.0 / fastest, sqrt(2.0 / most_bent))


def next_length(length: Scalar, error: Scalar, taken: Scalar) -> Scalar:
    """Return the length of the step that is to be tried next.

    The error grows with the third power of the step.

    Args:
        length: of the step that was tried.
        error: what its prediction was off by.
        taken: positive where the step was taken.
    """
    longer = select(0.06 * ALLOWED - error, 2.0, select(0.4 * ALLOWED - error, 1.25, 0.8))
    return length * select(taken, longer, 0.4)


def _chosen(taken: Scalar, new: Place, old: Place) -> Place:
    """Return the new place where a number is positive, the old one elsewhere; sides are old."""
    x, v, a = (
        {key: select(taken, value, before[key]) for key, value in after.items()}
        for after, before in zip(new[:3], old[:3], strict=True)
    )
    return Place(x, v, a, old.sides)
