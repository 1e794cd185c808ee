"""Chart: where coordinates of one side lead, however far, and where they turn back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array
from ...kit.errors import AccuracyError
from ..dynamics.problem_solver import ProblemSolver
from ..kinematics.closing.all_groups import Kinematics
from ..kinematics.following.lines import Lines, Rows, along_lines, quintic
from ..kinematics.tolerances import CLOSURE_TOLERANCE, MOVES
from ..mechanics.following import ALLOWED

_PLACES = 5
"""Places from which the end of a line is extrapolated; what the last one adds says how well."""
_AWAY = EPS ** (1.0 / 3.0)
"""How far the nearest of them is from it, as a part of the line; others as 4, 9, 16, 25 of it. What
a series of roots leaves is its third power, and rounding, which grows as places come nearer, is
less than that."""


class Turning(NamedTuple):
    """Places at which straight lines of the given side end, since loops close no farther.

    Attributes:
        part: `(N,)` of each line, from 0 to 1.
        is_exact: `(N,)` whether the place is known to rounding; else to 1e-8 of the line.
    """

    part: Array
    is_exact: Array


class Chart:
    """A side as coordinates of all places that the mechanism comes to in one working mode.

    Attributes:
        solver: of the problem that the given side drives.
        given: names of its coordinates.
        columns: theirs in rows of coordinates.
        found: columns of the other side.
        rates: velocity coordinates of the found side, and which of the given ones count.
        units: `(n,)` displacements that count alike, of the given and of the found side.
    """

    def __init__(
        self,
        solver: ProblemSolver,
        found: Sequence[str],
        counted: Sequence[str] | None = None,
    ) -> None:
        """Make it.

        Args:
            solver: of the problem that the given side drives.
            found: names of the coordinates of the other side.
            counted: those of the given side by whose rates that of the other is told; all if None.
        """
        self.solver, mechanism = solver, solver.problem.mechanism
        coordinates, length = mechanism.coordinates, mechanism.characteristic_length
        self.given = solver.problem.independent
        self.columns, self.found = map(coordinates.columns_of, (self.given, found))
        self.rates = coordinates.rates_of(found)
        self._counted = [self.given.index(name) for name in counted or self.given]
        self._turns = [not coordinates.named[name].slides for name in found]
        self.units = tuple(
            np.where([coordinates.named[name].slides for name in names], length, 1.0)
            for names in (counted or self.given, found)
        )

    @property
    def kinematics(self) -> Kinematics:
        """Closes loops at positions of the given side."""
        return self.solver.assembly.kinematics

    def slopes(self, x: Array) -> Array:
        """Return derivatives `(N, n, n)` of the found side by the given one, in units of both."""
        state = self.kinematics.evaluate(x)
        ratios = self.kinematics.velocity_ratios(state)[:, self.rates][:, :, self._counted]
        given, found = self.units
        return np.asarray(ratios * given / found[:, None])

    def step(self, x: Array, ends: Array) -> tuple[Array, Array]:
        """Return where a single step of a follower leads from `x (N, size)`, and if to its end."""
        lines = Lines(self.kinematics, x, self.columns, ends)
        lines.advance(np.arange(len(ends)))
        return lines.rows.x, lines.share == 1.0

    def led(self, x: Array, ends: Array) -> tuple[Array, Array]:
        """Return where straight lines lead from `x (N, size)`, and whether to their ends."""
        return along_lines(self.kinematics, x, self.columns, ends)

    def apart(self, x: Array, other: Array) -> Array:
        """Return `(N,)` whether the found side differs by more than whole turns."""
        off = x[:, self.found] - other[:, self.found]
        off -= np.where(self._turns, 2.0 * np.pi * np.rint(off / (2.0 * np.pi)), 0.0)
        return np.asarray(np.max(np.abs(off) / self.units[1], axis=1) > MOVES)

    def between(self, x: Array, ends: Array) -> Callable[[Array, Array], Array]:
        """Return what leads to places on lines, closed at both of their ends.

        Args:
            x: `(N, size)` at which they begin.
            ends: `(N, size)` at which they end, in the same assembly mode.

        Returns:
            From parts `(K,)` of lines, and which these are (index), to coordinates `(K, size)`.
        """
        begins, way = x[:, self.columns], (ends - x)[:, self.columns]
        begun = self.kinematics.evaluate(x)
        inverses = [group.inverse for group in begun.groups]
        first, last = (
            Rows.along(self.kinematics, state, way)
            for state in (begun, self.kinematics.evaluate(ends))
        )
        polynomials = first.quintics(np.ones(len(x)), last)

        def places(parts: Array, lines: Array) -> Array:
            guess = quintic(polynomials, lines, parts)
            at = guess[:, self.columns] = begins[lines] + parts[:, None] * way[lines]
            state = self.kinematics.close(guess)
            found = state.x
            is_there = (state.residual < CLOSURE_TOLERANCE) & (state.correction < ALLOWED)
            # Near the end of reach, where working modes meet, another one may be close.
            is_there &= self.kinematics.same_side(state, [inverse[lines] for inverse in inverses])
            (bad,) = np.nonzero(~is_there)
            if bad.size:
                found[bad], is_there = self.led(x[lines[bad]], at[bad])
                if not np.all(is_there):
                    raise AccuracyError("a line of a workspace is lost between closed places")
            return found

        return places

    def turning(self, x: Array, ends: Array, near: Array) -> Turning:
        """Return where straight lines of the given side turn back.

        There the given side depends on all else as a parabola does, and the reciprocal m of the
        condition number falls to zero as the root of the way that is left, which is a series of m²,
        m³, m⁴ …: places close by tell its coefficients, and where it ends.

        Args:
            x: `(N, size)` coordinates at which the lines begin.
            ends: `(N, d)` to which they do not lead.
            near: `(N, size)` coordinates where they stopped.
        """
        starts = x[:, self.columns]
        way = ends - starts
        squares = np.sum(way**2, axis=1)
        stopped = np.sum((near[:, self.columns] - starts) * way, axis=1) / squares
        away = _AWAY * np.arange(1, _PLACES + 1)[:, None] ** 2
        parts = stopped - away
        at = starts + parts[..., None] * way
        found, are_there = self.led(np.tile(x, (_PLACES, 1)), at.reshape(-1, len(self.columns)))
        margins = 1.0 / self.kinematics.evaluate(found).condition.reshape(parts.shape).T
        is_exact = np.all(are_there.reshape(parts.shape), axis=0)
        is_exact &= np.all(np.diff(margins) > 0.0, axis=1)
        powers = (margins[is_exact] / margins[is_exact, -1:])[..., None]
        powers = powers ** [0, *range(2, _PLACES + 1)]
        less, more = (
            np.linalg.solve(powers[:, :count, :count], -away[:count])[:, 0, 0]
            for count in (_PLACES - 1, _PLACES)
        )
        stopped[is_exact] += more
        is_exact[is_exact] = (np.abs(more - less) < _AWAY**2) & (np.abs(more) < _AWAY)
        return Turning(stopped, is_exact)
