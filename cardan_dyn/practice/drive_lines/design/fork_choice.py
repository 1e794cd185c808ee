"""Fork choice: which offsets forks can take, and the best of them for the residual angle.

Forks that can only be taken in steps join the joints around them to links, and free forks are the
corners between these. A link moves like one joint, so every choice of steps makes a `fork_polygon`
of its own, whose best position is known in closed form.

If no fork is free, branch and bound goes from the input to the output: where the forks up to a
shaft stand, the corners of the polygon behind it cannot come closer than its remaining sides allow.
Branches whose least distance exceeds the best line found so far are left out, so what is found is
the global optimum.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cardan_dyn.analytic import drive_line

from ....kit.arrays import BLOCK_SIZE, EPS, ROUNDED, Array
from .fork_polygon import (
    Link,
    added,
    distance,
    least_distances,
    least_greatest,
    least_shortfall,
    polygon_phases,
    turning_senses,
)
from .fork_search import Choice, minima

_MOST_CHOICES = 1_000_000
"""Choices of steps between free forks that are all looked at."""
_BUDGET = 20_000_000
"""Branches of a search by branch and bound: some seconds."""
Allowed = Sequence[Array | None]
"""For each intermediate shaft the offsets that its fork can take [rad], None if any."""


def tooth_offsets(offset: float, teeth: int) -> Array:
    """Return the offsets that a spline can take, with `offset` among them [rad].

    A fork is the same after half a turn, so that an even number of teeth has half as many offsets.
    """
    count = teeth // 2 if teeth % 2 == 0 else teeth
    return np.asarray(halved(offset + np.arange(count) * (np.pi / count)))


def halved(offsets: Array | float) -> Array:
    """Return offsets without half turns: -π/2 < offset <= π/2 [rad]."""
    rest = np.asarray(offsets) - np.pi * np.ceil(np.asarray(offsets) / np.pi - 0.5)
    # Rounding of π makes a fork that stands in line or across miss it by as much.
    for exact in (0.0, np.pi / 2):
        rest = np.where(np.abs(np.abs(rest) - exact) < 4.0 * EPS, exact, rest)
    return rest


def phases_of(offsets: Array, planes: Array) -> Array:
    """Return fork phases `(..., n)` of fork offsets `(..., n - 1)`, the first 0 [rad].

    Args:
        offsets: of the intermediate shafts.
        planes: `(n,)` plane offsets of the joints, see `Geometry`.
    """
    return drive_line.fork_phases(np.broadcast_to(planes[1:], offsets.shape), offsets)


def offsets_of(phases: Array, planes: Array) -> Array:
    """Return the fork offsets `(n - 1,)` of fork phases `(n,)`, without half turns [rad]."""
    return halved(np.diff(phases) - np.pi / 2 + planes[1:])


def least_residual(
    betas: Array, planes: Array, allowed: Allowed, corners: Sequence[int], given: Array, count: int
) -> Choice:
    """Return forks that make the greatest residual angle of chosen shafts least.

    Args:
        betas: `(n,)` joint angles [rad].
        planes: `(n,)` plane offsets [rad].
        allowed: what forks can take.
        corners: numbers 1 … n of the joints behind which the residual angle counts.
        given: `(n - 1,)` offsets that a search tries as well [rad].
        count: about how many lines to return.
    """
    steps = [values for values in allowed if values is not None]
    if len(steps) == len(allowed):
        return _in_steps(betas, planes, steps, corners, count)
    blocks = _blocks(allowed)
    ends = [block[-1] + 1 for block in blocks]
    inner = [corner for corner in corners if corner not in ends]
    choices = float(np.prod([float(len(values)) for values in steps]))
    if all(corner < ends[0] for corner in inner) and choices <= _MOST_CHOICES:
        return _polygons(betas, planes, allowed, corners, count)

    def squares(offsets: Array) -> Array:
        """|u|² = tan⁴(β_E/2), which is smooth where the residual angle vanishes."""
        phases = phases_of(offsets, planes)
        angles = [drive_line.residual_angle(betas[:k], phases[:, :k]) for k in corners]
        return np.asarray(np.tan(np.stack(angles, axis=1) / 2.0) ** 4)

    return minima(squares, squares, allowed, count, given)


def _in_steps(
    betas: Array, planes: Array, steps: Sequence[Array], corners: Sequence[int], count: int
) -> Choice:
    phase_steps = [
        values + (np.pi / 2 - plane) for values, plane in zip(steps, planes[1:], strict=True)
    ]
    found = StepSearch(betas, phase_steps, corners, count, _BUDGET)
    offsets = [values[chosen] for values, chosen in zip(steps, found.choices.T, strict=True)]
    method = f"branch and bound over the teeth, {found.visited} branches"
    return Choice(np.stack(offsets, axis=1), found.complete, method)


def _blocks(allowed: Allowed) -> list[list[int]]:
    """Return the indices of the joints of each link: those that no free fork is between."""
    blocks = [[0]]
    for index, values in enumerate(allowed, 1):
        if values is None:
            blocks.append([])
        blocks[-1].append(index)
    return blocks


def _combinations(sizes: Sequence[int]) -> Array:
    """Return all ways to pick one of each size, `(c, s)` indices: of any number of sizes."""
    # A grid has as many dimensions as there are sizes, and NumPy's arrays have 32 at most.
    picks = np.zeros((1, 0), dtype=int)
    for size in sizes:
        added = np.tile(np.arange(size), len(picks))
        picks = np.column_stack([np.repeat(picks, size, axis=0), added])
    return picks


def _polygons(
    betas: Array, planes: Array, allowed: Allowed, corners: Sequence[int], count: int
) -> Choice:
    """Return the best polygons of all links that the steps between free forks make."""
    blocks = _blocks(allowed)
    phases, sides = [], []
    for block in blocks:
        lists = [values for index in block[1:] if (values := allowed[index - 1]) is not None]
        of_block = np.zeros((1, 1))
        if lists:
            chosen_of = _combinations([len(values) for values in lists])
            columns = [values[chosen_of[:, i]] for i, values in enumerate(lists)]
            of_block = phases_of(np.stack(columns, axis=1), planes[block])
        phases.append(of_block)
        sides.append(distance(drive_line.residual_angle(betas[block], of_block)))
    ends = [block[-1] + 1 for block in blocks]
    links = [number for number, end in enumerate(ends, 1) if end in corners]
    picks = _combinations([len(side) for side in sides])
    of_links = np.stack([side[picks[:, k]] for k, side in enumerate(sides)], axis=1)
    values = least_greatest(of_links, links)
    for corner in (corner for corner in corners if corner < ends[0]):
        start = distance(drive_line.residual_angle(betas[:corner], phases[0][:, :corner]))
        values = np.maximum(values, start[picks[:, 0]])
    offsets_found = []
    for row in np.argsort(values, kind="stable")[:count]:
        chosen = [Link(betas[block], phases[k][picks[row, k]]) for k, block in enumerate(blocks)]
        distances = least_distances(of_links[row], links)
        offsets_found += [
            offsets_of(polygon_phases(chosen, distances, senses), planes)
            for senses in turning_senses(of_links[row], distances)
        ]
    among = f" of {len(picks)} choices of steps" if len(picks) > 1 else ""
    return Choice(np.array(offsets_found), True, f"closed form: fork polygon{among}")


class StepSearch:
    """The best choices of offsets that can be taken in steps, by branch and bound.

    Attributes:
        choices: `(c, n - 1)` indices of the offsets of the best lines, the best first.
        values: `(c,)` greatest |u| = tan²(β_E/2) of the chosen corners.
        visited: number of branches that were looked at.
        complete: whether all others are proven to be worse.
    """

    def __init__(
        self,
        betas: Array,
        steps: Sequence[Array],
        corners: Sequence[int],
        count: int,
        budget: int,
    ) -> None:
        """Search.

        Args:
            betas: `(n,)` joint angles [rad].
            steps: for each of the n - 1 intermediate shafts the phases `(s,)` by which joint k + 1
                can follow joint k [rad].
            corners: numbers 1 … n of the joints behind which the residual angle counts; the
                greatest of them is minimised.
            count: number of lines that are found, if there are as many.
            budget: number of branches after which the search ends incomplete.
        """
        self.kappas = np.tan(betas / 2.0) ** 2
        self.sides = 2.0 * np.arctanh(self.kappas)
        self.turns = [np.exp(-2j * np.asarray(phases)) for phases in steps]
        self.corners = sorted(set(corners))
        self.count = count
        # What is within rounding of the sum is a tie.
        self.tie = ROUNDED * float(np.sum(self.kappas))
        self.values = np.full(count, np.inf)
        self.choices = np.zeros((count, len(steps)), dtype=np.int64)
        self.visited = 0
        self.complete = self.run(budget)
        found = np.isfinite(self.values)
        self.choices, self.values = self.choices[found], self.values[found]

    def run(self, budget: int) -> bool:
        """Follow all branches, depth first, and return whether none is left."""
        first = float(self.kappas[0]) if 1 in self.corners else 0.0
        one = np.ones(1, dtype=complex)
        start = (0, self.kappas[0] * one, one, np.full(1, first), np.zeros((1, 0), dtype=np.int64))
        stack = [start]
        while stack and self.visited < budget:
            depth, corner, turn, value, choices = stack.pop()
            corner, turn, value, choices = self.children(depth, corner, turn, value, choices)
            depth += 1
            if depth == len(self.turns):
                self.keep(value, choices)
                continue
            bound = np.maximum(value, self.bound(depth, corner))
            order = np.argsort(bound, kind="stable")
            order = order[bound[order] <= self.values[-1] + self.tie]
            # The most promising block is popped first.
            for begin in reversed(range(0, len(order), BLOCK_SIZE)):
                part = order[begin : begin + BLOCK_SIZE]
                stack.append((depth, corner[part], turn[part], value[part], choices[part]))
        return not stack

    def children(
        self, depth: int, corner: Array, turn: Array, value: Array, choices: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Return the branches with one more joint: corners, turns, values, choices."""
        # An older branch may be worse than what was found since.
        limit = self.values[-1] + self.tie
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
        values = np.concatenate([self.values, value])
        every = np.concatenate([self.choices, choices])
        order = np.argsort(values, kind="stable")[: self.count]
        self.values, self.choices = values[order], every[order]
