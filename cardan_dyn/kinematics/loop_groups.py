"""Groups: the smallest sets of loops that can be solved one after the other.

A drive line with bearings between its joints is a row of loops, each of which needs only the
motion of the one before it. Solving them one by one keeps the cost and Pinocchio's memory linear
in the number of joints. A loop and the passive joints on it form a bipartite graph; its matching
and the strong components of what depends on what give the groups.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array
from .graph import components, matched
from .structure import Structure

_PIECE = 8  # Bodies on no loop are taken in pieces of this size.
_LONG = 3 * _PIECE
_WHOLE = 14  # Up to this many bodies, one model costs less than two.


class Group(NamedTuple):
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
