"""Fork choice: which offsets forks can take, and the best of them for the residual angle.

Forks that can only be taken in steps join the joints around them to links, and free forks are the
corners between these. A link moves like one joint, so every choice of steps makes a `fork_polygon`
of its own, whose best position is known in closed form.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from analytic import drive_line

from ..arrays import Array
from .fork_polygon import (
    Link,
    distance,
    least_distances,
    least_greatest,
    polygon_phases,
    turning_senses,
)
from .fork_search import minima
from .tooth_search import best_steps

_MOST_CHOICES = 1_000_000
"""Choices of steps between free forks that are all looked at."""
_BUDGET = 20_000_000
"""Branches of a search by branch and bound: some seconds."""
Allowed = Sequence[Array | None]
"""For each intermediate shaft the offsets that its fork can take [rad], None if any."""


class Choice(NamedTuple):
    """Forks that were found.

    Attributes:
        offsets: `(c, n - 1)` fork offsets of lines that may be the best [rad].
        complete: whether one of them is proven to be it.
        method: how they were found.
    """

    offsets: Array
    complete: bool
    method: str


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
        rest = np.where(np.abs(np.abs(rest) - exact) < 4.0 * np.finfo(float).eps, exact, rest)
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

    found = minima(squares, squares, allowed, count, given)
    method = f"search from the best of {found.visited} candidates"
    return Choice(np.array([item.offsets for item in found.found]), False, method)


def _in_steps(
    betas: Array, planes: Array, steps: Sequence[Array], corners: Sequence[int], count: int
) -> Choice:
    phase_steps = [
        values + (np.pi / 2 - plane) for values, plane in zip(steps, planes[1:], strict=True)
    ]
    found = best_steps(betas, phase_steps, corners, count=count, budget=_BUDGET)
    offsets = [
        [values[index] for values, index in zip(steps, choice, strict=True)]
        for choice in found.choices
    ]
    method = f"branch and bound over the teeth, {found.visited} branches"
    return Choice(np.array(offsets), found.complete, method)


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
