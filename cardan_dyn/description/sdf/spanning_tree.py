"""Spanning tree: which joints of an SDF model carry links, and which close loops."""

from __future__ import annotations

import heapq
from collections.abc import Collection
from dataclasses import dataclass, field

from .frames import WORLD
from .joints import Edge


@dataclass
class SpanningTree:
    """A tree over all links, whose root is the world.

    Attributes:
        joints: its joints in the order in which they were reached, and whether each is a `fixed`
            one that carries its parent.
        floating: links that no joint carries from the world.
        loops: the other joints in file order.
    """

    joints: list[tuple[Edge, bool]] = field(default_factory=list)
    floating: list[str] = field(default_factory=list)
    loops: list[Edge] = field(default_factory=list)


def spanning_tree(links: Collection[str], canonical: str, edges: list[Edge]) -> SpanningTree:
    """Return the tree that a model's joints span.

    It grows from the world: of all joints whose parent is in the tree and whose child is not, the
    one that stands first in the file is taken. So of several joints with the same child, one
    carries it, and the others are loops; parents, children and signs stay those of the file. A
    `fixed` joint, which has no coordinate, may carry its parent as well.

    A link that no chain of joints carries from the world floats. If it is the parent of a joint
    whose child is in the tree, that joint is a loop.

    Args:
        links: names of all links in file order.
        canonical: name of the one that carries the model's frame.
        edges: all joints in file order.
    """
    tree = SpanningTree()
    around: dict[str, list[int]] = {name: [] for name in (WORLD, *links)}
    for index, item in enumerate(edges):
        if not item.is_cut:
            around[item.parent].append(index)
            if item.type == "fixed":
                around[item.child].append(index)
    reached = {WORLD}
    used: set[int] = set()
    _grow(tree, WORLD, edges, around, reached, used)
    while len(reached) <= len(links):
        root = _next_root([name for name in links if name not in reached], canonical, edges)
        tree.floating.append(root)
        reached.add(root)
        _grow(tree, root, edges, around, reached, used)
    tree.loops = [item for index, item in enumerate(edges) if index not in used]
    return tree


def _grow(
    tree: SpanningTree,
    start: str,
    edges: list[Edge],
    around: dict[str, list[int]],
    reached: set[str],
    used: set[int],
) -> None:
    """Add all links that joints carry from one that was just reached."""
    waiting = list(around[start])
    heapq.heapify(waiting)
    while waiting:
        index = heapq.heappop(waiting)
        item = edges[index]
        is_reversed = item.parent not in reached
        child = item.parent if is_reversed else item.child
        if child in reached:
            continue
        reached.add(child)
        used.add(index)
        tree.joints.append((item, is_reversed))
        for other in around[child]:
            heapq.heappush(waiting, other)


def _next_root(left: list[str], canonical: str, edges: list[Edge]) -> str:
    """Return the link that is to float: one that no other link carries, if there is one.

    Of several such links, the canonical one or else the first in the file is taken.
    """
    bodies = _bodies(left, edges)
    carried = {
        bodies[item.child]
        for item in edges
        if not item.is_cut
        and item.type != "fixed"
        and item.parent in bodies
        and item.child in bodies
        and bodies[item.parent] != bodies[item.child]
    }
    free = [name for name in left if bodies[name] not in carried] or left
    return canonical if canonical in free else free[0]


def _bodies(left: list[str], edges: list[Edge]) -> dict[str, str]:
    """Return link to the first of the links that fixed joints make one body with it."""
    around: dict[str, list[str]] = {name: [] for name in left}
    for item in edges:
        if item.type == "fixed" and not item.is_cut and item.parent in around:
            around[item.parent].append(item.child)
            around[item.child].append(item.parent)
    bodies: dict[str, str] = {}
    for first in left:
        waiting = [first]
        while waiting:
            name = waiting.pop()
            if name not in bodies:
                bodies[name] = first
                waiting += around[name]
    return bodies
