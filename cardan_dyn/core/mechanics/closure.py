"""Closure: what keeps loops closed, as equations of one sample.

A loop gives six rows: its predecessor's weld less its successor's, and the rotation between both; a
coupling gives one, and so does a rod that spins idly, after all others.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from ...kit.arrays import ROUNDED
from ..tape import absolute, greater, select, sqrt
from . import spins
from .bodies import Coupling, Tree
from .elimination import Row
from .placements import Motion, Placed
from .vectors import (
    UNTURNED,
    ZERO,
    Rotation,
    Scalar,
    Vector,
    added,
    cross,
    dot,
    less,
    times,
    turned,
)


class Gap(NamedTuple):
    """How far the welds of a loop are apart, however far that is.

    Attributes:
        shift: from the successor's weld to the predecessor's.
        middle: the point halfway between them.
    """

    shift: Vector
    middle: Vector


def gaps(tree: Tree, at: Placed) -> list[Gap]:
    """Return how far the loops' welds are apart."""
    result = []
    for loop in tree.loops:
        first, second = (
            added(at.point(end.body), at.end(end)[1]) for end in (loop.predecessor, loop.successor)
        )
        result.append(Gap(less(first, second), times(added(first, second), 0.5)))
    return result


def turns(tree: Tree, at: Placed) -> list[Vector]:
    """Return the rotations that take the axes of loops' successors to those of predecessors.

    Along the axis, twice the sine of half the angle: the angle itself where it is small.
    """
    return [_turn(at.end(loop.predecessor)[0], at.end(loop.successor)[0]) for loop in tree.loops]


def _turn(first: Rotation, second: Rotation) -> Vector:
    """Return the rotation that takes second axes to first ones, see `turns`."""
    # The rotation's columns.
    x, y, z = columns = [turned(first, [axis[k] for axis in second]) for k in range(3)]
    sines = y[2] - z[1], z[0] - x[2], x[1] - y[0]
    # Four times the squared cosine of half the angle. Where it is rounding of its terms, the angle
    # is within 1e-6 rad of a half turn, and counts as one.
    square = x[0] + y[1] + z[2] + 1.0
    turn = times(sines, 1.0 / sqrt(greater(square, ROUNDED)))
    # The sines of a half turn about n vanish and show no axis: of R + 1 = 2 n nᵀ the longest
    # column gives n most accurately.
    longest, size = added(x, UNTURNED[0]), x[0]
    for k in (1, 2):
        longer, column = columns[k][k] - size, added(columns[k], UNTURNED[k])
        longest = [select(longer, *both) for both in zip(column, longest, strict=True)]
        size = greater(size, columns[k][k])
    half = times(longest, 2.0 / sqrt(dot(longest, longest)))
    return [select(square - ROUNDED, *both) for both in zip(turn, half, strict=True)]


def errors(tree: Tree, at: Placed, offsets: Sequence[Scalar]) -> tuple[list[Scalar], Scalar]:
    """Return what the rows of loops and couplings are off by, and the greatest of all.

    A coupling counts by what the faster of its joints is off.

    Of a rotation, its axis times the sine of its angle; beyond a right angle it counts as open.

    Args:
        tree: the loops and couplings.
        at: where the bodies are.
        offsets: of the couplings, with the whole turns that coordinates lack.
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
    each = zip(tree.couplings, slips(tree, at.positions, offsets), strict=True)
    for coupling, slip in each:
        result.append(slip)
        faster = greater(1.0, absolute(slope(coupling, at)))
        worst = greater(worst, absolute(slip) * (1.0 / faster))
    return result, worst


def slips(tree: Tree, x: Mapping[int, Scalar], offsets: Sequence[Scalar]) -> list[Scalar]:
    """Return how far couplings are from where they hold.

    Args:
        tree: the couplings.
        x: velocity coordinate to the displacement that couplings count.
        offsets: see `errors`.
    """
    result = []
    for coupling, slip in zip(tree.couplings, offsets, strict=True):
        for rate in coupling.predecessors:
            slip = slip + coupling.ratio * x[rate]
        for rate in coupling.successors:
            slip = slip - x[rate]
        if coupling.higher:
            first = sum((x[rate] for rate in coupling.predecessors), 0.0)
            slip = slip + _valued(coupling.higher, first) * first * first
        result.append(slip)
    return result


def slope(coupling: Coupling, at: Placed) -> Scalar:
    """Return how fast the successor of a coupling moves per unit rate of the predecessor."""
    if not coupling.higher:
        return coupling.ratio
    factors = [power * value for power, value in enumerate(coupling.higher, 2)]
    return _valued([coupling.ratio, *factors], _first(coupling, at))


def bends(tree: Tree, at: Placed, v: Mapping[int, Scalar]) -> list[Scalar]:
    """Return how fast rates of couplings' rows change as their slopes do.

    Args:
        tree: the couplings.
        at: where the bodies are.
        v: velocity coordinate to joint velocity; what is missing is zero.
    """
    result: list[Scalar] = []
    for coupling in tree.couplings:
        bend: Scalar = 0.0
        if coupling.higher:
            rate = sum((v.get(rate, 0.0) for rate in coupling.predecessors), 0.0)
            factors = [
                power * (power - 1) * value for power, value in enumerate(coupling.higher, 2)
            ]
            bend = _valued(factors, _first(coupling, at)) * rate * rate
        result.append(bend)
    return result


def _first(coupling: Coupling, at: Placed) -> Scalar:
    """Return the displacement of a coupling's predecessor."""
    return sum((at.positions[rate] for rate in coupling.predecessors), 0.0)


def _valued(coefficients: Sequence[float], x: Scalar) -> Scalar:
    """Return the value of a polynomial, of ascending powers (Horner)."""
    *others, result = coefficients
    for coefficient in reversed(others):
        result = result * x + coefficient
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
        paths = tree.apart(*(end.body for end in ends))
        for end, own, sign in zip(ends, paths, (1.0, -1.0), strict=True):
            if about is None:
                _, lever = at.end(end)
                point = added(at.point(end.body), lever)
            else:
                point = about[number]
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
        of_coupling: dict[int, Scalar] = dict.fromkeys(coupling.predecessors, slope(coupling, at))
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
        ends = [
            [
                *at.in_tree(end.body, motion.at(end.body, end.translation)),
                *at.in_tree(end.body, motion.spin_rate(end.body)),
            ]
            for end in (loop.predecessor, loop.successor)
        ]
        result += [first - second for first, second in zip(*ends, strict=True)]
    return result
