"""Closure: what keeps loops closed, as equations of one sample.

A loop gives six rows: its predecessor's weld less its successor's, and the rotation between both; a
coupling gives one, and so does a rod that spins idly, after all others.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from ..tape import absolute, greater, select
from . import spins
from .bodies import Tree
from .elimination import Row
from .placements import Motion, Placed
from .vectors import ZERO, Scalar, added, cross, dot, less, times


def errors(
    tree: Tree, at: Placed, x: Mapping[int, Scalar], offsets: Sequence[Scalar]
) -> tuple[list[Scalar], Scalar]:
    """Return what the rows of loops and couplings are off by, and the greatest of all.

    Of a rotation, its axis times the sine of its angle; beyond a right angle it counts as open.

    Args:
        tree: the loops and couplings.
        at: where the bodies are.
        x: velocity coordinate to the displacement that couplings count.
        offsets: of the couplings, whole turns that `x` lacks included.
    """
    result: list[Scalar] = []
    worst: Scalar = 0.0
    for loop in tree.loops:
        (first, lever), (second, other) = at.end(loop.predecessor), at.end(loop.successor)
        gap = less(
            added(at.point(loop.predecessor.body), lever),
            added(at.point(loop.successor.body), other),
        )
        turn = ZERO
        for axis, target in zip(second, first, strict=True):
            turn = added(turn, cross(axis, target))
        turn = times(turn, 0.5)
        result += [*gap, *turn]
        for value in (*gap, *turn):
            worst = greater(worst, absolute(value))
        # 1 + 2 cos of the angle.
        trace = sum(dot(axis, target) for axis, target in zip(second, first, strict=True))
        worst = select(trace - 1.0, worst, 1.0)
    for coupling, offset in zip(tree.couplings, offsets, strict=True):
        slip = offset
        for rate in coupling.predecessors:
            slip = slip + coupling.ratio * x[rate]
        for rate in coupling.successors:
            slip = slip - x[rate]
        result.append(slip)
        worst = greater(worst, absolute(slip))
    return result, worst


def rows(tree: Tree, at: Placed, moving: Collection[int]) -> list[Row]:
    """Return how fast the rows' errors grow with velocity coordinates.

    Args:
        tree: the loops and couplings.
        at: where the bodies are.
        moving: the velocity coordinates that count; what others move is left out.
    """
    result: list[Row] = []
    for loop in tree.loops:
        of_loop: list[dict[int, Scalar]] = [{} for _ in range(6)]
        ends = loop.predecessor, loop.successor
        paths = tree.apart(*(end.body for end in ends))
        for end, own, sign in zip(ends, paths, (1.0, -1.0), strict=True):
            _, lever = at.end(end)
            point = added(at.point(end.body), lever)
            for index in own:
                body = tree.bodies[index]
                for rate in body.rates:
                    if rate not in moving:
                        continue
                    axis = at.directions[rate]
                    column = [*axis, *ZERO]
                    if body.kind != "prismatic":
                        column = [*cross(axis, less(point, at.points[index])), *axis]
                    for entries, entry in zip(of_loop, column, strict=True):
                        entries[rate] = sign * entry
        result += of_loop
    for coupling in tree.couplings:
        of_coupling: dict[int, Scalar] = dict.fromkeys(coupling.predecessors, coupling.ratio)
        of_coupling |= dict.fromkeys(coupling.successors, -1.0)
        result.append({rate: entry for rate, entry in of_coupling.items() if rate in moving})
    return result + [spins.row(tree, at, spin, moving) for spin in tree.spins]


def drifts(tree: Tree, at: Placed, motion: Motion) -> list[Scalar]:
    """Return how the rates of loops' rows change while no unknown acceleration acts.

    Args:
        tree: the loops and couplings.
        at: where the bodies are.
        motion: with the velocities of all coordinates and the accelerations of known ones.
    """
    result: list[Scalar] = []
    for loop in tree.loops:
        ends = loop.predecessor, loop.successor
        first, second = (motion.at(end.body, at.end(end)[1]) for end in ends)
        spin_rates = [motion.spin_rates[end.body] if end.body >= 0 else ZERO for end in ends]
        result += [*less(first, second), *less(*spin_rates)]
    return result
