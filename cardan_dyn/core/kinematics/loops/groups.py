"""Loop groups: the smallest sets of loops that can be solved one after the other.

A drive line with bearings between its joints is a row of loops, each of which needs only the
motion of the one before it. Solving them one by one keeps the cost and Pinocchio's memory linear
in the number of joints. A loop and the passive joints on it form a bipartite graph; its matching
and the strong components of what depends on what give the groups.
"""

from __future__ import annotations

from collections.abc import Hashable
from graphlib import TopologicalSorter
from typing import NamedTuple

import numpy as np
import pinocchio

from ....kit.arrays import Array
from .idle_rods import IdleRod, idle_rods
from .structure import Structure


class Group(NamedTuple):
    """Loops that are solved together.

    Attributes:
        loops, couplings: indices in `Mechanism.loops` and `Mechanism.couplings`.
        passives: velocity coordinates that they decide.
        known: moving coordinates on them that are driven or decided by earlier groups.
        bodies: the bodies (0-based) on these loops and between them and the base, each after what
            carries it.
        base: the nearest body (0-based) from which all of them hang, -1 for the world. Loops
            close relative to it, however it moves.
        inertial_bodies: bodies whose inertia is accounted for in this group.
        idle: idle rods among its bodies, see `idle_rods`. As many passives as there are
            of them are decided by no loop.
    """

    loops: tuple[int, ...]
    couplings: tuple[int, ...]
    passives: Array
    known: Array
    bodies: list[int]
    base: int
    inertial_bodies: set[int]
    idle: tuple[IdleRod, ...] = ()

    @property
    def closure(self) -> Hashable:
        """All that its closure equations follow from, whatever moves, as a key."""
        return (
            self.loops,
            self.couplings,
            *(tuple(self.bodies), self.base),
            *((rod.body, rod.columns, rod.line.tobytes(), rod.frame) for rod in self.idle),
        )

    @property
    def key(self) -> Hashable:
        """All that it consists of, as the key of a dictionary."""
        moving = self.passives.tobytes(), self.known.tobytes()
        return self.closure, *moving, frozenset(self.inertial_bodies)

    def items(self, structure: Structure) -> set[int]:
        """Return the loops and couplings as `Structure` counts them: these after all loops."""
        loops = len(structure.mechanism.loops)
        return {*self.loops, *(loops + index for index in self.couplings)}


class _Block(NamedTuple):
    """Loops and couplings that are solved together.

    Attributes:
        items: their indices, loops first, then couplings.
        passives: velocity coordinates that they decide, ascending.
    """

    items: list[int]
    passives: list[int]


def partition(
    structure: Structure,
    x: Array,
    drives: Array,
    passives: Array,
    together: bool = False,
    loop_ranks: list[int] | None = None,
) -> list[Group]:
    """Return the groups in the order in which motion passes through them.

    Args:
        structure: of the mechanism.
        x: `(size,)` coordinates with the held joints at their positions.
        drives: velocity coordinates of the drives.
        passives: velocity coordinates that are neither driven nor held.
        together: solve all loops in one group, whatever their structure.
        loop_ranks: how many independent equations each loop has; those of open loops if None.
    """
    mechanism = structure.mechanism
    unknown = set(passives.tolist())
    moving = unknown | set(drives.tolist())
    items = range(len(structure.paths))
    rods = idle_rods(mechanism, unknown)
    # One coordinate of each rod is left out where loops are matched with what they decide.
    idle: dict[int, IdleRod] = {}
    for rod in rods:
        column = next((column for column in rod.columns if column not in idle), None)
        if column is not None:
            idle[column] = rod
    touched = [
        [column for column in structure.coordinates_on(item) if column in moving] for item in items
    ]
    if together or len(items) <= 1:
        decided = {column for columns in touched for column in columns} & unknown
        blocks = [_Block(list(items), sorted(decided))] if items else []
    else:
        if loop_ranks is None:
            loop_ranks = structure.ranks(x, moving)
        decidable = unknown - set(idle)
        passives_on = [[column for column in columns if column in decidable] for columns in touched]
        ranks = [*loop_ranks, *[1] * len(mechanism.couplings)]
        blocks = _with_idle(_blocks(passives_on, ranks), idle)
    groups: list[Group] = []
    carried: set[int] = set()
    for block in blocks:
        group = _group(structure, block, touched, carried)
        spinning = [rod for column, rod in idle.items() if column in block.passives]
        groups.append(group._replace(idle=tuple(spinning)))
        carried |= group.inertial_bodies
    return groups + _branches(mechanism.model, carried)


def _with_idle(blocks: list[_Block], idle: dict[int, IdleRod]) -> list[_Block]:
    """Return blocks with the idle coordinates beside the ones that they spin with."""
    result = []
    for block in blocks:
        columns = set(block.passives)
        # Rods that follow each other may have no column but those of their neighbours.
        for _ in idle:
            columns |= {
                column for column, rod in idle.items() if not columns.isdisjoint(rod.columns)
            }
        result.append(block._replace(passives=sorted(columns)))
    return result


def independent_groups(structure: Structure, free: Array) -> list[Group]:
    """Return groups of loops and couplings that have no joint in common.

    Args:
        structure: of the mechanism.
        free: velocity coordinates that may move, all of them passives.
    """
    unknown = set(free.tolist())
    items = range(len(structure.paths))
    touched = [
        [column for column in structure.coordinates_on(item) if column in unknown] for item in items
    ]
    on = {column: item for item in items for column in touched[item]}
    joined = {(item, on[column]) for item in items for column in touched[item]}
    labels = components(len(items), joined | {(other, item) for item, other in joined})
    blocks = []
    for label in sorted(set(labels)):
        members = [item for item in items if labels[item] == label]
        blocks.append(_Block(members, sorted({c for item in members for c in touched[item]})))
    return [_group(structure, block, touched, set()) for block in blocks]


def _group(
    structure: Structure,
    block: _Block,
    touched: list[list[int]],
    carried: set[int],
) -> Group:
    """Return the group of some loops and couplings, with the ways around them."""
    loops = len(structure.mechanism.loops)
    moving = {column for item in block.items for column in touched[item]}
    model = structure.mechanism.model
    base = _nearest_common(model, [structure.bases[item] for item in block.items])
    on_loops = {body for item in block.items for body in structure.paths[item]}
    bodies = _between(model, base, on_loops)
    return Group(
        loops=tuple(item for item in block.items if item < loops),
        couplings=tuple(item - loops for item in block.items if item >= loops),
        passives=np.array(block.passives, dtype=int),
        known=np.array(sorted(moving - set(block.passives)), dtype=int),
        bodies=bodies,
        base=base,
        inertial_bodies=set(bodies) - carried,
    )


def _blocks(passives_on: list[list[int]], ranks: list[int]) -> list[_Block]:
    """Return the smallest sets of loops and couplings that can be solved one after the other."""
    items = range(len(passives_on))
    decider = _deciders(passives_on, ranks)
    dependences = {
        (item, decider[column])
        for item in items
        for column in passives_on[item]
        if decider[column] != item
    }
    labels, dependences = _without_surplus(ranks, decider, dependences)
    blocks = []
    for label in _in_order(labels, dependences):
        members = [item for item in items if labels[item] == label]
        decided = sorted(column for column, item in decider.items() if labels[item] == label)
        blocks.append(_Block(members, decided))
    return blocks


def _deciders(passives_on: list[list[int]], ranks: list[int]) -> dict[int, int]:
    """Return for each passive coordinate the loop or coupling that decides it.

    Each of them decides as many as it has independent equations, if a matching finds them.
    """
    equations = [
        item for item, rank in enumerate(ranks) for _ in range(min(rank, len(passives_on[item])))
    ]
    matches = matched([passives_on[item] for item in equations])
    decider = {column: equations[row] for column, row in matches.items()}
    for item, columns in enumerate(passives_on):
        for column in columns:
            # A coordinate that no equation decides still needs a group. The study of mobility
            # reports its joint later, by name.
            decider.setdefault(column, item)
    return decider


def _without_surplus(
    ranks: list[int], decider: dict[int, int], dependences: set[tuple[int, int]]
) -> tuple[list[int], set[tuple[int, int]]]:
    """Join components until none that depends on others has more equations than it decides.

    The surplus equations of such a component restrict the motion of those that it depends on, so
    these have to be solved together with it.

    Returns:
        The component of each item, named by its smallest item, and the dependences with those that
        surplus equations add.
    """
    items = range(len(ranks))
    while True:
        labels = components(len(ranks), dependences)
        added = set()
        for label in set(labels):
            members = {item for item in items if labels[item] == label}
            decides = sum(item in members for item in decider.values())
            if sum(ranks[item] for item in members) > decides:
                added |= {(b, a) for a, b in dependences if a in members and b not in members}
        if added <= dependences:
            return labels, dependences
        dependences = dependences | added


def _in_order(labels: list[int], dependences: set[tuple[int, int]]) -> list[int]:
    """Return components in an order in which each comes after those that it depends on."""
    sorter = TopologicalSorter[int](dict.fromkeys(labels, ()))
    for item, needed in dependences:
        if labels[item] != labels[needed]:
            sorter.add(labels[item], labels[needed])
    sorter.prepare()
    order: list[int] = []
    while ready := sorted(sorter.get_ready()):
        order += ready
        sorter.done(*ready)
    return order


def _branches(model: pinocchio.Model, carried: set[int]) -> list[Group]:
    """Return a group for each branch of bodies on no loop, of bodies that carry each other."""
    none, branches = np.zeros(0, dtype=int), dict[int, list[int]]()
    for body in range(model.njoints - 1):
        if body not in carried:
            base = model.parents[body + 1] - 1
            branches[body] = branches.get(base, [])
            branches[body].append(body)
    return [
        Group((), (), none, none, bodies, model.parents[bodies[0] + 1] - 1, set(bodies))
        for first, bodies in branches.items()
        if first == bodies[0]
    ]


def _nearest_common(model: pinocchio.Model, bodies: list[int]) -> int:
    """Return the nearest body (0-based) from which all of some bodies hang, or that is one of them.

    It is -1, the world, if there is none.
    """
    common = set(bodies)
    while len(common) > 1:
        # A body has a greater index than what it hangs from.
        deepest = max(common)
        common = (common - {deepest}) | {model.parents[deepest + 1] - 1}
    return common.pop() if common else -1


def _between(model: pinocchio.Model, base: int, bodies: set[int]) -> list[int]:
    """Return bodies (0-based) that hang from a base, and all between them and it, ascending."""
    result: set[int] = set()
    for body in bodies:
        while body != base and body not in result:
            result.add(body)
            body = model.parents[body + 1] - 1
    return sorted(result)


def matched(options: list[list[int]]) -> dict[int, int]:
    """Return a maximum matching of rows with columns, at most one column per row.

    Args:
        options: for each row, the columns that it may have.

    Returns:
        Matched column to its row.
    """
    row_of: dict[int, int] = {}
    for start in range(len(options)):
        # Breadth-first search for an augmenting path: from `start` to a row with a free column.
        # `came_from` holds, for each row reached, the row before it and the column between them.
        came_from: dict[int, tuple[int, int]] = {}
        queue = [start]
        for row in queue:
            free = next((column for column in options[row] if column not in row_of), None)
            if free is not None:
                # Every row on the path takes the next column and hands over its previous one.
                while row != start:
                    previous, column_between = came_from[row]
                    row_of[free] = row
                    free, row = column_between, previous
                row_of[free] = start
                break
            for column in options[row]:
                holder = row_of[column]
                if holder != start and holder not in came_from:
                    came_from[holder] = (row, column)
                    queue.append(holder)
    return row_of


def components(size: int, edges: set[tuple[int, int]]) -> list[int]:
    """Return the strong components of a directed graph with nodes 0 … `size` - 1.

    Returns:
        For each node the smallest node of its component: of all nodes that it can reach and that
        can reach it.
    """
    reach = np.eye(size, dtype=bool)
    for start, end in edges:
        reach[start, end] = True
    for middle in range(size):
        reach |= reach[:, [middle]] & reach[middle]
    return [int(np.argmax(own)) for own in reach & reach.T]
