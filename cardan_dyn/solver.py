"""Solver: close the loops of many samples at once, and find their rates.

Newton's method on whole arrays. Each sample is factorised once: the inverse that gave the last
small step serves the rates and the closure forces as well, mended to rounding by one refinement.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .closure import RANK_TOLERANCE, Closure, Reduction
from .twin import Array, Coordinates, Twin

_CONVERGED = 1e-9  # A Newton step of this size leaves an error of its square.
_STALE = 1e-8  # An inverse off by this much is mended to rounding by one refinement.


@dataclass(frozen=True)
class Closed:
    """Positions whose loops are closed, with what the next steps need of them.

    Attributes:
        x: `(N, size)` coordinates.
        q: `(N, 7 n)` configurations of the twin.
        actions: see `Twin.actions`.
        twists: `(N, m, 6)` unit twists of the moving coordinates.
        drive_rows, passive_rows: transposed closure matrices `(N, d, R)` and `(N, p, R)`.
        inverse: `(N, R, p)`: inverse of `passive_rows`, or its pseudoinverse.
        null: `(N, R, R - p)`: multipliers that no passive effort feels, at each position.
        residual: `(N,)` closure error, see `Closure.error`.
        condition: `(N,)` condition number of `passive_rows`.
        correction: `(N,)` how far the guess was off.
    """

    x: Array
    q: Array
    actions: Array
    twists: Array
    drive_rows: Array
    passive_rows: Array
    inverse: Array
    null: Array
    residual: Array
    condition: Array
    correction: Array

    def only(self, samples: Array) -> Closed:
        """Return some of the positions, chosen by index or mask."""
        return Closed(*(getattr(self, name)[samples] for name in self.__dataclass_fields__))

    def same_side(self, other: Closed) -> bool:
        """Return whether no singular position needs to be crossed to get from `other` to here.

        Two ways of assembling a mechanism that meet in a singular position differ in the
        orientation of the closure equations.
        """
        change = np.matmul(self.passive_rows, other.inverse)
        return bool(np.all(np.linalg.det(change) > 0.0))

    def solve(self, right: Array) -> Array:
        """Solve the closure equations for passive rates: `(N, R)` to `(N, p)`."""
        return self._refined(right, self.inverse.transpose(0, 2, 1), self.passive_rows, 1)

    def solve_transposed(self, right: Array) -> Array:
        """Solve for closure forces: passive efforts `(N, p)` to multipliers `(N, R)`."""
        return self._refined(right, self.inverse, self.passive_rows, 2)

    def _refined(self, right: Array, inverse: Array, rows: Array, axis: int) -> Array:
        # One refinement makes the explicit inverse as stable as an elimination.
        matrix = rows.transpose(0, 2, 1) if axis == 1 else rows
        solution = _times(inverse, right)
        return solution + _times(inverse, right - _times(matrix, solution))


class Solver:
    """Closes loops for many samples by Newton's method on whole arrays.

    Attributes:
        drives, passives: velocity coordinates of the drives and of the joints that the loops
            decide.
        passive_columns: places of the passives among the closure's moving coordinates.
        reduction: which rows are solved; all of them until the motion is known.
    """

    def __init__(
        self,
        twin: Twin,
        coordinates: Coordinates,
        closure: Closure,
        drives: Array,
        passives: Array,
    ) -> None:
        self.twin = twin
        self.coordinates = coordinates
        self.closure = closure
        self.drives = drives
        self.passives = passives
        self.reduction: Reduction = closure.full()
        length = closure.mechanism.length
        linear = np.any(twin.subspace[passives, :3] != 0.0, axis=1)
        self._scale = np.where(linear, 1.0 / length, 1.0)
        position = {coordinate: k for k, coordinate in enumerate(closure.moving)}
        self._drive_columns = [position[coordinate] for coordinate in drives]
        self.passive_columns = [position[coordinate] for coordinate in passives]

    def evaluate(self, x: Array, inverse: Array | None = None) -> tuple[Closed, Array]:
        """Return the closure equations at `x` and their reduced error `(N, R)`, closed or not.

        Args:
            x: `(N, size)` coordinates.
            inverse: inverse at a position nearby; used where it is near enough.
        """
        q = self.coordinates.twin_configuration(x)
        actions = self.twin.actions(q)
        twists = self.twin.twists(actions, self.closure.moving)
        rows = self.closure.rows(twists, self.reduction)
        passive = rows[:, self.passive_columns]
        error, residual = self.closure.error(actions)
        if inverse is not None and _near(passive, inverse):
            null, condition = np.zeros((len(x), inverse.shape[1], 0)), _conditions(passive, inverse)
        else:
            inverse, null, condition = _factorised(passive)
        closed = Closed(
            x=x,
            q=q,
            actions=actions,
            twists=twists,
            drive_rows=rows[:, self._drive_columns],
            passive_rows=passive,
            inverse=inverse,
            null=null,
            residual=residual,
            condition=condition,
            correction=np.zeros(len(x)),
        )
        return closed, self.closure.project(error, self.reduction)

    def close(self, guess: Array, most: int = 12) -> Closed:
        """Close the loops from a guess; the caller judges `residual` and `correction`.

        Args:
            guess: `(N, size)` coordinates; the passive ones are corrected.
            most: greatest number of Newton steps.
        """
        here, error = self.evaluate(guess)
        correction = np.zeros(len(guess))
        for _ in range(most):
            if not self.passives.size:
                break
            step = -_times(here.inverse.transpose(0, 2, 1), error)
            sizes = np.max(np.abs(step * self._scale), axis=1)
            # Far from closed, a full step may leave the branch.
            step *= np.minimum(1.0, 0.5 / np.maximum(sizes, 0.5))[:, None]
            correction += sizes
            worst = float(np.max(sizes))
            if not np.isfinite(worst):
                break
            full = np.zeros((len(guess), self.coordinates.model.nv))
            full[:, self.passives] = step
            stale = here.inverse if worst < 1e-4 else None
            here, error = self.evaluate(self.coordinates.moved(here.x, full), stale)
            if worst < _CONVERGED:
                break
        return replace(here, correction=correction)

    def rates(self, here: Closed, drive_rates: Array) -> Array:
        """Return joint rates `(N, nv)` for drive rates `(N, d)`; held joints rest."""
        return self._rates(here, drive_rates, _times(_flip(here.drive_rows), drive_rates))

    def accelerations(self, here: Closed, v: Array, drive_accelerations: Array) -> Array:
        """Return joint accelerations `(N, nv)` at joint rates `v (N, nv)`."""
        drift = self.closure.drift(here.twists, v[:, self.closure.moving])
        right = _times(_flip(here.drive_rows), drive_accelerations)
        return self._rates(
            here, drive_accelerations, right + self.closure.project(drift, self.reduction)
        )

    def _rates(self, here: Closed, drive_rates: Array, right: Array) -> Array:
        rates = np.zeros((len(right), self.coordinates.model.nv))
        rates[:, self.drives] = drive_rates
        rates[:, self.passives] = -here.solve(right)
        return rates


def _factorised(rows: Array) -> tuple[Array, Array, Array]:
    """Return inverses `(N, R, p)`, null spaces `(N, R, R - p)` and condition numbers `(N,)`.

    Args:
        rows: transposed closure matrices `(N, p, R)`, p ≤ R.
    """
    count, p, r = rows.shape
    if p == r:
        try:
            inverse = np.linalg.inv(rows)
            return inverse, np.zeros((count, r, 0)), _conditions(rows, inverse)
        except np.linalg.LinAlgError:
            pass
    left, values, right = np.linalg.svd(rows)
    size = min(p, r)
    greatest = values[:, :1] if size else np.ones((count, 1))
    small = values <= RANK_TOLERANCE * greatest
    reciprocal = np.where(small, 0.0, 1.0 / np.where(small, 1.0, values))
    inverse = (right[:, :size].transpose(0, 2, 1) * reciprocal[:, None]) @ left[
        :, :, :size
    ].transpose(0, 2, 1)
    smallest = values[:, -1] if size else np.ones(count)
    condition = np.divide(
        greatest[:, 0], smallest, out=np.full(count, np.inf), where=smallest > 0.0
    )
    return inverse, right[:, p:].transpose(0, 2, 1), condition


def _times(matrices: Array, vectors: Array) -> Array:
    """Return stacked products `(N, i, j) (N, j)`."""
    return np.asarray(np.matmul(matrices, vectors[:, :, None])[:, :, 0])


def _flip(matrices: Array) -> Array:
    return matrices.transpose(0, 2, 1)


def _conditions(rows: Array, inverse: Array) -> Array:
    return _size(rows) * _size(inverse)


def _size(matrices: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("nij,nij->n", matrices, matrices)))


def _near(rows: Array, inverse: Array) -> bool:
    """Return whether `inverse` is one refinement away from the inverse of `rows`."""
    _, p, r = rows.shape
    if p != r:
        return False
    product = np.matmul(rows, inverse)
    product -= np.eye(p)
    return bool(np.max(np.abs(product), initial=0.0) < _STALE)
