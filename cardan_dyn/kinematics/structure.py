"""Structure: which joints each loop and coupling depends on, and how many motions they have."""

from __future__ import annotations

import numpy as np
import pinocchio

from ..arrays import Array, generic
from ..mechanism.mechanism import Mechanism
from ..mechanism.tree import ancestors
from .tolerances import RANK_TOLERANCE


class Structure:
    """What each loop and coupling of a mechanism depends on.

    Attributes:
        paths: per loop, then per coupling: bodies between its two ends (0-based).
        chains: per loop and coupling: all bodies from the root to both ends.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        ends = [(loop.predecessor, loop.successor) for loop in mechanism.loops]
        ends += [(item.predecessor, item.successor) for item in mechanism.couplings]
        chains = [tuple(set(ancestors(mechanism.model, body)) for body in pair) for pair in ends]
        self.paths = [sorted(first ^ second) for first, second in chains]
        self.chains = [sorted(first | second) for first, second in chains]
        model = mechanism.model
        self._columns = [
            list(range(model.idx_vs[index], model.idx_vs[index] + model.nvs[index]))
            for index in range(1, model.njoints)
        ]

    def coordinates_on(self, item: int) -> list[int]:
        """Return the velocity coordinates between the ends of a loop or coupling."""
        return [column for body in self.paths[item] for column in self._columns[body]]

    def ranks(self, x: Array, moving: set[int]) -> list[int]:
        """Return for each loop how many independent motions its moving joints have.

        Args:
            x: `(size,)` coordinates of the joints that do not move; the others are taken at
                random, since a planar or spherical chain stays one however it is bent.
            moving: velocity coordinates that move.
        """
        result = []
        for number in range(len(self.mechanism.loops)):
            path = self.paths[number]
            twists = [
                self._twists(path, x, moving, values)
                for values in generic(3, 3 * len(path)).reshape(3, -1, 3)
            ]
            values = np.linalg.svd(np.concatenate(twists, axis=0), compute_uv=False)
            result.append(int(np.sum(values > RANK_TOLERANCE * max(values, default=0.0))))
        return result

    def _twists(self, path: list[int], x: Array, moving: set[int], values: Array) -> Array:
        """Return unit twists `(k, 6)` of the moving coordinates on a path.

        They are seen from the body that carries the loop, lengths in units of the mechanism's.

        Args:
            path: bodies on the loop, ascending.
            x: `(size,)` coordinates of the joints that do not move.
            moving: velocity coordinates that move.
            values: `(len(path), 3)` where they are.
        """
        length = self.mechanism.characteristic_length
        model = self.mechanism.model
        parts = {part.id - 1: (part, start) for part, start in self._parts()}
        placements: dict[int, pinocchio.SE3] = {}
        # Far from the origin of what carries the loop, lengths would hide its rank.
        corner = model.jointPlacements[path[0] + 1].translation if path else np.zeros(3)
        twists: list[Array] = []
        for body, where in zip(path, values, strict=True):
            part, start = parts[body]
            moves = self._columns[body][0] in moving
            value = where if moves else x[start : start + 4]
            if part.kind == "revolute":
                own = pinocchio.SE3(pinocchio.exp3(part.axis * value[0]), np.zeros(3))
                units = np.concatenate([np.zeros(3), part.axis])[None]
            elif part.kind == "prismatic":
                slide = part.axis * value[0] * (length if moves else 1.0)
                own = pinocchio.SE3(np.eye(3), slide)
                units = np.concatenate([length * part.axis, np.zeros(3)])[None]
            else:
                turn = pinocchio.exp3(value) if moves else _rotation(value)
                own = pinocchio.SE3(turn, np.zeros(3))
                units = np.concatenate([np.zeros((3, 3)), np.eye(3)], axis=1)
            origin = model.jointPlacements[body + 1]
            parent = placements.get(model.parents[body + 1] - 1)
            if parent is None:
                here = pinocchio.SE3(origin.rotation, origin.translation - corner) * own
            else:
                here = parent * origin * own
            placements[body] = here
            if moves:
                twists.extend(here.action @ unit for unit in units)
        return np.array(twists).reshape(-1, 6) * np.repeat([1.0 / length, 1.0], 3)

    def _parts(self) -> list[tuple]:  # type: ignore[type-arg]
        return list(
            zip(self.mechanism.coordinates.parts, self.mechanism.coordinates.starts, strict=True)
        )


def _rotation(quaternion: Array) -> Array:
    return np.asarray(pinocchio.Quaternion(quaternion).toRotationMatrix())
