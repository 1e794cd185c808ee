"""Solver: close the loops of a group for many samples at once, and find its rates.

Newton's method on whole arrays. Each sample is factorised once: the inverse that gave the last
small step serves the rates and the closure forces as well, mended to rounding by one refinement.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .closure import Closure, Reduction
from .coordinates import Array, Coordinates, generic
from .groups import RANK_TOLERANCE, Group
from .mechanism import Mechanism
from .twin import twin_of

if TYPE_CHECKING:
    from pinocchio import SE3

_EXACT = 2e-15  # A Newton step of this size, relative to an angle's amplitude, is its rounding.
_CONVERGED = 1e-9  # A Newton step of this size leaves an error of its square.
_LONGEST = 0.5  # Newton step [rad].
_OPEN_STATES = 3
_STALE = 1e-8  # An inverse off by this much is mended to rounding by one refinement.


@dataclass(frozen=True, eq=False, repr=False)
class Closed:
    """Positions whose loops are closed, with what the next steps need of them.

    Attributes:
        solver: what closed them, with the rows that it solved.
        q: `(N, 7 n)` configurations of the twin.
        actions: see `Twin.actions`.
        twists: `(N, m, 6)` unit twists of the moving coordinates.
        known_rows, passive_rows: transposed closure matrices `(N, k, R)` and `(N, p, R)`.
        inverse: `(N, R, p)`: inverse of `passive_rows`, or its pseudoinverse.
        null: `(N, R, R - p)`: multipliers that no passive effort feels, at each position.
        residual: `(N,)` closure error, see `Closure.error`.
        condition: `(N,)` condition number of `passive_rows`, slides counted in lengths.
        correction: `(N,)` how far the guess was off.
    """

    solver: Solver
    q: Array
    actions: Array
    twists: Array
    known_rows: Array
    passive_rows: Array
    inverse: Array
    null: Array
    residual: Array
    condition: Array
    correction: Array

    @property
    def scaled_rows(self) -> Array:
        """The passives' rows with slides counted in lengths, for decisions about rank."""
        scale = self.solver.row_scale
        return self.passive_rows if scale is None else self.passive_rows * scale

    @property
    def all_scaled_rows(self) -> Array:
        """The rows of what is known, then of the passives, slides counted in lengths."""
        known = self.known_rows * self.solver.known_scale
        return np.concatenate([known, self.scaled_rows], axis=1)

    def same_side(self, inverse: Array) -> Array:
        """Return `(N,)` whether no singular position needs to be crossed to come from another one.

        Args:
            inverse: of the closure equations at the other positions.
        """
        return same_side(self.passive_rows, inverse)

    def solve(self, right: Array) -> Array:
        """Solve the closure equations for passive rates: `(N, R)` to `(N, p)`."""
        return _refined(_flip(self.passive_rows), _flip(self.inverse), right[:, :, None])[:, :, 0]

    def solve_transposed(self, right: Array) -> Array:
        """Solve for closure forces: passive efforts `(N, p, k)` to multipliers `(N, R, k)`."""
        return _refined(self.passive_rows, self.inverse, right)


class Solver:
    """Closes the loops of a group for many samples by Newton's method on whole arrays.

    Nothing in it changes; solvers of other rows, or of other amplitudes, are made from it.

    Attributes:
        group: what it solves.
        twin: its bodies.
        closure: its equations.
        reduction: which rows are solved; all of them until the motion is known.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        coordinates: Coordinates,
        group: Group,
        zero: dict[int, SE3],
    ) -> None:
        """Make the solver.

        Args:
            mechanism: the mechanism.
            coordinates: layout of its coordinate rows.
            group: what to solve.
            zero: placements of the bodies with every joint at zero.
        """
        self.group = group
        self.coordinates = coordinates
        near = [mechanism.loops[number].predecessor - 1 for number in group.loops]
        points = [zero[body].translation for body in near or group.massive]
        origin = np.mean(points, axis=0) if points else np.zeros(3)
        self.twin = twin_of(mechanism, coordinates, group.bodies, group.massive, origin)
        self.closure = Closure(mechanism, self.twin, group, zero)
        self.reduction: Reduction = self.closure.full()
        self._moves = coordinates.moves(group.passives)
        linear = np.any(self.twin.subspace[group.passives, :3] != 0.0, axis=1)
        self._scale = np.where(linear, 1.0 / mechanism.length, 1.0)
        # Slides count in lengths of the mechanism, or units would decide about condition.
        self.row_scale = mechanism.length ** linear[:, None] if np.any(linear) else None
        slides = np.any(self.twin.subspace[group.known, :3] != 0.0, axis=1)
        self.known_scale = mechanism.length ** slides[:, None]
        self._exact = np.zeros(len(self._scale))

    def solving(self, reduction: Reduction) -> Solver:
        """Return the solver of other rows."""
        other = copy(self)
        other.reduction = reduction
        return other

    def moving(self, states: Array) -> Solver:
        """Return the solver that knows how far the passives move, over states `(K, size)`.

        A guess is exact when it is off by the rounding of that; where the motion is small, so is
        what its wrenches follow from.
        """
        moved = np.zeros(len(self._scale))
        moved[self._moves.steps] = np.max(np.abs(states[:, self._moves.columns]), axis=0)
        for _, start in self._moves.balls:
            moved[start : start + 3] = 1.0
        moved *= self._scale
        # A slide that stays where it is only shows its rounding.
        other = copy(self)
        other._exact = _EXACT * np.where(moved < 1e-13, 1.0, np.minimum(1.0, moved))
        return other

    def evaluate(
        self, x: Array, turns: Array | None = None, inverse: Array | None = None
    ) -> tuple[Closed, Array]:
        """Return the closure equations at `x` and their reduced error `(N, R)`, closed or not.

        Args:
            x: `(N, size)` coordinates.
            turns: `(N, size)` whole turns that the angles in `x` lack; couplings count them.
            inverse: inverse at a position nearby; used where it is near enough.
        """
        closure, known = self.closure, len(self.group.known)
        q = self.twin.configuration(x)
        actions = self.twin.actions(q)
        twists = closure.unit_twists.of(actions)
        rows = closure.rows(twists, actions, self.reduction)
        passive = rows[:, known:]
        error, residual = closure.error(actions)
        slips = self._slips(x, turns)
        if slips.size:
            residual = np.maximum(residual, np.max(np.abs(slips) / closure.gear_units, axis=1))
        if inverse is not None and _near(passive, inverse, self.row_scale):
            null = np.zeros((len(x), inverse.shape[1], 0))
            condition = _conditions(passive, inverse, self.row_scale)
        else:
            inverse, null, condition = _factorised(passive, self.row_scale)
        closed = Closed(
            solver=self,
            q=q,
            actions=actions,
            twists=twists,
            known_rows=rows[:, :known],
            passive_rows=passive,
            inverse=inverse,
            null=null,
            residual=residual,
            condition=condition,
            correction=np.zeros(len(x)),
        )
        return closed, closure.project(error, slips, actions, self.reduction)

    def open_reduction(self, x: Array) -> Reduction:
        """Return the rows that the joints of each loop can reach while the loops are open.

        A planar or spherical chain stays one however it is bent, so a few positions tell.
        Closed loops may reach less, never more.

        Args:
            x: `(size,)` coordinates of the joints that do not move.
        """
        rows = np.repeat(x[None, :], _OPEN_STATES, axis=0)
        moving = self.closure.moving
        moves = self.coordinates.moves(moving)
        step = generic(_OPEN_STATES, len(moving))
        step[:, moves.slides] *= self.closure.mechanism.length
        moves.apply(rows, step)
        actions = self.twin.actions(self.twin.configuration(rows))
        return self.closure.reduction(self.closure.unit_twists.of(actions), actions)

    def approach(self, x: Array) -> Closed:
        """Take one Newton step from a guess; return what is known at the guess.

        Args:
            x: `(N, size)` coordinates; those of the passives are corrected in place.
        """
        here, error = self.evaluate(x)
        step = -_times(_flip(here.inverse), error)
        self._moves.apply(x, step)
        return replace(here, correction=np.abs(step * self._scale).max(axis=1, initial=0.0))

    def close(self, x: Array, turns: Array | None = None, most: int = 12) -> Closed:
        """Close the loops from a guess; the caller judges `residual` and `correction`.

        Args:
            x: `(N, size)` coordinates; those of the passives are corrected in place.
            turns: see `evaluate`.
            most: greatest number of Newton steps.
        """
        here, error = self.evaluate(x, turns)
        correction = np.zeros(len(x))
        for _ in range(most if self.group.passives.size else 0):
            step = -_times(_flip(here.inverse), error)
            scaled = np.abs(step * self._scale)
            if (scaled <= self._exact).all():
                break
            sizes = scaled.max(axis=1)
            correction += sizes
            worst = float(sizes.max())
            if worst > _LONGEST:
                # Far from closed, a full step may leave the branch.
                step *= np.minimum(1.0, _LONGEST / np.maximum(sizes, _LONGEST))[:, None]
            if not np.isfinite(worst):
                break
            self._moves.apply(x, step)
            here, error = self.evaluate(x, turns, here.inverse if worst < 1e-4 else None)
            if worst < _CONVERGED:
                break
        return replace(here, correction=correction)

    def rates(self, here: Closed, known: Array) -> Array:
        """Return passive rates `(N, p)` for the rates `(N, k)` of what is known."""
        return -here.solve(_times(_flip(here.known_rows), known))

    def accelerations(self, here: Closed, v: Array, known: Array) -> Array:
        """Return passive accelerations `(N, p)` at joint rates `v (N, nv)`.

        Args:
            here: closed positions.
            v: joint rates.
            known: accelerations `(N, k)` of what is known.
        """
        drift = self.closure.drift(here.twists, v[:, self.closure.moving])
        right = _times(_flip(here.known_rows), known)
        return -here.solve(right + self.closure.project(drift, None, here.actions, self.reduction))

    def _slips(self, x: Array, turns: Array | None) -> Array:
        """Return how far the couplings are from their ratio `(N, G)` [rad or m]."""
        if not self.closure.couplings:
            return np.zeros((len(x), 0))
        angles = x if turns is None else x + 2.0 * np.pi * turns
        columns = self.coordinates.column_of(self.closure.geared)
        return np.asarray(angles[:, columns] @ self.closure.gear_ratios)


def same_side(rows: Array, inverses: Array) -> Array:
    """Return `(N,)` whether closure matrices lie on the same side of singular positions.

    Two ways of assembling a mechanism that meet in a turning point differ in the orientation of
    the closure equations.

    Args:
        rows: `(N, p, R)` see `Closed.passive_rows`.
        inverses: `(N, R, p)` of those at the other positions.
    """
    return np.linalg.det(np.matmul(rows, inverses)) > 0.0


def _factorised(rows: Array, scale: Array | None) -> tuple[Array, Array, Array]:
    """Return inverses `(N, R, p)`, null spaces `(N, R, R - p)` and condition numbers `(N,)`.

    Args:
        rows: transposed closure matrices `(N, p, R)`, p ≤ R.
        scale: `(p, 1)` units of their rows for condition and rank, None if all are 1.
    """
    count, p, r = rows.shape
    if p == r:
        try:
            inverse = np.linalg.inv(rows)
            return inverse, np.zeros((count, r, 0)), _conditions(rows, inverse, scale)
        except np.linalg.LinAlgError:
            pass
    left, values, right = np.linalg.svd(rows if scale is None else rows * scale)
    size = min(p, r)
    greatest = values[:, :1] if size else np.ones((count, 1))
    small = values <= RANK_TOLERANCE * greatest
    reciprocal = np.where(small, 0.0, 1.0 / np.where(small, 1.0, values))
    inverse = (right[:, :size].transpose(0, 2, 1) * reciprocal[:, None]) @ left[
        :, :, :size
    ].transpose(0, 2, 1)
    if scale is not None:
        inverse *= scale.T
    smallest = values[:, -1] if size else np.ones(count)
    condition = np.divide(
        greatest[:, 0], smallest, out=np.full(count, np.inf), where=smallest > 0.0
    )
    return inverse, right[:, p:].transpose(0, 2, 1), condition


def _refined(matrices: Array, inverses: Array, right: Array) -> Array:
    # One refinement makes an explicit inverse as stable as an elimination.
    solution = np.matmul(inverses, right)
    solution += np.matmul(inverses, right - np.matmul(matrices, solution))
    return solution


def _times(matrices: Array, vectors: Array) -> Array:
    """Return stacked products `(N, i, j) (N, j)`."""
    return np.asarray(np.matmul(matrices, vectors[:, :, None])[:, :, 0])


def _flip(matrices: Array) -> Array:
    return matrices.transpose(0, 2, 1)


def _conditions(rows: Array, inverse: Array, scale: Array | None) -> Array:
    if scale is not None:
        rows, inverse = rows * scale, inverse / scale.T
    return _size(rows) * _size(inverse)


def _size(matrices: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("nij,nij->n", matrices, matrices)))


def _near(rows: Array, inverse: Array, scale: Array | None) -> bool:
    """Return whether `inverse` is one refinement away from the inverse of `rows`."""
    _, p, r = rows.shape
    if p != r:
        return False
    product = np.matmul(rows, inverse)
    if scale is not None:
        product *= scale / scale.T
    product -= np.eye(p)
    return bool(np.max(np.abs(product), initial=0.0) < _STALE)
