"""Structure: which joints each loop and coupling depends on, and how many motions they have."""

from __future__ import annotations

import numpy as np
import pinocchio

from ....kit.arrays import Array, generic
from ...mechanism.kept import MOST
from ...mechanism.mechanism import Mechanism
from ...mechanism.tree import ancestors
from ..tolerances import CONFIGURATIONS, RANK_TOLERANCE


class Structure:
    """What each loop and coupling of a mechanism depends on.

    An item is a loop or a coupling: the loops come first, then the couplings.

    Attributes:
        mechanism: the mechanism.
        paths: per loop: bodies between its two ends (0-based), ascending; per coupling: those
            whose joints it couples.
        bases: per item: the nearest body (0-based) from which all of these hang, -1 for the world.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        model = mechanism.model
        self._columns = [
            list(range(first, first + size))
            for first, size in zip(model.idx_vs[1:], model.nvs[1:], strict=True)
        ]
        body_of = {column: body for body, own in enumerate(self._columns) for column in own}
        self.paths: list[list[int]] = []
        self.bases: list[int] = []
        for loop in mechanism.loops:
            first, second = (
                set(ancestors(model, end)) for end in (loop.predecessor, loop.successor)
            )
            self.paths.append(sorted(first ^ second))
            self.bases.append(max(first & second, default=-1))
        for item in mechanism.couplings:
            columns = *item.predecessor_columns, *item.successor_columns
            path = sorted({body_of[column] for column in columns})
            below = (set(ancestors(model, model.parents[body + 1])) for body in path)
            self.paths.append(path)
            self.bases.append(max(set.intersection(*below), default=-1))

    def coordinates_on(self, item: int) -> list[int]:
        """Return the velocity coordinates around a loop, or in a coupling, by its index."""
        return [column for body in self.paths[item] for column in self._columns[body]]

    def ranks(self, x: Array, moving: set[int]) -> list[int]:
        """Return for each loop how many independent motions its moving joints have.

        The moving joints are taken at generic values, since a planar or spherical chain stays one
        however it is bent.

        Args:
            x: `(size,)` coordinates, of which those of the joints that do not move count.
            moving: velocity coordinates that move.
        """
        coordinates, result = self.mechanism.coordinates, []
        for loop in range(len(self.mechanism.loops)):
            own = self._own(loop, moving)
            resting = np.setdiff1d(self.coordinates_on(loop), own)
            key = loop, resting.tobytes(), x[coordinates.columns_moved_by(resting)].tobytes()

            def found(loop: int = loop, own: Array = own) -> int:
                step = generic(CONFIGURATIONS, len(own))
                return self._rank(loop, coordinates.displaced(x, own, step), own)

            result.append(self.mechanism.kept.of("rank", key, found, MOST * len(self.paths)))
        return result

    def _own(self, loop: int, moving: set[int]) -> Array:
        """Return which velocity coordinates move around a loop."""
        around = self.coordinates_on(loop)
        return np.array([column for column in around if column in moving], dtype=int)

    def ranks_at(self, x: Array, moving: set[int]) -> list[int]:
        """Return the same at one position, with x `(size,)`."""
        loops = range(len(self.mechanism.loops))
        return [self._rank(loop, x[None, :], self._own(loop, moving)) for loop in loops]

    def _rank(self, loop: int, x: Array, moving: Array) -> int:
        """Return how many unit twists of velocity coordinates on a loop are independent.

        They are those at all of some positions `(K, size)`, seen from the body that carries the
        loop, lengths in units of the mechanism's.
        """
        if not moving.size:
            return 0
        model, units = self.mechanism.model, self.mechanism.coordinates.rate_scale
        data, base, length = (
            model.createData(),
            self.bases[loop],
            self.mechanism.characteristic_length,
        )
        # Far from the origin of that body, the lengths to the origin would outweigh those within
        # the loop, and its rank would be lost in rounding.
        corner = model.jointPlacements[self.paths[loop][0] + 1].translation
        twists = []
        for q in self.mechanism.coordinates.configuration(x):
            columns = pinocchio.computeJointJacobians(model, data, q)[:, moving] * units[moving]
            seen = data.oMi[base + 1] * pinocchio.SE3(np.eye(3), corner)
            twists.append((seen.toActionMatrixInverse() @ columns).T)
        values = np.concatenate(twists) * np.repeat([1.0 / length, 1.0], 3)
        sizes = np.linalg.svd(values, compute_uv=False)
        return int(np.sum(sizes > RANK_TOLERANCE * np.max(sizes)))
