"""Groups: the smallest sets of loops that can be solved one after the other.

A drive line with bearings between its joints is a row of loops, each of which needs only the
motion of the one before it. Solving them one by one keeps the cost and Pinocchio's memory linear
in the number of joints. A loop and the passive joints on it form a bipartite graph; its matching
and the strong components of what depends on what give the groups.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio

from .coordinates import Array, Coordinates, generic
from .mechanism import Mechanism
from .tree import ancestors

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the greatest count as zero in rank decisions."""
_PIECE = 8  # Bodies on no loop are taken in pieces of this size.
_LONG = 3 * _PIECE
_WHOLE = 14  # Up to this many bodies, one model costs less than two.


@dataclass(frozen=True, eq=False, repr=False)
class Group:
    """Loops that are solved together.

    Attributes:
        loops, couplings: numbers in `Mechanism.loops` and `Mechanism.couplings`.
        passives: velocity coordinates that they decide.
        known: moving coordinates on them that are driven or decided by earlier groups.
        bodies: bodies carried (0-based), ancestors included, ascending.
        massive: bodies whose inertia is accounted for in this group.
    """

    loops: tuple[int, ...]
    couplings: tuple[int, ...]
    passives: Array
    known: Array
    bodies: list[int]
    massive: set[int]


class Structure:
    """What each loop and coupling of a mechanism depends on.

    Attributes:
        paths: per loop, then per coupling: bodies between its two ends (0-based).
        chains: per loop and coupling: all bodies from the root to both ends.
    """

    def __init__(self, mechanism: Mechanism, coordinates: Coordinates) -> None:
        self.mechanism = mechanism
        self.coordinates = coordinates
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
        length = self.mechanism.length
        model = self.mechanism.model
        parts = {part.index - 1: (part, start) for part, start in self._parts()}
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
        return list(zip(self.coordinates.parts, self.coordinates.starts, strict=True))


def partition(
    structure: Structure, x: Array, drives: Array, passives: Array, together: bool = False
) -> list[Group]:
    """Return the groups in the order in which motion passes through them.

    Args:
        structure: of the mechanism.
        x: `(size,)` coordinates with the held joints at their positions.
        drives: velocity coordinates of the drives.
        passives: velocity coordinates that are neither driven nor held.
        together: solve all loops in one group, whatever their structure.
    """
    mechanism = structure.mechanism
    wanted = {int(column) for column in passives}
    moving = wanted | {int(column) for column in drives}
    count = len(structure.paths)
    touched = [
        [column for column in structure.coordinates_on(item) if column in moving]
        for item in range(count)
    ]
    if count <= 1 or together:
        blocks = [list(range(count))] if count else []
        decided = {0: sorted({column for item in touched for column in item} & wanted)}
    else:
        ranks = structure.ranks(x, moving) + [1] * len(mechanism.couplings)
        blocks, decided = _blocks(touched, ranks, wanted)
    groups: list[Group] = []
    carried: set[int] = set()
    loops = len(mechanism.loops)
    for number, block in enumerate(blocks):
        own = decided[number]
        known = sorted({column for item in block for column in touched[item]} - set(own))
        bodies = sorted({body for item in block for body in structure.chains[item]})
        groups.append(
            Group(
                tuple(item for item in block if item < loops),
                tuple(item - loops for item in block if item >= loops),
                np.array(own, dtype=int),
                np.array(known, dtype=int),
                bodies,
                set(bodies) - carried,
            )
        )
        carried |= set(bodies)
    return _with_loose_bodies(mechanism.model, groups, carried)


def _blocks(
    touched: list[list[int]], ranks: list[int], wanted: set[int]
) -> tuple[list[list[int]], dict[int, list[int]]]:
    """Return sets of loops and couplings in order, and the passives that each decides."""
    unknown = [[column for column in item if column in wanted] for item in touched]
    slots = [item for item, rank in enumerate(ranks) for _ in range(min(rank, len(unknown[item])))]
    match = matched([unknown[item] for item in slots])
    decider = {column: slots[row] for column, row in match.items()}
    for item, own in enumerate(unknown):
        for column in own:
            # A joint that nothing decides is reported later, by name.
            decider.setdefault(column, item)

    edges = {
        (item, decider[column])
        for item, own in enumerate(unknown)
        for column in own
        if decider[column] != item
    }
    size = len(touched)
    while True:
        labels = components(size, edges)
        # A group with more rows than unknowns limits the ones that it depends on.
        more = set()
        for label in set(labels):
            members = {item for item in range(size) if labels[item] == label}
            decides = sum(decider[column] in members for column in decider)
            if sum(ranks[item] for item in members) > decides:
                more |= {(b, a) for a, b in edges if a in members and b not in members}
        if more <= edges:
            break
        edges |= more

    order: list[int] = []
    needs = {
        label: {labels[b] for a, b in edges if labels[a] == label} - {label} for label in labels
    }
    while len(order) < len(needs):
        ready = [label for label in needs if label not in order and needs[label] <= set(order)]
        order.extend(sorted(ready))
    blocks = [[item for item in range(size) if labels[item] == label] for label in order]
    decided = {
        number: sorted(column for column, item in decider.items() if item in block)
        for number, block in enumerate(blocks)
    }
    return blocks, decided


def _with_loose_bodies(
    model: pinocchio.Model, groups: list[Group], carried: set[int]
) -> list[Group]:
    """Add the bodies that are on no loop, with the only group if the model stays small."""
    everything = model.njoints - 1
    loose = [body for body in range(everything) if body not in carried]
    if not loose:
        return groups
    none = np.zeros(0, dtype=int)
    if len(groups) <= 1 and everything <= _WHOLE:
        group = groups[0] if groups else Group((), (), none, none, [], set())
        bodies = list(range(everything))
        return [
            Group(group.loops, group.couplings, group.passives, group.known, bodies, set(bodies))
        ]
    while loose:
        piece = loose[:_PIECE]
        bodies = _with_ancestors(model, piece)
        if len(bodies) > _LONG:
            # A piece of a long chain would carry the chain up to it once more.
            piece = loose
            bodies = _with_ancestors(model, piece)
        groups.append(Group((), (), none, none, bodies, set(piece)))
        loose = loose[len(piece) :]
    return groups


def _with_ancestors(model: pinocchio.Model, bodies: list[int]) -> list[int]:
    found: set[int] = set()
    for body in bodies:
        index = body + 1
        while index > 0 and index - 1 not in found:
            found.add(index - 1)
            index = model.parents[index]
    return sorted(found)


def _rotation(quaternion: Array) -> Array:
    return np.asarray(pinocchio.Quaternion(quaternion).toRotationMatrix())


# SciPy has both of these for graphs of any size, but takes a hundred times as long to be imported
# as a mechanism's graph takes.


def matched(options: list[list[int]]) -> dict[int, int]:
    """Return a greatest matching of rows with columns, one column per row: column to row.

    Args:
        options: columns that each row may have.
    """
    found: dict[int, int] = {}
    for first in range(len(options)):
        # Breadth first to a row with a free column; the rows on the way then pass theirs on.
        asked: dict[int, tuple[int, int]] = {}
        way = [first]
        for row in way:
            free = next((column for column in options[row] if column not in found), None)
            if free is not None:
                while row != first:
                    asking, own = asked[row]
                    found[free] = row
                    free, row = own, asking
                found[free] = first
                break
            for column in options[row]:
                holder = found[column]
                if holder != first and holder not in asked:
                    asked[holder] = (row, column)
                    way.append(holder)
    return found


def components(size: int, edges: set[tuple[int, int]]) -> list[int]:
    """Return for each of `size` nodes the least node from and to which directed edges lead."""
    reach = np.eye(size, dtype=bool)
    for start, end in edges:
        reach[start, end] = True
    for middle in range(size):
        reach |= reach[:, [middle]] & reach[middle]
    return [int(label) for label in np.argmax(reach & reach.T, axis=1)]
