"""Tooth search: the best fork offsets of splines, which a fork can only take in steps.

Branch and bound from the input to the output: where the forks up to a shaft stand, the corners of
the `fork_polygon` behind it cannot come closer than its remaining sides allow. Branches whose least
distance exceeds the best line found so far are left out, so what is found is the global optimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .fork_polygon import added, least_shortfall

_BLOCK = 4096
"""Branches that are followed together: large enough for arrays, small enough to be cut early."""
_SAME = 64.0 * float(np.finfo(float).eps)
"""Rounding of kappa of a line, relative to the sum of all kappa_k: ties are within it."""


class Found(NamedTuple):
    """What the search found.

    Attributes:
        choices: `(m, n - 1)` indices of the offsets of the best lines, the best first.
        values: `(m,)` greatest |u| = tan²(β_E/2) of the chosen corners.
        visited: number of branches that were looked at.
        complete: whether all others are proven to be worse.
    """

    choices: Array
    values: Array
    visited: int
    complete: bool


class _Search:
    """Branch and bound for one line."""

    def __init__(
        self,
        kappas: Array,
        steps: Sequence[Array],
        corners: Sequence[int],
        count: int,
        budget: int,
    ) -> None:
        self.kappas = kappas
        self.sides = 2.0 * np.arctanh(kappas)
        self.turns = [np.exp(-2j * np.asarray(phases)) for phases in steps]
        self.corners = sorted(set(corners))
        self.count = count
        self.budget = budget
        self.tie = _SAME * float(np.sum(kappas))
        self.best_values = np.full(count, np.inf)
        self.best_choices = np.zeros((count, len(steps)), dtype=np.int64)
        self.visited = 0

    def run(self) -> None:
        """Follow all branches, depth first."""
        first = float(self.kappas[0]) if 1 in self.corners else 0.0
        one = np.ones(1, dtype=complex)
        start = (0, self.kappas[0] * one, one, np.full(1, first), np.zeros((1, 0), dtype=np.int64))
        stack = [start]
        while stack and self.visited < self.budget:
            depth, corner, turn, value, choices = stack.pop()
            corner, turn, value, choices = self.children(depth, corner, turn, value, choices)
            depth += 1
            if depth == len(self.turns):
                self.keep(value, choices)
                continue
            bound = np.maximum(value, self.bound(depth, corner))
            order = np.argsort(bound, kind="stable")
            order = order[bound[order] <= self.best_values[-1] + self.tie]
            # The most promising block is popped first.
            for begin in reversed(range(0, len(order), _BLOCK)):
                part = order[begin : begin + _BLOCK]
                stack.append((depth, corner[part], turn[part], value[part], choices[part]))
        self.complete = not stack

    def children(
        self, depth: int, corner: Array, turn: Array, value: Array, choices: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Return the branches with one more joint: corners, turns, values, choices."""
        # An older branch may be worse than what was found since.
        limit = self.best_values[-1] + self.tie
        kept = np.maximum(value, self.bound(depth, corner)) <= limit
        corner, turn, value, choices = corner[kept], turn[kept], value[kept], choices[kept]
        number = len(self.turns[depth])
        turn = (turn[:, None] * self.turns[depth]).ravel()
        corner = added(np.repeat(corner, number), self.kappas[depth + 1] * turn)
        value = np.repeat(value, number)
        if depth + 2 in self.corners:
            value = np.maximum(value, np.abs(corner))
        picked = np.tile(np.arange(number), len(choices))[:, None]
        self.visited += len(corner)
        return corner, turn, value, np.hstack([np.repeat(choices, number, axis=0), picked])

    def bound(self, depth: int, corner: Array) -> Array:
        """Return the least |u| that the chosen corners behind joint `depth + 1` can have."""
        at = 2.0 * np.arctanh(np.abs(corner))
        found = np.zeros(len(corner))
        for end in self.corners:
            if end > depth + 1:
                rest = np.broadcast_to(self.sides[depth + 1 : end], (len(at), end - depth - 1))
                shortfall = least_shortfall(np.column_stack([at, rest]))
                found = np.maximum(found, np.tanh(shortfall / 2.0))
        return found

    def keep(self, value: Array, choices: Array) -> None:
        """Keep the best of these and of those found so far."""
        values = np.concatenate([self.best_values, value])
        every = np.concatenate([self.best_choices, choices])
        order = np.argsort(values, kind="stable")[: self.count]
        self.best_values, self.best_choices = values[order], every[order]


def best_steps(
    betas: Array,
    steps: Sequence[Array],
    corners: Sequence[int],
    *,
    count: int = 8,
    budget: int = 20_000_000,
) -> Found:
    """Return the best choices of offsets that can be taken in steps.

    Args:
        betas: `(n,)` joint angles [rad].
        steps: for each of the n - 1 intermediate shafts the phases `(s,)` by which joint k + 1 can
            follow joint k [rad].
        corners: numbers 1 … n of the joints behind which the residual angle counts; the greatest of
            them is minimised.
        count: number of lines to return, if there are as many.
        budget: number of branches after which the search ends incomplete.
    """
    search = _Search(np.tan(betas / 2.0) ** 2, steps, corners, count, budget)
    search.run()
    found = np.isfinite(search.best_values)
    return Found(
        search.best_choices[found], search.best_values[found], search.visited, search.complete
    )
