"""Ranks of mechanisms by screws on free bodies: plain NumPy, any joints, any number of loops.

Every body has six freedoms, and every joint takes away what its screws do not span. This is another
matrix than the closure equations of loops, made from points and directions in the world alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

Array = np.ndarray

_ZERO = 1e-8
"""Singular values and components below this part of one count as zero: all lengths are near one."""


class Connection(NamedTuple):
    """A joint between two bodies.

    Attributes:
        name: of the joint.
        first, second: indices of the bodies, -1 for the world.
        screws: `(f, 6)` unit twists (linear part about the world's origin, angular part).
        frame: `(4, 4)` placement of the joint's frame in the world.
    """

    name: str
    first: int
    second: int
    screws: Array
    frame: Array

    @property
    def wrenches(self) -> Array:
        """Forces and moments about the world's origin `(6 - f, 6)` without work on its twists."""
        _, values, right = np.linalg.svd(self.screws)
        return right[int(np.sum(values > _ZERO)) :]


class FreeBodies(NamedTuple):
    """What the constraints of all joints together do.

    Attributes:
        mobility: number of independent motions of all bodies.
        self_stresses: number of independent states of stress without a load.
        open: joint to the components of its wrench, in its frame, that self-stresses change:
            letters of the force, then of the moment.
    """

    mobility: int
    self_stresses: int
    open: dict[str, tuple[str, str]]


def free_bodies(count: int, connections: list[Connection]) -> FreeBodies:
    """Return mobility, self-stresses and open components of some bodies and their joints."""
    blocks = []
    for item in connections:
        rows = np.zeros((len(item.wrenches), 6 * count))
        for body, sign in ((item.first, -1.0), (item.second, 1.0)):
            if body >= 0:
                rows[:, 6 * body : 6 * body + 6] = sign * item.wrenches
        blocks.append(rows)
    left, values, _ = np.linalg.svd(np.concatenate(blocks))
    rank = int(np.sum(values > _ZERO))
    stresses = left[:, rank:]
    found, first = {}, 0
    for item, rows in zip(connections, blocks, strict=True):
        reactions = stresses[first : first + len(rows)].T @ item.wrenches
        first += len(rows)
        axes, point = item.frame[:3, :3], item.frame[:3, 3]
        force = reactions[:, :3] @ axes
        moment = (reactions[:, 3:] - np.cross(point, reactions[:, :3])) @ axes
        found[item.name] = _letters(force), _letters(moment)
    return FreeBodies(6 * count - rank, stresses.shape[1], found)


def _letters(vectors: Array) -> str:
    sizes = np.max(np.abs(vectors), axis=0, initial=0.0)
    return "".join(axis for axis, size in zip("xyz", sizes, strict=True) if size > 1e-6)
