"""Spins: rods that may turn about a line without any other body moving.

No loop decides such a spin. A rule does where motion is asked for: a rod stands as the least
rotation takes its line from the description's zero, and has no rate about it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ...kit.arrays import Array
from ..tape import arctan2, greater
from .bodies import Spin, Tree
from .elimination import Row
from .placements import Motion, Placed, placed
from .vectors import UNTURNED, Rotation, Scalar, Vector, added, cross, dot, less, seen, times
from .vectors import turned as in_axes


def spins_of(
    tree: Tree, zero: Array, rods: Sequence[tuple[int, tuple[int, ...], Array, int]]
) -> tuple[Spin, ...]:
    """Return the spins of rods.

    Args:
        tree: the mechanism.
        zero: `(size,)` coordinates of the description's zero.
        rods: body, velocity coordinates at its ends, line in it `(3,)`, and frame, see `Spin`.
    """
    at = placed(tree, dict(enumerate((zero / tree.coordinate_units(len(zero))).tolist())))
    result = []
    for body, rates, direction, frame in rods:
        line = direction.tolist()
        # Across the line: along the axis that is farthest from it, less the part along the line.
        side = np.eye(3)[np.argmin(np.abs(direction))]
        side = side - (side @ direction) * direction
        across = (side / np.linalg.norm(side)).tolist()
        seen_at_zero, across_at_zero = (
            tuple(map(float, _from_frame(at, body, frame, vector))) for vector in (line, across)
        )
        ends = tuple(line), tuple(across), seen_at_zero, across_at_zero
        result.append(Spin(body, frame, *ends, rates))
    return tuple(result)


def _rotation(at: Placed, body: int) -> Rotation:
    return at.rotations[body] if body >= 0 else UNTURNED


def _from_frame(at: Placed, body: int, frame: int, vector: Vector) -> Vector:
    """Return a vector that a body carries, as seen from another one."""
    return seen(_rotation(at, frame), in_axes(at.rotations[body], vector))


def row(tree: Tree, at: Placed, spin: Spin, moved: Collection[int]) -> Row:
    """Return how fast a rod turns about its line relative to its frame, per unit of rates.

    Args:
        tree: the mechanism.
        at: where it is.
        spin: of the rod.
        moved: velocity coordinates that count.
    """
    line = in_axes(at.rotations[spin.body], spin.line)
    return {
        rate: sign * dot(at.directions[rate], line)
        for bodies, sign in zip(tree.apart(spin.body, spin.frame), (1.0, -1.0), strict=True)
        for body in bodies
        if tree.bodies[body].kind != "prismatic"
        for rate in tree.bodies[body].rates
        if rate in moved
    }


def drift(at: Placed, motion: Motion, spin: Spin) -> Scalar:
    """Return the acceleration about the line, seen from the frame, of a motion."""
    own, frame = (
        [at.in_tree(body, of) for of in (motion.spin(body), motion.spin_rate(body))]
        for body in (spin.body, spin.frame)
    )
    relative, change = map(less, own, frame)
    return dot(at.in_tree(spin.body, spin.line), less(change, cross(frame[0], relative)))


def turned(at: Placed, spin: Spin) -> Scalar:
    """Return the angle [rad] of a rod about its line from where the least rotation takes it.

    At half a turn of the line there is none; nearby, the result turns fast.
    """
    start, level = spin.line_at_zero, spin.across_at_zero
    now, found = (_from_frame(at, spin.body, spin.frame, of) for of in (spin.line, spin.across))
    # A vector across the line, turned by the least rotation.
    axis = cross(start, now)
    change = cross(axis, level)
    scale = 1.0 / greater(1.0 + dot(start, now), float(np.finfo(float).tiny))
    settled = added(added(level, change), times(cross(axis, change), scale))
    return arctan2(dot(now, cross(settled, found)), dot(settled, found))
