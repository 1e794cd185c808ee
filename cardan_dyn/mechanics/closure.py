"""Closure: what keeps loops closed, as equations of one sample.

A loop gives six rows: its predecessor's weld less its successor's, and the rotation between both; a
coupling gives one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from ..tape import absolute, greater, select, sqrt
from .bodies import Tree
from .elimination import Row
from .placements import Motion, Placed
from .vectors import UNTURNED, ZERO, Rotation, Scalar, Vector, added, cross, dot, less, times

_HALF_TURN = 1e-12
"""Four times the squared cosine of half an angle up to which a rotation counts as a half turn: it
is then within 1e-6 rad of one. A smaller square would lose its digits in rounding: of 1e-12, the
rounding of its terms, 1e-16, is already 1e-4."""


class Gap(NamedTuple):
    """How far a loop is from closed, however far that is.

    Attributes:
        shift: from the successor's weld to the predecessor's.
        turn: of the rotation that takes the successor's axes to the predecessor's, its axis times
            twice the sine of half its angle: the angle itself where it is small.
        middle: the point halfway between the welds.
    """

    shift: Vector
    turn: Vector
    middle: Vector


def gaps(tree: Tree, at: Placed) -> list[Gap]:
    """Return how far the loops are from closed."""
    result = []
    for loop in tree.loops:
        (first, lever), (second, other) = at.end(loop.predecessor), at.end(loop.successor)
        to = added(at.point(loop.predecessor.body), lever)
        start = added(at.point(loop.successor.body), other)
        turn = _turn(first, second)
        result.append(Gap(less(to, start), turn, times(added(to, start), 0.5)))
    return result


def _turn(first: Rotation, second: Rotation) -> Vector:
    """Return the rotation that takes second axes to first ones, see `Gap`."""
    sines, trace = ZERO, 0.0
    for target, axis in zip(first, second, strict=True):
        sines, trace = added(sines, cross(axis, target)), trace + dot(axis, target)
    # Four times the squared cosine of half the angle.
    square = trace + 1.0
    turn = times(sines, 1.0 / sqrt(greater(square, _HALF_TURN)))
    # The sines of a half turn about n vanish and show no axis: of R + 1 = 2 n nᵀ the longest
    # column gives n most accurately.
    columns = []
    for k, unit in enumerate(UNTURNED):
        column = unit
        for target, axis in zip(first, second, strict=True):
            column = added(column, times(target, axis[k]))
        columns.append(column)
    longest, size = columns[0], columns[0][0]
    for k in (1, 2):
        longer = columns[k][k] - size
        longest = [select(longer, *both) for both in zip(columns[k], longest, strict=True)]
        size = greater(size, columns[k][k])
    half = times(longest, 2.0 / sqrt(dot(longest, longest)))
    return [select(square - _HALF_TURN, *both) for both in zip(turn, half, strict=True)]


def errors(
    tree: Tree, at: Placed, x: Mapping[int, Scalar], offsets: Sequence[Scalar]
) -> tuple[list[Scalar], Scalar]:
    """Return what the rows are off by, and the greatest of all.

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
    for slip in slips(tree, x, offsets):
        result.append(slip)
        worst = greater(worst, absolute(slip))
    return result, worst


def slips(tree: Tree, x: Mapping[int, Scalar], offsets: Sequence[Scalar]) -> list[Scalar]:
    """Return how far couplings are from their ratios and offsets; arguments as of `errors`."""
    result = []
    for coupling, slip in zip(tree.couplings, offsets, strict=True):
        for rate in coupling.predecessors:
            slip = slip + coupling.ratio * x[rate]
        for rate in coupling.successors:
            slip = slip - x[rate]
        result.append(slip)
    return result


def rows(
    tree: Tree, at: Placed, moving: Collection[int], about: Sequence[Vector] | None = None
) -> list[Row]:
    """Return how fast the rows' errors grow with velocity coordinates.

    Args:
        tree: the loops and couplings.
        at: where the bodies are.
        moving: the velocity coordinates that count; what others move is left out.
        about: a point per loop about which both ends' twists are taken; the welds if None.
    """
    result: list[Row] = []
    for number, loop in enumerate(tree.loops):
        of_loop: list[dict[int, Scalar]] = [{} for _ in range(6)]
        ends = loop.predecessor, loop.successor
        paths = [tree.path(end.body) for end in ends]
        each = zip(ends, paths, paths[::-1], (1.0, -1.0), strict=True)
        for end, own, opposite, sign in each:
            if about is None:
                _, lever = at.end(end)
                point = added(at.point(end.body), lever)
            else:
                point = about[number]
            for index in own:
                if index in opposite:
                    continue
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
    return result


def drifts(tree: Tree, at: Placed, motion: Motion) -> list[Scalar]:
    """Return how the rows' rates change while no unknown acceleration acts.

    Args:
        tree: the loops and couplings.
        at: where the bodies are.
        motion: with the velocities of all coordinates and the accelerations of known ones.
    """
    result: list[Scalar] = []
    for loop in tree.loops:
        ends = loop.predecessor, loop.successor
        first, second = (motion.at(end.body, at.end(end)[1]) for end in ends)
        result += [*less(first, second), *less(*(motion.spin_rate(end.body) for end in ends))]
    return result
