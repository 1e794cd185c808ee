"""Group state: the closure equations of a group at given positions, factorised, and its rates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .batch_model import BatchModel
from .closure_equations import ClosureEquations
from .loop_groups import Group
from .reduction import Reduction
from .stacked import refined, same_side, times, transposed


class GroupState(NamedTuple):
    """A group at given positions: its closure equations there and their factors.

    Attributes:
        group: its loops and joints.
        batch: its bodies.
        equations: its closure equations.
        reduction: which of their rows were solved.
        row_scale: `(p, 1)` lengths for the rows of slides, or None where nothing slides.
        known_scale: `(k, 1)` likewise for what is known.
        q: `(N, 7 n)` configurations of the batch model.
        actions: see `BatchModel.actions`.
        twists: `(N, m, 6)` unit twists of the movable coordinates.
        known_rows, passive_rows: transposed closure matrices `(N, k, R)` and `(N, p, R)`.
        inverse: `(N, R, p)`: inverse of `passive_rows`, or its pseudoinverse.
        null: `(N, R, R - p)`: multipliers that no passive effort feels, at each position.
        residual: `(N,)` closure error, see `ClosureEquations.error`.
        condition: `(N,)` condition number of `passive_rows`, slides counted in lengths.
        correction: `(N,)` how far the guess was off.
        idle: `(N, p, k)` passive rates that violate no equation, of k idle freedoms.
    """

    group: Group
    batch: BatchModel
    equations: ClosureEquations
    reduction: Reduction
    row_scale: Array | None
    known_scale: Array
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
    idle: Array

    @property
    def scaled_rows(self) -> Array:
        """The passives' rows with slides counted in lengths, for decisions about rank."""
        return self.passive_rows if self.row_scale is None else self.passive_rows * self.row_scale

    @property
    def all_scaled_rows(self) -> Array:
        """The rows of what is known, then of the passives, slides counted in lengths."""
        known = self.known_rows * self.known_scale
        return np.concatenate([known, self.scaled_rows], axis=1)

    @property
    def reachable(self) -> Reduction:
        """The rows that the loops' joints can reach at these positions together."""
        return self.equations.reduction(self.twists, self.actions)

    def same_side(self, inverse: Array) -> Array:
        """Return `(N,)` whether other positions lie on the same side of singular configurations.

        Args:
            inverse: of the closure equations at the other positions.
        """
        return same_side(self.passive_rows, inverse, self._idle_projectors())

    def follows_on(self) -> Array:
        """Return `(N - 1,)` whether positions lie on the same side as those before them."""
        idle = self._idle_projectors()
        return same_side(
            self.passive_rows[1:], self.inverse[:-1], None if idle is None else idle[1:]
        )

    def _idle_projectors(self) -> Array | None:
        """Return projectors `(N, p, p)` onto idle motions; None without any."""
        if not self.group.idle:
            return None
        return np.eye(self.idle.shape[1]) - np.matmul(self.passive_rows, self.inverse)

    def solve(self, right: Array) -> Array:
        """Solve the closure equations for passive rates: `(N, R)` to `(N, p)`."""
        matrices, inverses = transposed(self.passive_rows), transposed(self.inverse)
        return refined(matrices, inverses, right[:, :, None])[:, :, 0]

    def solve_transposed(self, right: Array) -> Array:
        """Solve for closure forces: passive efforts `(N, p, k)` to multipliers `(N, R, k)`."""
        return refined(self.passive_rows, self.inverse, right)

    def step(self, error: Array) -> Array:
        """Return Newton's step `(N, p)` that removes an error `(N, R)`."""
        step = -times(transposed(self.inverse), error)
        if not self.group.idle:
            return step
        return self._without_spins(step, np.zeros((len(step), len(self.group.known))))

    def rates(self, known: Array) -> Array:
        """Return passive rates `(N, p)` for the rates `(N, k)` of what is known.

        Idle rods do not turn about their lines.
        """
        rates = -self.solve(times(transposed(self.known_rows), known))
        return self._without_spins(rates, known)

    def accelerations(self, v: Array, known: Array) -> Array:
        """Return passive accelerations `(N, p)` at joint rates `v (N, nv)`.

        Args:
            v: joint rates.
            known: accelerations `(N, k)` of what is known.
        """
        v = v[:, self.equations.movable]
        drift = self.equations.drift(self.twists, v)
        right = times(transposed(self.known_rows), known)
        drift = self.equations.project(drift, None, self.actions, self.reduction)
        return self._without_spins(-self.solve(right + drift), known, v)

    def _without_spins(self, rates: Array, known: Array, v: Array | None = None) -> Array:
        """Return passive rates `(N, p)` at which idle rods do not turn about their lines.

        Args:
            rates: `(N, p)` of the passives; or accelerations.
            known: likewise `(N, k)` of what is known.
            v: `(N, m)` rates of all movable coordinates, where `rates` are accelerations.
        """
        if not self.group.idle:
            return rates
        every = np.concatenate([known, rates], axis=1)
        return rates - times(
            self.idle, self.equations.rod_spins.of(self.twists, every, self.idle, v)
        )
