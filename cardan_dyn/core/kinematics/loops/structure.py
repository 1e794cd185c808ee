"""Structure: which joints each loop and coupling depends on, and how many motions they have."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial

import numpy as np
import pinocchio

from ....kit.arrays import Array, generic
from ...mechanism.joints import Part
from ...mechanism.kept import MOST
from ...mechanism.mechanism import Mechanism
from ...mechanism.tree import ancestors
from ..tolerances import CONFIGURATIONS, RANK_TOLERANCE
from .routes import Carriers, Route, carried, carriers_of, short_routes


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
        body_of = {
            column: index - 1
            for index in range(1, model.njoints)
            for column in range(model.idx_vs[index], model.idx_vs[index] + model.nvs[index])
        }
        loops = [
            tuple(set(ancestors(model, body)) for body in (loop.predecessor, loop.successor))
            for loop in mechanism.loops
        ]
        coupled = [
            {body_of[column] for column in (*item.predecessor_columns, *item.successor_columns)}
            for item in mechanism.couplings
        ]
        self.paths = [sorted(first ^ second) for first, second in loops]
        self.paths += [sorted(bodies) for bodies in coupled]
        self.bases = [max(first & second, default=-1) for first, second in loops]
        self.bases += [
            max(
                set.intersection(
                    *(set(ancestors(model, model.parents[body + 1])) for body in bodies)
                ),
                default=-1,
            )
            for bodies in coupled
        ]
        self._columns = [
            list(range(model.idx_vs[index], model.idx_vs[index] + model.nvs[index]))
            for index in range(1, model.njoints)
        ]
        coordinates = mechanism.coordinates
        self._parts = {
            part.id - 1: (part, start)
            for part, start in zip(coordinates.parts, coordinates.starts, strict=True)
        }

    @cached_property
    def routes(self) -> dict[int, Route]:
        """Loops to ways around them that are much shorter than along the tree, see `routes`."""
        return self.mechanism.kept.of(
            "routes", "", lambda: short_routes(self.mechanism, self.paths)
        )

    def route(self, item: int, routes: Mapping[int, Route]) -> Route:
        """Return one of some routes, or else the way along the tree."""
        return routes.get(item) or Route(self.bases[item], self.paths[item], ())

    def coordinates_on(self, item: int, routes: Mapping[int, Route] | None = None) -> list[int]:
        """Return the velocity coordinates around a loop, or in a coupling.

        Args:
            item: its index.
            routes: ways around loops; others, and all if None, are those along the tree.
        """
        bodies = self.route(item, routes or {}).bodies
        return [column for body in bodies for column in self._columns[body]]

    def ranks(
        self, x: Array, moving: set[int], routes: Mapping[int, Route] | None = None
    ) -> list[int]:
        """Return for each loop how many independent motions its moving joints have.

        The moving joints are taken at generic values, since a planar or spherical chain stays one
        however it is bent.

        Args:
            x: `(size,)` coordinates, of which those of the joints that do not move count.
            moving: velocity coordinates that move.
            routes: ways around loops; others, and all if None, are those along the tree.
        """
        result = []
        for loop, way in enumerate(self._ways(routes)):
            resting = [body for body in way.bodies if self._columns[body][0] not in moving]
            at = []
            for body in resting:
                part, start = self._parts[body]
                at.append(x[start : start + (4 if part.kind == "spherical" else 1)].tobytes())
            key, most = (loop, way.crossed, tuple(resting), *at), MOST * len(self.paths)
            found = partial(self._generic_rank, way, x, moving)
            result.append(self.mechanism.kept.of("rank", key, found, most))
        return result

    def _ways(self, routes: Mapping[int, Route] | None) -> list[Route]:
        """Return the way around each loop."""
        return [self.route(loop, routes or {}) for loop in range(len(self.mechanism.loops))]

    def _generic_rank(self, way: Route, x: Array, moving: set[int]) -> int:
        """Return the rank of one loop, see `ranks`."""
        # For each body a rotation vector, of which a turn or a slide takes the first component.
        values = generic(CONFIGURATIONS, 3 * len(way.bodies))
        each = values.reshape(CONFIGURATIONS, -1, 3)
        return _rank(np.concatenate([self._twists(way, x, moving, own) for own in each], axis=0))

    def ranks_at(
        self, x: Array, moving: set[int], routes: Mapping[int, Route] | None = None
    ) -> list[int]:
        """Return for each loop how many independent motions its moving joints have at one position.

        Args:
            x: `(size,)` coordinates.
            moving: velocity coordinates that move.
            routes: ways around loops; others, and all if None, are those along the tree.
        """
        return [_rank(self._twists(way, x, moving)) for way in self._ways(routes)]

    def _twists(self, way: Route, x: Array, moving: set[int], values: Array | None = None) -> Array:
        """Return unit twists `(k, 6)` of the moving coordinates on a way around a loop.

        They are seen from the body that carries the loop, lengths in units of the mechanism's.

        With x `(size,)`, values `(len(way.bodies), 3)`.
        """
        path, carriers = way.bodies, carriers_of(self.mechanism, way.crossed)
        length = self.mechanism.characteristic_length
        placements: dict[int, pinocchio.SE3] = {}
        # Far from the origin of the body that carries the loop, the lengths to that origin would
        # outweigh those within the loop, and its rank would be lost in rounding.
        corner = self._hung(path[0], carriers)[1].translation if path else np.zeros(3)
        twists: list[Array] = []
        for index, body in enumerate(path):
            part, start = self._parts[body]
            moves = self._columns[body][0] in moving
            if not moves or values is None:
                moved = _displacement(part, x[start : start + 4])
            elif part.kind == "spherical":
                moved = pinocchio.SE3(pinocchio.exp3(values[index]), np.zeros(3))
            else:
                unit = length if part.kind == "prismatic" else 1.0
                moved = _displacement(part, values[index] * unit)
            carrier, origin = self._hung(body, carriers)
            parent = placements.get(carrier)
            if parent is None:
                shifted = pinocchio.SE3(origin.rotation, origin.translation - corner)
                placements[body] = shifted * moved
            else:
                placements[body] = parent * origin * moved
            if moves:
                units = _unit_twists(part, length)
                twists.extend(placements[body].action @ unit for unit in units)
        return np.array(twists).reshape(-1, 6) * np.repeat([1.0 / length, 1.0], 3)

    def _hung(self, body: int, carriers: Carriers) -> tuple[int, pinocchio.SE3]:
        """Return the body that carries a joint, and where."""
        model = self.mechanism.model
        carrier, at = carried(model.parents[body + 1] - 1, carriers)
        placement = model.jointPlacements[body + 1]
        return carrier, placement if at is None else at * placement


def _rank(twists: Array) -> int:
    """Return how many of some unit twists `(k, 6)` are independent."""
    singular = np.linalg.svd(twists, compute_uv=False)
    return int(np.sum(singular > RANK_TOLERANCE * max(singular, default=0.0)))


def _displacement(part: Part, x: Array) -> pinocchio.SE3:
    """Return how a part is displaced at its coordinates, the first ones of `x`."""
    if part.kind == "prismatic":
        return pinocchio.SE3(np.eye(3), part.axis * x[0])
    if part.kind == "revolute":
        return pinocchio.SE3(pinocchio.exp3(part.axis * x[0]), np.zeros(3))
    rotation = np.asarray(pinocchio.Quaternion(x).toRotationMatrix())
    return pinocchio.SE3(rotation, np.zeros(3))


def _unit_twists(part: Part, length: float) -> Array:
    """Return unit twists `(k, 6)` of a part in its frame; a slide's unit is the length."""
    if part.kind == "revolute":
        return np.concatenate([np.zeros(3), part.axis])[None]
    if part.kind == "prismatic":
        return np.concatenate([length * part.axis, np.zeros(3)])[None]
    return np.concatenate([np.zeros((3, 3)), np.eye(3)], axis=1)
